//! Reads the textures of a glTF file, and loads their images from files, data URIs and buffer views. An image that several
//! textures use is read and decoded once.

use super::accessors::{Accessors, get};
use super::document::{
    Document, Image as FileImage, Material, MaterialExtensions, TextureInfo, TextureTransform,
};
use super::materials::Uses;
use super::{buffers, damaged, out_of_range};
use crate::scene::notices::{Tally, label, quoted};
use crate::scene::texture::{Image, Texture, Wrap};
use crate::scene_files::progress::Progress;
use crate::scene_files::scene_folder::{SceneFile, SceneFolder};
use crate::scene_files::{image_files, images};
use crate::{Error, Result};
use glam::{Affine2, Mat2, Vec2};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;

/// The textures of a glTF file, whose images are loaded already. The reader of materials calls [`Self::of_material`] to give
/// each material of the scene its textures.
pub struct Textures<'a> {
    document: &'a Document,
    uses: &'a Uses,
    /// One entry for each image of the glTF file, in the file's order: the index of its decoded image among the images of
    /// the scene. `None` if no material of the scene's faces needs the image, or if the image was left out; materials are
    /// then made without the textures that use the image.
    images: Vec<Option<u32>>,
}

/// The images whose bytes are being read, before they are decoded together.
struct Reading<'a, 'b> {
    accessors: &'b Accessors<'a>,
    folder: &'b SceneFolder<'b>,
    encoded: Vec<images::Encoded<'a>>,
    /// The sources of the images in `encoded`, each with its index there.
    known: HashMap<Identity<'a>, u32>,
}

impl<'a, 'b> Reading<'a, 'b> {
    /// A list without images. They are images of the document of `accessors`, and their files are in `folder`.
    fn new(accessors: &'b Accessors<'a>, folder: &'b SceneFolder<'b>) -> Self {
        Self {
            accessors,
            folder,
            encoded: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Decodes the images that were read. If the user permits missing images, damaged ones are left out, with notices in
    /// `tally`. Fails if they are not permitted, or if the images need too many texels or too much memory.
    fn decode(&self, progress: &mut Progress<'_>, tally: &mut Tally) -> Result<images::Decoded> {
        let allow_missing = self.folder.options.allow_missing;
        images::decode(
            &self.encoded,
            &mut images::TexelCount::default(),
            progress,
            &mut |_, fault| image_files::leave_out(fault, allow_missing, tally),
        )
    }

    /// Reads the bytes of the image with the index `index` in the file, unless another image has the same source. Returns the
    /// index of the bytes in `encoded`; `None`, with a notice in `tally`, if the image's file is missing and the user permits
    /// this. Fails if the image cannot be read.
    fn read(
        &mut self,
        index: usize,
        progress: &mut Progress<'_>,
        tally: &mut Tally,
    ) -> Result<Option<u32>> {
        let image = &self.accessors.document.images[index];
        let what = label("image", index, &image.name);
        let uri = image.uri.as_deref().unwrap_or_default();
        let Some(source) = Source::of(&what, image, self.folder, tally)? else {
            image_files::missing(&what, uri, self.folder, tally)?;
            return Ok(None);
        };
        let identity = source.identity();
        if let Some(known) = self.known.get(&identity) {
            return Ok(Some(*known));
        }
        let name = match &source {
            Source::File(_) => uri,
            _ => &image.name,
        };
        let encoded = self.encoded.len() as u32;
        self.encoded.push(images::Encoded {
            bytes: source.read(&what, self.accessors, progress)?,
            name: name.to_owned(),
            what,
        });
        self.known.insert(identity, encoded);
        Ok(Some(encoded))
    }
}

/// The source of the encoded bytes of an image (PNG, JPEG, WebP or KTX2): a file, a data URI or a buffer view. The
/// bytes are read only if no earlier image has the same source.
enum Source<'a> {
    File(SceneFile),
    /// The text of a data URI after `data:`, such as `image/png;base64,…`. The bytes are decoded from its
    /// base64.
    Uri(&'a str),
    /// The index, among the buffer views of the glTF file, of the view that contains the bytes.
    View(u64),
}

/// The identity of an image's source: the device and inode numbers of a file, the text of a data URI, or the index of a
/// buffer view. Images of the glTF file with equal identities are one image in the scene, which is read and decoded once.
#[derive(PartialEq, Eq, Hash)]
enum Identity<'a> {
    File((u64, u64)),
    Uri(&'a str),
    View(u64),
}

impl<'a> Textures<'a> {
    /// Loads the images that the materials of the scene's faces need. `uses` states which materials these are, and which of
    /// them emit light. Returns the textures, and the decoded images, which become the images of the scene. If the user
    /// permits missing files, images that are missing or damaged are left out, with notices in `tally`.
    ///
    /// # Errors
    /// An image is missing or cannot be read although the user does not permit it; the images have too many texels or need
    /// more memory than there is; or the callback of `progress` returns an error.
    pub fn load(
        accessors: &Accessors<'a>,
        uses: &'a Uses,
        folder: &SceneFolder<'_>,
        progress: &mut Progress<'_>,
        tally: &mut Tally,
    ) -> Result<(Self, Vec<Image>)> {
        let document = accessors.document;
        let mut textures = Self {
            document,
            uses,
            images: vec![None; document.images.len()],
        };
        let mut reading = Reading::new(accessors, folder);
        let allow_missing = folder.options.allow_missing;
        let mut is_read = vec![false; document.images.len()];
        for (index, material) in document.materials.iter().enumerate() {
            if !uses.has_faces[index] {
                continue;
            }
            let what = label("material", index, &material.name);
            for (kind, info) in slots(material, uses.emits[index]) {
                let Some(info) = info else { continue };
                let read = match textures.image_of(&format!("{kind} of {what}"), info.index) {
                    Ok(index) if std::mem::replace(&mut is_read[index], true) => continue,
                    Ok(index) => (reading.read(index, progress, tally))
                        .map(|encoded| textures.images[index] = encoded),
                    Err(fault) => Err(fault),
                };
                read.or_else(|fault| image_files::leave_out(fault, allow_missing, tally))?;
            }
        }
        let decoded = reading.decode(progress, tally)?;
        for image in &mut textures.images {
            *image = image.and_then(|encoded| decoded.index_of[encoded as usize].map(|i| i as u32));
        }
        Ok((textures, decoded.images))
    }

    /// The textures of one material, in the order of [`slots`]; `index` is the material's index in the glTF file. An element is `None` if the material has no such texture or no faces, if the
    /// texture would have no effect, or if its image was left out. An unknown wrap mode counts as `REPEAT`, with a notice in
    /// `tally`. Fails if an index is wrong, or if the textures use more than two sets of texture coordinates; `what` is the
    /// name of the material in the error.
    pub fn of_material(
        &self,
        what: &str,
        index: usize,
        tally: &mut Tally,
    ) -> Result<[Option<Texture>; SLOTS]> {
        let mut textures = [None; SLOTS];
        if self.uses.has_faces[index] {
            let sets = self.coordinate_sets(index);
            let used = slots(&self.document.materials[index], self.uses.emits[index]);
            for (texture, (kind, info)) in textures.iter_mut().zip(used) {
                let Some(info) = info else { continue };
                let what = format!("{kind} of {what}");
                *texture = self.texture(&what, info, sets, tally)?;
            }
        }
        Ok(textures)
    }

    /// For the first and the second set of texture coordinates that meshes of the scene have: the set of the file that it is
    /// where a primitive has the material with the index `index`. Sets 0 and 1 of the file keep their places if the material
    /// uses them; other sets take free places.
    pub fn coordinate_sets(&self, index: usize) -> [u64; 2] {
        let slots = slots(&self.document.materials[index], self.uses.emits[index]);
        let infos = slots.iter().filter_map(|(_, info)| info.as_ref());
        let used: Vec<u64> = infos.map(coordinate_set).collect();
        let mut sets = [0, 1];
        for number in &used {
            let is_free = |set: &&mut u64| !used.contains(set);
            if !sets.contains(number)
                && let Some(free) = sets.iter_mut().find(is_free)
            {
                *free = *number;
            }
        }
        sets
    }

    /// True if the emissive texture of the material with the index `index` in the file was left out. The material must then
    /// emit nothing, because the factor alone would make all of its surface shine.
    pub fn has_lost_emission(&self, index: usize) -> bool {
        let [.., (_, emissive)] = slots(&self.document.materials[index], self.uses.emits[index]);
        let is_lost = |info: &TextureInfo| {
            let image = self.image_of("", info.index);
            image.map_or(true, |image| self.images[image].is_none())
        };
        self.uses.has_faces[index] && emissive.as_ref().is_some_and(is_lost)
    }

    fn texture(
        &self,
        what: &str,
        info: &TextureInfo,
        sets: [u64; 2],
        tally: &mut Tally,
    ) -> Result<Option<Texture>> {
        // A texture without an image was an error, or was left out, when the images were loaded.
        let Some(image) = self
            .image_of(what, info.index)
            .ok()
            .and_then(|i| self.images[i])
        else {
            return Ok(None);
        };
        let number = coordinate_set(info);
        let Some(set) = sets.iter().position(|set| *set == number) else {
            return Err(Error::input(format!(
                "{what}: uses texture coordinates {number}, and other textures of the material two other sets; export it with two sets"
            )));
        };
        let texture = &self.document.textures[info.index as usize];
        let sampler = match texture.sampler {
            None => None,
            Some(index) => Some(get(&self.document.samplers, index).ok_or_else(|| {
                damaged(format!(
                    "{what}: sampler {index} is out of range, there are {}",
                    self.document.samplers.len()
                ))
            })?),
        };
        let mut mode = |code: Option<i64>| match code {
            None | Some(10497) => Wrap::Repeat,
            Some(33648) => Wrap::Mirror,
            Some(33071) => Wrap::Clamp,
            Some(code) => {
                tally.add("unknown wrap modes count as REPEAT", || {
                    format!("{code} ({what})")
                });
                Wrap::Repeat
            }
        };
        let placed = info.extensions.transform.as_ref();
        Ok(Some(Texture {
            image,
            set: set as u32,
            transform: placed.map_or(Affine2::IDENTITY, transform),
            wrap: [
                mode(sampler.and_then(|s| s.wrap_s)),
                mode(sampler.and_then(|s| s.wrap_t)),
            ],
            nearest: sampler.is_some_and(|s| s.mag_filter == Some(9728)),
        }))
    }

    /// The index, in the file's list of images, of the image that the texture with the index `texture` uses. If the texture
    /// has several images, the WebP image is preferred, then the KTX2 image. Fails if an index is out of range or the texture has no supported image;
    /// `what` is the use of the texture in the error, such as `normal texture of material 3`.
    fn image_of(&self, what: &str, texture: u64) -> Result<usize> {
        let document = self.document;
        let Some(found) = get(&document.textures, texture) else {
            return Err(damaged(format!(
                "{what}: texture {texture} is out of range, there are {}",
                document.textures.len()
            )));
        };
        let extensions = &found.extensions;
        let preferred = extensions.webp.as_ref().or(extensions.basisu.as_ref());
        let Some(source) = preferred.map(|image| image.source).or(found.source) else {
            return Err(Error::input(format!(
                "{what}: texture {texture} has no image; export it with PNG, JPEG, WebP or KTX2 images"
            )));
        };
        match usize::try_from(source) {
            Ok(index) if index < document.images.len() => Ok(index),
            _ => Err(damaged(format!(
                "texture {texture}: image {source} is out of range, there are {}",
                document.images.len()
            ))),
        }
    }
}

/// The number of textures that a material can have, apart from those that are not supported.
const SLOTS: usize = 11;

/// Loads images that no texture names, such as the faces of a cube map; `indices` are their indices in the file. Returns one
/// entry for each: `None` if its image was left out, with a notice in `tally`, which happens only if the user permits missing
/// images. Fails like [`Textures::load`], and if an index is out of range; `what` is the name of their user in the error.
pub fn load_images(
    accessors: &Accessors<'_>,
    what: &str,
    indices: &[u64],
    folder: &SceneFolder<'_>,
    progress: &mut Progress<'_>,
    tally: &mut Tally,
) -> Result<Vec<Option<Image>>> {
    let count = accessors.document.images.len();
    let allow_missing = folder.options.allow_missing;
    let mut reading = Reading::new(accessors, folder);
    let mut read = Vec::with_capacity(indices.len());
    for &index in indices {
        if get(&accessors.document.images, index).is_none() {
            return Err(out_of_range(what, "image", index, count));
        }
        let encoded = reading.read(index as usize, progress, tally);
        read.push(
            encoded.or_else(|fault| {
                image_files::leave_out(fault, allow_missing, tally).map(|()| None)
            })?,
        );
    }
    let decoded = reading.decode(progress, tally)?;
    let image =
        |encoded: u32| decoded.index_of[encoded as usize].map(|i| decoded.images[i].clone());
    Ok(read
        .into_iter()
        .map(|encoded| encoded.and_then(image))
        .collect())
}

/// The set of texture coordinates in the file that a texture uses.
fn coordinate_set(info: &TextureInfo) -> u64 {
    let placed = info.extensions.transform.as_ref();
    placed
        .and_then(|placed| placed.tex_coord)
        .unwrap_or(info.tex_coord)
}

/// The supported textures of a material for base colour, metallic-roughness, normal, specular reflection, its colour, the
/// strength, roughness and normal of the clear coat, anisotropy, transmission, and emission, in this order, each with its name
/// for messages. A texture is `None` if the material lacks it, or if it has no effect on the picture. In an unlit material,
/// only the base colour texture has an effect. The emissive texture has an effect only if `emits` is true, which
/// means that the material emits light at some time, and the textures of a layer only if the factor of the layer is above 0.
fn slots(material: &Material, emits: bool) -> [(&'static str, &Option<TextureInfo>); SLOTS] {
    let pbr = &material.pbr_metallic_roughness;
    let MaterialExtensions {
        specular,
        coat,
        anisotropy,
        transmission,
        ..
    } = &material.extensions;
    let lit = |texture| {
        if material.is_unlit() { &None } else { texture }
    };
    let layer = |factor: f32, texture| if factor > 0.0 { lit(texture) } else { &None };
    let coated = |texture| layer(coat.clearcoat_factor, texture);
    [
        ("base colour texture", &pbr.base_color_texture),
        (
            "metallic-roughness texture",
            lit(&pbr.metallic_roughness_texture),
        ),
        ("normal texture", lit(&material.normal_texture)),
        ("specular texture", lit(&specular.specular_texture)),
        (
            "specular colour texture",
            lit(&specular.specular_color_texture),
        ),
        ("clear coat texture", coated(&coat.clearcoat_texture)),
        (
            "clear coat roughness texture",
            coated(&coat.clearcoat_roughness_texture),
        ),
        (
            "clear coat normal texture",
            coated(&coat.clearcoat_normal_texture),
        ),
        (
            "anisotropy texture",
            layer(
                anisotropy.anisotropy_strength,
                &anisotropy.anisotropy_texture,
            ),
        ),
        (
            "transmission texture",
            layer(
                transmission.transmission_factor,
                &transmission.transmission_texture,
            ),
        ),
        (
            "emissive texture",
            match emits {
                true => lit(&material.emissive_texture),
                false => &None,
            },
        ),
    ]
}

/// The matrix of `KHR_texture_transform` for texture coordinates: it scales them, then rotates them, then moves them. In the
/// extension, the text and the example matrix rotate in opposite directions. This function follows the text, as other
/// programs that read glTF do (KhronosGroup/glTF, issue 1563).
fn transform(placed: &TextureTransform) -> Affine2 {
    let (sin, cos) = placed.rotation.sin_cos();
    // Counter-clockwise where v points down.
    let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let scale = Mat2::from_diagonal(Vec2::from_array(placed.scale));
    Affine2::from_mat2_translation(turn * scale, Vec2::from_array(placed.offset))
}

impl<'a> Source<'a> {
    /// The source of an image's bytes, from which [`Self::read`] reads them. `None` if the image's file is
    /// missing, or is outside of the scene's folder while the user permits missing files. Fails if the image
    /// has no source, if its URI does not name a local file, or if the file cannot be opened or is outside of
    /// the scene's folder without a permission. `what` is the image's name in messages.
    fn of(
        what: &str,
        image: &'a FileImage,
        folder: &SceneFolder<'_>,
        tally: &mut Tally,
    ) -> Result<Option<Self>> {
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match uri.strip_prefix("data:") {
                Some(data) => Ok(Some(Self::Uri(data))),
                None => {
                    let name = buffers::file_name(what, uri)?;
                    let found = folder.open_dispensable(what, &[PathBuf::from(&*name)], tally)?;
                    Ok(found.map(Self::File))
                }
            },
            (None, Some(view)) => Ok(Some(Self::View(view))),
            (None, None) => Err(damaged(format!(
                "{what} has neither a uri nor a bufferView, {}",
                quoted(&image.name)
            ))),
        }
    }

    fn identity(&self) -> Identity<'a> {
        match self {
            Self::File(file) => Identity::File(file.id),
            Self::Uri(data) => Identity::Uri(data),
            Self::View(view) => Identity::View(*view),
        }
    }

    /// The bytes of the image in its encoding (PNG, JPEG, WebP or KTX2), read from this source. Fails if the file cannot be read,
    /// the data URI is not base64, or the buffer view is out of range. `what` is the image's name in messages.
    fn read<'b>(
        self,
        what: &str,
        accessors: &Accessors<'b>,
        progress: &mut Progress<'_>,
    ) -> Result<Cow<'b, [u8]>> {
        match self {
            Self::File(file) => image_files::read(what, file, progress).map(Cow::Owned),
            Self::Uri(data) => (buffers::decode_data_uri(data).map(Cow::Owned))
                .ok_or_else(|| damaged(format!("{what}: its data URI is not base64"))),
            Self::View(view) => accessors.view(what, view).map(Cow::Borrowed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_scales_then_turns_then_moves() {
        let placed = TextureTransform {
            offset: [0.25, 0.5],
            rotation: std::f32::consts::FRAC_PI_2,
            scale: [2.0, 3.0],
            tex_coord: None,
        };
        // A quarter turn in the extension's sense takes +u to −v.
        let found = transform(&placed).transform_point2(Vec2::new(1.0, 0.0));
        assert!(found.distance(Vec2::new(0.25, -1.5)) < 1e-6, "{found}");
        let found = transform(&placed).transform_point2(Vec2::new(0.0, 1.0));
        assert!(found.distance(Vec2::new(3.25, 0.5)) < 1e-6, "{found}");
    }
}

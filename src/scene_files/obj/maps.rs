//! Loads the textures of MTL materials, after the whole OBJ file is read. Only then is it known which
//! materials have faces, and only the images of these materials are read.

use super::combine;
use super::map_statements::Map;
use super::mtl::Maps;
use crate::base::memory;
use crate::scene::notices::{Tally, quoted};
use crate::scene::texture::{Image, Texture, Wrap};
use crate::scene::{AlphaMode, Material, Scene};
use crate::scene_files::images::{BYTES, Encoded, TexelCount};
use crate::scene_files::progress::Progress;
use crate::scene_files::scene_folder::SceneFolder;
use crate::scene_files::{image_files, images};
use crate::{Error, Result};
use glam::{Affine2, Mat2, Vec2, Vec3};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;

/// Loads the images of all materials that faces of `scene` use, and sets the textures of these materials. `maps` has one
/// entry for each material of the scene, in the same order: the textures that the MTL file states for it.
///
/// # Errors
/// An image cannot be read or decoded, or is missing although the user does not permit it; the images have too many texels
/// or need more memory than there is; or the callback of `progress` returns an error.
pub fn load(
    scene: &mut Scene,
    maps: &[Maps],
    folder: &SceneFolder<'_>,
    progress: &mut Progress<'_>,
    tally: &mut Tally,
) -> Result<()> {
    let mut has_faces = vec![false; maps.len()];
    for part in scene.meshes.iter().flat_map(|mesh| &mesh.parts) {
        has_faces[part.material as usize] = true;
    }
    let mut count = TexelCount::default();
    let needed = (maps.iter().zip(&has_faces)).filter_map(|(maps, needed)| needed.then_some(maps));
    let files = Files::read(needed, folder, &mut count, progress, tally)?;
    let mut images = SceneImages {
        files,
        images: &mut scene.images,
        index_of: HashMap::new(),
        have_alpha: HashMap::new(),
        are_normal_maps: HashMap::new(),
        count,
    };
    let materials = scene.materials.iter_mut().zip(maps).zip(&has_faces);
    for ((material, maps), _) in materials.filter(|(_, has_faces)| **has_faces) {
        set_color(material, maps, &mut images, tally)?;
        set_emission(material, maps, &mut images, tally)?;
        set_normals(material, maps, &mut images, tally)?;
        set_surface(material, maps, &mut images, tally)?;
    }
    Ok(())
}

/// Sets the texture of base colour and opacity.
fn set_color(
    material: &mut Material,
    maps: &Maps,
    images: &mut SceneImages<'_>,
    tally: &mut Tally,
) -> Result<()> {
    let color = images.files.of(&maps.base_color);
    let Some((opacity_map, opacity)) = images.files.of(&maps.opacity) else {
        if let Some((map, file)) = color {
            material.base_color_texture = Some(images.texture(map, Content::File(file))?);
        }
        return Ok(());
    };
    let mut keep_opaque = |what: &str| tally.add(what, || name_of(material));
    let color_file = color.map(|(_, file)| file);
    let (map, content) = match color {
        Some((map, file)) if !is_laid_like(map, opacity_map) => {
            keep_opaque("map_d is left out where its scale, offset or clamp differs from map_Kd");
            (map, Content::File(file))
        }
        // Some programs name the image of the colour, and mean its alpha.
        Some((map, file)) if file == opacity && !images.has_alpha(file) => {
            keep_opaque("map_d is left out where it is the image of map_Kd and has no alpha");
            (map, Content::File(file))
        }
        _ => {
            material.alpha_mode = AlphaMode::Blend;
            (opacity_map, Content::WithOpacity(color_file, opacity))
        }
    };
    material.base_color_texture = Some(images.texture(map, content)?);
    Ok(())
}

/// Sets the texture of emission. Without its image the material emits nothing, because most of such an image is black.
fn set_emission(
    material: &mut Material,
    maps: &Maps,
    images: &mut SceneImages<'_>,
    tally: &mut Tally,
) -> Result<()> {
    if let Some((map, file)) = images.files.of(&maps.emission) {
        material.emissive_texture = Some(images.texture(map, Content::File(file))?);
    } else if maps.emission.is_some() {
        material.emission = Vec3::ZERO;
        tally.add(
            "materials without their image of emission emit nothing",
            || name_of(material),
        );
    }
    Ok(())
}

/// Sets the normal map, which `norm` or `map_Bump` states.
fn set_normals(
    material: &mut Material,
    maps: &Maps,
    images: &mut SceneImages<'_>,
    tally: &mut Tally,
) -> Result<()> {
    if maps.normal.is_some() && maps.bump.is_some() {
        tally.add("map_Bump is left out beside norm", || name_of(material));
    }
    let mut found = images.files.of(&maps.normal);
    if maps.normal.is_none() {
        found = images.files.of(&maps.bump);
        if let Some((_, file)) = found
            && !images.is_normal_map(file)
        {
            tally.add("height maps (map_Bump) are left out", || name_of(material));
            return Ok(());
        }
    }
    if let Some((map, file)) = found {
        material.normal_texture = Some(images.texture(map, Content::File(file))?);
        material.normal_scale = map.bump_multiplier;
    }
    Ok(())
}

/// Sets the texture of roughness and metalness.
fn set_surface(
    material: &mut Material,
    maps: &Maps,
    images: &mut SceneImages<'_>,
    tally: &mut Tally,
) -> Result<()> {
    let roughness = images.files.of(&maps.roughness);
    let mut metallic = images.files.of(&maps.metallic);
    if let (Some((first, _)), Some((second, _))) = (roughness, metallic)
        && !is_laid_like(first, second)
    {
        let what = "map_Pm is left out where its scale, offset or clamp differs from map_Pr";
        tally.add(what, || name_of(material));
        metallic = None;
    }
    if let Some((map, _)) = roughness.or(metallic) {
        let files = [roughness, metallic].map(|found| found.map(|(_, file)| file));
        let texture = images.texture(map, Content::Surface(files))?;
        material.metallic_roughness_texture = Some(texture);
    }
    Ok(())
}

/// The name of a material for notices.
fn name_of(material: &Material) -> String {
    format!("material {}", quoted(&material.name))
}

/// True if two textures lie in the same way on the surface, so that their images can be combined into one.
fn is_laid_like(a: &Map, b: &Map) -> bool {
    (a.transform, a.clamp) == (b.transform, b.clamp)
}

/// The content of an image of the scene, by the indices of image files. Textures with the same content share the image.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Content {
    /// The image of a file.
    File(usize),
    /// Roughness and metalness, each from the red channel of an image.
    Surface([Option<usize>; 2]),
    /// The colours of the first image, white for `None`, and the opacity of the second one.
    WithOpacity(Option<usize>, usize),
}

/// The images of the scene, which are made from those of the files when a material needs them.
struct SceneImages<'a> {
    files: Files<'a>,
    images: &'a mut Vec<Image>,
    index_of: HashMap<Content, u32>,
    /// The results of [`combine::has_alpha`] for images of files, because many materials may name one image.
    have_alpha: HashMap<usize, bool>,
    /// The results of [`combine::is_normal_map`] for images of files.
    are_normal_maps: HashMap<usize, bool>,
    /// The number of texels of all images, with those of the files.
    count: TexelCount,
}

impl SceneImages<'_> {
    /// The texture that `map` states, with an image of this content, which is made if it does not exist yet. Fails if the
    /// images have too many texels or if there is not enough memory.
    fn texture(&mut self, map: &Map, content: Content) -> Result<Texture> {
        let index = match self.index_of.entry(content) {
            Entry::Occupied(index) => *index.get(),
            Entry::Vacant(index) => {
                let files = &self.files.images;
                let file = |file: Option<usize>| Some(&files[file?]);
                let image = match content {
                    Content::File(file) => files[file].clone(),
                    Content::Surface(sources) => {
                        let [roughness, metallic] = sources.map(file);
                        let sources = [roughness, metallic];
                        check(&mut self.count, map, sources, sources)?;
                        combine::surface(roughness, metallic)?
                    }
                    Content::WithOpacity(color, opacity) => {
                        let sources = [file(color), Some(&files[opacity])];
                        let like = sources[0].or(sources[1]);
                        check(&mut self.count, map, [like, None], sources)?;
                        combine::with_opacity(file(color), &files[opacity])?
                    }
                };
                self.images.push(image);
                *index.insert(self.images.len() as u32 - 1)
            }
        };
        Ok(texture(map, index))
    }

    /// True if some texel of the image of the file with the index `file` is not opaque.
    fn has_alpha(&mut self, file: usize) -> bool {
        let known = self.have_alpha.entry(file);
        *known.or_insert_with(|| combine::has_alpha(&self.files.images[file]))
    }

    /// True if the image of the file with the index `file` is a normal map, and not a height map.
    fn is_normal_map(&mut self, file: usize) -> bool {
        let known = self.are_normal_maps.entry(file);
        *known.or_insert_with(|| combine::is_normal_map(&self.files.images[file]))
    }
}

/// Checks that the scene may have one more image, which is as large as the largest of `like` and has 16 bits per channel if one
/// of `sources` has. Fails if the images then have too many texels or if there is not enough memory. `map` is the texture with
/// the image, for the error.
fn check(
    count: &mut TexelCount,
    map: &Map,
    like: [Option<&Image>; 2],
    sources: [Option<&Image>; 2],
) -> Result<()> {
    let sizes = like
        .iter()
        .flatten()
        .map(|image| u64::from(image.width) * u64::from(image.height));
    let entries = match sources.iter().flatten().any(|image| image.is_deep()) {
        true => 2,
        false => 1,
    };
    let texels = entries * sizes.max().unwrap_or(0);
    count.add(texels, || what(map))?;
    memory::check(BYTES * texels)
        .map_err(|cause| Error::input(format!("{}: {cause}; scale it", what(map))))
}

/// The decoded images of all files that the textures of used materials name; the images of the scene are made from them.
/// Each file is read once, however many textures name it.
struct Files<'a> {
    /// Maps the possible paths of a texture's file ([`Map::files`]) to the index of its image in `images`. `None`, or no
    /// entry, if the file is missing or cannot be read and the scene can do without it; the material then gets no such
    /// texture.
    image_of: HashMap<&'a [PathBuf], Option<usize>>,
    images: Vec<Image>,
}

impl<'a> Files<'a> {
    fn read(
        materials: impl Iterator<Item = &'a Maps>,
        folder: &SceneFolder<'_>,
        count: &mut TexelCount,
        progress: &mut Progress<'_>,
        tally: &mut Tally,
    ) -> Result<Self> {
        let mut image_of = HashMap::new();
        let mut known: HashMap<(u64, u64), usize> = HashMap::new();
        let mut encoded = Vec::new();
        // For each encoded image, true if it is an error that it cannot be decoded.
        let mut is_needed: Vec<bool> = Vec::new();
        let maps = materials.flat_map(|maps| maps.all().map(move |map| (map, maps.is_bump(map))));
        for (map, is_bump) in maps {
            let needs = !is_bump && !folder.options.allow_missing;
            if let Some(known) = image_of.get(&map.files[..]) {
                if let Some(image) = *known {
                    is_needed[image] |= needs;
                }
                continue;
            }
            let (what, name) = (what(map), map.name());
            let read = match folder.open_dispensable(&what, &map.files, tally) {
                // Most are height maps, which have no effect.
                Ok(None) | Err(_) if is_bump => {
                    let what = || format!("{} ({what})", quoted(&name));
                    tally.add(
                        "textures of map_Bump that cannot be read are left out",
                        what,
                    );
                    continue;
                }
                Ok(None) => {
                    image_files::missing(&what, &name, folder, tally)?;
                    image_of.insert(&map.files[..], None);
                    continue;
                }
                Ok(Some(file)) => match known.entry(file.id) {
                    Entry::Occupied(image) => Ok(*image.get()),
                    Entry::Vacant(image) => {
                        let read = image_files::read(&what, file, progress);
                        read.map(|bytes| {
                            encoded.push(Encoded {
                                bytes: bytes.into(),
                                name,
                                what,
                            });
                            is_needed.push(false);
                            *image.insert(encoded.len() - 1)
                        })
                    }
                },
                Err(fault) => Err(fault),
            };
            let image = match read {
                Ok(image) => {
                    is_needed[image] |= needs;
                    Some(image)
                }
                Err(fault) => {
                    image_files::leave_out(fault, !needs, tally)?;
                    None
                }
            };
            image_of.insert(&map.files[..], image);
        }
        let decoded = images::decode(&encoded, count, progress, &mut |index, fault| {
            image_files::leave_out(fault, !is_needed[index], tally)
        })?;
        for image in image_of.values_mut() {
            *image = image.and_then(|image| decoded.index_of[image]);
        }
        Ok(Self {
            image_of,
            images: decoded.images,
        })
    }

    /// The texture in `map`, with the index of its image in [`Self::images`]. `None` if `map` is `None`, because the
    /// material has no such texture, or if the texture's file is missing.
    fn of<'b>(&self, map: &'b Option<Box<Map>>) -> Option<(&'b Map, usize)> {
        let map = map.as_deref()?;
        Some((map, (*self.image_of.get(&map.files[..])?)?))
    }
}

/// The name of a texture in messages, by its line in the MTL file: `texture in line 12 of its MTL file`.
fn what(map: &Map) -> String {
    format!("texture in {} of its MTL file", map.location)
}

/// Converts a texture of an MTL file to a texture of the scene; `image` is the index of its image in the scene. The
/// transform changes too, because v points up in OBJ and down in the scene.
fn texture(map: &Map, image: u32) -> Texture {
    let flip = Affine2::from_mat2_translation(Mat2::from_diagonal(Vec2::new(1.0, -1.0)), Vec2::Y);
    let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
    Texture {
        transform: flip * map.transform * flip,
        wrap: [wrap; 2],
        ..Texture::plain(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_files::images::MAX_TEXELS;

    /// The image has the size of the one with 8 bits per channel, and the depth of the other one.
    #[test]
    fn an_image_made_from_one_of_16_bits_counts_twice() {
        let image = |entries: usize| Image {
            name: String::new(),
            width: 2,
            height: 1,
            texels: vec![[0; 4]; entries].into(),
        };
        let (color, opacity) = (image(2), image(4));
        let map = Map {
            files: Vec::new(),
            transform: Affine2::IDENTITY,
            clamp: false,
            bump_multiplier: 1.0,
            location: "line 1".into(),
        };
        for (sources, entries) in [([Some(&color); 2], 2), ([Some(&color), Some(&opacity)], 4)] {
            for room in [entries - 1, entries] {
                let mut count = TexelCount::default();
                count.add(MAX_TEXELS - room, String::new).unwrap();
                let checked = check(&mut count, &map, [Some(&color), None], sources);
                assert_eq!(checked.is_ok(), room == entries);
            }
        }
    }
}

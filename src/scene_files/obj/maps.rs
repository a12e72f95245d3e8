//! Loads the textures of MTL materials, after the whole OBJ file is read. Only then is it known which
//! materials have faces, and only the images of these materials are read.

use super::mtl::{Map, Maps};
use crate::base::memory;
use crate::scene::Scene;
use crate::scene::notices::Tally;
use crate::scene::texture::{Image, Texture, Wrap};
use crate::scene_files::images::{BYTES, Encoded, TexelCount};
use crate::scene_files::progress::Progress;
use crate::scene_files::scene_folder::SceneFolder;
use crate::scene_files::{image_files, images};
use crate::{Error, Result};
use glam::{Affine2, Mat2, Vec2};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::PathBuf;

/// Loads the images of all materials that faces of `scene` use, and sets the textures of these materials. `maps` has one
/// entry for each material of the scene, in the same order: the textures that the MTL file states for it.
///
/// # Errors
/// An image cannot be read or decoded, or is missing although the user does not permit it; the images have too many texels
/// or need more memory than there is; a material's textures of roughness and metalness differ in size, scale, offset or
/// clamp, so that they cannot be combined into one image; or the callback of `progress` returns an error.
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
    let read = Files::read(needed, folder, &mut count, progress, tally)?;
    let images = &mut scene.images;
    // Indices in the scene: of the images of files, and of those made from files of roughness and metalness.
    let mut whole: HashMap<usize, u32> = HashMap::new();
    let mut surfaces: HashMap<[Option<usize>; 2], u32> = HashMap::new();
    let materials = scene.materials.iter_mut().zip(maps).zip(&has_faces);
    for ((material, maps), has_faces) in materials {
        if !has_faces {
            continue;
        }
        for (map, slot) in [
            (&maps.base_color, &mut material.base_color_texture),
            (&maps.emission, &mut material.emissive_texture),
            (&maps.normal, &mut material.normal_texture),
        ] {
            if let Some((map, file)) = read.of(map) {
                let index = *whole.entry(file).or_insert_with(|| {
                    images.push(read.images[file].clone());
                    images.len() as u32 - 1
                });
                *slot = Some(texture(map, index));
            }
        }
        let (roughness, metallic) = (read.of(&maps.roughness), read.of(&maps.metallic));
        let Some((map, file)) = roughness.or(metallic) else {
            continue;
        };
        let like = &read.images[file];
        if let (Some((a, first)), Some((b, second))) = (roughness, metallic) {
            let [first, second] = [first, second].map(|file| &read.images[file]);
            if (a.transform, a.clamp, first.width, first.height)
                != (b.transform, b.clamp, second.width, second.height)
            {
                return Err(Error::input(format!(
                    "map_Pr in {} and map_Pm in {} of the MTL file differ in size, scale, offset or clamp; give both the same",
                    a.location, b.location
                )));
            }
        }
        let files = [roughness, metallic].map(|found| found.map(|(_, file)| file));
        let index = match surfaces.entry(files) {
            Entry::Occupied(image) => *image.get(),
            Entry::Vacant(image) => {
                let texels = like.texels.len() as u64;
                count.add(texels, || what(map))?;
                memory::check(BYTES * texels)
                    .map_err(|cause| Error::input(format!("{}: {cause}; scale it", what(map))))?;
                let [roughness, metallic] = files.map(|file| Some(&read.images[file?]));
                images.push(combine(like, roughness, metallic));
                *image.insert(images.len() as u32 - 1)
            }
        };
        material.metallic_roughness_texture = Some(texture(map, index));
    }
    Ok(())
}

/// The decoded images of all files that the textures of used materials name; the images of the scene are made from them.
/// Each file is read once, however many textures name it.
struct Files<'a> {
    /// Maps the two possible paths of a texture's file ([`Map::files`]) to the index of its image in `images`. `None` if the
    /// file is missing and the user permits this; the material then gets no such texture.
    image_of: HashMap<&'a [PathBuf; 2], Option<usize>>,
    images: Vec<Image>,
}

impl<'a> Files<'a> {
    fn read(
        maps: impl Iterator<Item = &'a Maps>,
        folder: &SceneFolder<'_>,
        count: &mut TexelCount,
        progress: &mut Progress<'_>,
        tally: &mut Tally,
    ) -> Result<Self> {
        let mut image_of = HashMap::new();
        let mut known: HashMap<(u64, u64), usize> = HashMap::new();
        let mut encoded = Vec::new();
        for map in maps.flat_map(Maps::all) {
            if image_of.contains_key(&map.files) {
                continue;
            }
            let what = what(map);
            let name = map.files[1].to_string_lossy();
            let image = match folder.open_dispensable(&what, &map.files, tally)? {
                None => {
                    image_files::missing(&what, &name, folder, tally)?;
                    None
                }
                Some(file) => Some(match known.entry(file.id) {
                    Entry::Occupied(image) => *image.get(),
                    Entry::Vacant(image) => {
                        encoded.push(Encoded {
                            bytes: image_files::read(&what, file, progress)?.into(),
                            name: name.into_owned(),
                            what,
                        });
                        *image.insert(encoded.len() - 1)
                    }
                }),
            };
            image_of.insert(&map.files, image);
        }
        let images = images::decode(&encoded, count, progress)?;
        Ok(Self { image_of, images })
    }

    /// The texture in `map`, with the index of its image in [`Self::images`]. `None` if `map` is `None`, because the
    /// material has no such texture, or if the texture's file is missing.
    fn of<'b>(&self, map: &'b Option<Box<Map>>) -> Option<(&'b Map, usize)> {
        let map = map.as_deref()?;
        Some((map, (*self.image_of.get(&map.files)?)?))
    }
}

/// The name of a texture in messages, by its line in the MTL file: `texture in line 12 of its MTL file`.
fn what(map: &Map) -> String {
    format!("texture in {} of its MTL file", map.location)
}

/// Makes an image with roughness in the green channel and metalness in the blue one, as glTF stores them. Their values are
/// read from the red channels of the images `roughness` and `metallic`. For `None` the channel is 255, so that only the
/// material's factor counts. The new image has the size and the name of `like`; the caller ensures that the other images
/// have this size too.
fn combine(like: &Image, roughness: Option<&Image>, metallic: Option<&Image>) -> Image {
    let red = |image: Option<&Image>, i: usize| image.map_or(255, |image| image.texels[i][0]);
    let texel = |i| [255, red(roughness, i), red(metallic, i), 255];
    Image {
        texels: (0..like.texels.len()).map(texel).collect(),
        ..like.clone()
    }
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

//! Loads the textures of MTL materials.

use super::mtl::{Map, Maps};
use crate::scene::load::Options;
use crate::scene::notices::Tally;
use crate::scene::progress::Progress;
use crate::scene::texture::{Image, Texture, Wrap};
use crate::scene::{Scene, images};
use crate::{Error, Result};
use glam::{Affine2, Mat2, Vec2};
use std::collections::HashMap;
use std::path::Path;

/// Loads the textures of a scene's materials, of which `maps` has one entry each.
///
/// # Errors
/// An image that cannot be read or, unless `options` permit it, is missing; textures of roughness and metalness that
/// cannot be put together.
pub fn load(
    scene: &mut Scene,
    maps: &[Maps],
    folder: &Path,
    options: Options,
    progress: &mut Progress<'_>,
    tally: &mut Tally,
) -> Result<()> {
    // The images of files; none where a file is missing.
    let mut read: HashMap<&str, Option<Image>> = HashMap::new();
    let all = maps.iter().flat_map(Maps::all);
    for map in all {
        if read.contains_key(map.file.as_str()) {
            continue;
        }
        let what = format!("texture in {} of its MTL file", map.place);
        let found = match images::read_file(&what, &map.file, folder, progress)? {
            Some(bytes) => Some(images::decode(&what, &map.file, &bytes)?),
            None => {
                images::missing(&what, Some(&map.file), options, tally)?;
                None
            }
        };
        read.insert(&map.file, found);
    }
    let images = &mut scene.images;
    // Indices in the scene, by what an image is for and the files that it is made of.
    let mut places: HashMap<(&str, [&str; 2]), u32> = HashMap::new();
    let mut place = |what, files, make: &dyn Fn() -> Image| {
        *places.entry((what, files)).or_insert_with(|| {
            images.push(make());
            images.len() as u32 - 1
        })
    };
    for (material, maps) in scene.materials.iter_mut().zip(maps) {
        for (map, slot) in [
            (&maps.base_color, &mut material.base_color_texture),
            (&maps.emission, &mut material.emissive_texture),
            (&maps.normal, &mut material.normal_texture),
        ] {
            if let Some((map, image)) = found(&read, map) {
                let index = place("one file", [&map.file, ""], &|| image.clone());
                *slot = Some(texture(map, index));
            }
        }
        let (roughness, metallic) = (found(&read, &maps.roughness), found(&read, &maps.metallic));
        let Some((map, like)) = roughness.or(metallic) else {
            continue;
        };
        if let (Some((a, first)), Some((b, second))) = (roughness, metallic)
            && (a.transform, a.clamp, first.width, first.height)
                != (b.transform, b.clamp, second.width, second.height)
        {
            return Err(Error::input(format!(
                "map_Pr in {} and map_Pm in {} of the MTL file differ in size, scale, offset or clamp; give both the same",
                a.place, b.place
            )));
        }
        let files = [roughness, metallic].map(|found| found.map_or("", |(map, _)| &map.file));
        let [roughness, metallic] =
            [roughness, metallic].map(|found| found.map(|(_, image)| image));
        let index = place("surface", files, &|| combine(like, roughness, metallic));
        material.metallic_roughness_texture = Some(texture(map, index));
    }
    Ok(())
}

/// A texture with its image, unless the image is missing.
fn found<'a>(
    read: &'a HashMap<&str, Option<Image>>,
    map: &'a Option<Map>,
) -> Option<(&'a Map, &'a Image)> {
    let map = map.as_ref()?;
    Some((map, read[map.file.as_str()].as_ref()?))
}

/// An image of the size of `like` with roughness in green and metalness in blue, as glTF has it.
fn combine(like: &Image, roughness: Option<&Image>, metallic: Option<&Image>) -> Image {
    let red = |image: Option<&Image>, i: usize| image.map_or(255, |image| image.texels[i][0]);
    let texel = |i| [255, red(roughness, i), red(metallic, i), 255];
    Image {
        texels: (0..like.texels.len()).map(texel).collect(),
        ..like.clone()
    }
}

/// In OBJ, v points up; here, down.
fn texture(map: &Map, image: u32) -> Texture {
    let flip = Affine2::from_mat2_translation(Mat2::from_diagonal(Vec2::new(1.0, -1.0)), Vec2::Y);
    let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
    Texture {
        transform: flip * map.transform * flip,
        wrap: [wrap; 2],
        ..Texture::plain(image)
    }
}

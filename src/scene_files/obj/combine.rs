//! Makes images of a scene from several images of MTL textures, which state roughness and metalness, or colour and opacity,
//! in files of their own.

use crate::base::memory;
use crate::scene::texture::{Image, Texture, Wrap, linear};
use crate::scene_files::images::BYTES;
use crate::{Error, Result};
use glam::Vec2;
use std::borrow::Cow;

/// Makes an image with roughness in the green channel and metalness in the blue one, as glTF stores them. Their values are
/// read from the red channels of the images `roughness` and `metallic`. Without one of them, its channel has the largest
/// value, so that only the material's factor counts. The new image has the size and the name of the image with more texels.
pub fn surface(roughness: Option<&Image>, metallic: Option<&Image>) -> Result<Image> {
    let larger = [roughness, metallic].into_iter().flatten();
    let Some(like) = larger.max_by_key(|image| count(image)) else {
        return Err(Error::input(
            "a texture of roughness or metalness is needed",
        ));
    };
    let [roughness, metallic] = [roughness, metallic].map(|image| Some(resized(image?, like)));
    let sources = [roughness.transpose()?, metallic.transpose()?];
    let red = |image: &Option<Cow<'_, Image>>, i: usize| {
        image.as_ref().map_or(u16::MAX, |image| image.texel(i)[0])
    };
    let texel = |i| [u16::MAX, red(&sources[0], i), red(&sources[1], i), u16::MAX];
    let is_deep = sources.iter().flatten().any(|image| image.is_deep());
    Ok(image_of(like, is_deep, texel))
}

/// Makes an image with the colours of `color`, or white for `None`, and with the opacity of `opacity` as alpha. It has the
/// size and the name of `color`, or of `opacity` without a colour.
pub fn with_opacity(color: Option<&Image>, opacity: &Image) -> Result<Image> {
    let like = color.unwrap_or(opacity);
    let alpha = match has_alpha(opacity) {
        true => 3,
        false => 0,
    };
    let opacity = resized(opacity, like)?;
    let texel = |i: usize| {
        let [r, g, b, _] = color.map_or([u16::MAX; 4], |color| color.texel(i));
        [r, g, b, opacity.texel(i)[alpha]]
    };
    let is_deep = opacity.is_deep() || color.is_some_and(Image::is_deep);
    Ok(image_of(like, is_deep, texel))
}

/// The number of texels of an image.
fn count(image: &Image) -> usize {
    image.width as usize * image.height as usize
}

/// An image with the size and the name of `like`, and with the texels that `texel` returns for their indices. If `is_deep` is
/// true, it has 16 bits per channel, otherwise the upper 8 of them.
fn image_of(like: &Image, is_deep: bool, texel: impl Fn(usize) -> [u16; 4]) -> Image {
    let entries = (0..count(like)).map(|i| Image::entries(texel(i)));
    Image {
        texels: match is_deep {
            true => entries.flatten().collect(),
            false => entries.map(|[high, _]| high).collect(),
        },
        ..like.clone()
    }
}

/// True if some texel of the image is not opaque.
pub fn has_alpha(image: &Image) -> bool {
    (0..count(image)).any(|i| image.texel(i)[3] != u16::MAX)
}

/// True if the image is a normal map in tangent space, and not a height map: if three quarters of its texels are not grey and
/// are vectors of nearly unit length that point away from the surface.
pub fn is_normal_map(image: &Image) -> bool {
    let is_normal = |index: &usize| {
        let texel = image.texel(*index);
        let [r, g, b, _] = texel;
        let normal = linear(texel).truncate() * 2.0 - 1.0;
        let is_grey = r.abs_diff(g).max(g.abs_diff(b)) <= 4 * 257;
        !is_grey && normal.z >= 0.0 && (0.8..=1.2).contains(&normal.length())
    };
    let normals = (0..count(image)).filter(is_normal).count();
    4 * normals >= 3 * count(image)
}

/// The image with the size of `like`, by interpolation between its texels. Fails if there is not enough memory.
fn resized<'a>(image: &'a Image, like: &Image) -> Result<Cow<'a, Image>> {
    let size = |image: &Image| (image.width, image.height);
    if size(image) == size(like) {
        return Ok(Cow::Borrowed(image));
    }
    let entries = if image.is_deep() { 2 } else { 1 };
    memory::check(BYTES * entries * count(like) as u64)
        .map_err(|cause| Error::input(format!("image {:?}: {cause}; scale it", image.name)))?;
    let whole = Texture {
        wrap: [Wrap::Clamp; 2],
        ..Texture::plain(0)
    };
    let texel = |i: usize| {
        let (x, y) = (i as u32 % like.width, i as u32 / like.width);
        let center = Vec2::new(x as f32, y as f32) + 0.5;
        let uv = center / Vec2::new(like.width as f32, like.height as f32);
        let value = whole.at(image, uv, linear).to_array();
        value.map(|channel| match image.is_deep() {
            true => (channel * 65535.0).round() as u16,
            false => 257 * (channel * 255.0).round() as u16,
        })
    };
    Ok(Cow::Owned(Image {
        name: image.name.clone(),
        ..image_of(like, image.is_deep(), texel)
    }))
}

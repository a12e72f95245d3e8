//! Textures: images that vary a material over a surface, and their mapping to the surface.

use glam::{Affine2, Vec2, Vec4};
use std::sync::Arc;

/// An RGBA image with 8 or 16 bits per channel, which one or more textures of materials use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The image's name in messages: the name of its file or, if the image is part of the scene's file, the name that it has
    /// there.
    pub name: String,
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// RGBA texels, row by row from the top, which is at v = 0. In an image with 16 bits per channel, a texel has two
    /// entries: the high bytes of its channels, then the low bytes. The texels are in an `Arc`, so that copies of a scene
    /// share them.
    pub texels: Arc<[[u8; 4]]>,
}

impl Image {
    /// The entries of [`Image::texels`] for one texel with 16 bits per channel.
    pub fn entries(texel: [u16; 4]) -> [[u8; 4]; 2] {
        [
            texel.map(|value| (value >> 8) as u8),
            texel.map(|value| value as u8),
        ]
    }

    /// True if the image has 16 bits per channel. Shaders then read two entries per texel.
    pub fn is_deep(&self) -> bool {
        self.texels.len() as u64 > u64::from(self.width) * u64::from(self.height)
    }

    /// The number of entries of [`Image::texels`] in one row of the image.
    pub fn row_length(&self) -> u32 {
        self.width * if self.is_deep() { 2 } else { 1 }
    }

    /// The texel with the index `index`, counted row by row, in 16 bits per channel. An 8-bit value v becomes 257 · v, which
    /// is the same fraction of the largest value.
    pub fn texel(&self, index: usize) -> [u16; 4] {
        let [high, low] = match self.is_deep() {
            true => [self.texels[2 * index], self.texels[2 * index + 1]],
            false => [self.texels[index]; 2],
        };
        std::array::from_fn(|channel| u16::from_be_bytes([high[channel], low[channel]]))
    }
}

/// The rule by which a lookup outside of an image finds a texel, along one axis. A lookup is outside if its texture
/// coordinate on this axis is below 0 or above 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image repeats without mirroring, so only the fractional part of the coordinate counts.
    #[default]
    Repeat,
    /// The image repeats, and every second repetition is mirrored.
    Mirror,
    /// A lookup beyond an edge reads the texel at that edge.
    Clamp,
}

/// A use of an image by a material: the set and the transform of texture coordinates, and the way in which a lookup reads
/// texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Index into [`Scene::images`](super::Scene::images): the image that the texture reads.
    pub image: u32,
    /// The set of texture coordinates, 0 or 1: index into [`Mesh::uvs`](super::Mesh::uvs).
    pub set: u32,
    /// The transform from the mesh's texture coordinates to those of the image, in which the image covers [0, 1] along both
    /// axes.
    pub transform: Affine2,
    /// The rules by which lookups beyond the image's edges find a texel: first along u, then along v.
    pub wrap: [Wrap; 2],
    /// True if a lookup returns the nearest texel; false if it interpolates between the four nearest ones.
    pub nearest: bool,
}

impl Texture {
    /// The simplest texture with the image at the index `image` in [`Scene::images`](super::Scene::images), for tests. It is
    /// repeated and interpolated, and uses the first set of texture coordinates without a transform.
    pub fn plain(image: u32) -> Self {
        Self {
            image,
            set: 0,
            transform: Affine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
            nearest: false,
        }
    }

    /// The texture's value at the mesh's texture coordinates `uv`, each channel in [0, 1], for computations on the CPU, such
    /// as the powers of textured lights. `image` must be the image that [`Texture::image`] names. `decode` converts each
    /// texel before interpolation: [`linear`] or [`srgb`].
    pub fn at(&self, image: &Image, uv: Vec2, decode: fn([u16; 4]) -> Vec4) -> Vec4 {
        let size = Vec2::new(image.width as f32, image.height as f32);
        let position = self.transform.transform_point2(uv) * size;
        // Huge coordinates can become infinities and NaN.
        let position = if position.is_finite() {
            position
        } else {
            Vec2::ZERO
        };
        if self.nearest {
            return decode(self.texel(image, position.x.floor() as i64, position.y.floor() as i64));
        }
        // Centres of texels are at halves.
        let position = position - 0.5;
        let (corner, part) = (position.floor(), position - position.floor());
        let (x, y) = (corner.x as i64, corner.y as i64);
        let texel = |dx, dy| decode(self.texel(image, x.saturating_add(dx), y.saturating_add(dy)));
        let top = texel(0, 0).lerp(texel(1, 0), part.x);
        let bottom = texel(0, 1).lerp(texel(1, 1), part.x);
        top.lerp(bottom, part.y)
    }

    fn texel(&self, image: &Image, x: i64, y: i64) -> [u16; 4] {
        let x = wrapped(self.wrap[0], x, image.width);
        let y = wrapped(self.wrap[1], y, image.height);
        image.texel(y as usize * image.width as usize + x as usize)
    }
}

/// The index, along one axis, of the texel that a lookup at the index `i` reads; `i` may be beyond the image.
/// `wrap` maps `i` into the image of `size` texels, so the result is at least 0 and less than `size`.
fn wrapped(wrap: Wrap, i: i64, size: u32) -> u32 {
    let size = i64::from(size);
    let index = match wrap {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::Mirror => {
            let i = i.rem_euclid(2 * size);
            i.min(2 * size - 1 - i)
        }
        Wrap::Clamp => i.clamp(0, size - 1),
    };
    index as u32
}

/// The parts of an image that are not black, in blocks of 8 × 8 texels. They decide which triangles with this image as
/// emissive texture are lights.
pub struct LitTexels {
    size: [u32; 2],
    /// The number of blocks, of 8 × 8 texels each, that cover the width of the image. It gives the length of
    /// a row in `lit_before`.
    columns: usize,
    /// A summed-area table over the blocks, with one entry per corner of a block, in rows of `columns` + 1 entries. Each
    /// entry is the number of lit blocks (with a texel that is not black) above and left of its corner. Four entries thus
    /// give the number of lit blocks in any rectangle of blocks.
    lit_before: Vec<u32>,
}

/// The number of texels along each side of a block of [`LitTexels`], which stores for each block only whether all its texels
/// are black. Larger blocks need less memory, but fewer black triangles are then recognised as black.
const BLOCK: u32 = 8;

impl LitTexels {
    /// Finds the lit blocks of an image: those with a texel whose red, green or blue is not 0. They show later whether a
    /// triangle that uses the image as its emissive texture may emit light.
    pub fn of(image: &Image) -> Self {
        let columns = image.width.div_ceil(BLOCK) as usize;
        let row_length = image.row_length() as usize;
        let block_length = row_length / image.width as usize * BLOCK as usize;
        let mut lit_before = vec![0; columns + 1];
        for texels in image.texels.chunks(row_length * BLOCK as usize) {
            let mut lit = vec![false; columns];
            for row in texels.chunks(row_length) {
                for (lit, texels) in lit.iter_mut().zip(row.chunks(block_length)) {
                    *lit = *lit || texels.iter().any(|texel| texel[..3] != [0; 3]);
                }
            }
            let mut in_row = 0;
            lit_before.push(0);
            for lit in lit {
                in_row += u32::from(lit);
                lit_before.push(in_row + lit_before[lit_before.len() - columns - 1]);
            }
        }
        Self {
            size: [image.width, image.height],
            columns,
            lit_before,
        }
    }

    /// True if a lookup with `texture`, which must use this image, may find a colour other than black at some point of a
    /// triangle. `uvs` are the texture coordinates of the triangle's corners. False means that the texture is certainly
    /// black on the whole triangle, which is then not a light.
    pub fn may_be_seen(&self, texture: &Texture, uvs: [Vec2; 3]) -> bool {
        let size = Vec2::from(self.size.map(|side| side as f32));
        let transform = &texture.transform;
        let positions = uvs.map(|uv| transform.transform_point2(uv) * size);
        if positions.iter().any(|position| !position.is_finite()) {
            return true;
        }
        let matrix = transform.matrix2;
        let terms = uvs.map(|uv| {
            let products = matrix.x_axis.abs() * uv.x.abs() + matrix.y_axis.abs() * uv.y.abs();
            (products + transform.translation.abs()) * size
        });
        // The margin allows for the neighbours that a lookup interpolates, and for different rounding in
        // shaders.
        let margin = 2.0 + 1e-5 * (terms[0] + terms[1] + terms[2]);
        let low = positions[0].min(positions[1]).min(positions[2]) - margin;
        let high = positions[0].max(positions[1]).max(positions[2]) + margin;
        let [columns, rows] =
            [0, 1].map(|axis| self.spans(texture.wrap[axis], axis, low[axis], high[axis]));
        (rows.iter()).any(|rows| columns.iter().any(|columns| self.has_lit(*columns, *rows)))
    }

    /// True if any block in the columns `left` to `right` and the rows `top` to `bottom` of blocks is lit, which means that
    /// a texel of it is not black. Both ends are included.
    fn has_lit(&self, [left, right]: [usize; 2], [top, bottom]: [usize; 2]) -> bool {
        let before = |column: usize, row: usize| self.lit_before[row * (self.columns + 1) + column];
        before(right + 1, bottom + 1) + before(left, top)
            > before(left, bottom + 1) + before(right + 1, top)
    }

    /// The blocks along one axis (0 is u, 1 is v) that lookups at texel indices from `low` to `high` may read. Each entry is
    /// a range of blocks: the indices of its first and its last block, both included. There can be several ranges, because
    /// `wrap` maps indices beyond the image into it.
    fn spans(&self, wrap: Wrap, axis: usize, low: f32, high: f32) -> Vec<[usize; 2]> {
        let size = i64::from(self.size[axis]);
        let last = size - 1;
        let blocks =
            |[low, high]: [i64; 2]| [low, high].map(|texel| (texel / i64::from(BLOCK)) as usize);
        // Far beyond any image, and their products are still integers.
        let [low, high] = [low, high].map(|index| index.clamp(-1e18, 1e18) as i64);
        if wrap == Wrap::Clamp {
            return vec![blocks([low.clamp(0, last), high.clamp(0, last)])];
        }
        if high - low >= 2 * size {
            return vec![blocks([0, last])];
        }
        // The indices from low to high lie in three copies of the image at most.
        let copies = low.div_euclid(size)..=high.div_euclid(size);
        let spans = copies.map(|copy| {
            let within = [low, high].map(|index| (index - copy * size).clamp(0, last));
            match wrap == Wrap::Mirror && copy % 2 != 0 {
                true => blocks([last - within[1], last - within[0]]),
                false => blocks(within),
            }
        });
        spans.collect()
    }
}

/// Decodes a texel of data (normals, metalness, roughness) for [`Texture::at`]: divides each 16-bit channel by 65535, so that
/// it is in [0, 1].
pub fn linear(texel: [u16; 4]) -> Vec4 {
    Vec4::from_array(texel.map(f32::from)) / 65535.0
}

/// Decodes a texel of colour for [`Texture::at`] to channels in [0, 1]. Red, green and blue are converted
/// from sRGB to linear; alpha is linear already.
pub fn srgb(texel: [u16; 4]) -> Vec4 {
    let [r, g, b, a] = linear(texel).to_array();
    Vec4::new(decode_srgb(r), decode_srgb(g), decode_srgb(b), a)
}

/// The linear value in [0, 1] of an sRGB value in [0, 1] (IEC 61966-2-1), with which [`srgb`] decodes each
/// colour channel.
pub(crate) fn decode_srgb(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image of two by two texels: black and red in the top row, green and white in the bottom row.
    fn image() -> Image {
        let texels = [[0, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [255; 4]];
        Image {
            name: String::new(),
            width: 2,
            height: 2,
            texels: texels.into(),
        }
    }

    fn red(texture: Texture, u: f32, v: f32) -> f32 {
        texture.at(&image(), Vec2::new(u, v), linear).x
    }

    #[test]
    fn centres_are_texels_and_between_them_is_a_mixture() {
        let texture = Texture::plain(0);
        let at = |u, v| texture.at(&image(), Vec2::new(u, v), linear);
        assert_eq!(at(0.25, 0.25), Vec4::new(0.0, 0.0, 0.0, 1.0));
        assert_eq!(at(0.75, 0.25), Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(at(0.25, 0.75), Vec4::new(0.0, 1.0, 0.0, 1.0));
        assert_eq!(at(0.5, 0.5), Vec4::new(0.5, 0.5, 0.25, 1.0));
    }

    #[test]
    fn sixteen_bits_are_read_whole() {
        let texels = [[0x1234, 0x00FF, 0, u16::MAX], [0, 1, 2, 3]];
        let deep = Image {
            width: 1,
            texels: texels.into_iter().flat_map(Image::entries).collect(),
            ..image()
        };
        assert!(deep.is_deep() && !image().is_deep());
        assert_eq!([deep.row_length(), image().row_length()], [2, 2]);
        assert_eq!([deep.texel(0), deep.texel(1)], texels);
        assert_eq!(image().texel(1), [u16::MAX, 0, 0, u16::MAX]);
        let seen = Texture::plain(0).at(&deep, Vec2::new(0.0, 0.25), linear);
        assert_eq!(seen * 65535.0, Vec4::new(4660.0, 255.0, 0.0, 65535.0));
    }

    /// The low byte of a single texel is all that is not black.
    #[test]
    fn the_least_of_sixteen_bits_is_lit() {
        let texel = |i| {
            if i == 20 {
                [1, 0, 0, u16::MAX]
            } else {
                [0, 0, 0, u16::MAX]
            }
        };
        let deep = Image {
            width: 32,
            height: 1,
            texels: (0..32).map(texel).flat_map(Image::entries).collect(),
            ..image()
        };
        let lit = LitTexels::of(&deep);
        let is_seen = |u: f32| {
            let clamped = Texture {
                wrap: [Wrap::Clamp; 2],
                ..Texture::plain(0)
            };
            lit.may_be_seen(&clamped, [Vec2::splat(u); 3])
        };
        assert!(is_seen(20.5 / 32.0));
        assert!(!is_seen(4.5 / 32.0) && !is_seen(31.5 / 32.0));
    }

    #[test]
    fn edges_repeat_mirror_or_end() {
        let with = |wrap| Texture {
            wrap: [wrap; 2],
            ..Texture::plain(0)
        };
        // Left of the first column, between it and what comes before.
        assert_eq!(red(with(Wrap::Repeat), 0.0, 0.25), 0.5);
        assert_eq!(red(with(Wrap::Mirror), 0.0, 0.25), 0.0);
        assert_eq!(red(with(Wrap::Clamp), 0.0, 0.25), 0.0);
        assert_eq!(red(with(Wrap::Clamp), -7.0, 0.25), 0.0);
        assert_eq!(red(with(Wrap::Repeat), -0.25, 0.25), 1.0);
        assert_eq!(red(with(Wrap::Mirror), -0.75, 0.25), 1.0);
        assert_eq!(red(with(Wrap::Mirror), 1.25, 0.25), 1.0);
        assert_eq!(red(with(Wrap::Repeat), 1.25, 0.25), 0.0);
        let nearest = Texture {
            nearest: true,
            ..Texture::plain(0)
        };
        assert_eq!(red(nearest, 0.49, 0.25), 0.0);
        assert_eq!(red(nearest, 0.51, 0.25), 1.0);
    }

    /// A triangle that [`LitTexels::may_be_seen`] reports as black is black at many random points. Most black triangles are
    /// reported as black.
    #[test]
    fn what_is_black_all_over_a_triangle_is_known() {
        // A linear congruential generator (Numerical Recipes).
        let mut state = 1_u32;
        let mut unit = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let (width, height) = (96, 40);
        let lit = [(17, 5), (95, 39), (40, 20)];
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texels = texels.map(|texel| match lit.contains(&texel) {
            true => [0, 1, 0, 255],
            false => [0, 0, 0, 255],
        });
        let image = Image {
            name: String::new(),
            width,
            height,
            texels: texels.collect(),
        };
        let blocks = LitTexels::of(&image);
        let (mut known, mut unknown) = (0, 0);
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for round in 0..3000 {
                let side = [0.05, 0.2, 1.0][round % 3];
                let transform = Affine2::from_scale_angle_translation(
                    Vec2::new(1.0 + unit(), 0.5 + unit()),
                    unit() - 0.5,
                    Vec2::new(unit(), unit()) - 0.5,
                );
                let texture = Texture {
                    transform,
                    wrap: [wrap; 2],
                    nearest: unit() < 0.5,
                    ..Texture::plain(0)
                };
                let corner = Vec2::new(unit(), unit()) * 4.0 - 1.5;
                let mut beside = || corner + side * (Vec2::new(unit(), unit()) - 0.5);
                let uvs = [corner, beside(), beside()];
                let mut brightest = 0.0_f32;
                for _ in 0..400 {
                    let (x, y) = (unit(), unit());
                    let (x, y) = if x + y > 1.0 {
                        (1.0 - x, 1.0 - y)
                    } else {
                        (x, y)
                    };
                    let uv = uvs[0] + x * (uvs[1] - uvs[0]) + y * (uvs[2] - uvs[0]);
                    brightest = brightest.max(texture.at(&image, uv, linear).y);
                }
                if !blocks.may_be_seen(&texture, uvs) {
                    assert_eq!(brightest, 0.0, "{texture:?} {uvs:?}");
                    known += 1;
                } else if brightest == 0.0 {
                    unknown += 1;
                }
            }
        }
        assert!(known > 2 * unknown && known > 2000, "{known} {unknown}");
        let nowhere = [Vec2::ZERO, Vec2::X, Vec2::new(f32::INFINITY, 0.0)];
        assert!(blocks.may_be_seen(&Texture::plain(0), nowhere));
        let far = [Vec2::splat(1e30), Vec2::splat(-1e30), Vec2::ZERO];
        assert!(blocks.may_be_seen(&Texture::plain(0), far));
    }

    #[test]
    fn colours_are_decoded_before_they_are_mixed() {
        let srgb_of = |bytes: [u8; 4]| srgb(bytes.map(|byte| 257 * u16::from(byte)));
        assert!((srgb_of([188, 0, 0, 128]).x - 0.5029).abs() < 1e-3);
        assert!((srgb_of([10, 0, 0, 128]).x - 10.0 / 255.0 / 12.92).abs() < 1e-9);
        assert_eq!(srgb_of([0, 255, 0, 51]), Vec4::new(0.0, 1.0, 0.0, 0.2));
        assert!((srgb([0x8040, 0, 0, 0]).x - 0.21495).abs() < 1e-5);
    }
}

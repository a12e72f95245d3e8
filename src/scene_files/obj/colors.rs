//! Vertex colours of OBJ files: three or four numbers behind the position of a vertex, as MeshLab and scanners write them.

use super::Reader;
use super::lines::Line;
use super::mtl::Maps;
use crate::scene::texture::decode_srgb;
use crate::scene::{Material, Mesh};
use glam::{Vec3, Vec4};

/// The largest value of a colour in a file that states colours from 0 to 255.
const BYTE: f32 = 255.0;

/// The vertex colours of a file, sRGB as the file states them. They are converted after the last vertex is read, because
/// only then is it known whether the file states colours from 0 to 1 or from 0 to 255.
#[derive(Default)]
pub struct VertexColors {
    /// One entry for each position up to the last one with a colour; NaN where a position has none. The component w is alpha,
    /// NaN where the file states none.
    stated: Vec<Vec4>,
    is_above_one: bool,
    has_fraction: bool,
}

impl VertexColors {
    /// Reads the colour of a vertex, if the statement has one; `position` is the index of its position. Returns false, and
    /// reads no colour, if the words behind the position are no numbers.
    pub fn read(&mut self, line: &Line, position: usize) -> bool {
        let mut words = line.words().skip(3);
        let Some(first) = words.next() else {
            return true;
        };
        let mut color = Vec4::NAN;
        let mut count = 0;
        for word in std::iter::once(first).chain(words).take(4) {
            match word.parse::<f32>() {
                Ok(number) if number.is_finite() => color[count] = number,
                _ => return false,
            }
            count += 1;
        }
        // One number is the weight of a curve's control point; two have no meaning.
        if count >= 3 {
            let numbers = &color.to_array()[..count];
            self.is_above_one |= numbers.iter().any(|n| *n > 1.0);
            self.has_fraction |= numbers.iter().any(|n| n.fract() != 0.0);
            self.stated.resize(position, Vec4::NAN);
            self.stated.push(color);
        }
        true
    }

    /// The colour of the position with this index, as the file states it.
    pub fn of(&self, position: u32) -> Option<Vec4> {
        let color = self.stated.get(position as usize).copied();
        color.filter(|color| !color.x.is_nan())
    }

    /// True if the file states colours from 0 to 255: all are whole numbers, and some are above 1.
    pub fn are_bytes(&self) -> bool {
        self.is_above_one && !self.has_fraction
    }

    /// Converts the colours of a mesh from those that the file states to linear ones. NaN becomes white, or the alpha 1.
    pub fn convert(&self, colors: &mut [Vec4]) {
        let scale = if self.are_bytes() { BYTE } else { 1.0 };
        for color in colors {
            let [r, g, b, alpha] = (*color / scale).to_array();
            let rgb = match r.is_nan() {
                true => Vec3::ONE,
                // Validation clamps what is finite.
                false => Vec3::new(decode_srgb(r), decode_srgb(g), decode_srgb(b)).min(Vec3::MAX),
            };
            *color = rgb.extend(if alpha.is_nan() { 1.0 } else { alpha });
        }
    }
}

impl Reader<'_> {
    /// Converts the vertex colours of all meshes to linear ones. In meshes with colours, faces without a material take a
    /// white one instead of the grey one, so that their colours are those of the file.
    pub(super) fn finish_colors(&mut self) {
        if self.attributes.colors.are_bytes() {
            let what = "vertex colours are divided by 255";
            let why = || "all are whole numbers, and some are above 1".to_owned();
            self.ignored.tally.add(what, why);
        }
        for mesh in &mut self.scene.meshes {
            self.attributes.colors.convert(&mut mesh.colors);
        }
        let Some(grey) = self.grey else {
            return;
        };
        let of_grey = |mesh: &Mesh| mesh.parts.iter().any(|part| part.material == grey);
        let (colored, plain): (Vec<_>, Vec<_>) = (self.scene.meshes.iter_mut())
            .filter(|mesh| of_grey(mesh))
            .partition(|mesh| !mesh.colors.is_empty());
        if colored.is_empty() {
            return;
        }
        let what = "faces without a material but with vertex colours are given one";
        let white = || "white Lambert".to_owned();
        self.ignored.tally.add(what, white);
        if plain.is_empty() {
            self.grey = None;
            self.scene.materials[grey as usize].base_color = Vec3::ONE;
            return;
        }
        let white = self.scene.materials.len() as u32;
        self.scene.materials.push(Material::lambert("", Vec3::ONE));
        self.maps.push(Maps::default());
        for part in colored.into_iter().flat_map(|mesh| &mut mesh.parts) {
            if part.material == grey {
                part.material = white;
            }
        }
    }
}

//! Reads the image-based light of a glTF file (`EXT_lights_image_based`) as an environment. The file has a cube map, blurred
//! for several roughnesses, and coefficients of the irradiance. Both follow from the sharpest level of the cube map, which
//! alone is read: a path tracer blurs it by itself.

use super::accessors::{Accessors, get};
use super::nodes::is_rotation;
use super::{damaged, out_of_range, textures};
use crate::scene::environment::{Environment, direction};
use crate::scene::notices::{Tally, label};
use crate::scene::texture::{Image, srgb};
use crate::scene_files::progress::Progress;
use crate::scene_files::scene_folder::SceneFolder;
use crate::{Error, Result};
use glam::{DQuat, DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The largest number of texels along a side of a cube's face of which an environment keeps each. The environment of a larger
/// cube has as many texels as that of this one.
const LARGEST_SIDE: u32 = 2048;

/// The smallest alpha by which a colour is divided, so that a texel with alpha 0 has a finite radiance. It is the smallest
/// step of 8 bits.
const LEAST_DIVISOR: f32 = 1.0 / 255.0;

/// The number of points along each side of a texel of the environment, whose mean it stores.
const POINTS: u32 = 2;

/// The environment that the file's scene has by `EXT_lights_image_based`; `None` if it has none, or if an image of it is missing
/// and the user permits this. Notices in `tally` name what is left out. Fails if an index, a number or an image is wrong.
pub fn read(
    accessors: &Accessors<'_>,
    folder: &SceneFolder<'_>,
    progress: &mut Progress<'_>,
    tally: &mut Tally,
) -> Result<Option<Environment>> {
    let document = accessors.document;
    let shown = get(&document.scenes, document.scene.unwrap_or(0));
    let Some(used) = shown.and_then(|scene| scene.extensions.image_based.as_ref()) else {
        return Ok(None);
    };
    let lights = &document.extensions.image_based.lights;
    let Some(light) = get(lights, used.light) else {
        let kind = "image-based light";
        return Err(out_of_range("the scene", kind, used.light, lights.len()));
    };
    let what = label("image-based light", used.light as usize, &light.name);
    let Some(faces) = light
        .specular_images
        .first()
        .filter(|faces| faces.len() == 6)
    else {
        return Err(damaged(format!(
            "{what}: the first level of its specularImages does not have 6 faces"
        )));
    };
    let rotation = DQuat::from_array(light.rotation);
    if !is_rotation(rotation) {
        return Err(damaged(format!(
            "{what}: its rotation is not a unit quaternion"
        )));
    }
    if !(0.0..=f32::MAX).contains(&light.intensity) {
        return Err(Error::input(format!(
            "{what}: its intensity is {}; it must be finite and not negative",
            light.intensity
        )));
    }
    let images = textures::load_images(accessors, &what, faces, folder, progress, tally)?;
    let Some(faces) = images
        .iter()
        .map(Option::as_ref)
        .collect::<Option<Vec<_>>>()
    else {
        let text = "image-based lights without all images of their cube are left out";
        tally.add(text, || what);
        return Ok(None);
    };
    let text =
        "of image-based lights only the sharpest level is used, from which all reflections follow";
    tally.add(text, || what.clone());
    let cube: Vec<Face> = faces.into_iter().map(Face::of).collect();
    let (height, texels) = unfolded(&cube, rotation.normalize());
    Ok(Some(Environment {
        name: what,
        width: 2 * height,
        height,
        texels: texels.into(),
        rotation: 0.0,
        intensity: light.intensity,
    }))
}

/// The radiance of a face of the cube, row by row from the top, as it is seen from the cube's centre.
struct Face {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
}

impl Face {
    /// Decodes an image: sRGB, divided by alpha, which lets colours exceed 1 (RGBD). Images without alpha have an alpha of 1.
    fn of(image: &Image) -> Self {
        let (width, height) = (image.width as usize, image.height as usize);
        let texels = (0..width * height).map(|index| {
            let texel = srgb(image.texel(index));
            texel.truncate() / texel.w.max(LEAST_DIVISOR)
        });
        Self {
            width,
            height,
            texels: texels.collect(),
        }
    }

    /// The radiance at a point of the face, in [0, 1] from the left and from the top, interpolated between the centres of
    /// texels.
    fn at(&self, point: DVec2) -> Vec3 {
        let last = DVec2::new((self.width - 1) as f64, (self.height - 1) as f64);
        let at = (point * (last + 1.0) - 0.5).clamp(DVec2::ZERO, last);
        let part = at.fract().as_vec2();
        let [x, y] = [at.x as usize, at.y as usize];
        let [right, below] = [(x + 1).min(self.width - 1), (y + 1).min(self.height - 1)];
        let texel = |x: usize, y: usize| self.texels[y * self.width + x];
        let upper = texel(x, y).lerp(texel(right, y), part.x);
        let lower = texel(x, below).lerp(texel(right, below), part.x);
        upper.lerp(lower, part.y)
    }
}

/// The face of a cube map that a direction meets, in the order +X, −X, +Y, −Y, +Z, −Z, and the point on it, in [0, 1] from the
/// left and from the top. The extension stores the faces of OpenGL mirrored from left to right, as they are seen from the
/// centre in glTF's right-handed space.
fn face_at(toward: DVec3) -> (usize, DVec2) {
    let size = toward.abs();
    let DVec3 { x, y, z } = toward;
    // The coordinates s and t of OpenGL (Vulkan 1.3 specification, cube map face selection), times `along`.
    let (face, s, t, along) = if size.x >= size.y && size.x >= size.z {
        if x > 0.0 {
            (0, -z, -y, x)
        } else {
            (1, z, -y, -x)
        }
    } else if size.y >= size.z {
        if y > 0.0 {
            (2, x, z, y)
        } else {
            (3, x, -z, -y)
        }
    } else if z > 0.0 {
        (4, x, -y, z)
    } else {
        (5, -x, -y, -z)
    };
    (face, DVec2::new(1.0 - s / along, 1.0 + t / along) / 2.0)
}

/// Resamples a cube, rotated by `rotation`, to an image by longitude and latitude. Returns the number of rows, and the texels
/// as [`Environment::texels`] has them, with twice as many columns as rows. At the equator the image is as fine as the cube.
fn unfolded(cube: &[Face], rotation: DQuat) -> (u32, Vec<Vec3>) {
    let sides = cube.iter().flat_map(|face| [face.width, face.height]);
    let side = sides.max().unwrap_or(1).min(LARGEST_SIDE as usize) as u32;
    let height = 2 * side;
    let to_cube = rotation.inverse();
    let radiance = |column: u32, row: u32, point: u32| {
        let part = |index: u32| (f64::from(index) + 0.5) / f64::from(POINTS);
        let x = f64::from(column) + part(point % POINTS);
        let y = f64::from(row) + part(point / POINTS);
        let around = (x / f64::from(2 * height) - 0.5) * TAU;
        let (face, at) = face_at(to_cube * direction(around, y / f64::from(height) * PI));
        cube[face].at(at)
    };
    let texel = |column, row| {
        let points = (0..POINTS * POINTS).map(|point| radiance(column, row, point));
        points.sum::<Vec3>() / (POINTS * POINTS) as f32
    };
    let rows = (0..height).into_par_iter();
    let texels = rows.flat_map_iter(|row| (0..2 * height).map(move |column| texel(column, row)));
    (height, texels.collect())
}

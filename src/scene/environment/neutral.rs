//! A neutral environment, which lights scenes that have no light of their own.

use super::{Environment, direction};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// The width and the height of the image in texels. The radiance changes so slowly that more would show no difference.
const SIZE: (u32, u32) = (64, 32);

/// The direction towards the brightest part: above, in front (+Z) and to the right (+X), where
/// [`framing_camera`](crate::scene::camera::framing_camera) stands, so that the camera sees lit surfaces.
const BRIGHTEST: DVec3 = DVec3::new(0.5, 0.8, 0.6);

impl Environment {
    /// A grey environment without edges: its radiance falls from 1.1 in one direction, above and in front of the scene, to
    /// 0.2 in the opposite one. A white diffuse surface that faces the brightest part has the radiance 0.84, and one that
    /// faces away from it 0.24, so that shapes can be seen, and nothing is brighter than a picture can show.
    pub fn neutral() -> Self {
        let (width, height) = SIZE;
        let brightest = BRIGHTEST.normalize();
        let radiance = |index: u32| {
            let direction = direction_of(index);
            let near = 0.5 + 0.5 * direction.dot(brightest);
            Vec3::splat((0.2 + 0.9 * near * near) as f32)
        };
        Self {
            name: "neutral".to_owned(),
            width,
            height,
            texels: (0..width * height).map(radiance).collect(),
            rotation: 0.0,
            intensity: 1.0,
        }
    }
}

/// The direction of the centre of the texel with the index `index`, counted row by row from the zenith.
fn direction_of(index: u32) -> DVec3 {
    let [x, y] = [index % SIZE.0, index / SIZE.0].map(|i| f64::from(i) + 0.5);
    direction(
        TAU * (x / f64::from(SIZE.0) - 0.5),
        PI * y / f64::from(SIZE.1),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_surfaces_are_within_what_a_picture_shows() {
        let environment = Environment::neutral();
        let radiance_of = |normal: DVec3| -> f64 {
            let texels = environment.texels.iter().enumerate();
            let light = texels.map(|(index, texel)| {
                let solid_angle = environment.solid_angle(index as u32 / SIZE.0);
                f64::from(texel.x) * direction_of(index as u32).dot(normal).max(0.0) * solid_angle
                    / PI
            });
            light.sum()
        };
        let facing = BRIGHTEST.normalize();
        for (normal, expected) in [(facing, 0.8375), (-facing, 0.2375)] {
            let radiance = radiance_of(normal);
            assert!((radiance - expected).abs() < 0.003, "{radiance}");
        }
    }
}

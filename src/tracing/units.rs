//! The units of lengths and of radiance on the device.

use crate::scene::Scene;
use crate::scene::bounds::exponent;
use glam::{DAffine3, DVec3, Vec3};

/// Units of lengths and of radiance, and the origin, in which a scene is uploaded. Both units are powers of two, so that
/// nothing is rounded. In these units the brightest light has a radiance of 1 to 2, and instances are about as large
/// as 1. Otherwise, products such as that of light and area would leave the range of f32 where a scene is both far
/// and dim, or both near and bright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// The point of the world that is at zero on the device, so that f32 is finest around it.
    pub origin: DVec3,
    /// Scene units of a length of 1 on the device.
    pub length: f64,
    /// Radiance of 1 on the device.
    pub radiance: f64,
}

impl Units {
    /// The units that suit a scene, with an origin (usually the camera's position).
    pub fn of(scene: &Scene, origin: DVec3) -> Self {
        let brightest = |lights: f32, emission: Vec3| lights.max(emission.max_element());
        let lights = scene.materials.iter().map(|m| m.emission);
        let changing = scene.motion.iter().flat_map(|motion| &motion.emission);
        let lights = lights.chain(changing.map(|emission| emission.brightest()));
        Self {
            origin,
            length: scene.usual_size(),
            radiance: power_of_two(f64::from(lights.fold(0.0, brightest))),
        }
    }

    /// From the world to the device.
    pub fn to_device(&self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(1.0 / self.length))
            * DAffine3::from_translation(-self.origin)
    }

    /// From the device to the world.
    pub fn to_world(&self) -> DAffine3 {
        DAffine3::from_translation(self.origin) * DAffine3::from_scale(DVec3::splat(self.length))
    }
}

/// The largest power of two that is not above a number; 1 for 0.
fn power_of_two(number: f64) -> f64 {
    if number > 0.0 {
        2.0_f64.powi(exponent(number) as i32)
    } else {
        1.0
    }
}

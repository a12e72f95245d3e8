//! The origin, and the units of length and radiance, in which a scene is stored on the device.

use crate::scene::bounds::{exponent, usual_size};
use crate::scene::{Bounds, Environment, PunctualLight, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// The origin and the units of length and radiance in which a scene is stored on the device. In these units the brightest
/// light has a radiance of 1 to 2, and an instance typically has a size around 1. In units that do not fit the scene,
/// products such as radiance × area could leave the range of f32. Both units are powers of two, so that dividing by them
/// rounds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// The point of the world, in scene units, that becomes zero on the device; it is usually the camera's position. f32 is
    /// most precise around zero.
    pub origin: DVec3,
    /// The device's unit of length: the length, in scene units, that is stored as 1. It is a power of two
    /// near the usual size of the scene's instances, or larger if the scene reaches very far from the origin.
    pub length: f64,
    /// The device's unit of radiance: the radiance, in W/(m²·sr), that is stored as 1. It is a power of two
    /// near the radiance of the brightest light.
    pub radiance: f64,
}

/// Half of the upper limit of absolute coordinates on the device, in the device's unit of length. The unit of
/// length is chosen so large that every coordinate is below the limit, 2⁵¹. Squares of coordinates are then
/// within the range of f32.
const FARTHEST: f64 = (1_u64 << 50) as f64;

impl Units {
    /// Chooses the units for a scene from the usual size of its instances, its extent, and its brightest light at any time.
    /// `origin`, usually the camera's position, is a point of the world in scene units.
    pub fn of(scene: &Scene, origin: DVec3) -> Self {
        let brightest = |lights: f32, emission: Vec3| lights.max(emission.max_element());
        let lights = scene.materials.iter().map(|m| m.emission);
        let changing = scene.motion.iter().flat_map(|motion| &motion.emission);
        let lights = lights.chain(changing.map(|emission| emission.brightest()));
        let brightest = lights.fold(0.0, brightest);
        let environment = scene
            .environment
            .as_ref()
            .map_or(0.0, Environment::brightest);
        let boxes = scene.loose_boxes();
        let all = Bounds::around(boxes.iter().copied());
        let corners = all.iter().flat_map(|all| [all.min, all.max]);
        let near_lights = scene.punctual_lights.iter().filter(|l| !l.is_distant());
        let points = corners.chain(near_lights.map(PunctualLight::position));
        let farthest = points.map(|point| (point - origin).abs().max_element());
        let farthest = power_of_two(farthest.fold(0.0, f64::max));
        // Squares of the largest coordinates must not overflow either.
        let length = usual_size(&boxes).max(farthest / FARTHEST);
        // A punctual light counts with its intensity divided by the square of its distance to the scene's
        // geometry, which counts as at least 1 on the device.
        let punctual = scene
            .punctual_lights
            .iter()
            .enumerate()
            .map(|(index, light)| {
                let moves = (scene.motion.as_ref())
                    .is_some_and(|motion| motion.lights.get(index).is_some_and(Option::is_some));
                let distance = match all {
                    Some(all) if !moves => {
                        let nearest = light.position().clamp(all.min, all.max);
                        (light.position() - nearest).length().max(length)
                    }
                    _ => length,
                };
                let intensity = f64::from(light.intensity.max_element());
                intensity
                    / if light.is_distant() {
                        1.0
                    } else {
                        distance.powi(2)
                    }
            });
        let brightest = punctual.fold(f64::from(brightest.max(environment)), f64::max);
        Self {
            origin,
            length,
            radiance: power_of_two(brightest),
        }
    }

    /// The largest distance from [`Units::origin`] along an axis, in scene units, at which something can be stored on the
    /// device. A pose (state of the scene at one time) with something further away is refused.
    pub fn farthest(&self) -> f64 {
        2.0 * FARTHEST * self.length
    }

    /// The transform of points from the world, in scene units, to the device's world space, in which shaders
    /// compute.
    pub fn to_device(&self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(1.0 / self.length))
            * DAffine3::from_translation(-self.origin)
    }

    /// The transform of points from the device's world space to the world, in scene units; the inverse of
    /// [`Units::to_device`]. Transforms from the current to the previous frame are computed with both.
    pub fn to_world(&self) -> DAffine3 {
        DAffine3::from_translation(self.origin) * DAffine3::from_scale(DVec3::splat(self.length))
    }
}

/// The largest power of two that is not above `number`; 1 if `number` is not positive. The device's units are
/// such powers, so that dividing by them rounds nothing.
pub(super) fn power_of_two(number: f64) -> f64 {
    if number > 0.0 {
        2.0_f64.powi(exponent(number) as i32)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Instance, Mesh};

    #[test]
    fn a_sun_far_from_specks_of_dust_stays_within_range() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::ONE],
            ..Mesh::default()
        };
        let placed = |scale: f64, at: f64| Instance {
            name: String::new(),
            mesh: 0,
            object_to_world: DAffine3::from_translation(DVec3::X * at)
                * DAffine3::from_scale(DVec3::splat(scale)),
        };
        let mut scene = Scene {
            meshes: vec![mesh],
            instances: vec![placed(1e-6, 0.0); 100],
            ..Scene::default()
        };
        let dust = Units::of(&scene, DVec3::ZERO);
        assert_eq!(dust.length, 2_f64.powi(-20));
        assert!((1e9..1e15).contains(&dust.farthest()));
        scene.instances.push(placed(1e9, 1e15));
        let with_sun = Units::of(&scene, DVec3::ZERO);
        assert!(with_sun.farthest() > 1e15 && with_sun.length < 1.0);
    }
}

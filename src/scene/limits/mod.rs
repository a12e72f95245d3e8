//! Limits that a scene comes near. What holds within them, and which test says so: `tests/LIMITS.md`.

mod close_lights;
mod overlaps;

use super::lights::{self, LightTriangle, light_triangles};
use super::validate::{BRIGHTEST, LARGEST_COORDINATE, SMALLEST_SCENE};
use super::{PunctualShape, Scene};
pub use close_lights::{COARSE_LIGHT, CloseLight, SMALLEST_HEIGHT};
use std::collections::HashMap;

/// A scene comes near a limit if a quantity that is this many times larger, or smaller, passes it.
const NEAR: f64 = 1e3;

/// The largest ratio of the powers of two lamps that is tested.
const CONTRAST: f64 = 1e9;

/// The smallest half angle of a spot that is tested, in radians.
const NARROWEST: f64 = 1e-5;

impl Scene {
    /// The limits that a valid scene comes near or passes: each a line that says what, where, and what it means.
    pub fn limits(&self) -> Vec<String> {
        let mut found = Vec::new();
        if let Some(bounds) = self.bounds() {
            let size = bounds.size().max_element();
            if size < SMALLEST_SCENE * NEAR {
                found.push(format!(
                    "size: the scene is {size:.1e} units wide; below {SMALLEST_SCENE:e} it is refused"
                ));
            }
            let furthest = bounds.min.abs().max(bounds.max.abs()).max_element();
            if furthest > LARGEST_COORDINATE / NEAR {
                found.push(format!(
                    "distance: the scene reaches {furthest:.1e} from the origin; beyond {LARGEST_COORDINATE:e} it is refused"
                ));
            }
        }
        let emissions = self.materials.iter().map(|m| m.emission.max_element());
        let brightest = emissions.fold(0.0, f32::max);
        if f64::from(brightest) > f64::from(BRIGHTEST) / NEAR {
            found.push(format!(
                "radiance: a material emits {brightest:.1e} W/(m²·sr); above {BRIGHTEST:e} it is refused"
            ));
        }
        for light in &self.punctual_lights {
            if let PunctualShape::Spot { outer, .. } = light.shape
                && outer < NARROWEST
            {
                found.push(format!(
                    "angle: a spot has a half angle of {outer:.1e} radians; below {NARROWEST:e} its edge is not tested"
                ));
                break;
            }
        }
        let lights = light_triangles(self);
        found.extend(self.contrast(&lights));
        let eyes = self.cameras.iter().map(|c| c.camera_to_world.translation);
        let close = eyes.filter_map(|eye| close_lights::closest(self, &lights, eye, COARSE_LIGHT));
        let closest = close.min_by(|a, b| a.height.total_cmp(&b.height));
        found.extend(closest.map(|light| format!("height of a light: {light}")));
        found.extend(overlaps::text(self, &lights));
        found
    }

    /// A line if some lamp is much brighter than another one.
    fn contrast(&self, lights: &[LightTriangle]) -> Option<String> {
        let mut lamps: HashMap<(u32, u32), f64> = HashMap::new();
        for light in lights {
            let power = lights::power(light, &self.materials[light.material as usize]);
            *lamps.entry((light.instance, light.material)).or_default() += power;
        }
        let points = self.punctual_lights.iter();
        let points = points.filter_map(lights::punctual_power);
        let lit = lamps.into_values().chain(points);
        let lit: Vec<f64> = lit.filter(|power| *power > 0.0).collect();
        let (low, high) = lit
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), power| {
                (low.min(*power), high.max(*power))
            });
        (high > CONTRAST * low).then(|| {
            format!(
                "contrast: one lamp has {:.1e} times the power of another; up to {CONTRAST:e} is tested",
                high / low
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Instance, Material, Mesh, Part, PunctualLight};
    use super::*;
    use glam::{DAffine3, DVec3, Vec3};

    /// A floor that reaches from −1 to 1, seen from a height of 4.
    fn floor() -> Scene {
        let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
        Scene {
            meshes: vec![Mesh {
                positions: vec![
                    corner(-1.0, -1.0),
                    corner(-1.0, 1.0),
                    corner(1.0, 1.0),
                    corner(1.0, -1.0),
                ],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                parts: vec![Part {
                    first_triangle: 0,
                    triangle_count: 2,
                    material: 0,
                }],
                ..Mesh::default()
            }],
            materials: vec![Material::default()],
            instances: vec![place(DVec3::ZERO, 1.0)],
            cameras: vec![super::super::camera::look_at(
                DVec3::Y * 4.0,
                DVec3::X * 0.01,
                1.0,
            )],
            ..Scene::default()
        }
    }

    fn place(at: DVec3, scale: f64) -> Instance {
        Instance {
            name: String::new(),
            mesh: 0,
            object_to_world: DAffine3::from_translation(at)
                * DAffine3::from_scale(DVec3::splat(scale)),
        }
    }

    /// The floor's mesh once more, as a lamp of such a radiance that shines downwards.
    fn add_lamp(scene: &mut Scene, at: DVec3, size: f64, radiance: f32) {
        let mut mesh = scene.meshes[0].clone();
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh.parts[0].material = scene.materials.len() as u32;
        scene.materials.push(Material {
            emission: Vec3::splat(radiance),
            ..Material::default()
        });
        scene.instances.push(Instance {
            mesh: scene.meshes.len() as u32,
            ..place(at, size / 2.0)
        });
        scene.meshes.push(mesh);
    }

    fn point(height: f64) -> PunctualLight {
        PunctualLight {
            name: "bulb".into(),
            light_to_world: DAffine3::from_translation(DVec3::Y * height),
            ..PunctualLight::point(1.0)
        }
    }

    #[track_caller]
    fn assert_near(scene: &Scene, limits: &[&str]) {
        let found = scene.limits();
        assert_eq!(found.len(), limits.len(), "{found:?}");
        for (found, limit) in found.iter().zip(limits) {
            assert!(found.starts_with(limit), "{found}");
        }
    }

    #[test]
    fn an_ordinary_scene_is_near_no_limit() {
        let mut scene = floor();
        add_lamp(&mut scene, DVec3::Y, 0.5, 10.0);
        // Just below the lamp, which shines at it from behind.
        scene.punctual_lights = vec![point(0.5)];
        assert_near(&scene, &[]);
        assert_near(&Scene::default(), &[]);
    }

    #[test]
    fn each_limit_is_named() {
        let mut scene = floor();
        scene.instances[0].object_to_world = DAffine3::from_scale(DVec3::splat(1e-10));
        assert_near(&scene, &["size"]);
        scene.instances[0].object_to_world = DAffine3::from_translation(DVec3::X * 1e13);
        assert_near(&scene, &["distance"]);

        let mut scene = floor();
        add_lamp(&mut scene, DVec3::Y, 0.5, 1e10);
        add_lamp(&mut scene, DVec3::Y * 2.0, 0.5, 1.0);
        assert_near(&scene, &["radiance", "contrast"]);

        let mut scene = floor();
        let bright = PunctualLight {
            intensity: Vec3::splat(1e10),
            ..point(2.0)
        };
        scene.punctual_lights = vec![point(2.0), bright];
        assert_near(&scene, &["contrast"]);

        let mut scene = floor();
        scene.punctual_lights = vec![PunctualLight {
            shape: PunctualShape::Spot {
                inner: 0.0,
                outer: 1e-6,
            },
            ..point(2.0)
        }];
        assert_near(&scene, &["angle"]);
    }

    #[test]
    fn lights_close_to_a_surface_are_found() {
        for (part, close) in [(1e-6, true), (2e-5, true), (3e-5, false)] {
            let mut scene = floor();
            scene.punctual_lights = vec![point(4.0 * part)];
            let closest = scene.closest_light(DVec3::Y * 4.0, COARSE_LIGHT);
            assert_eq!(closest.is_some(), close, "{part}");
            if let Some(light) = closest {
                assert!((light.height / part - 1.0).abs() < 0.01, "{light}");
                assert!(light.to_string().contains("\"bulb\""), "{light}");
                assert_eq!(
                    light.to_string().contains("more than 5 %"),
                    part < SMALLEST_HEIGHT
                );
            }
            assert_eq!(!scene.limits().is_empty(), close);

            let mut scene = floor();
            let height = 4.0 * part;
            add_lamp(&mut scene, DVec3::new(0.3, height, 0.4), height, 1.0);
            assert_eq!(!scene.limits().is_empty(), close, "{:?}", scene.limits());
        }
    }

    #[test]
    fn what_a_light_does_not_shine_at_is_not_close() {
        let mut scene = floor();
        // A lamp at a ceiling, and a spot that looks away from it.
        add_lamp(&mut scene, DVec3::Y * -1e-6, 1e-6, 1.0);
        let up = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        scene.punctual_lights = vec![PunctualLight {
            shape: PunctualShape::Spot {
                inner: 0.0,
                outer: 1.0,
            },
            light_to_world: DAffine3::from_translation(DVec3::Y * -1e-6) * up,
            intensity: Vec3::splat(1e-12),
            ..point(0.0)
        }];
        assert_near(&scene, &[]);
    }

    #[test]
    fn lamps_in_one_plane_that_overlap_are_found() {
        // Beside each other, above each other, and crossing.
        for (at, overlaps) in [
            (DVec3::new(0.5, 1.0, 0.0), false),
            (DVec3::new(0.0, 1.001, 0.0), false),
            (DVec3::new(0.3, 1.0, 0.1), true),
            (DVec3::new(0.0, 1.0, 0.0), true),
        ] {
            let mut scene = floor();
            add_lamp(&mut scene, DVec3::Y, 0.5, 1.0);
            add_lamp(&mut scene, at, 0.5, 1.0);
            let found = scene.limits();
            assert_eq!(found.len(), usize::from(overlaps), "{at}: {found:?}");
            assert!(
                found.iter().all(|line| line.starts_with("overlap")),
                "{found:?}"
            );
        }
    }

    #[test]
    fn both_sides_of_a_thin_lamp_far_away_are_two_planes() {
        let mut scene = floor();
        for height in [1000.0, 1000.005] {
            add_lamp(&mut scene, DVec3::Y * height, 0.5, 1.0);
        }
        assert_near(&scene, &[]);
    }

    #[test]
    fn many_lamps_in_one_place_are_not_counted_to_the_end() {
        let mut scene = floor();
        add_lamp(&mut scene, DVec3::Y, 0.5, 1.0);
        let lamp = scene.instances[1].clone();
        scene.instances.extend(vec![lamp; 100_000]);
        let found = scene.limits();
        assert!(found[0].contains("1000 or more pairs"), "{found:?}");
    }
}

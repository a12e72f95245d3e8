//! Finds the quantities of a scene (sizes, radiances, powers of lights) that are near or beyond a limit of the renderer, so
//! that the user learns that its pictures may be wrong. `tests/LIMITS.md` lists all limits, the accuracy of pictures within
//! each limit, and the tests that check this accuracy.

mod close_lights;
mod overlaps;

use super::lights::{self, EmitterName, LightPowers, LightTriangle, light_triangles};
use super::notices::label;
use super::validate::{BRIGHTEST, LARGEST_COORDINATE, SMALLEST_SCENE};
use super::{Bounds, Material, PunctualShape, Scene};
use glam::DVec3;
use serde::Serialize;
use std::collections::HashMap;

/// The factor that decides whether a quantity of a scene (size, distance from the origin, radiance or contrast) is near its
/// limit: the quantity is within the limit, but differs from it by less than this factor. `headwater scene inspect` reports
/// such a quantity.
const NEAR: f64 = 1e3;

/// The largest ratio of the power of one emitter to the power of another for which tests check pictures. Above it, the light
/// of the dimmer emitter may be missing from pictures, and commands that render print a notice.
const CONTRAST: f64 = 1e9;

/// The factor by which a ratio of powers may exceed [`CONTRAST`] before the limit counts as passed. It allows for the
/// rounding of the areas and colours from which powers are computed.
const ROUNDED: f64 = 1.001;

/// The smallest radiance of an emissive surface for which tests check pictures, in W/(m²·sr). Below it, the surface's light
/// may be missing from pictures, and commands that render print a notice.
const DIMMEST: f64 = 1e-30;

/// The smallest half angle of a spot's cone for which tests check pictures, in radians. Below it, the light in the cone may
/// be wrong or missing, and commands that render print a notice.
const NARROWEST: f64 = 1e-5;

/// A limit that a scene approaches or exceeds. `headwater scene inspect` prints all of them; commands that render print
/// those that the scene exceeds.
#[derive(Clone, Debug, Serialize)]
pub struct Limit {
    /// One line for the user that states the quantity and its value, the element of the scene that has it, and the effect on
    /// pictures.
    pub text: String,
    /// True if the scene exceeds the limit, so that pictures may be wrong. False if it is only near the limit: pictures are
    /// then right, with one exception. The light on surfaces very close to a light may be wrong by a few percent.
    pub passed: bool,
}

impl Scene {
    /// The limits that this scene, which must be valid, approaches or exceeds; empty if there are none. `eyes` are the
    /// positions of the cameras in world space. An animated emission counts with an upper bound of its values at the
    /// keyframes. Instances and lights count at the positions that the fields of the scene state, without their motion.
    pub fn limits(&self, eyes: &[DVec3]) -> Vec<Limit> {
        let (triangles, materials) = (light_triangles(self), self.brightest_materials());
        let mut found = self.size_and_distance();
        found.extend(self.brightest(&materials));
        found.extend(self.dimmest(&materials));
        found.extend(self.narrowest_spot());
        found.extend(self.contrast(&triangles, &materials));
        let close = eyes.iter();
        let close = close.filter_map(|eye| close_lights::closest(self, &triangles, *eye));
        let closest = close.min_by(|a, b| a.height.total_cmp(&b.height));
        found.extend(closest.map(|light| Limit {
            text: format!("height of a light: {light}"),
            passed: light.is_wrong(),
        }));
        found.extend(overlaps::text(self, &triangles).map(|text| Limit { text, passed: true }));
        found
    }

    fn size_and_distance(&self) -> Vec<Limit> {
        let mut found = Vec::new();
        let mut near = |text: String| {
            found.push(Limit {
                text,
                passed: false,
            });
        };
        if let Some(bounds) = Bounds::around(self.loose_boxes().into_iter()) {
            let size = bounds.size().max_element();
            if size < SMALLEST_SCENE * NEAR {
                near(format!(
                    "size: the scene is {size:.1e} units wide; below {SMALLEST_SCENE:e} it is refused"
                ));
            }
            let furthest = bounds.min.abs().max(bounds.max.abs()).max_element();
            if furthest > LARGEST_COORDINATE / NEAR {
                near(format!(
                    "distance: the scene reaches {furthest:.1e} from the origin; beyond {LARGEST_COORDINATE:e} it is refused"
                ));
            }
        }
        found
    }

    /// A report on the brightest material or environment, if its radiance is near or above [`BRIGHTEST`]; otherwise `None`.
    fn brightest(&self, materials: &[Material]) -> Option<Limit> {
        let emissions = materials.iter().enumerate().map(|(index, material)| {
            let name = label("material", index, &material.name);
            (name, material.emission.max_element())
        });
        let environment = self.environment.as_ref();
        let environment = environment.map(|e| ("the environment".to_owned(), e.brightest()));
        let all = emissions.chain(environment);
        let (name, brightest) = all.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let limit = f64::from(BRIGHTEST);
        (f64::from(brightest) > limit / NEAR).then(|| Limit {
            text: format!(
                "radiance: {name} has {brightest:.1e} W/(m²·sr); above {limit:e} pictures may be wrong"
            ),
            passed: f64::from(brightest) > limit,
        })
    }

    /// A report on the emissive material with the lowest radiance, if this radiance is near or below [`DIMMEST`]; otherwise
    /// `None`.
    fn dimmest(&self, materials: &[Material]) -> Option<Limit> {
        let lit = materials
            .iter()
            .enumerate()
            .filter_map(|(index, material)| {
                let emission = f64::from(material.emission.max_element());
                (emission > 0.0).then_some((index, emission))
            });
        let (index, emission) = lit.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (emission < DIMMEST * NEAR).then(|| Limit {
            text: format!(
                "radiance: {} emits {emission:.1e} W/(m²·sr); below {DIMMEST:e} its light may be lost",
                label("material", index, &materials[index].name)
            ),
            passed: emission < DIMMEST,
        })
    }

    fn narrowest_spot(&self) -> Option<Limit> {
        let lights = self.punctual_lights.iter().enumerate();
        let spots = lights.filter_map(|(index, light)| match light.shape {
            PunctualShape::Spot { outer, .. } => Some((index, outer)),
            _ => None,
        });
        let (index, outer) = spots.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (outer < NARROWEST).then(|| Limit {
            text: format!(
                "angle: {} has a half angle of {outer:.1e} radians; below {NARROWEST:e} its cone may be wrong, down to black",
                label("light", index, &self.punctual_lights[index].name)
            ),
            passed: true,
        })
    }

    /// A report on the contrast (the power of the brightest emitter divided by the power of the dimmest one), if the
    /// contrast is near or above [`CONTRAST`]; otherwise `None`.
    fn contrast(&self, triangles: &[LightTriangle], materials: &[Material]) -> Option<Limit> {
        let environment = self.environment.as_ref().map(|e| e.integrals().0);
        let powers = LightPowers::of(self, environment);
        let powers = powers.of_all(triangles, materials, &self.punctual_lights);
        let mut emitters: HashMap<EmitterName, f64> = HashMap::new();
        for (name, power) in lights::emitter_names(triangles, powers.len()).zip(powers) {
            *emitters.entry(name).or_default() += power;
        }
        let lit = || emitters.iter().filter(|(_, power)| **power > 0.0);
        let (dimmest, low) = lit().min_by(|a, b| a.1.total_cmp(b.1).then(a.0.cmp(b.0)))?;
        let (brightest, high) = lit().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)))?;
        let ratio = high / low;
        (ratio > CONTRAST / NEAR).then(|| Limit {
            text: format!(
                "contrast: {} has {ratio:.1e} times the power of {}; above {CONTRAST:e} the dimmer one's light may be lost",
                self.emitter_label(brightest),
                self.emitter_label(dimmest)
            ),
            passed: ratio > ROUNDED * CONTRAST,
        })
    }

    /// The name, for messages, of the emitter that an [`EmitterName`] identifies: its instance and material, its punctual
    /// light, or the environment.
    fn emitter_label(&self, (instance, index): &EmitterName) -> String {
        let index = *index as usize;
        if let Some(instance) = instance {
            let material = label("material", index, &self.materials[index].name);
            let name = &self.instances[*instance as usize].name;
            return format!(
                "{} ({material})",
                label("instance", *instance as usize, name)
            );
        }
        match self.punctual_lights.get(index) {
            Some(light) => label("light", index, &light.name),
            None => "the environment".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Environment, Instance, Mesh, Part, PunctualLight};
    use super::*;
    use glam::{DAffine3, Vec3};

    /// A scene with a square floor at y = 0, which reaches from −1 to 1 along x and z. The camera of the tests is 4 scene
    /// units above it.
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

    /// Adds a square that emits the given radiance downwards (towards −Y). Its centre is `at`, and its edges have the length
    /// `size`.
    fn add_emitter(scene: &mut Scene, at: DVec3, size: f64, radiance: f32) {
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

    fn limits(scene: &Scene) -> Vec<Limit> {
        scene.limits(&[DVec3::Y * 4.0])
    }

    /// Fails unless the scene reports exactly as many limits as `wanted` has entries, and the text of each limit begins with
    /// its entry, in this order. An entry that ends with an exclamation mark means that the scene must have passed the
    /// limit; without the mark, the scene must only be near the limit.
    #[track_caller]
    fn assert_near(scene: &Scene, wanted: &[&str]) {
        let found = limits(scene);
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (found, wanted) in found.iter().zip(wanted) {
            assert!(
                found.text.starts_with(wanted.trim_end_matches('!')),
                "{found:?}"
            );
            assert_eq!(found.passed, wanted.ends_with('!'), "{found:?}");
        }
    }

    #[test]
    fn an_ordinary_scene_is_near_no_limit() {
        let mut scene = floor();
        add_emitter(&mut scene, DVec3::Y, 0.5, 10.0);
        // Just below the emitter, which shines at it from behind.
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
        scene.punctual_lights = vec![PunctualLight {
            shape: PunctualShape::Spot {
                inner: 0.0,
                outer: 1e-6,
            },
            ..point(2.0)
        }];
        assert_near(&scene, &["angle!"]);
    }

    #[test]
    fn very_bright_and_very_dim_emitters_are_named() {
        let emitters = |bright: f32, dim: f32| {
            let mut scene = floor();
            add_emitter(&mut scene, DVec3::Y, 0.5, bright);
            add_emitter(&mut scene, DVec3::Y * 2.0, 0.5, dim);
            scene
        };
        assert_near(&emitters(1e6, 2.0), &[]);
        assert_near(&emitters(1e8, 1.0), &["contrast"]);
        assert_near(&emitters(1e10, 1.0), &["radiance", "contrast!"]);
        assert_near(&emitters(1e-28, 1e-28), &["radiance"]);
        assert_near(&emitters(1e-28, 1e-31), &["radiance!"]);

        let bright = PunctualLight {
            intensity: Vec3::splat(1e10),
            ..point(2.0)
        };
        let sun = PunctualLight {
            shape: PunctualShape::Directional,
            ..bright.clone()
        };
        for light in [bright, sun] {
            let mut scene = floor();
            scene.punctual_lights = vec![point(2.0), light];
            assert_near(&scene, &["contrast: light 1 \"bulb\" has!"]);
        }

        let mut scene = emitters(1e-6, 1.0);
        scene.environment = Some(Environment {
            intensity: 2.0,
            ..environment(1e12)
        });
        let contrast = "contrast: the environment has";
        assert_near(
            &scene,
            &["radiance: the environment!", &format!("{contrast}!")],
        );
        let found = limits(&scene);
        let dim = "times the power of instance 1 (material 1);";
        assert!(found[1].text.contains(dim), "{found:?}");
    }

    /// An environment with the same radiance, in W/(m²·sr), in all directions and colour channels.
    fn environment(radiance: f32) -> Environment {
        Environment {
            name: "bright".into(),
            width: 4,
            height: 2,
            texels: vec![Vec3::splat(radiance); 8].into(),
            rotation: 0.0,
            intensity: 1.0,
        }
    }

    #[test]
    fn lights_close_to_a_surface_are_found() {
        for (part, close) in [(1e-6, true), (2e-5, true), (3e-5, false)] {
            let mut scene = floor();
            scene.punctual_lights = vec![point(4.0 * part)];
            let triangles = light_triangles(&scene);
            let closest = close_lights::closest(&scene, &triangles, DVec3::Y * 4.0);
            assert_eq!(closest.is_some(), close, "{part}");
            if let Some(light) = closest {
                assert!((light.height / part - 1.0).abs() < 0.01, "{light}");
                assert!(light.to_string().contains("\"bulb\""), "{light}");
                assert_eq!(light.to_string().contains("more than 5 %"), part < 2e-6);
            }
            assert_eq!(!limits(&scene).is_empty(), close);

            let mut scene = floor();
            let height = 4.0 * part;
            add_emitter(&mut scene, DVec3::new(0.3, height, 0.4), height, 1.0);
            let found = limits(&scene);
            assert_eq!(!found.is_empty(), close, "{found:?}");
            assert!(found.iter().all(|limit| limit.passed == (part < 2e-6)));
        }
    }

    #[test]
    fn what_a_light_does_not_shine_at_is_not_close() {
        let mut scene = floor();
        // An emitter at a ceiling, and a spot that looks away from it.
        add_emitter(&mut scene, DVec3::Y * -1e-6, 1e-6, 1.0);
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
    fn emitters_in_one_plane_that_overlap_are_found() {
        // Beside each other, above each other, and crossing.
        for (at, overlaps) in [
            (DVec3::new(0.5, 1.0, 0.0), false),
            (DVec3::new(0.0, 1.001, 0.0), false),
            (DVec3::new(0.3, 1.0, 0.1), true),
            (DVec3::new(0.0, 1.0, 0.0), true),
        ] {
            let mut scene = floor();
            add_emitter(&mut scene, DVec3::Y, 0.5, 1.0);
            add_emitter(&mut scene, at, 0.5, 1.0);
            let found = limits(&scene);
            assert_eq!(found.len(), usize::from(overlaps), "{at}: {found:?}");
            assert!(
                found
                    .iter()
                    .all(|limit| limit.passed && limit.text.starts_with("overlap")),
                "{found:?}"
            );
        }
    }

    /// Among many emitters in rows and columns, the search finds one more emitter that overlaps some of them, although it
    /// divides their plane into strips and compares only emitters in the same strip.
    #[test]
    fn an_overlap_among_many_emitters_is_found() {
        let emitters = |last: DVec3, size: f64| {
            let mut scene = floor();
            for index in 0..400 {
                let (row, column) = (f64::from(index / 20), f64::from(index % 20));
                add_emitter(&mut scene, DVec3::new(row, 1.0, column), 1.0, 1.0);
            }
            add_emitter(&mut scene, last, size, 1.0);
            scene
        };
        assert_near(&emitters(DVec3::new(20.0, 1.0, 3.0), 1.0), &[]);
        assert_near(&emitters(DVec3::new(12.4, 1.0, 7.5), 0.3), &["overlap!"]);
        // One below all of them.
        let found = limits(&emitters(DVec3::new(9.5, 1.0, 9.5), 30.0));
        assert!(found[0].text.contains("800 pairs"), "{found:?}");
    }

    /// The message about overlapping emissive triangles names the same pair of instances each time it is computed. Here more
    /// pairs overlap than the search finds before it ends at its maximum number of pairs.
    #[test]
    fn overlaps_in_several_planes_are_named_in_one_order() {
        let mut scene = floor();
        for height in [1.0, 2.0, 3.0] {
            add_emitter(&mut scene, DVec3::Y * height, 0.5, 1.0);
            let emitter = scene.instances[scene.instances.len() - 1].clone();
            scene.instances.extend(vec![emitter; 50]);
        }
        let first = limits(&scene)[0].text.clone();
        for _ in 0..8 {
            assert_eq!(limits(&scene)[0].text, first);
        }
    }

    #[test]
    fn both_sides_of_a_thin_emitter_far_away_are_two_planes() {
        let mut scene = floor();
        for height in [1000.0, 1000.005] {
            add_emitter(&mut scene, DVec3::Y * height, 0.5, 1.0);
        }
        assert_near(&scene, &[]);
    }

    #[test]
    fn many_emitters_at_one_position_are_not_counted_to_the_end() {
        let mut scene = floor();
        add_emitter(&mut scene, DVec3::Y, 0.5, 1.0);
        let emitter = scene.instances[1].clone();
        scene.instances.extend(vec![emitter; 100_000]);
        let found = limits(&scene);
        assert!(found[0].text.contains("1000 or more pairs"), "{found:?}");
    }
}

//! Tests of the contents of reservoirs after a frame, as `--aov direct` and `--aov indirect` show them.

mod support;

use glam::Vec2;
use headwater::device_scene::GpuScene;
use headwater::gpu::Device;
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::{Lighting, Renderer, ResolvedSettings, Settings, Tracking, View};
use headwater::scene::Scene;
use headwater::shader_interface::{NONE, PrimarySurface, ReservoirAov};
use std::sync::Arc;

/// Number of emissive triangles of the room's emitter.
const LIGHTS: u32 = 2;

fn room() -> Scene {
    procedural::generate("cornell", &[]).unwrap()
}

/// A device, and a renderer with counters and origins after `frames` frames of the room with changed settings.
fn rendered(frames: u32, bounces: u32, changes: &[&str]) -> (Arc<Device>, Renderer) {
    let scene = room();
    let (device, selection) = support::open_device(None);
    let preset = Preset::named("accurate").unwrap().settings().unwrap();
    let settings = changes.iter().fold(preset, |settings: Settings, change| {
        settings
            .with(&Settings::parse_change(change).unwrap())
            .unwrap()
    });
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 50,
        height: 44,
        seed: 3,
        bounces,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, selection.variant).unwrap());
    let tracking = Tracking {
        counts: true,
        origins: true,
        ..Tracking::default()
    };
    let mut renderer = {
        let settings = ResolvedSettings::new(&settings, &uploaded, view.bounces);
        Renderer::tracking(&device, uploaded, &view, &settings, tracking).unwrap()
    };
    for number in 0..frames {
        renderer.counts().unwrap();
        renderer.single_frame(number).unwrap();
    }
    (device, renderer)
}

/// The reservoir of direct light and the primary surface of each pixel, row by row. It asserts that empty reservoirs are
/// marked as empty.
fn look((device, renderer): &mut (Arc<Device>, Renderer)) -> Vec<(ReservoirAov, PrimarySurface)> {
    let reservoirs = renderer.reservoir_aovs(Lighting::Direct).unwrap();
    let surfaces = renderer.primary_surfaces().unwrap();
    support::assert_no_messages(device);
    assert_eq!(reservoirs.len(), surfaces.len());
    for (reservoir, surface) in reservoirs.iter().zip(&surfaces) {
        assert!(reservoir.weight.is_finite() && reservoir.weight >= 0.0);
        let empty = reservoir.weight == 0.0;
        assert_eq!(empty, reservoir.light == NONE, "{reservoir:?}");
        assert!(empty || reservoir.light < LIGHTS, "{reservoir:?}");
        assert!(empty || surface.instance != NONE, "{reservoir:?}");
    }
    let full = reservoirs.iter().filter(|r| r.weight > 0.0).count();
    assert!(full > reservoirs.len() / 3, "{full} are not empty");
    reservoirs.into_iter().zip(surfaces).collect()
}

#[test]
fn confidence_grows_by_a_frame_up_to_the_cap_and_samples_age() {
    for (frames, confidence) in [(1, 1.0), (3, 3.0), (5, 5.0), (9, 5.0)] {
        let changes = ["direct.reuse=temporal", "direct.temporal.confidence_cap=4"];
        let seen = look(&mut rendered(frames, 1, &changes));
        for (reservoir, surface) in &seen {
            let expected = match surface.instance {
                NONE => 1.0,
                _ => confidence,
            };
            assert_eq!(reservoir.confidence, expected, "after {frames} frames");
            assert_eq!(reservoir.neighbours, 0);
        }
        let ages = seen.iter().map(|(reservoir, _)| reservoir.age);
        let oldest = ages.max().unwrap();
        // Some of so many are as old as can be.
        assert!(oldest < frames && oldest >= (frames - 1).min(4), "{oldest}");
    }
}

/// With one uniformly drawn candidate per pixel, the weight of a reservoir must be one over the candidate's density: the
/// area of the emitter.
#[test]
fn a_lone_candidate_weighs_what_its_density_says() {
    let emitter: Vec<f32> = emitter_areas(&room());
    assert_eq!(emitter.len(), LIGHTS as usize);
    for format in ["compact", "full"] {
        let changes = [
            "direct.reuse=none",
            "direct.candidates=uniform",
            "direct.light_samples=1",
            "direct.bsdf_samples=0",
            &format!("reservoirs.format={format}"),
            "reservoirs.order=swizzle:8",
        ];
        for (reservoir, _) in look(&mut rendered(2, 1, &changes)) {
            assert_eq!((reservoir.confidence, reservoir.age), (1.0, 0));
            assert_eq!(reservoir.neighbours, 0);
            if reservoir.light != NONE {
                let expected = emitter[reservoir.light as usize] * LIGHTS as f32;
                let off = reservoir.weight / expected - 1.0;
                // The weight also compensates for the stored point, which is up to 2^-21 of the emitter's edges away from
                // the one that was drawn.
                assert!(off.abs() < 2e-4, "{reservoir:?}, expected {expected}");
            }
        }
    }
}

/// The areas of the emissive triangles, in squared scene units.
fn emitter_areas(scene: &Scene) -> Vec<f32> {
    let mut areas = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for part in &mesh.parts {
            if !scene.materials[part.material as usize].is_emissive() {
                continue;
            }
            let first = part.first_triangle as usize;
            for triangle in &mesh.triangles[first..first + part.triangle_count as usize] {
                let [a, b, c] = triangle.map(|corner| {
                    let point = mesh.positions[corner as usize].as_dvec3();
                    instance.object_to_world.transform_point3(point)
                });
                areas.push(((b - a).cross(c - a).length() / 2.0) as f32);
            }
        }
    }
    areas
}

#[test]
fn neighbours_are_those_that_the_frame_merged() {
    for passes in [1, 3] {
        let changes = [
            "direct.reuse=spatial",
            "direct.spatial.search=random",
            "direct.spatial.neighbours=5",
            &format!("direct.spatial.passes={passes}"),
        ];
        let mut renderer = rendered(2, 1, &changes);
        let counted = renderer.1.counts().unwrap();
        let counted = counted.iter().find(|c| c.pass == "spatial_direct").unwrap();
        let seen = look(&mut renderer);
        let sum: u64 = seen.iter().map(|(r, _)| u64::from(r.neighbours)).sum();
        assert_eq!(sum, counted.neighbours);
        for (reservoir, surface) in &seen {
            let most = if surface.instance == NONE {
                0
            } else {
                5 * passes
            };
            assert!(reservoir.neighbours <= most, "{reservoir:?}");
            assert_eq!(reservoir.age, 0);
            // All had one initial reservoir each.
            if passes == 1 {
                assert_eq!(reservoir.confidence, 1.0 + reservoir.neighbours as f32);
            }
        }
    }
}

#[test]
fn without_direct_light_all_are_empty() {
    for reservoir in rendered(1, 0, &[])
        .1
        .reservoir_aovs(Lighting::Direct)
        .unwrap()
    {
        assert_eq!((reservoir.weight, reservoir.light), (0.0, NONE));
        assert_eq!(reservoir.neighbours, 0);
        assert_eq!(reservoir.source, Vec2::NEG_ONE);
    }
}

#[test]
fn path_tracing_has_none() {
    let (_, renderer) = rendered(1, 1, &["integrator=path-tracing"]);
    let error = renderer
        .reservoir_aovs(Lighting::Direct)
        .unwrap_err()
        .to_string();
    assert!(error.contains("no reservoirs"), "{error}");
}

/// Reservoirs of indirect light must fulfil the same conditions as those of direct light, and age in the same way.
#[test]
fn indirect_light_has_reservoirs_of_its_own() {
    let changes = [
        "indirect.temporal.confidence_cap=4",
        "indirect.reuse=temporal",
    ];
    let (device, renderer) = rendered(4, 3, &changes);
    let seen = renderer.reservoir_aovs(Lighting::Indirect).unwrap();
    let pixels = seen.len();
    support::assert_no_messages(&device);
    let full = seen.iter().filter(|r| r.weight > 0.0).count();
    assert!(full > seen.len() / 2, "{full} are not empty");
    let lit = seen.iter().filter(|r| r.light != NONE).count();
    assert!(lit > full / 4 && lit < full, "{lit} of {full} end at once");
    assert!(seen.iter().all(|r| r.light == NONE || r.light < LIGHTS));
    assert!(seen.iter().all(|r| r.weight.is_finite()));
    assert_eq!(seen.iter().map(|r| r.age).max(), Some(3));
    let confident = |c: f32| seen.iter().filter(|r| r.confidence == c).count();
    assert_eq!(confident(4.0) + confident(1.0), seen.len());

    // Without a second bounce there are none, nor before a frame, nor where what is found is shared with nobody.
    for (frames, bounces, changes) in [
        (1, 1, &[][..]),
        (0, 3, &[]),
        (1, 3, &["indirect.mode=path"]),
    ] {
        let (device, renderer) = rendered(frames, bounces, changes);
        let seen = renderer.reservoir_aovs(Lighting::Indirect).unwrap();
        support::assert_no_messages(&device);
        assert_eq!(seen.len(), pixels);
        assert!(seen.iter().all(|r| r.weight == 0.0 && r.light == NONE));
    }
}

/// A sample of the pixel itself must have Jacobian 1. A sample of another pixel must come from within the radius and, for
/// indirect light, have a Jacobian within the limit.
#[test]
fn sources_are_near_and_own_samples_have_no_jacobian() {
    for (lighting, bounces) in [(Lighting::Direct, 1), (Lighting::Indirect, 3)] {
        let changes = [
            "direct.reuse=spatial",
            "indirect.reuse=spatial",
            "direct.spatial.radius=6",
            "indirect.spatial.radius=6",
            "indirect.jacobian_limit=1.5",
        ];
        let (device, renderer) = rendered(1, bounces, &changes);
        let seen = renderer.reservoir_aovs(lighting).unwrap();
        support::assert_no_messages(&device);
        let (mut own, mut others) = (0, 0);
        for (number, reservoir) in seen.iter().enumerate() {
            if reservoir.weight == 0.0 {
                assert_eq!((reservoir.source.x, reservoir.jacobian), (-1.0, 0.0));
                continue;
            }
            let pixel = Vec2::new((number % 50) as f32, (number / 50) as f32);
            let away = pixel.distance(reservoir.source);
            // A pixel is half as wide again along its diagonal.
            assert!(away <= 6.0 + 0.75, "{lighting:?} {pixel} {reservoir:?}");
            if away == 0.0 {
                own += 1;
                let off = reservoir.jacobian - 1.0;
                assert!(off.abs() < 1e-4, "{lighting:?} {pixel} {reservoir:?}");
            } else {
                others += 1;
                let within = (1.0 / 1.501..=1.501).contains(&reservoir.jacobian);
                assert!(
                    within || lighting == Lighting::Direct,
                    "{pixel} {reservoir:?}"
                );
            }
        }
        assert!(
            own > 100 && others > 100,
            "{lighting:?}: {own} and {others}"
        );
    }
}

mod thorough {
    use super::*;

    /// The layout of pixels in memory must not change the picture. Each format and order compiles all shaders again, so all
    /// combinations are tested with `--all` only.
    #[test]
    fn orders_and_arrays_give_the_same_bits() {
        let picture = |changes: &[&str]| {
            let (device, renderer) = rendered(3, 3, changes);
            support::assert_no_messages(&device);
            renderer.frame_radiance().unwrap()
        };
        let others = [
            ("column", "soa"),
            ("swizzle:2", "aos"),
            ("swizzle:40", "soa"),
        ];
        let (with_compact, with_full) = match support::takes_largest() {
            true => (&others[..], &others[..]),
            false => (&others[..2], &others[2..]),
        };
        for (format, others) in [
            ("reservoirs.format=compact", with_compact),
            ("reservoirs.format=full", with_full),
        ] {
            let first = picture(&[format, "reservoirs.order=row"]);
            assert!(first.iter().any(|pixel| pixel[0] > 0.0));
            for (order, arrays) in others {
                let order = format!("reservoirs.order={order}");
                let arrays = format!("reservoirs.arrays={arrays}");
                let other = picture(&[format, &order, &arrays]);
                assert!(first == other, "{format} {order} {arrays}");
            }
        }
    }

    /// A surface without history merges more neighbours, but its confidence grows less: close pixels merge the same samples,
    /// and at full confidence their common noise would stay.
    #[test]
    fn a_surface_without_history_has_more_neighbours() {
        let found = |frames: u32, mis: &str| {
            let changes = [
                "direct.spatial.neighbours=1",
                "direct.spatial.neighbours_without_history=6",
                mis,
            ];
            let seen = look(&mut rendered(frames, 1, &changes));
            let most = seen.iter().map(|(r, _)| r.neighbours).max().unwrap();
            (most, seen)
        };
        let (most, seen) = found(1, "direct.mis=defensive");
        assert_eq!(most, 6);
        for (reservoir, _) in &seen {
            let merged = 1.0 + reservoir.neighbours as f32;
            assert_eq!(reservoir.confidence, merged.min(3.0), "{reservoir:?}");
        }
        assert_eq!(found(2, "direct.mis=defensive").0, 1);
        assert_eq!(found(1, "direct.mis=balance").0, 1);
    }
}

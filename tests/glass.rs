//! Tests of pictures with glass: sheets, slabs and balls equal closed forms, from outside and with the camera inside; reuse is
//! unbiased, and planted faults are found.

mod support;

use glam::{DVec3, Vec3};
use headwater::render::presets::Preset;
use headwater::render::{Settings, View};
use headwater::scene::layers::{Layers, Transmission, Volume};
use headwater::scene::{Camera, Material, Scene};
use std::process::Command;
use support::{planted, said};

const COLOR: Vec3 = Vec3::new(0.9, 0.8, 0.5);
/// The colour that light has after 1 metre of the volumes.
const ATTENUATION: Vec3 = Vec3::new(0.4, 0.8, 0.5);
const IOR: f32 = 1.5;
/// The reflectance of the glass at normal incidence.
const REFLECTED: f64 = 0.04;

fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

/// Glass of a colour, a sheet or a volume.
fn glass(color: Vec3, roughness: f32, volume: Volume) -> Material {
    Material {
        name: "glass".into(),
        base_color: color,
        metallic: 0.0,
        roughness,
        ior: IOR,
        layers: Layers {
            transmission: Transmission {
                factor: 1.0,
                texture: None,
            },
            volume,
            ..Layers::default()
        },
        ..Material::default()
    }
}

fn volume() -> Volume {
    Volume {
        thickness: 1.0,
        attenuation_distance: 1.0,
        attenuation_color: ATTENUATION,
    }
}

fn sheet(z: f32) -> Vec<[Vec3; 3]> {
    support::quad(Vec3::new(-3.0, -3.0, z), Vec3::X * 6.0, Vec3::Y * 6.0)
}

/// The outward faces of the block of the given half size around the origin.
fn block(half: Vec3) -> Vec<[Vec3; 3]> {
    support::block(half)
        .flat_map(|[corner, u, v]| support::quad(corner, u, v))
        .collect()
}

fn emitter() -> Material {
    Material {
        emission: Vec3::ONE,
        ..Material::lambert("emitter", Vec3::ZERO)
    }
}

/// An emitter of radiance 1 at z = −2, which faces +Z.
fn backlit(mut parts: Vec<(Material, Vec<[Vec3; 3]>)>) -> Scene {
    parts.push((emitter(), sheet(-2.0)));
    support::scene_of(&parts)
}

/// A narrow camera at (0, 0, z) that looks along −Z.
fn camera(z: f64) -> Camera {
    support::look_at(
        DVec3::new(0.0, 0.0, z),
        DVec3::new(0.0, 0.0, z - 1.0),
        DVec3::Y,
        0.01,
    )
}

/// Mean radiance of the picture and its standard error.
fn measured(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    bounces: u32,
    samples: u32,
) -> (DVec3, DVec3) {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: camera.clone(),
        width: 8,
        height: 8,
        seed: 3,
        bounces,
        jitter: false,
    };
    let picture = support::render(&device, scene, selection.variant, &view, settings, samples);
    support::assert_no_messages(&device);
    let count = picture.mean.len() as f64;
    let sum = |of: &[[f64; 3]]| of.iter().map(|p| DVec3::from_array(*p)).sum::<DVec3>();
    let error = sum(&picture.error_squared);
    (
        sum(&picture.mean) / count,
        DVec3::from_array(error.to_array().map(f64::sqrt)) / count,
    )
}

/// Asserts that path tracing and resampling show `expected`.
fn assert_shows(scene: &Scene, camera: &Camera, bounces: u32, expected: DVec3) {
    for name in ["path-tracing", "balanced", "accurate"] {
        let (mean, error) = measured(scene, camera, &preset(name), bounces, 512);
        let allowed = 4.0 * error + 5e-4 * expected;
        assert!(
            (mean - expected).abs().cmple(allowed).all(),
            "{name}: {mean} ± {error}, not {expected}"
        );
        assert!(
            error.max_element() < 0.01 * expected.min_element(),
            "{name}: {error}"
        );
    }
}

/// A sheet lets 1 − F of the light through, tinted once. Between two sheets, light goes back and forth.
#[test]
fn sheets_before_an_emitter_let_through_what_they_do_not_reflect() {
    let color = COLOR.as_dvec3();
    let sheets = |places: &[f32]| {
        let places = places.iter();
        backlit(
            places
                .map(|z| (glass(COLOR, 0.0, Volume::default()), sheet(*z)))
                .collect(),
        )
    };
    let passed = (1.0 - REFLECTED) * color;
    assert_shows(&sheets(&[0.0]), &camera(2.0), 6, passed);
    let twice = passed * passed / (1.0 - REFLECTED * REFLECTED);
    assert_shows(&sheets(&[0.0, 0.5]), &camera(2.0), 8, twice);
}

/// Beer's law through a slab with parallel faces, with all reflections inside, seen from outside.
#[test]
fn a_slab_absorbs_by_its_thickness() {
    let slab = (
        glass(COLOR, 0.0, volume()),
        block(Vec3::new(2.0, 2.0, 0.35)),
    );
    let absorbed = ATTENUATION.as_dvec3().powf(0.7);
    let passed = (1.0 - REFLECTED) * COLOR.as_dvec3();
    let expected =
        passed * passed * absorbed / (1.0 - (REFLECTED * absorbed) * (REFLECTED * absorbed));
    assert_shows(&backlit(vec![slab]), &camera(2.0), 8, expected);
}

/// Inside glass, radiance is larger by the squared index. The camera is 0.2 behind the front of a slab of 0.7. The side of the
/// slab that faces the camera is the back of a surface that is not double-sided, which a volume shows nevertheless.
#[test]
fn a_camera_in_glass_sees_radiance_by_the_squared_index() {
    let mut material = glass(COLOR, 0.0, volume());
    material.culled = true;
    let slab = (material, block(Vec3::new(2.0, 2.0, 0.35)));
    let absorbed = |length: f64| ATTENUATION.as_dvec3().powf(length);
    let passed = f64::from(IOR).powi(2) * (1.0 - REFLECTED) * COLOR.as_dvec3();
    let round_trip = REFLECTED * REFLECTED * absorbed(1.4);
    let expected = passed * absorbed(0.2) / (1.0 - round_trip);
    assert_shows(&backlit(vec![slab]), &camera(-0.15), 8, expected);
}

/// A clear ball in a room of uniform light cannot be seen; a rough one is a little darker.
#[test]
fn a_ball_of_glass_keeps_the_light_of_a_room() {
    let clear = Volume {
        thickness: 1.0,
        ..Volume::default()
    };
    for (roughness, least) in [(0.0, 1.0), (0.3, 0.93)] {
        let mut scene = Scene::open("furnace:body=sphere").unwrap();
        scene.materials[0] = glass(Vec3::ONE, roughness, clear.clone());
        let camera = support::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y, 0.3);
        let (mean, error) = measured(&scene, &camera, &preset("path-tracing"), 40, 4096);
        let allowed = 4.0 * error.x + 1e-3;
        assert!(
            mean.x <= 1.0 + allowed && mean.x >= least - allowed && allowed < 0.02,
            "{roughness}: {mean} ± {error}"
        );
    }
}

/// Runs a study of one configuration with changed shaders. Returns true if it proves the absence of bias, and its output.
fn study(scene: &str, settings: &str, changes: &[(&str, &str, &str)]) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    let shaders = folder.path().join("glsl");
    planted(&shaders, changes);
    let plan = folder.path().join("plan.toml");
    let text = format!(
        r#"
scenes = ["{scene}"]
width = 32
frames = 3
seeds = 128
most_seeds = 1024
bounces = 5
reference_spp = 8192
[[configurations]]
name = "glass"
{settings}
"#
    );
    std::fs::write(&plan, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command.args(["study", "-o"]).arg(folder.path());
    command.arg("--plan").arg(&plan);
    command.env("HEADWATER_GLSL", &shaders);
    // The validation layers keep something of every submission.
    command.env_remove("HEADWATER_VALIDATION");
    let output = command.output().unwrap();
    println!("{}", said(&output));
    let passes = output.status.success() && !said(&output).contains("undecided");
    (passes, said(&output))
}

const ACCURATE: &str = "preset = \"accurate\"";

fn assert_found(scene: &str, change: (&str, &str, &str)) {
    let (passes, said) = study(scene, ACCURATE, &[change]);
    assert!(!passes && said.contains("should be unbiased"), "{said}");
}

mod thorough {
    use super::*;

    #[test]
    fn clear_glass_around_the_camera_is_unbiased() {
        assert!(study("glass:object=camera", ACCURATE, &[]).0);
    }

    /// Radiance grows with the squared index of its medium. Rays that leave the glass around the camera lack the factor in their
    /// weight, while the BSDF that is evaluated for them has it.
    #[test]
    fn a_missing_squared_index_in_one_estimator_is_found() {
        assert_found(
            "glass:object=camera,roughness=0.3",
            (
                "restir/samples/pilot.glsl",
                "if (HAS_TRANSMISSION) chosen.weight *= shading_point.passed_to_viewer;",
                "chosen.weight *= shading_point.passed_to_viewer * (chosen.direction.z < 0.0 ? 1.0 / 2.25 : 1.0);",
            ),
        );
    }
}

mod largest {
    use super::*;

    #[test]
    fn rough_glass_before_surfaces_is_unbiased() {
        assert!(study("glass:object=window,roughness=0.3", ACCURATE, &[]).0);
        assert!(
            study(
                "glass:object=window,roughness=0.3",
                "preset = \"balanced\"",
                &[]
            )
            .0
        );
    }

    #[test]
    fn a_rough_ball_that_absorbs_is_unbiased() {
        assert!(study("glass:roughness=0.3", ACCURATE, &[]).0);
    }

    #[test]
    fn attenuation_that_only_the_target_of_a_weight_lacks_is_found() {
        assert_found(
            "glass:roughness=0.3",
            (
                "restir/passes/initial_indirect.comp",
                "float target = target_function(eye, chosen);",
                "vec3 way = chosen.point.position - eye.position;
                float target = target_function(eye, chosen) / luminance(passed_light(medium_left(eye, way), length(way)));",
            ),
        );
    }

    /// The path has a second vertex of clear glass, whose light no other pixel can evaluate.
    #[test]
    fn a_reconnection_through_a_delta_vertex_is_found() {
        assert_found(
            "glass",
            (
                "restir/samples/path_candidates.glsl",
                "path.is_reusable = path.is_reusable && !onward.delta;",
                "",
            ),
        );
    }
}

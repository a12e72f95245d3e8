//! Tests of environments and punctual lights against closed forms, and of resampling against path tracing with all kinds of
//! light.

mod alpha;
mod kinds;
#[path = "../support/mod.rs"]
mod support;
mod unlit;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use headwater::device_scene::GpuScene;
use headwater::metrics::statistics::Estimate;
use headwater::procedural;
use headwater::render::lighting::Lighting;
use headwater::render::presets::Preset;
use headwater::render::settings::{self, Format};
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{
    Environment, Image, Material, PunctualLight, PunctualShape, Scene, Texture,
};
use headwater::shader_interface::Tracer;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

pub const ALBEDO: f64 = 0.5;

pub fn environment(width: u32, height: u32, texel: impl Fn(u32, u32) -> Vec3) -> Environment {
    let coordinates = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    Environment {
        name: "test".into(),
        width,
        height,
        texels: coordinates.map(|(x, y)| texel(x, y)).collect(),
        rotation: 0.0,
        intensity: 1.0,
    }
}

/// A punctual light at a position, aimed along a direction.
pub fn punctual(shape: PunctualShape, position: DVec3, direction: DVec3) -> PunctualLight {
    let z = -direction.normalize();
    let x = z.any_orthonormal_vector();
    PunctualLight {
        name: "test".into(),
        light_to_world: DAffine3::from_mat3_translation(
            DMat3::from_cols(x, z.cross(x), z),
            position,
        ),
        shape,
        intensity: Vec3::new(3.0, 2.0, 1.0),
        range: None,
    }
}

/// A scene with a grey floor at y = 0.
pub fn floor() -> Scene {
    let floor = support::quad(Vec3::new(-4.0, 0.0, 4.0), Vec3::X * 8.0, Vec3::NEG_Z * 8.0);
    support::scene_of(&[(
        Material::lambert("floor", Vec3::splat(ALBEDO as f32)),
        floor,
    )])
}

pub const SIDE: u32 = 32;

/// A view straight down on the part of the floor within one unit of the origin, along x and z.
pub fn from_above(bounces: u32, seed: u32) -> View {
    let mut camera = support::look_at(
        DVec3::Y * 4.0,
        DVec3::ZERO,
        DVec3::NEG_Z,
        2.0 * 0.25_f64.atan(),
    );
    camera.aspect_ratio = Some(1.0);
    View {
        camera,
        width: SIDE,
        height: SIDE,
        seed,
        bounces,
        jitter: false,
    }
}

/// The point of the floor that the centre of a pixel shows.
pub fn floor_point(pixel: usize) -> DVec3 {
    let at = |i: usize| (i as f64 + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
    DVec3::new(at(pixel % SIDE as usize), 0.0, at(pixel / SIDE as usize))
}

pub fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

/// One mean picture per seed, each a list of RGB values row by row; `None` if the device lacks the tracer. The error of a
/// mean comes from several seeds, because the frames of one seed are correlated.
pub fn pictures(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    tracer: Tracer,
    samples: u32,
    seeds: u32,
) -> Option<Vec<Vec<[f64; 3]>>> {
    let variant = *support::variants(tracer).first()?;
    let (device, _) = support::open_device(Some(variant));
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, scene, origin, variant).unwrap());
    let mut renderer = Renderer::new(&device, uploaded, view, settings).unwrap();
    let found = (0..seeds).map(|seed| {
        renderer.restart(view.seed + seed).unwrap();
        renderer.add_samples(0, samples).unwrap();
        assert_eq!(renderer.rejected().unwrap(), 0, "values were rejected");
        let mean = renderer.sums().unwrap().mean(samples);
        mean.iter().map(|pixel| pixel.to_array()).collect()
    });
    let found = found.collect();
    support::assert_no_messages(&device);
    Some(found)
}

pub fn picture(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    tracer: Tracer,
    samples: u32,
) -> Option<Vec<[f64; 3]>> {
    pictures(scene, view, settings, tracer, samples, 1)?.pop()
}

/// The number of seeds into which the samples are divided where a test needs the error of a mean.
pub const SEEDS: u32 = 8;

/// The sum over the pixels and channels of a picture, with its error over seeds; `None` if the device lacks the tracer.
fn totals(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    tracer: Tracer,
    samples: u32,
) -> Option<Estimate> {
    let found = pictures(scene, view, settings, tracer, samples / SEEDS, SEEDS)?;
    let totals: Vec<f64> = found.iter().map(|picture| total(picture)).collect();
    Some(Estimate::of(&totals))
}

pub fn total(values: &[[f64; 3]]) -> f64 {
    values.iter().flatten().sum()
}

/// The irradiance (RGB) of the floor from the environment above it, computed with a fine grid.
fn irradiance(environment: &Environment) -> DVec3 {
    const FINE: u32 = 16;
    let (width, height) = (environment.width, environment.height);
    let texel = |x: i64, y: i64| {
        let column = x.rem_euclid(i64::from(width));
        let row = y.clamp(0, i64::from(height) - 1);
        environment.texels[(row * i64::from(width) + column) as usize].as_dvec3()
    };
    let mut sum = DVec3::ZERO;
    for v in 0..FINE * height / 2 {
        let y = (f64::from(v) + 0.5) / f64::from(FINE);
        let down = PI * y / f64::from(height);
        let weight = down.sin() * down.cos() * TAU * PI
            / (f64::from(width * height) * f64::from(FINE * FINE));
        for u in 0..FINE * width {
            let x = (f64::from(u) + 0.5) / f64::from(FINE);
            let (cx, cy) = ((x - 0.5).floor(), (y - 0.5).floor());
            let (px, py) = (x - 0.5 - cx, y - 0.5 - cy);
            let row = |dy| {
                texel(cx as i64, cy as i64 + dy).lerp(texel(cx as i64 + 1, cy as i64 + dy), px)
            };
            sum += row(0).lerp(row(1), py) * weight;
        }
    }
    sum * f64::from(environment.intensity)
}

/// Preset, tracer, and number of samples that brings the error below 0.1 %: path tracing with both tracers, and resampling.
pub const TECHNIQUES: [(&str, Tracer, u32); 3] = [
    ("path-tracing", Tracer::ComputeBvh, 1024),
    ("path-tracing", Tracer::RayQuery, 512),
    ("accurate", Tracer::ComputeBvh, 256),
];

/// The sun as a point light: its intensity and its distance are far beyond the range of values on the floor.
#[test]
fn a_floor_reflects_a_point_light_as_far_as_the_sun() {
    let (distance, intensity) = (1.5e11, 3e25);
    let mut sun = punctual(PunctualShape::Point, DVec3::Y * distance, DVec3::Y);
    sun.intensity = Vec3::splat(intensity as f32);
    let expected = intensity / distance.powi(2) * ALBEDO / PI;
    let mut scene = floor();
    scene.punctual_lights = vec![sun];
    scene.validate().unwrap();
    for (technique, tracer, _) in TECHNIQUES {
        let view = from_above(1, 3);
        for found in picture(&scene, &view, &preset(technique), tracer, 2).unwrap_or_default() {
            let off = found.map(|channel| (channel / expected - 1.0).abs());
            assert!(
                off.iter().all(|off| *off < 1e-4),
                "{technique}: {found:?} {expected}"
            );
        }
    }
    let units = headwater::device_scene::units::Units::of(&scene, DVec3::ZERO);
    let on_device = intensity / distance.powi(2) / units.radiance;
    assert!((1.0..2.0).contains(&on_device), "{on_device}");
}

/// The weight of a sample of the environment is a solid angle, so it must not depend on the size of the scene.
#[test]
fn weights_of_the_environment_do_not_depend_on_lengths() {
    let variant = support::variants(Tracer::ComputeBvh)[0];
    let (device, _) = support::open_device(Some(variant));
    let weights = [1.0_f32, 8.0].map(|scale| {
        let mut scene = floor();
        for position in &mut scene.meshes[0].positions {
            *position *= scale;
        }
        scene.environment = Some(environment(8, 4, |_, _| Vec3::ONE));
        let mut view = from_above(1, 3);
        view.camera.camera_to_world.translation *= f64::from(scale);
        let origin = view.camera.camera_to_world.translation;
        let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, variant).unwrap());
        let mut renderer = Renderer::new(&device, uploaded, &view, &preset("accurate")).unwrap();
        renderer.single_frame(0).unwrap();
        let found = renderer.reservoir_aovs(Lighting::Direct).unwrap();
        found.iter().map(|aov| aov.weight).collect::<Vec<f32>>()
    });
    assert!(weights[0].iter().any(|weight| *weight > 0.0));
    assert_eq!(weights[0], weights[1]);
}

/// A floor with a normal map must reflect light by its bent normal, for every position and mirroring of its instance.
#[test]
fn normal_maps_turn_the_normal() {
    let texel = [230, 90, 200, 255];
    let (scale, slanted) = (0.5, DVec3::new(0.3, -1.0, 0.6));
    let turned = texel.map(|byte: u8| f64::from(byte) / 127.5 - 1.0);
    for (mirrored, shared, flat) in [
        (false, false, false),
        (true, false, false),
        (false, true, false),
        (true, true, false),
        (true, true, true),
    ] {
        let mut scene = floor();
        scene.images = vec![image(|_| texel)];
        scene.materials[0].normal_texture = Some(Texture::plain(0));
        scene.materials[0].normal_scale = scale as f32;
        let mesh = &mut scene.meshes[0];
        // From above, u points right and v down.
        mesh.uvs[0] = (mesh.positions.iter())
            .map(|p| Vec2::new(p.x, p.z))
            .collect();
        if !flat {
            mesh.normals = vec![Vec3::Y; mesh.positions.len()];
        }
        if mirrored {
            scene.instances[0].object_to_world = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        }
        if shared {
            let mut other = scene.instances[0].clone();
            other.object_to_world.translation.y -= 9.0;
            scene.instances.push(other);
        }
        scene.punctual_lights = vec![punctual(PunctualShape::Directional, DVec3::ZERO, slanted)];
        scene.validate().unwrap();
        let side = if mirrored { -1.0 } else { 1.0 };
        let normal =
            DVec3::new(side * scale * turned[0], turned[2], -scale * turned[1]).normalize();
        let cosine = -normal.dot(slanted.normalize());
        let expected = scene.punctual_lights[0].intensity.as_dvec3() * (cosine * ALBEDO / PI);
        for (technique, tracer, _) in TECHNIQUES {
            let Some(mean) = picture(&scene, &from_above(1, 3), &preset(technique), tracer, 2)
            else {
                continue;
            };
            for found in &mean {
                let off = (DVec3::from_array(*found) - expected).abs().max_element();
                assert!(
                    off < 2e-4 * expected.x,
                    "mirrored {mirrored}, shared {shared}, {technique} {tracer:?}: {found:?} {expected}"
                );
            }
        }
    }
}

/// An image of eight by eight texels; `texel` gives the RGBA bytes of each index.
pub fn image(texel: impl Fn(u32) -> [u8; 4]) -> Image {
    Image {
        name: "test".into(),
        width: 8,
        height: 8,
        texels: (0..64).map(texel).collect(),
    }
}

/// Gives every material textures of colours and normals that differ from texel to texel.
fn with_textures(scene: &mut Scene) {
    let hash = |i: u32| {
        i.wrapping_mul(0x9E37_79B9)
            .rotate_left(13)
            .wrapping_mul(0x85EB_CA6B)
    };
    let byte = |i: u32, shift: u32| (hash(i) >> shift) as u8;
    scene.images = vec![
        image(|i| [byte(i, 0) | 64, byte(i, 8) | 64, byte(i, 16) | 64, 255]),
        image(|i| [byte(i, 3), byte(i, 11), 255, 255]),
    ];
    for material in &mut scene.materials {
        material.base_color_texture = Some(Texture::plain(0));
        material.normal_texture = Some(Texture::plain(1));
        material.normal_scale = 0.4;
    }
    for mesh in &mut scene.meshes {
        let laid = |p: &Vec3| Vec2::new(p.x + 0.7 * p.y, p.z - 0.6 * p.y);
        mesh.uvs[0] = mesh.positions.iter().map(laid).collect();
    }
    scene.validate().unwrap();
}

/// A room without its front wall, with all kinds of light and of textures.
fn all_kinds() -> Scene {
    let mut scene = procedural::generate("cornell-glossy", &[]).unwrap();
    // Smoother lobes would reflect punctual lights as rare, bright paths, of which no interval can be told.
    scene
        .materials
        .iter_mut()
        .for_each(|m| m.roughness = m.roughness.max(0.4));
    let middle = scene.bounds().unwrap().center();
    let size = scene.bounds().unwrap().size().max_element();
    scene.punctual_lights = vec![
        punctual(
            PunctualShape::Point,
            middle + DVec3::new(0.2, 0.1, 0.2) * size,
            DVec3::X,
        ),
        punctual(
            PunctualShape::Spot {
                inner: 0.1,
                outer: 0.7,
            },
            middle + DVec3::new(-0.2, 0.3, 0.3) * size,
            DVec3::new(0.3, -1.0, -0.4),
        ),
        punctual(
            PunctualShape::Directional,
            middle,
            DVec3::new(0.2, -0.4, -1.0),
        ),
    ];
    for light in &mut scene.punctual_lights {
        light.intensity *= if light.is_distant() {
            2.0
        } else {
            0.1 * (size * size) as f32
        };
    }
    scene.environment = Some(environment(32, 16, |x, y| {
        Vec3::new(0.5, 0.7, 1.0) * if (x, y) == (3, 6) { 40.0 } else { 1.0 }
    }));
    with_textures(&mut scene);
    scene
}

/// The difference of the mean of resampling from that of path tracing, and its standard error, both relative to the mean of
/// path tracing.
pub fn bias(scene: &Scene, settings: &Settings, samples: u32) -> [f64; 2] {
    let view = |seed| View {
        camera: scene.cameras[0].clone(),
        width: 40,
        height: 40,
        ..from_above(3, seed)
    };
    let tracer = Tracer::ComputeBvh;
    let reference = totals(scene, &view(1), &preset("path-tracing"), tracer, 4096).unwrap();
    let found = totals(scene, &view(100), settings, tracer, samples).unwrap();
    let off = found.minus(&reference);
    [off.mean, off.standard_error].map(|x| x / reference.mean)
}

/// Runs a test of this file again in a new process with a fault in the shaders, and asserts that the test fails.
pub fn assert_seen(test: &str, fault: (&str, &str, &str)) {
    let output = support::run_with_fault(test, fault, |command| command);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        !output.status.success() && said.contains("0 passed; 1 failed"),
        "{said}"
    );
    assert!(
        said.contains("path-tracing") || said.contains("accurate"),
        "{said}"
    );
}

#[test]
fn densities_that_forget_the_sphere_are_seen() {
    assert_seen(
        "thorough::a_floor_reflects_the_irradiance_of_the_environment",
        (
            "lights/kinds/environment.glsl",
            "environment_texel(texel).w / sine",
            "environment_texel(texel).w",
        ),
    );
}

mod thorough {
    use super::*;

    #[test]
    fn resampling_all_kinds_of_light_is_unbiased() {
        let scene = all_kinds();
        let all = support::takes_largest();
        let formats = [Format::Compact, Format::Full];
        for format in formats.into_iter().take(if all { 2 } else { 1 }) {
            let mut settings = preset("accurate");
            settings.reservoirs.format = format;
            let [off, sigma] = bias(&scene, &settings, 512);
            println!("{format:?}: {:.3} ± {:.3} %", 100.0 * off, 100.0 * sigma);
            assert!(
                sigma < 0.002 && off.abs() < 0.001 + 3.1 * sigma,
                "{format:?}: {off} ± {sigma}"
            );
        }
    }

    #[test]
    fn a_punctual_light_that_rays_are_said_to_hit_is_seen() {
        assert_seen(
            "thorough::a_floor_reflects_punctual_lights_exactly",
            (
                "restir/samples/light_sample.glsl",
                "if (is_punctual(value.point.kind)) return false;",
                "if (is_punctual(value.point.kind)) return true;",
            ),
        );
    }

    #[test]
    fn an_environment_that_no_candidate_ray_finds_is_seen() {
        assert_seen(
            "thorough::a_floor_reflects_the_irradiance_of_the_environment",
            (
                "restir/samples/pilot.glsl",
                "if (hit.instance == NONE && sees_environment()) return environment_point(direction);",
                "",
            ),
        );
    }

    #[test]
    fn a_mirrored_bitangent_is_seen() {
        assert_seen(
            "normal_maps_turn_the_normal",
            (
                "scene/normal_map.glsl",
                "(mirrored ? -first.w : first.w)",
                "first.w",
            ),
        );
    }

    /// A floor under an environment must have a radiance of irradiance × albedo / π, for each environment.
    #[test]
    fn a_floor_reflects_the_irradiance_of_the_environment() {
        let constant = environment(8, 4, |_, _| Vec3::new(1.0, 2.0, 0.5));
        let sun = |x: u32, y: u32| {
            environment(64, 32, move |u, v| match (u, v) == (x, y) {
                true => Vec3::splat(5e4),
                false => Vec3::splat(0.01),
            })
        };
        for (name, environment) in [
            ("constant", constant),
            ("one bright texel", sun(11, 6)),
            ("one at the zenith", sun(40, 0)),
            ("one at the seam", sun(63, 10)),
        ] {
            let expected = irradiance(&environment) * (ALBEDO / PI);
            let mut scene = floor();
            scene.environment = Some(environment);
            for (technique, tracer, samples) in TECHNIQUES {
                let Some(found) = totals(
                    &scene,
                    &from_above(1, 3),
                    &preset(technique),
                    tracer,
                    samples,
                ) else {
                    continue;
                };
                let expected = f64::from(SIDE * SIDE) * expected.element_sum();
                let [off, sigma] = [found.mean / expected - 1.0, found.standard_error / expected];
                println!(
                    "{name}, {technique} {tracer:?}: {:.3} ± {:.3} %",
                    100.0 * off,
                    100.0 * sigma
                );
                assert!(off.abs() < 0.005, "{name}, {technique} {tracer:?}: {off}");
            }
        }
    }

    /// The light of one punctual light on a floor must be exact at every pixel, from the first sample on.
    #[test]
    fn a_floor_reflects_punctual_lights_exactly() {
        let above = DVec3::new(0.3, 1.5, -0.2);
        let slanted = DVec3::new(0.4, -1.0, 0.2);
        let spot = PunctualShape::Spot {
            inner: 0.2,
            outer: 0.6,
        };
        let ranged = PunctualLight {
            range: Some(1.8),
            ..punctual(PunctualShape::Point, above, slanted)
        };
        for (name, light) in [
            ("point", punctual(PunctualShape::Point, above, slanted)),
            ("point of some range", ranged),
            ("spot", punctual(spot, above, slanted)),
            (
                "half a sphere",
                punctual(
                    PunctualShape::Spot {
                        inner: 0.0,
                        outer: FRAC_PI_2,
                    },
                    above,
                    slanted,
                ),
            ),
            (
                "direction",
                punctual(PunctualShape::Directional, above, slanted),
            ),
        ] {
            let expected = |point: DVec3| -> DVec3 {
                let toward = above - point;
                let (distance, direction) = (toward.length(), toward.normalize());
                let axis = slanted.normalize();
                let (fraction, cosine) = match light.shape {
                    PunctualShape::Directional => (1.0, -axis.y),
                    PunctualShape::Point => (distance.powi(-2), direction.y),
                    PunctualShape::Spot { inner, outer } => {
                        let scale = 1.0 / (inner.cos() - outer.cos());
                        let within = ((-direction.dot(axis) - outer.cos()) * scale).clamp(0.0, 1.0);
                        (within * within * distance.powi(-2), direction.y)
                    }
                };
                let within = light.range.map_or(1.0, |range| {
                    (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0)
                });
                light.intensity.as_dvec3() * (fraction * within * cosine * ALBEDO / PI)
            };
            let mut scene = floor();
            scene.punctual_lights = vec![light.clone()];
            scene.validate().unwrap();
            for (technique, tracer, _) in TECHNIQUES {
                let Some(mean) = picture(&scene, &from_above(1, 3), &preset(technique), tracer, 2)
                else {
                    continue;
                };
                let brightest = (0..mean.len()).map(|pixel| expected(floor_point(pixel)).x);
                let brightest = brightest.fold(0.0, f64::max);
                let mut lit = 0;
                for (pixel, found) in mean.iter().enumerate() {
                    let expected = expected(floor_point(pixel));
                    lit += u32::from(expected.x > 0.0);
                    let off = (DVec3::from_array(*found) - expected).abs().max_element();
                    assert!(
                        off < 1e-4 * expected.x + 5e-5 * brightest,
                        "{name}, {technique} {tracer:?}, pixel {pixel}: {found:?} {expected}"
                    );
                }
                assert!(lit > 80, "{name}: {lit}");
            }
        }
    }

    /// A white sphere must be invisible in a uniform environment: a matte one, and a rough metal with energy compensation.
    #[test]
    fn a_white_sphere_vanishes_in_a_uniform_environment() {
        let mut scene =
            procedural::generate("furnace", &[("body".into(), "sphere".into())]).unwrap();
        scene
            .materials
            .iter_mut()
            .for_each(|m| m.emission = Vec3::ZERO);
        scene.environment = Some(environment(4, 2, |_, _| Vec3::ONE));
        // What stood around the body is taken away: the environment is around it instead.
        let size = |i: &headwater::scene::Instance| {
            scene.meshes[i.mesh as usize]
                .bounds()
                .unwrap()
                .size()
                .max_element()
        };
        let smallest = scene
            .instances
            .iter()
            .map(size)
            .fold(f64::INFINITY, f64::min);
        let kept: Vec<_> = (scene.instances.iter())
            .filter(|i| size(i) == smallest)
            .cloned()
            .collect();
        scene.instances = kept;
        for (name, material) in [
            ("matt", Material::lambert("white", Vec3::ONE)),
            (
                "metal",
                Material {
                    roughness: 0.6,
                    ..Material::default()
                },
            ),
        ] {
            scene
                .materials
                .iter_mut()
                .for_each(|m| *m = material.clone());
            for (technique, tracer, samples) in TECHNIQUES {
                let mut settings = preset(technique);
                settings.energy = headwater::render::settings::Energy::Compensated;
                let view = View {
                    camera: scene.cameras[0].clone(),
                    ..from_above(3, 3)
                };
                let Some(mean) = picture(&scene, &view, &settings, tracer, samples) else {
                    continue;
                };
                let off = total(&mean) / f64::from(3 * SIDE * SIDE) - 1.0;
                println!("{name}, {technique} {tracer:?}: {:.3} %", 100.0 * off);
                assert!(off.abs() < 0.005, "{name}, {technique} {tracer:?}: {off}");
            }
        }
    }
}

mod largest {
    use super::*;

    #[test]
    fn the_full_variant_renders_all_kinds_of_light_to_the_same_bits() {
        let scene = all_kinds();
        for name in ["accurate", "s1", "path-tracing"] {
            let mut settings = preset(name);
            let auto = support::frame_bits(&scene, &settings, None);
            settings.variant = settings::Variant::Full;
            assert!(
                auto == support::frame_bits(&scene, &settings, None),
                "{name}"
            );
        }
    }
}

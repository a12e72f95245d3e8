//! Tests of alpha channels: in front of a constant environment, the picture without alpha follows from the one with it.

use crate::{orthographic, preset, support, view, with_lens};
use glam::{DVec3, Vec3};
use headwater::device_scene::GpuScene;
use headwater::gpu::Device;
use headwater::render::outputs::Sums;
use headwater::render::{Renderer, ResolvedSettings, Settings, Tracking, View};
use headwater::scene::environment::Environment;
use headwater::scene::{AlphaMode, Camera, Material, Scene};
use std::sync::Arc;

const SIDE: u32 = 24;
const SAMPLES: u32 = 6;
/// The radiance of the environment.
const AROUND: f32 = 0.75;

/// An opaque square, one that covers 0.4 of its light, and one with holes that has none, in an environment of one radiance.
fn scene() -> Scene {
    let opaque = Material::lambert("opaque", Vec3::new(0.6, 0.3, 0.1));
    let blended = Material {
        alpha: 0.4,
        alpha_mode: AlphaMode::Blend,
        ..Material::lambert("blended", Vec3::splat(0.5))
    };
    let cut_out = Material {
        alpha: 0.2,
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::lambert("cut out", Vec3::ONE)
    };
    let square = |x: f32, z: f32| support::quad(Vec3::new(x, -0.7, z), Vec3::X, Vec3::Y * 1.3);
    let mut scene = support::scene_of(&[
        (opaque, square(-1.1, -3.0)),
        (blended, square(-0.4, -2.5)),
        (cut_out, square(0.1, -2.0)),
    ]);
    scene.environment = Some(Environment {
        name: "uniform".into(),
        width: 4,
        height: 2,
        texels: vec![Vec3::splat(AROUND); 8].into(),
        rotation: 0.0,
        intensity: 1.0,
    });
    scene
}

/// The sums of [`SAMPLES`] frames, or of the last of them alone.
fn sums(view: &View, settings: &Settings, coverage: bool, accumulates: bool) -> Sums {
    let (device, selection): (Arc<Device>, _) = support::open_device(None);
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, &scene(), origin, selection.variant).unwrap();
    let settings = ResolvedSettings::new(settings, &uploaded, view.bounces);
    let tracking = Tracking {
        coverage,
        ..Tracking::default()
    };
    let uploaded = Arc::new(uploaded);
    let mut renderer = Renderer::tracking(&device, uploaded, view, &settings, tracking).unwrap();
    if accumulates {
        renderer.add_samples(0, SAMPLES).unwrap();
    } else {
        for index in 0..SAMPLES {
            renderer.single_frame(index).unwrap();
        }
        renderer.keep_single_frame().unwrap();
    }
    support::assert_no_messages(&device);
    renderer.sums().unwrap()
}

/// The camera's rays and all random numbers are the same with alpha, so only the environment that the camera sees is missing, to
/// the last sample.
#[test]
fn a_picture_over_its_environment_is_the_picture_without_alpha() {
    let own: Camera = support::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.9);
    let lens = with_lens(&own, 0.2, 4.0);
    let flat = orthographic(&own, 3.0);
    for (camera, name, accumulates, jitter) in [
        (&own, "path-tracing", true, true),
        (&lens, "accurate", true, true),
        (&own, "fast", false, false),
        (&flat, "path-tracing", false, true),
    ] {
        let what = format!("{name}, accumulates {accumulates}, jitter {jitter}");
        let mut view = view(camera.clone(), SIDE, SIDE, 3);
        view.jitter = jitter;
        let samples = if accumulates { SAMPLES } else { 1 };
        let over = sums(&view, &preset(name), false, accumulates);
        assert!(over.coverage.is_none());
        let cut = sums(&view, &preset(name), true, accumulates);
        let alpha = cut.alpha(samples).unwrap();
        assert!(alpha.contains(&0.0) && alpha.contains(&1.0), "{what}");
        let parts = alpha.iter().filter(|a| **a > 0.0 && **a < 1.0).count();
        assert_eq!(parts > 0, accumulates, "{what}: {parts} covered in part");
        for ((with, without), alpha) in cut.mean(samples).iter().zip(over.mean(samples)).zip(alpha)
        {
            let expected = *with + f64::from((1.0 - alpha) * AROUND);
            let error = (expected - without).abs().max_element();
            assert!(error < 1e-5, "{what}: {expected} and {without}");
        }
    }
}

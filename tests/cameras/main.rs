//! Tests of cameras: orthographic ones and lenses against closed forms, and resampling against path tracing with both.

mod bias;
mod coverage;
mod lens;
mod orthographic;
#[path = "../support/mod.rs"]
mod support;

use headwater::device_scene::GpuScene;
use headwater::gpu::Device;
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::camera::{Lens, Projection};
use headwater::scene::{Camera, Scene};
use std::sync::Arc;

/// The `camera` with an orthographic projection of a picture that is `height` scene units high.
fn orthographic(camera: &Camera, height: f64) -> Camera {
    Camera {
        projection: Projection::Orthographic { height },
        ..camera.clone()
    }
}

/// The `camera` with a lens.
fn with_lens(camera: &Camera, diameter: f64, focus_distance: f64) -> Camera {
    let lens = Lens {
        diameter,
        focus_distance,
    };
    camera.clone().with_lens(lens).unwrap()
}

fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

/// A view of `width` × `height` pixels without jitter.
fn view(camera: Camera, width: u32, height: u32, bounces: u32) -> View {
    View {
        camera,
        width,
        height,
        seed: 5,
        bounces,
        jitter: false,
    }
}

/// A device, and a renderer of `scene`.
fn renderer(scene: &Scene, view: &View, settings: &Settings) -> (Arc<Device>, Renderer) {
    let (device, selection) = support::open_device(None);
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let renderer = Renderer::new(&device, Arc::new(uploaded), view, settings).unwrap();
    (device, renderer)
}

/// The radiance of each pixel in frame 0.
fn frame(scene: &Scene, view: &View, settings: &Settings) -> Vec<[f32; 3]> {
    let (device, mut renderer) = renderer(scene, view, settings);
    renderer.single_frame(0).unwrap();
    support::assert_no_messages(&device);
    renderer.frame_radiance().unwrap()
}

#[test]
fn a_white_body_in_a_white_room_cannot_be_seen() {
    let body = [("metallic", "0"), ("specular", "0")];
    let scene = procedural::generate("furnace", &body.map(|(a, b)| (a.into(), b.into()))).unwrap();
    let own = &scene.cameras[0];
    for camera in [orthographic(own, 3.0), with_lens(own, 0.5, 3.2)] {
        for name in ["path-tracing", "accurate"] {
            const FRAMES: u32 = 16;
            let mut view = view(camera.clone(), 32, 32, 2);
            view.jitter = true;
            let (device, mut renderer) = renderer(&scene, &view, &preset(name));
            renderer.add_samples(0, FRAMES).unwrap();
            support::assert_no_messages(&device);
            let mean = renderer.sums().unwrap().mean(FRAMES);
            let picture = mean.iter().map(|pixel| pixel.x).sum::<f64>() / mean.len() as f64;
            println!("{name}, {:?}: {picture}", camera.projection);
            assert!((picture - 1.0).abs() < 5e-3, "{name}: {picture}");
        }
    }
}

#[test]
fn a_renderer_refuses_a_camera_of_another_model() {
    let scene = procedural::generate("cornell", &[]).unwrap();
    let own = &scene.cameras[0];
    let others = [orthographic(own, 3.0), with_lens(own, 0.1, 3.0)];
    let (_device, mut renderer) = renderer(&scene, &view(own.clone(), 8, 8, 0), &preset("fast"));
    for other in others {
        renderer.set_camera(&other);
        let error = renderer.single_frame(0).unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.to_string().contains("Pinhole"), "{error}");
    }
    renderer.set_camera(own);
    renderer.single_frame(0).unwrap();
}

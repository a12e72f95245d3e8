//! Tests of motion vectors against reprojection in f64.

use crate::{playroom, support};
use glam::{DVec2, DVec3};
use headwater::device_scene::GpuScene;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::camera::Projection;
use headwater::scene::{Camera, Scene};
use headwater::shader_interface::NONE;
use std::sync::Arc;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

fn is_perspective(camera: &Camera) -> bool {
    matches!(camera.projection, Projection::Perspective { .. })
}

/// The position in the picture, in pixels, at which a camera sees a point.
fn project(camera: &Camera, point: DVec3) -> DVec2 {
    let seen = camera.camera_to_world.inverse().transform_point3(point);
    let half = camera.projection.half_height();
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    let distance = if is_perspective(camera) { -seen.z } else { 1.0 };
    let plane = DVec2::new(seen.x / (half * aspect), -seen.y / half) / distance;
    (plane * 0.5 + 0.5) * DVec2::new(f64::from(WIDTH), f64::from(HEIGHT))
}

/// The origin and the unit direction of the ray through the centre of a pixel.
fn ray(camera: &Camera, x: u32, y: u32) -> (DVec3, DVec3) {
    let half = camera.projection.half_height();
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    let u = (f64::from(x) + 0.5) / f64::from(WIDTH) * 2.0 - 1.0;
    let v = (f64::from(y) + 0.5) / f64::from(HEIGHT) * 2.0 - 1.0;
    let (to_world, beside) = (
        camera.camera_to_world,
        DVec3::new(u * half * aspect, -v * half, 0.0),
    );
    let (origin, direction) = match is_perspective(camera) {
        true => (DVec3::ZERO, beside + DVec3::NEG_Z),
        false => (beside, DVec3::NEG_Z),
    };
    (
        to_world.transform_point3(origin),
        to_world.transform_vector3(direction).normalize(),
    )
}

/// The largest error of a motion vector and the longest vector, both in pixels, and the number of pixels that show no
/// surface.
fn check(scene: &Scene, before: f64, now: f64) -> (f64, f64, usize) {
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: scene.camera_at(0, before).unwrap(),
        width: WIDTH,
        height: HEIGHT,
        seed: 0,
        bounces: 0,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let settings = Settings::default();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    for time in [before, now] {
        renderer.set_time(time);
        renderer.set_camera(&scene.camera_at(0, time).unwrap());
        renderer.skip_frame(0).unwrap();
    }
    let surfaces = renderer.primary_surfaces().unwrap();
    support::assert_no_messages(&device);
    let (then, here) = (scene.pose_at(before).unwrap(), scene.pose_at(now).unwrap());
    let (eye, old_eye) = (&here.cameras[0], &then.cameras[0]);
    let (mut worst, mut longest, mut empty) = (0.0_f64, 0.0_f64, 0);
    for (i, surface) in (0..).zip(&surfaces) {
        let (from, ray) = ray(eye, i % WIDTH, i / WIDTH);
        let expected = if surface.instance == NONE {
            empty += 1;
            // All pixels of an orthographic camera show the same direction.
            let far = 1e12 * ray;
            let vector = project(old_eye, old_eye.camera_to_world.translation + far)
                - project(eye, from + far);
            if is_perspective(eye) {
                vector
            } else {
                DVec2::ZERO
            }
        } else {
            let point = from + ray * f64::from(surface.depth);
            let transform =
                |scene: &Scene| scene.instances[surface.instance as usize].object_to_world;
            let old = transform(&then) * transform(&here).inverse();
            project(old_eye, old.transform_point3(point)) - project(eye, point)
        };
        worst = worst.max((surface.motion.as_dvec2() - expected).length());
        longest = longest.max(expected.length());
    }
    (worst, longest, empty)
}

#[test]
fn vectors_lead_to_where_things_were() {
    let mut scene = playroom(&["camera", "object", "light"], 1.0);
    // Without walls there is something to see beyond.
    scene.instances[0].object_to_world.translation.y = -50.0;
    let perspective = scene.cameras[0].projection;
    for projection in [perspective, Projection::Orthographic { height: 4.0 }] {
        scene.cameras[0].projection = projection;
        for (before, now) in [(0.0, 0.1), (1.0, 1.25), (5.0, 4.5)] {
            let (worst, longest, empty) = check(&scene, before, now);
            println!(
                "{projection:?}, {before} → {now}: off by {worst:.5} of up to {longest:.2} pixels; {empty} empty"
            );
            assert!(worst < 2e-3, "{worst} pixels off");
            assert!(longest > 2.0 && empty > 100);
        }
    }
}

#[test]
fn what_stands_still_has_no_motion() {
    let scene = playroom(&["object"], 1.0);
    let (worst, longest, _) = check(&scene, 20.0, 21.0);
    assert!(worst < 1e-9 && longest < 1e-9, "{worst} {longest}");
}

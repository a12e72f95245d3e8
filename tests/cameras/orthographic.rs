//! Tests of orthographic cameras: known surfaces at known pixels and depths, the sky, and reuse that does not depend on how far
//! away the camera stands.

use crate::support::brute_force::camera_ray;
use crate::{frame, orthographic, preset, renderer, support, view};
use glam::{DVec3, Vec3};
use headwater::device_scene::GpuScene;
use headwater::procedural;
use headwater::render::{Lighting, Renderer, ResolvedSettings, Tracking};
use headwater::scene::environment::sky;
use headwater::scene::{Camera, Material, Scene};
use headwater::shader_interface::NONE;
use std::sync::Arc;

fn emitter(radiance: Vec3) -> Material {
    Material {
        emission: radiance,
        double_sided: true,
        ..Material::lambert("emitter", Vec3::ZERO)
    }
}

/// A camera that looks along −Z at (0.2, 0.1, 0) from the distance `distance`, with 8 pixels per scene unit.
fn straight(distance: f64) -> Camera {
    let target = DVec3::new(0.2, 0.1, 0.0);
    let camera = support::look_at(target + DVec3::Z * distance, target, DVec3::Y, 1.0);
    orthographic(&camera, 4.0)
}

#[test]
fn a_square_has_its_size_at_every_distance() {
    let corner = Vec3::new(-0.5, -0.5, 0.0);
    let square = support::quad(corner, Vec3::X, Vec3::Y);
    let scene = support::scene_of(&[(emitter(Vec3::new(2.0, 3.0, 5.0)), square)]);
    for distance in [0.5, 7.0, 700.0] {
        for name in ["path-tracing", "accurate"] {
            let view = view(straight(distance), 64, 32, 0);
            let picture = frame(&scene, &view, &preset(name));
            for (pixel, radiance) in picture.iter().enumerate() {
                let (x, y) = (pixel % 64, pixel / 64);
                // The edges of the square are at 26.4, 34.4, 12.8 and 20.8 pixels.
                let inside = (26..34).contains(&x) && (13..21).contains(&y);
                let expected = if inside { [2.0, 3.0, 5.0] } else { [0.0; 3] };
                assert_eq!(*radiance, expected, "{name}, {distance}: pixel {x}, {y}");
            }
        }
    }
}

#[test]
fn a_tilted_plane_has_the_depth_along_the_ray() {
    const SIZE: [u32; 2] = [48, 40];
    let (corner, u, v) = (
        Vec3::new(-1.5, -1.0, -2.0),
        Vec3::new(3.0, 0.5, 1.0),
        Vec3::new(-0.25, 1.5, 3.0),
    );
    let scene = support::scene_of(&[(emitter(Vec3::ONE), support::quad(corner, u, v))]);
    let eye = DVec3::new(3.0, 4.0, 5.0);
    let camera = support::look_at(
        eye,
        DVec3::new(0.1, 0.2, 0.0),
        DVec3::new(0.3, 1.0, 0.1),
        1.0,
    );
    let camera = orthographic(&camera, 3.0);
    let (device, mut renderer) = renderer(
        &scene,
        &view(camera.clone(), SIZE[0], SIZE[1], 0),
        &preset("fast"),
    );
    let surfaces = renderer.primary_surfaces().unwrap();
    support::assert_no_messages(&device);
    let [corner, u, v] = [corner, u, v].map(|vector| vector.as_dvec3());
    let normal = u.cross(v).normalize();
    let forward = -camera.camera_to_world.matrix3.z_axis;
    let (mut seen, mut worst) = (0, 0.0_f64);
    for (index, surface) in (0..).zip(&surfaces) {
        let (from, direction) = camera_ray(&camera, [index % SIZE[0], index / SIZE[0]], SIZE);
        assert!((direction - forward).length() < 1e-12);
        let depth = (corner - from).dot(normal) / direction.dot(normal);
        let point = from + depth * direction - corner;
        // The parallelogram's coordinates of the point.
        let across = |a: DVec3, b: DVec3| point.cross(b).dot(normal) / a.cross(b).dot(normal);
        let inside = [across(u, v), across(v, u)].map(|at| at.min(1.0 - at));
        let margin = inside[0].min(inside[1]);
        if margin.abs() < 1e-4 {
            continue;
        }
        assert_eq!(surface.instance != NONE, margin > 0.0, "pixel {index}");
        if margin > 0.0 {
            seen += 1;
            worst = worst.max((f64::from(surface.depth) / depth - 1.0).abs());
        }
    }
    println!("{seen} pixels, off by {worst:e}");
    assert!(seen > 250 && worst < 1e-6, "{seen} {worst}");
}

#[test]
fn every_pixel_sees_the_same_direction_of_the_sky() {
    let mut scene = procedural::generate("cornell", &[]).unwrap();
    scene.environment = Some(sky::generate("sun=40,width=64").unwrap());
    // Away from the room, up into the sky.
    let eye = DVec3::new(0.0, 50.0, 0.0);
    let camera = support::look_at(eye, eye + DVec3::new(0.3, 0.7, 0.2), DVec3::Y, 0.5);
    for name in ["path-tracing", "balanced"] {
        let view_of = |camera| view(camera, 33, 17, 1);
        let wide = frame(
            &scene,
            &view_of(orthographic(&camera, 100.0)),
            &preset(name),
        );
        let perspective = frame(&scene, &view_of(camera.clone()), &preset(name));
        let centre = perspective[8 * 33 + 16];
        assert!(centre[0] > 0.0);
        assert!(wide.iter().all(|pixel| *pixel == centre), "{name}");
        assert!(perspective.iter().any(|pixel| *pixel != centre));
    }
}

/// The room as an orthographic camera sees it from the front, from the distance `distance`.
fn room(distance: f64) -> Scene {
    let mut scene = procedural::generate("cornell", &[]).unwrap();
    let target = DVec3::new(0.0, 1.0, 0.0);
    let camera = support::look_at(target + DVec3::Z * distance, target, DVec3::Y, 1.0);
    scene.cameras[0] = orthographic(&camera, 1.9);
    scene
}

/// The mean number of neighbours that a pixel merges in the second frame, and the mean age of its reservoir.
fn reuse(distance: f64) -> [f64; 2] {
    let scene = room(distance);
    let (device, selection) = support::open_device(None);
    let view = view(scene.cameras[0].clone(), 48, 48, 1);
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, selection.variant).unwrap());
    let settings = ResolvedSettings::new(&preset("accurate"), &uploaded, view.bounces);
    let tracking = Tracking {
        origins: true,
        ..Tracking::default()
    };
    let mut renderer = Renderer::tracking(&device, uploaded, &view, &settings, tracking).unwrap();
    for index in 0..3 {
        renderer.single_frame(index).unwrap();
    }
    support::assert_no_messages(&device);
    let reservoirs = renderer.reservoir_aovs(Lighting::Direct).unwrap();
    let mean = |of: &dyn Fn(usize) -> f64| {
        (0..reservoirs.len()).map(of).sum::<f64>() / reservoirs.len() as f64
    };
    [
        mean(&|i| f64::from(reservoirs[i].neighbours)),
        mean(&|i| f64::from(reservoirs[i].confidence)),
    ]
}

/// With the camera's position as the eye, everything would be similar from afar, and almost nothing from close by.
#[test]
fn reuse_does_not_depend_on_the_distance_of_the_camera() {
    let [close, usual, far] = [1.05, 4.0, 300.0].map(reuse);
    println!("{close:?} {usual:?} {far:?}");
    assert!(usual[0] > 1.0 && usual[1] > 2.0, "{usual:?}");
    for other in [close, far] {
        for (a, b) in usual.iter().zip(other) {
            assert!((a / b - 1.0).abs() < 0.02, "{usual:?} {other:?}");
        }
    }
}

/// From far away, a narrow perspective camera sees what an orthographic one sees.
#[test]
fn it_is_the_limit_of_a_far_perspective_camera() {
    const SAMPLES: u32 = 64;
    let scene = room(4.0);
    let far = 4000.0_f64;
    let target = DVec3::new(0.0, 1.0, 0.0);
    let fov = 2.0 * (0.95 / far).atan();
    let perspective = support::look_at(target + DVec3::Z * far, target, DVec3::Y, fov);
    let [ours, limit] = [scene.cameras[0].clone(), perspective].map(|camera| {
        let (device, mut renderer) =
            renderer(&scene, &view(camera, 32, 32, 3), &preset("path-tracing"));
        renderer.add_samples(0, SAMPLES).unwrap();
        support::assert_no_messages(&device);
        renderer.sums().unwrap().mean(SAMPLES)
    });
    let mut worst = 0.0_f64;
    for block in 0..16 {
        let sum = |picture: &[DVec3]| -> f64 {
            let pixels = (0..64).map(|i| (block / 4 * 8 + i / 8) * 32 + block % 4 * 8 + i % 8);
            pixels.map(|pixel| picture[pixel].element_sum()).sum()
        };
        worst = worst.max((sum(&ours) / sum(&limit) - 1.0).abs());
    }
    println!("a block is off by at most {worst}");
    assert!(worst < 0.04, "{worst}");
}

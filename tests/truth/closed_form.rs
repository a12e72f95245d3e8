//! Tests of direct light against a closed form.

use crate::comparison::{Comparison, exact, failures, on_device};
use crate::rooms::emitter;
use crate::support;
use crate::support::brute_force::camera_ray;
use glam::{DVec3, Vec3};
use headwater::render::View;
use headwater::scene::Material;
use std::f64::consts::PI;

/// The irradiance at a point with this normal from a polygon of radiance 1 that is entirely above the horizon; its corners
/// are clockwise as seen from the point (Lambert 1760; Baum, Rushmeier and Winget, "Improving radiosity solutions through
/// the use of analytically determined form-factors", 1989).
fn polygon_irradiance(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let toward: Vec<DVec3> = corners.iter().map(|c| (*c - point).normalize()).collect();
    let edges = toward.iter().zip(toward.iter().cycle().skip(1));
    let around: DVec3 = edges
        .map(|(a, b)| a.cross(*b).normalize() * a.angle_between(*b))
        .sum();
    0.5 * around.dot(normal).abs()
}

#[test]
fn a_quad_lights_a_plane_as_the_closed_form_says() {
    const SIZE: u32 = 16;
    const SAMPLES: u32 = 2048;
    let albedo = Vec3::new(0.8, 0.5, 0.2);
    let radiance = Vec3::new(3.0, 5.0, 9.0);
    // Tilted, so that no symmetry hides a fault, and above the plane everywhere.
    let (corner, u, v) = (
        Vec3::new(-0.5, 1.0, -0.75),
        Vec3::new(1.25, 0.25, 0.0),
        Vec3::new(0.0, 0.5, 1.5),
    );
    let floor = support::quad(Vec3::new(-8.0, 0.0, 8.0), Vec3::X * 16.0, -Vec3::Z * 16.0);
    let scene = support::scene_of(&[
        (Material::lambert("floor", albedo), floor),
        (emitter(radiance, 0.0), support::quad(corner, u, v)),
    ]);
    let corners = [corner, corner + u, corner + u + v, corner + v].map(|c| c.as_dvec3());
    assert!(u.cross(v).y < 0.0, "the emitter faces down");

    let mut comparisons = Vec::new();
    let points = [
        [0.0, 0.0],
        [1.5, 0.5],
        [-2.0, 1.0],
        [0.25, -3.0],
        [3.0, 3.0],
    ];
    for (number, [x, z]) in points.into_iter().enumerate() {
        let target = DVec3::new(x, 0.0, z);
        // From the side, under the emitter's lowest corner.
        let eye = target + DVec3::new(0.3, 0.5, 0.4);
        let camera = support::look_at(eye, target, DVec3::Y, 0.02);
        let pixels = (0..SIZE * SIZE).map(|p| [p % SIZE, p / SIZE]);
        let irradiance: f64 = pixels
            .map(|pixel| {
                let (origin, direction) = camera_ray(&camera, pixel, [SIZE, SIZE]);
                let point = origin - direction * (origin.y / direction.y);
                polygon_irradiance(point, DVec3::Y, &corners) / f64::from(SIZE * SIZE)
            })
            .sum();
        let view = View {
            camera,
            width: SIZE,
            height: SIZE,
            seed: 7 + number as u32,
            bounces: 1,
            jitter: false,
        };
        let picture = on_device(&scene, &view, SAMPLES);
        let all: Vec<usize> = (0..picture.mean.len()).collect();
        for channel in 0..3 {
            let wanted = f64::from(albedo[channel]) * f64::from(radiance[channel]) / PI;
            comparisons.push(Comparison {
                what: format!("point {x}, {z}, channel {channel}"),
                one: picture.mean_of(&all, channel),
                other: exact(wanted * irradiance),
                sharp: true,
            });
        }
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
}

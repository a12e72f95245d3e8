//! Tests of lenses: the circle of confusion of a small emitter against its closed form, and sharpness at the focus distance.

use crate::{preset, renderer, support, view, with_lens};
use glam::{DVec3, Vec3};
use headwater::scene::{Camera, Material, Scene};

const SIDE: u32 = 40;
const RADIANCE: f32 = 6.0;
/// The distance of the emitter from the camera.
const DISTANCE: f64 = 5.0;
/// The side of the square emitter, in scene units.
const EMITTER: f64 = 0.25;
/// Pixels per scene unit at distance 1 from the camera.
const PIXELS: f64 = 40.0;

/// An emitter that faces the camera, on its axis.
fn scene() -> Scene {
    let emitter = Material {
        emission: Vec3::splat(RADIANCE),
        ..Material::lambert("emitter", Vec3::ZERO)
    };
    let side = EMITTER as f32;
    let corner = Vec3::new(-0.5 * side, -0.5 * side, -(DISTANCE as f32));
    support::scene_of(&[(
        emitter,
        support::quad(corner, Vec3::X * side, Vec3::Y * side),
    )])
}

fn camera() -> Camera {
    let fov = 2.0 * (f64::from(SIDE) / PIXELS / 2.0).atan();
    support::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, fov)
}

/// The sum over the pixels of their mean radiance, the mean square of their distance from the centre of the picture, in
/// pixels, and the largest distance of a bright pixel.
fn blur(diameter: f64, focus: f64, integrator: &str, samples: u32) -> [f64; 3] {
    let mut view = view(with_lens(&camera(), diameter, focus), SIDE, SIDE, 0);
    view.jitter = true;
    let (device, mut renderer) = renderer(&scene(), &view, &preset(integrator));
    renderer.add_samples(0, samples).unwrap();
    support::assert_no_messages(&device);
    let mean = renderer.sums().unwrap().mean(samples);
    let (mut energy, mut square, mut reach) = (0.0, 0.0, 0.0_f64);
    for (pixel, radiance) in (0..).zip(mean) {
        let from_centre = |at: u32| f64::from(at) + 0.5 - 0.5 * f64::from(SIDE);
        let (x, y) = (from_centre(pixel % SIDE), from_centre(pixel / SIDE));
        energy += radiance.x;
        square += radiance.x * (x * x + y * y);
        if radiance.x > 0.0 {
            reach = reach.max(x.hypot(y));
        }
    }
    [energy, square / energy, reach]
}

/// A point of the emitter spreads over the circle of confusion: all of its light, in a disc.
#[test]
fn the_circle_of_confusion_has_its_size_and_all_of_the_light() {
    // In front of the plane of focus, behind it, and with the focus at infinity.
    for (diameter, focus) in [(1.6, 10.0), (0.8, 2.5), (1.25, f64::INFINITY)] {
        // Similar triangles, at distance 1: the lens seen from the emitter, less what the tilt of the rays takes back.
        let radius = 0.5 * diameter * (1.0 / DISTANCE - 1.0 / focus).abs() * PIXELS;
        let side = EMITTER / DISTANCE * PIXELS;
        let energy = f64::from(RADIANCE) * side * side;
        // The variances of a disc, of a square, and of the square pixels into which the light is sorted.
        let square = 0.5 * radius * radius + side * side / 6.0 + 1.0 / 6.0;
        for (integrator, samples) in [("path-tracing", 8192), ("fast", 2048)] {
            let [of_picture, mean_square, reach] = blur(diameter, focus, integrator, samples);
            println!(
                "{integrator}, aperture {diameter}, focus {focus}: energy {of_picture:.3} of {energy:.3}, square {mean_square:.3} of {square:.3}, reach {reach:.2} of {radius:.2}"
            );
            // Each of `hits` samples meets the emitter independently, if not stratified.
            let hits = side * side * f64::from(samples);
            let tolerance = 4.0 / hits.sqrt();
            assert!((of_picture / energy - 1.0).abs() < tolerance);
            assert!((mean_square / square - 1.0).abs() < tolerance);
            assert!((radius - 1.0..radius + 0.75 * side + 1.0).contains(&reach));
        }
    }
}

#[test]
fn what_is_in_focus_is_as_sharp_as_with_a_pinhole() {
    let pinhole = view(camera(), SIDE, SIDE, 0);
    let sharp = view(with_lens(&camera(), 1.5, DISTANCE), SIDE, SIDE, 0);
    for name in ["path-tracing", "fast"] {
        let [expected, seen] = [&pinhole, &sharp].map(|view| {
            let (device, mut renderer) = renderer(&scene(), view, &preset(name));
            renderer.add_samples(0, 8).unwrap();
            support::assert_no_messages(&device);
            renderer.sums().unwrap().mean(8)
        });
        assert!(expected.iter().any(|pixel| pixel.x > 0.0));
        // The emitter is two pixels wide: its edges lie between pixels, half a pixel from the nearest rays.
        assert_eq!(expected, seen, "{name}");
    }
}

/// AOVs are those of the pinhole in the centre of the lens.
#[test]
fn depths_are_those_of_a_pinhole() {
    let [pinhole, lens] = [camera(), with_lens(&camera(), 1.5, 2.0)].map(|camera| {
        let (_device, mut renderer) =
            renderer(&scene(), &view(camera, SIDE, SIDE, 0), &preset("fast"));
        renderer.single_frame(0).unwrap();
        renderer.primary_surfaces().unwrap()
    });
    assert!(pinhole.iter().any(|surface| surface.depth > 0.0));
    for (a, b) in pinhole.iter().zip(&lens) {
        assert_eq!(a.instance, b.instance);
        assert!((a.depth - b.depth).abs() <= 1e-6 * a.depth);
    }
}

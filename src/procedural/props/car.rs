//! A small round car of the 1950s, for the scene `garage`. It stands at the origin with its front towards +Z.
//! Lengths are in metres.

use crate::procedural::modelling::dual_contouring::{Detail, surface, ticks};
use crate::procedural::modelling::implicit::{carve, common, cushion, ellipsoid, join, limb};
use crate::procedural::modelling::{Model, Profile, Shape, dielectric, metal};
use crate::scene::Material;
use glam::{Vec3, vec3};

/// The distance of each wheel from the car's middle plane x = 0, in metres. The left and the right wheels are
/// twice as far apart.
const TRACK: f32 = 0.64;
/// The distance of each axle from the car's middle plane z = 0, in metres. The wheels and the wheel arches
/// are placed by it.
const BASE: f32 = 1.13;
/// The radius of the wheels, in metres. It is also the height of the axles, and the wheel arches are slightly
/// larger.
const WHEEL: f32 = 0.31;

/// The signed distance in metres to the outer surface of the body and the cabin, without windows and wheel
/// arches, which are cut out later. `m` is the point; the caller mirrors it to the side +x, because the car
/// is symmetric.
fn form(m: Vec3) -> f32 {
    let mut hull = cushion(m, vec3(0.0, 0.52, -0.05), vec3(0.68, 0.3, 1.7), 0.24);
    let bonnet = ellipsoid(m, vec3(0.0, 0.6, 0.95), vec3(0.5, 0.32, 0.92));
    hull = join(hull, bonnet, 0.12);
    for (z, long) in [(BASE + 0.02, 0.56), (-BASE + 0.04, 0.62)] {
        let wing = ellipsoid(m, vec3(0.6, 0.47, z), vec3(0.23, 0.36, long));
        hull = join(hull, wing, 0.07);
    }
    let pod = (vec3(0.56, 0.66, 1.5), 0.125);
    hull = join(hull, limb(m, pod, (vec3(0.53, 0.6, 1.0), 0.1)), 0.07);
    // Leaning in towards the roof, and falling towards the tail.
    let lean = 1.0 + 0.28 * (m.y - 0.8).max(0.0);
    let q = vec3(m.x * lean, m.y + 0.07 * (m.z + 0.1).powi(2), m.z);
    let cabin = cushion(q, vec3(0.0, 0.94, -0.38), vec3(0.67, 0.46, 1.06), 0.32);
    let form = join(hull, cabin, 0.13);
    common(form, 0.2 - m.y, 0.06)
}

/// The signed distance in metres to the volumes that are cut out of the cabin as windows. `m` is the point;
/// the caller mirrors it to the side +x, because the car is symmetric.
fn windows(m: Vec3) -> f32 {
    let side = |from: f32, to: f32| {
        let middle = vec3(0.85, 1.09, (from + to) / 2.0);
        cushion(m, middle, vec3(0.42, 0.165, (to - from) / 2.0), 0.08)
    };
    let ends = |z: f32, low: f32, half: f32| {
        let middle = vec3(0.0, (low + 1.22) / 2.0, z);
        cushion(m, middle, vec3(half, (1.22 - low) / 2.0, 0.6), 0.08)
    };
    side(-0.3, 0.34)
        .min(side(-0.98, -0.37))
        .min(ends(0.85, 0.93, 0.44))
        .min(ends(-1.7, 0.96, 0.34))
}

fn painted(p: Vec3) -> f32 {
    let m = vec3(p.x.abs(), p.y, p.z);
    let form = form(m);
    // Windows are cut deeper than the glass, so that the glass is in front of the paint.
    let mut d = common(form, join(form + 0.09, -windows(m), 0.02), 0.012);
    for z in [BASE, -BASE] {
        let round = (m.y - WHEEL).hypot(m.z - z) - WHEEL - 0.06;
        d = carve(d, round.max(0.42 - m.x), 0.025);
    }
    // The seam of the doors.
    let seam = cushion(p, vec3(0.0, 0.72, 0.02), vec3(9.0, 0.42, 0.36), 0.06).abs();
    d + 0.012 * (1.0 - seam / 0.02).max(0.0) * f32::from(m.y < 0.9)
}

fn glass(p: Vec3) -> f32 {
    let m = vec3(p.x.abs(), p.y, p.z);
    common(form(m) + 0.013, 0.8 - m.y, 0.02)
}

/// A rod along X with round ends, for bumpers and door handles. `middle` is its centre, and `length` includes
/// the ends. All lengths are in metres.
fn rod(middle: Vec3, length: f32, radius: f32) -> Shape {
    let straight = length - 2.0 * radius;
    Profile::new(0.0, -length / 2.0)
        .arc(radius, radius, 90.0, 5)
        .line(0.0, straight)
        .arc(-radius, radius, 90.0, 5)
        .turned(16)
        .map(|p| vec3(p.y, -p.x, p.z) + middle)
}

/// Rotates a shape so that its axis, which is +Y, points to the front of the car (+Z), and then moves it by
/// `to` in metres. Lamps, which are made by turning a profile around +Y, are placed with it.
fn forwards(shape: Shape, to: Vec3) -> Shape {
    shape.map(|p| vec3(p.x, -p.z, p.y) + to)
}

fn wheels(model: &mut Model, chrome: &Material) {
    let tyre = Profile::new(0.19, -0.085)
        .line(0.09, -0.005)
        .arc(0.025, 0.03, 80.0, 5)
        .line(0.0, 0.12)
        .arc(-0.025, 0.03, 80.0, 5)
        .line(-0.09, -0.005)
        .line(0.0, -0.17)
        .turned(32);
    let cap = Profile::new(0.2, 0.0)
        .line(0.0, 0.075)
        .line(-0.015, 0.012)
        .arc(-0.05, -0.025, -60.0, 4)
        .line(-0.01, 0.0)
        .arc(-0.125, 0.045, 50.0, 8)
        .capped()
        .turned(32);
    let rubber = dielectric("tyres", Vec3::splat(0.025), 0.6);
    for side in [-1.0, 1.0] {
        for z in [BASE, -BASE] {
            // Upright becomes sideways, outwards on either side.
            let transform = |p: Vec3| vec3(side * (p.y + TRACK), WHEEL + side * -p.x, p.z + z);
            model.add(&rubber, tyre.clone().map(transform));
            model.add(chrome, cap.clone().map(transform));
        }
    }
}

fn front(model: &mut Model, chrome: &Material) {
    let ring = Profile::new(0.126, -0.06)
        .line(0.0, 0.07)
        .arc(-0.028, 0.0, 180.0, 6)
        .line(0.0, -0.07);
    let lens = Profile::new(0.104, 0.0)
        .arc(-0.104, 0.045, 60.0, 8)
        .turned(32);
    let clear = dielectric("lamp glass", vec3(0.75, 0.76, 0.74), 0.12);
    for x in [-0.56, 0.56] {
        let middle = vec3(x, 0.66, 1.635);
        model.add(chrome, forwards(ring.turned(32), middle));
        model.add(&clear, forwards(lens.clone(), middle));
    }
    for (z, y) in [(1.86, 0.34), (-1.8, 0.38)] {
        model.add(chrome, rod(vec3(0.0, y, z), 1.3, 0.042));
        for x in [-0.3, 0.3] {
            let upright = rod(Vec3::ZERO, 0.2, 0.034);
            model.add(
                chrome,
                upright.map(|p| vec3(x - p.y, y + 0.02 + p.x, z + p.z)),
            );
        }
    }
    for x in [-0.7, 0.7] {
        let handle = rod(Vec3::ZERO, 0.14, 0.012);
        model.add(
            chrome,
            handle.map(|p| vec3(x + p.z, 0.82 + p.y, -0.22 - p.x)),
        );
    }
}

/// The whole car, as one shape for each material. It stands on the ground at the origin and faces +Z; it is
/// about 1.7 m wide and 3.7 m long. `paint` is the colour of its body (linear RGB).
pub fn car(paint: Vec3) -> Model {
    let grid = |step: f32| {
        [
            ticks(-0.95, &[(0.95, step)]),
            ticks(0.1, &[(1.55, step)]),
            ticks(-2.0, &[(2.0, step)]),
        ]
    };
    let weight = |_| 1.0;
    let mut model = Model::default();
    let body = Detail {
        triangles: 9000,
        weight,
    };
    let body = surface(&grid(0.024), &body, painted);
    model.add(&dielectric("car paint", paint, 0.16), body);
    let panes = Detail {
        triangles: 2000,
        weight,
    };
    let panes = surface(&grid(0.04), &panes, glass);
    model.add(&dielectric("car glass", Vec3::splat(0.015), 0.06), panes);
    let chrome = metal("chrome", vec3(0.78, 0.79, 0.8), 0.12);
    wheels(&mut model, &chrome);
    front(&mut model, &chrome);
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_and_panes_are_closed() {
        for (material, shape) in &car(Vec3::ONE).0[..2] {
            assert!(shape.is_closed(), "{}", material.name);
            assert!(shape.signed_volume() > 0.0, "{}", material.name);
        }
    }
}

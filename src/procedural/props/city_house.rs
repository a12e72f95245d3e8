//! Houses for the scene `city-grid`, which shows a city from above. They have bands of windows, and flat
//! roofs with water tanks and signs.

use crate::base::random::Random;
use crate::procedural::modelling::{Model, Shape, dielectric, emitter, lathe, metal};
use crate::scene::Material;
use glam::Vec3;

/// The height of a storey of a house, in metres. It is the vertical distance from one band of windows to the next.
pub const STOREY: f32 = 3.4;

/// Adds a house with the middle of its foot at `foot`. `size` has its width, height and depth in metres; the height decides
/// the number of storeys. Each storey has bands of glass between piers. `random` chooses the colours, the objects on the
/// roof, and the windows that emit light; these are about the fraction `lit` of all windows.
pub fn house(model: &mut Model, random: &mut Random, foot: Vec3, size: Vec3, lit: f32) {
    let wall = random.pick(&[
        [0.42, 0.3, 0.23],
        [0.36, 0.36, 0.38],
        [0.5, 0.45, 0.38],
        [0.3, 0.22, 0.2],
        [0.45, 0.47, 0.48],
    ]);
    let wall = Material::lambert("wall", Vec3::from(wall));
    let glass = dielectric("window band", Vec3::splat(0.03), 0.12);
    let storeys = (size.y / STOREY) as u32;
    let middle = foot + Vec3::Y * size.y / 2.0;
    model.add(&wall, Shape::chunk(middle, size));
    let tints = [[1.5, 0.85, 0.32], [1.3, 0.95, 0.55], [0.8, 1.0, 1.2]];
    let tint = Vec3::from(random.pick(&tints));
    // East, north, west, south: the wall's outward axis, and the one along it.
    for (out, along, half, length) in [
        (Vec3::X, Vec3::NEG_Z, size.x / 2.0, size.z),
        (Vec3::NEG_Z, Vec3::NEG_X, size.z / 2.0, size.x),
        (Vec3::NEG_X, Vec3::Z, size.x / 2.0, size.z),
        (Vec3::Z, Vec3::X, size.z / 2.0, size.x),
    ] {
        let fields = (length / 2.6).max(1.0) as u32;
        let step = length / fields as f32;
        let at = |t: f32, y: f32, depth: f32| {
            foot + out * (half + depth) + along * (t - length / 2.0) + Vec3::Y * y
        };
        let bar = |from: Vec3, to: Vec3| Shape::block(from.min(to), from.max(to));
        for storey in 0..storeys {
            let (low, high) = (storey as f32 * STOREY + 1.0, storey as f32 * STOREY + 2.8);
            model.add(
                &glass,
                bar(at(0.3, low, -0.2), at(length - 0.3, high, 0.04)),
            );
            for field in 0..fields {
                if random.unit() < lit {
                    let corner = at(field as f32 * step + 0.35, low + 0.1, 0.05);
                    let pane =
                        Shape::quad(corner, along * (step - 0.7), Vec3::Y * (high - low - 0.2));
                    let dim = random.pick(&[0.35, 0.7, 1.0]);
                    model.add(&emitter("lit window", tint * dim), pane);
                }
            }
        }
        for field in 0..=fields {
            let t = (field as f32 * step).clamp(0.2, length - 0.2);
            model.add(
                &wall,
                bar(at(t - 0.2, 0.1, -0.1), at(t + 0.2, size.y - 0.1, 0.16)),
            );
        }
        // A parapet around the roof.
        model.add(
            &wall,
            bar(
                at(0.0, size.y - 0.3, 0.2),
                at(length - 0.25, size.y + 0.8, -0.25),
            ),
        );
    }
    roof(model, random, foot + Vec3::Y * size.y, size);
}

/// Adds the objects on the flat roof of a house, which `random` chooses: boxes, sometimes a water tank, a lamp or a sign.
/// Houses above 24 m also get a red light. `top` is the middle of the roof, and `size` the size of the house, in metres.
fn roof(model: &mut Model, random: &mut Random, top: Vec3, size: Vec3) {
    let grey = dielectric("roof box", Vec3::splat(0.3), 0.6);
    let free = Vec3::new(size.x / 2.0 - 1.8, 0.0, size.z / 2.0 - 1.8);
    let spot = |random: &mut Random| {
        top + free * Vec3::new(random.between(-1.0, 1.0), 0.0, random.between(-1.0, 1.0))
    };
    for _ in 0..4 {
        let box_size = Vec3::new(
            random.between(0.8, 2.4),
            random.between(0.6, 1.8),
            random.between(0.8, 2.4),
        );
        model.add(
            &grey,
            Shape::chunk(spot(random) + Vec3::Y * (box_size.y / 2.0 - 0.1), box_size),
        );
    }
    if size.y < 20.0 && random.unit() < 0.5 {
        let wood = dielectric("water tank", Vec3::new(0.25, 0.15, 0.09), 0.6);
        let foot = spot(random) + Vec3::Y * 1.3;
        let tank: [&[(f32, f32)]; 3] = [
            &[(0.0, 0.0), (1.2, 0.0)],
            &[(1.2, 0.0), (1.2, 2.2)],
            &[(1.2, 2.2), (0.0, 3.0)],
        ];
        model.add(&wood, lathe(&tank, 14).flat().map(|p| p + foot));
        for (x, z) in [(-0.7, -0.7), (0.7, -0.7), (-0.7, 0.7), (0.7, 0.7)] {
            let leg = foot + Vec3::new(x, -0.6, z);
            model.add(&wood, Shape::chunk(leg, Vec3::new(0.14, 1.6, 0.14)));
        }
    }
    if random.unit() < 0.75 {
        let foot = spot(random);
        model.add(
            &grey,
            Shape::chunk(foot + Vec3::Y * 1.2, Vec3::new(0.1, 2.6, 0.1)),
        );
        let bulb = Shape::sphere(0)
            .flat()
            .map(|p| p * 0.13 + foot + Vec3::Y * 2.64);
        model.add(&emitter("roof lamp", Vec3::new(420.0, 300.0, 165.0)), bulb);
    }
    if random.unit() < 0.3 {
        sign(model, random, top, size);
    }
    if size.y > 24.0 {
        let mast = metal("mast", Vec3::splat(0.3), 0.4);
        model.add(&mast, Shape::cylinder(top - Vec3::Y * 0.1, 0.12, 7.0, 8));
        let beacon = Shape::sphere(0)
            .flat()
            .map(|p| p * 0.35 + top + Vec3::Y * 7.2);
        model.add(&emitter("beacon", Vec3::new(40.0, 1.5, 0.8)), beacon);
    }
}

/// Adds a sign at one edge of a flat roof; it consists of a frame with bars of coloured light. `top` is the middle of the
/// roof, and `size` has the width, height and depth of the house, in metres.
fn sign(model: &mut Model, random: &mut Random, top: Vec3, size: Vec3) {
    let steel = metal("sign frame", Vec3::splat(0.2), 0.5);
    let color = random.pick(&[
        [12.0, 0.7, 1.8],
        [0.6, 6.0, 12.0],
        [12.0, 4.0, 0.4],
        [0.8, 10.0, 2.0],
    ]);
    let light = emitter("roof sign", Vec3::from(color));
    let along_x = random.unit() < 0.5;
    let turn = |v: Vec3| if along_x { v } else { Vec3::new(v.z, v.y, v.x) };
    let (deep, long) = if along_x {
        (size.z, size.x)
    } else {
        (size.x, size.z)
    };
    let foot = top + turn(Vec3::Z * (deep / 2.0 - 0.7));
    let half = (long / 2.0 - 1.0).min(3.5);
    for x in [-0.8, 0.0, 0.8] {
        let leg = foot + turn(Vec3::X * (half * x)) + Vec3::Y * 1.6;
        model.add(&steel, Shape::chunk(leg, turn(Vec3::new(0.1, 3.4, 0.1))));
    }
    for row in 0..4 {
        let length = half * random.between(1.0, 2.0);
        let bar = foot + Vec3::Y * (1.5 + 0.55 * row as f32) + turn(Vec3::Z * 0.12);
        model.add(
            &light,
            Shape::chunk(bar, turn(Vec3::new(length, 0.28, 0.1))),
        );
    }
}

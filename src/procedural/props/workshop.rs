//! The contents of the scene `garage`: a workbench, tools, shelves, crates and drums. Lengths are in metres.

use crate::base::random::Random;
use crate::procedural::modelling::{Model, Profile, Shape, dielectric, metal};
use crate::scene::Material;
use glam::{Mat3, Vec3, vec3};

/// Adds all shapes of the model `from` to the model `into`, so that an object that was made at the origin stands at its
/// place. The shapes are rotated by `degrees` around +Y, and then moved by `to` in metres.
pub fn put(into: &mut Model, from: Model, degrees: f32, to: Vec3) {
    let turn = Mat3::from_rotation_y(degrees.to_radians());
    for (material, shape) in from.0 {
        into.add(&material, shape.map(|p| turn * p + to));
    }
}

fn timber(name: &str, light: f32) -> Material {
    dielectric(name, vec3(0.42, 0.27, 0.14) * light, 0.5)
}

/// A closed crate of wooden slats on a frame, which stands at the origin. `size` has its width, height and
/// depth (along x, y and z) in metres.
pub fn crate_of(size: Vec3) -> Model {
    let mut model = Model::default();
    let half = size / 2.0;
    let (frame, slat) = (timber("crate frame", 0.75), timber("crate slats", 1.0));
    let dark = Material::lambert("crate inside", vec3(0.03, 0.02, 0.015));
    let inside = Vec3::splat(0.05);
    model.add(
        &dark,
        Shape::block(
            vec3(-half.x, 0.0, -half.z) + inside,
            vec3(half.x, size.y, half.z) - inside,
        ),
    );
    for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let middle = vec3(x * (half.x - 0.045), half.y, z * (half.z - 0.045));
        model.add(
            &frame,
            Shape::chunk(middle, vec3(0.05, size.y - 0.03, 0.05)),
        );
    }
    let slats = (size.y / 0.12) as u32;
    let step = size.y / slats as f32;
    for i in 0..slats {
        let y = (i as f32 + 0.5) * step;
        for side in [-1.0, 1.0] {
            let long = vec3(size.x, step - 0.018, 0.019);
            model.add(
                &slat,
                Shape::chunk(vec3(0.0, y, side * (half.z - 0.009)), long),
            );
            let across = vec3(0.019, step - 0.018, size.z - 0.04);
            model.add(
                &slat,
                Shape::chunk(vec3(side * (half.x - 0.009), y, 0.0), across),
            );
        }
    }
    let boards = (size.x / 0.14) as u32;
    let step = size.x / boards as f32;
    for i in 0..boards {
        let x = (i as f32 + 0.5) * step - half.x;
        let lid = vec3(step - 0.01, 0.02, size.z - 0.002);
        model.add(&slat, Shape::chunk(vec3(x, size.y - 0.006, 0.0), lid));
    }
    model
}

/// A cardboard box with a strip of tape, which stands at the origin. `size` has its width, height and depth
/// in metres, and `random` chooses its tint. Shelves and the workbench carry such boxes.
fn carton(random: &mut Random, size: Vec3) -> Model {
    let mut model = Model::default();
    let tint = random.pick(&[[0.45, 0.31, 0.18], [0.36, 0.24, 0.13], [0.52, 0.4, 0.26]]);
    let up = Vec3::Y * size.y / 2.0;
    model.add(
        &Material::lambert("cardboard", Vec3::from(tint)),
        Shape::chunk(up, size),
    );
    let tape = dielectric("tape", vec3(0.5, 0.36, 0.16), 0.25);
    let over = vec3(0.05, size.y + 0.004, size.z + 0.004);
    model.add(&tape, Shape::chunk(up, over));
    model
}

/// A tin with a rim and a label, which stands at the origin. `radius` and `height` are in metres, and
/// `random` chooses the colour of the label. Shelves and the workbench carry such tins.
fn tin(random: &mut Random, radius: f32, height: f32) -> Model {
    let mut model = Model::default();
    let steel = metal("tin", Vec3::splat(0.6), 0.3);
    let body = Profile::new(0.0, 0.0)
        .line(radius, 0.0)
        .line(0.0, height)
        .arc(-0.012, 0.0, 180.0, 5)
        .line(0.0, -0.01)
        .capped()
        .turned(28);
    model.add(&steel, body);
    let paint = random.pick(&[
        [0.55, 0.05, 0.04],
        [0.04, 0.16, 0.4],
        [0.6, 0.42, 0.05],
        [0.07, 0.3, 0.14],
        [0.6, 0.58, 0.52],
    ]);
    let label = Profile::new(radius + 0.0015, height * 0.12).line(0.0, height * 0.7);
    model.add(
        &dielectric("label", Vec3::from(paint), 0.35),
        label.turned(28),
    );
    model
}

/// Five steel shelves above each other, 2.2 m high and `wide` metres along X, with their backs towards −Z.
/// Boxes and tins fill each shelf, at most `things` of them per shelf; `random` chooses them.
pub fn shelves(random: &mut Random, wide: f32, things: u32) -> Model {
    let mut model = Model::default();
    let steel = metal("shelf", vec3(0.2, 0.24, 0.27), 0.45);
    let deep = 0.42;
    for (x, z) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
        let foot = vec3(x * wide, 1.1, z * deep);
        model.add(&steel, Shape::chunk(foot, vec3(0.04, 2.2, 0.04)));
    }
    let boards = 5;
    for board in 0..boards {
        let y = 0.12 + 0.5 * board as f32;
        let size = vec3(wide - 0.042, 0.03, deep + 0.03);
        model.add(&steel, Shape::chunk(Vec3::Y * y, size));
        let mut x = -wide / 2.0 + 0.04;
        for _ in 0..things {
            let size = vec3(
                random.between(0.14, 0.42),
                random.between(0.12, 0.36),
                random.between(0.2, 0.34),
            );
            let is_tin = random.unit() < 0.4;
            let width = if is_tin {
                size.x.min(0.2)
            } else {
                size.x + 0.03
            };
            if x + width > wide / 2.0 - 0.04 {
                break;
            }
            let at = vec3(x + width / 2.0, y + 0.014, random.between(-0.04, 0.05));
            let thing = if is_tin {
                tin(random, width * 0.46, size.y.min(0.26))
            } else {
                carton(random, size)
            };
            put(&mut model, thing, random.between(-5.0, 5.0), at);
            x += width + random.between(0.02, 0.12);
        }
    }
    model
}

/// A workbench, 2.4 m wide and 0.9 m high, with a vise, a toolbox, tins and boxes. It stands at the origin,
/// and its back is towards −Z. `random` chooses the sizes and colours of tins and boxes.
pub fn bench(random: &mut Random) -> Model {
    let mut model = Model::default();
    let (top, leg) = (timber("bench top", 0.9), timber("bench legs", 0.55));
    for plank in 0..4 {
        let z = -0.27 + 0.18 * plank as f32;
        model.add(
            &top,
            Shape::chunk(vec3(0.0, 0.88, z), vec3(2.4, 0.06, 0.177)),
        );
    }
    for (x, z) in [(-1.08, -0.28), (-1.08, 0.28), (1.08, -0.28), (1.08, 0.28)] {
        model.add(
            &leg,
            Shape::chunk(vec3(x, 0.426, z), vec3(0.09, 0.848, 0.09)),
        );
    }
    model.add(
        &leg,
        Shape::chunk(vec3(0.0, 0.3, 0.0), vec3(2.2, 0.035, 0.6)),
    );
    model.add(
        &leg,
        Shape::chunk(vec3(0.0, 0.78, 0.3), vec3(2.06, 0.14, 0.03)),
    );
    let iron = metal("vise", vec3(0.12, 0.2, 0.28), 0.35);
    for (middle, size) in [
        (vec3(0.6, 0.955, 0.2), vec3(0.16, 0.09, 0.22)),
        (vec3(0.6, 1.04, 0.17), vec3(0.2, 0.08, 0.06)),
        (vec3(0.6, 1.0, 0.4), vec3(0.2, 0.16, 0.06)),
        (vec3(0.6, 0.96, 0.3), vec3(0.07, 0.06, 0.24)),
    ] {
        model.add(&iron, Shape::chunk(middle, size));
    }
    let bar = Shape::cylinder(Vec3::Y * -0.14, 0.009, 0.28, 12);
    model.add(
        &metal("bar", Vec3::splat(0.7), 0.2),
        bar.map(|p| p + vec3(0.6, 0.96, 0.455)),
    );
    let red = dielectric("toolbox", vec3(0.5, 0.03, 0.02), 0.25);
    model.add(
        &red,
        Shape::chunk(vec3(-0.65, 1.02, -0.08), vec3(0.5, 0.22, 0.26)),
    );
    let handle = metal("toolbox handle", Vec3::splat(0.6), 0.25);
    model.add(
        &handle,
        Shape::chunk(vec3(-0.65, 1.16, -0.08), vec3(0.22, 0.015, 0.03)),
    );
    for x in [-0.755, -0.545] {
        model.add(
            &handle,
            Shape::chunk(vec3(x, 1.141, -0.08), vec3(0.015, 0.024, 0.03)),
        );
    }
    for i in 0..5 {
        let at = vec3(-0.1 + 0.16 * i as f32, 0.909, random.between(-0.28, -0.14));
        let size = (random.between(0.045, 0.07), random.between(0.1, 0.2));
        put(&mut model, tin(random, size.0, size.1), 0.0, at);
    }
    for x in [-0.7, 0.1, 0.7] {
        let size = vec3(
            random.between(0.3, 0.5),
            random.between(0.2, 0.36),
            random.between(0.3, 0.4),
        );
        put(&mut model, carton(random, size), 3.0, vec3(x, 0.317, 0.0));
    }
    model
}

/// A board, 2.2 m wide and 0.9 m high, on which twelve tools hang. The middle of its lower edge is at the
/// origin, and it faces +Z. `random` chooses the sizes and grips of the tools.
pub fn tools(random: &mut Random) -> Model {
    let mut model = Model::default();
    let board = Material::lambert("tool board", vec3(0.5, 0.42, 0.3));
    model.add(
        &board,
        Shape::chunk(vec3(0.0, 0.45, 0.01), vec3(2.2, 0.9, 0.02)),
    );
    let steel = metal("tools", vec3(0.62, 0.63, 0.65), 0.25);
    let grips = [
        dielectric("red grips", vec3(0.55, 0.03, 0.02), 0.3),
        dielectric("yellow grips", vec3(0.65, 0.45, 0.03), 0.3),
        timber("handles", 1.2),
    ];
    let upright = |x: f32, y: f32, radius: f32, long: f32| {
        Shape::cylinder(vec3(x, y, 0.045), radius, long, 12)
    };
    for (i, x) in (0..12).map(|i| (i, -0.98 + 0.17 * i as f32)) {
        let long = random.between(0.2, 0.34);
        let grip = &grips[random.index(3)];
        match i % 3 {
            0 => {
                model.add(grip, upright(x, 0.3, 0.014, long + 0.1));
                let head = vec3(x, 0.4 + long, 0.045);
                model.add(&steel, Shape::chunk(head, vec3(0.12, 0.04, 0.035)));
            }
            1 => {
                let shaft = vec3(x, 0.5, 0.035);
                model.add(&steel, Shape::chunk(shaft, vec3(0.028, long, 0.012)));
                for (end, size) in [(-0.5, 0.045), (0.5, 0.06)] {
                    let ring = Shape::cylinder(Vec3::ZERO, size, 0.016, 6);
                    let to = vec3(x, 0.5 + end * long, 0.027);
                    model.add(&steel, ring.map(|p| vec3(p.x, -p.z, p.y) + to));
                }
            }
            _ => {
                model.add(grip, upright(x, 0.55, 0.018, 0.11));
                model.add(&steel, upright(x, 0.55 - long, 0.005, long));
            }
        }
    }
    model
}

/// An oil drum, 0.87 m high and about 0.6 m wide, which stands at the origin. `paint` is its colour (linear
/// RGB).
pub fn drum(paint: Vec3) -> Model {
    let mut model = Model::default();
    let mut side = Profile::new(0.0, 0.0).line(0.29, 0.0);
    for _ in 0..3 {
        side = side.line(0.0, 0.26).arc(0.0, 0.03, 180.0, 6);
    }
    let drum = side.line(-0.012, 0.0).line(0.0, -0.02).capped();
    model.add(&dielectric("drum", paint, 0.3), drum.turned(40));
    model
}

/// A pile of `count` tyres that lie on each other, at the origin. Each tyre is 0.2 m high and 0.64 m wide.
pub fn tyres(count: u32) -> Model {
    let mut model = Model::default();
    let rubber = dielectric("old tyres", Vec3::splat(0.03), 0.6);
    let tyre = Profile::new(0.2, 0.16)
        .line(0.0, -0.14)
        .line(0.08, -0.02)
        .arc(0.04, 0.04, 80.0, 4)
        .line(0.0, 0.12)
        .arc(-0.04, 0.04, 80.0, 4)
        .line(-0.08, -0.02)
        .line(0.0, -0.02)
        .turned(36);
    for i in 0..count {
        let aside = 0.03 * (i as f32 * 2.4).sin();
        let to = vec3(aside, 0.202 * i as f32, -aside);
        model.add(&rubber, tyre.clone().map(|p| p + to));
    }
    model
}

//! The scene `garage`: a garage with a small car, a workbench, shelves and a bronze bust, under a few plain lamps. It tests
//! small highlights on metal and paint. Lengths are in metres, and the floor is at height 0.

use crate::base::random::Random;
use crate::procedural::modelling::{
    Builder, Model, Profile, SINK, Shape, dielectric, emitter, metal,
};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::procedural::props::car::car;
use crate::procedural::props::{statue, workshop};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3, vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "seed",
        doc: "Seed of what lies about, and of the bust",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
    Parameter {
        name: "paint",
        doc: "Colour of the car",
        default: "red",
        values: Range::Words(&["red", "blue", "green", "cream"]),
    },
    Parameter {
        name: "things",
        doc: "Boxes and tins on each shelf at most",
        default: "8",
        values: Range::Whole(0, 100),
    },
];

/// Half the width of the garage, in metres: the side walls are at x = ±`SIDE`.
const SIDE: f32 = 3.6;
/// The height of the ceiling above the floor, in metres. The walls reach up to it.
const HIGH: f32 = 3.2;
/// The z coordinate of the back wall, in metres. The rolling door is in this wall, and the workbench stands
/// at it.
const BACK: f32 = -4.6;
/// The z coordinate of the front wall, in metres. The wall is behind the camera and closes the room.
const FRONT: f32 = 4.4;
/// The height of the ground under the slabs of the floor, in metres. The walls reach down to it, so that no light leaks
/// through the joints between the slabs.
const DEEP: f32 = -0.02;
/// The x coordinates of the left and the right edge of the rolling door in the back wall, in metres. A post
/// of the frame stands at each.
const DOOR: (f32, f32) = (-3.15, -0.35);
/// The height of the rolling door above the floor, in metres; 20 slats of equal height fill it.
const DOOR_HIGH: f32 = 2.4;

/// Adds a wall of painted blocks, as high as the garage, with visible mortar in the joints. The wall is built with its foot
/// on the x axis, from 0 to `long` metres, and its visible side towards +Z; `transform` then moves it to its place.
fn blocks(model: &mut Model, random: &mut Random, long: f32, transform: impl Fn(Vec3) -> Vec3) {
    let mortar = Material::lambert("mortar", Vec3::splat(0.28));
    let wall = Shape::quad(Vec3::Y * DEEP, Vec3::X * long, Vec3::Y * (HIGH - DEEP));
    model.add(&mortar, wall.map(&transform));
    let (wide, high, joint) = (0.45, 0.2, 0.012);
    for row in 0..(HIGH / high) as u32 {
        let y = row as f32 * high;
        // Green up to chest height, white above.
        let paint = if row < 6 {
            vec3(0.16, 0.27, 0.22)
        } else {
            vec3(0.62, 0.6, 0.55)
        };
        let mut from = -wide * 0.5 * (row % 2) as f32;
        while from < long {
            let (left, right) = (from.max(0.0), (from + wide).min(long));
            if right - left > 3.0 * joint {
                let shade = random.pick(&[0.92, 1.0, 1.06]);
                let block = Shape::block(
                    vec3(left + joint / 2.0, y + joint / 2.0, -0.01),
                    vec3(right - joint / 2.0, y + high - joint / 2.0, 0.012),
                );
                model.add(
                    &dielectric("painted blocks", paint * shade, 0.55),
                    block.map(&transform),
                );
            }
            from += wide;
        }
    }
}

fn room(model: &mut Model, random: &mut Random) {
    let deep = FRONT - BACK;
    blocks(model, random, 2.0 * SIDE, |p| p + vec3(-SIDE, 0.0, BACK));
    blocks(model, random, deep, |p| vec3(-SIDE + p.z, p.y, FRONT - p.x));
    blocks(model, random, deep, |p| vec3(SIDE - p.z, p.y, BACK + p.x));
    let plaster = Material::lambert("plaster", Vec3::splat(0.5));
    let corner = vec3(-SIDE, DEEP, FRONT);
    model.add(
        &plaster,
        Shape::quad(corner, Vec3::Y * (HIGH - DEEP), Vec3::X * 2.0 * SIDE),
    );
    // Slabs with open joints over a dark ground.
    let ground = Material::lambert("joints", Vec3::splat(0.08));
    let corner = vec3(-SIDE, DEEP, BACK);
    model.add(
        &ground,
        Shape::quad(corner, Vec3::Z * deep, Vec3::X * 2.0 * SIDE),
    );
    for i in 0..4_u8 {
        for j in 0..5_u8 {
            let shade = random.between(0.27, 0.33);
            let low = vec3(1.8 * f32::from(i), DEEP, 1.8 * f32::from(j)) + corner;
            let top = vec3(low.x + 1.788, 0.0, low.z + 1.788);
            let slab = dielectric("concrete", vec3(1.0, 0.98, 0.94) * shade, 0.36);
            model.add(&slab, Shape::block(low, top));
        }
    }
    let corner = vec3(-SIDE, HIGH, BACK);
    let boards = Material::lambert("ceiling", vec3(0.42, 0.33, 0.24));
    model.add(
        &boards,
        Shape::quad(corner, Vec3::X * 2.0 * SIDE, Vec3::Z * deep),
    );
    let gaps = (2.0 * SIDE / 0.24) as u32;
    for i in 0..gaps {
        let x = -SIDE + (i as f32 + 0.5) * 0.24;
        let board = vec3(x, HIGH - 0.005, (BACK + FRONT) / 2.0);
        model.add(&boards, Shape::chunk(board, vec3(0.228, 0.02, deep)));
    }
    let steel = dielectric("beams", vec3(0.12, 0.14, 0.16), 0.4);
    for beam in 0..4 {
        let z = -3.5 + 2.1 * beam as f32;
        for (y, high, thick) in [(2.92, 0.02, 0.18), (3.04, 0.23, 0.02), (3.168, 0.03, 0.18)] {
            let middle = vec3(0.0, y, z);
            model.add(
                &steel,
                Shape::chunk(middle, vec3(2.0 * SIDE + 0.04, high, thick)),
            );
        }
    }
}

/// Adds the closed rolling door and its frame. They are in the back wall, behind the car.
fn door(model: &mut Model) {
    let mut slats = Profile::new(0.0, 0.0);
    for _ in 0..20 {
        slats = slats
            .arc(0.0, DOOR_HIGH / 20.0 - 0.012, 70.0, 5)
            .line(0.0, 0.012);
    }
    // Extruded along X, facing +Z.
    let to_back = |p: Vec3| vec3(-p.z, p.y, p.x + BACK + 0.06);
    let leaf = slats.drawn(-DOOR.1, -DOOR.0).map(to_back);
    model.add(&dielectric("door", vec3(0.34, 0.38, 0.4), 0.4), leaf);
    let steel = dielectric("door frame", vec3(0.1, 0.11, 0.12), 0.4);
    for x in [DOOR.0, DOOR.1] {
        let middle = vec3(x, DOOR_HIGH / 2.0, BACK + 0.06);
        model.add(&steel, Shape::chunk(middle, vec3(0.1, DOOR_HIGH, 0.14)));
    }
    let middle = vec3((DOOR.0 + DOOR.1) / 2.0, DOOR_HIGH + 0.18, BACK + 0.13);
    model.add(
        &steel,
        Shape::chunk(middle, vec3(DOOR.1 - DOOR.0 + 0.2, 0.4, 0.3)),
    );
}

/// Adds all lights of the garage: three long lamps under the ceiling's beams, a bright window in the left wall, and a lamp
/// over the workbench.
fn lamps(model: &mut Model) {
    let white = dielectric("lamp housing", Vec3::splat(0.6), 0.4);
    let glow = emitter("long lamp", vec3(52.0, 48.0, 41.0));
    for (x, z) in [(-1.7, -1.4), (1.5, -2.45), (1.5, 1.75)] {
        let middle = vec3(x, 2.7, z);
        model.add(&white, Shape::chunk(middle, vec3(1.5, 0.07, 0.2)));
        let corner = middle - vec3(0.7, 0.04, 0.07);
        model.add(&glow, Shape::quad(corner, Vec3::X * 1.4, Vec3::Z * 0.14));
        for end in [-0.6, 0.6] {
            let foot = middle + vec3(end, 0.03, 0.0);
            model.add(&white, Shape::cylinder(foot, 0.008, HIGH - foot.y, 8));
        }
    }
    let wood = dielectric("window frame", vec3(0.6, 0.58, 0.52), 0.4);
    let (low, high) = (
        vec3(-SIDE + 0.03, 1.35, -2.9),
        vec3(-SIDE + 0.03, 2.45, -1.1),
    );
    let size = high - low;
    model.add(
        &emitter("window", vec3(6.0, 8.4, 11.5)),
        Shape::quad(low, Vec3::Y * size.y, Vec3::Z * size.z),
    );
    for i in 0..5_u8 {
        let z = low.z + size.z * f32::from(i) / 4.0;
        let thick = if i % 4 == 0 { 0.09 } else { 0.04 };
        let bar = vec3(low.x, (low.y + high.y) / 2.0, z);
        model.add(&wood, Shape::chunk(bar, vec3(0.1, size.y + 0.09, thick)));
    }
    for (y, thick) in [
        (low.y, 0.09),
        ((low.y + high.y) / 2.0, 0.035),
        (high.y, 0.09),
    ] {
        let bar = vec3(low.x + 0.002, y, (low.z + high.z) / 2.0);
        model.add(&wood, Shape::chunk(bar, vec3(0.1, thick, size.z + 0.08)));
    }
    // A shade on an arm, with the light in its opening.
    let at = vec3(1.05, 1.52, BACK + 0.42);
    let shade = Profile::new(0.13, 0.0)
        .line(0.0, 0.02)
        .arc(-0.09, 0.11, 40.0, 5)
        .line(0.0, 0.05)
        .capped();
    let green = dielectric("shade", vec3(0.03, 0.16, 0.09), 0.25);
    model.add(&green, shade.turned(32).map(|p| p + at));
    let corner = at + vec3(-0.07, -0.004, -0.07);
    model.add(
        &emitter("bench lamp", vec3(120.0, 76.0, 34.0)),
        Shape::quad(corner, Vec3::X * 0.14, Vec3::Z * 0.14),
    );
    let iron = metal("arm", Vec3::splat(0.3), 0.3);
    let arm = vec3(at.x, at.y + 0.19, BACK + 0.22);
    model.add(&iron, Shape::chunk(arm, vec3(0.02, 0.02, 0.44)));
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let mut model = Model::default();
    room(&mut model, &mut random);
    door(&mut model);
    lamps(&mut model);
    let things = values.whole("things") as u32;
    for (thing, degrees, to) in [
        (
            workshop::bench(&mut random),
            0.0,
            vec3(1.6, 0.0, BACK + 0.42),
        ),
        (
            workshop::tools(&mut random),
            0.0,
            vec3(1.6, 1.25, BACK + 0.02),
        ),
        (
            workshop::shelves(&mut random, 2.2, things),
            -90.0,
            vec3(SIDE - 0.3, 0.0, -2.3),
        ),
        (
            workshop::drum(vec3(0.03, 0.13, 0.34)),
            0.0,
            vec3(0.02, 0.0, -3.75),
        ),
        (workshop::tyres(3), 0.0, vec3(2.95, 0.0, -0.35)),
        (
            workshop::crate_of(vec3(0.8, 0.72, 0.7)),
            14.0,
            vec3(1.35, 0.0, -0.9),
        ),
        (
            workshop::crate_of(vec3(0.55, 0.42, 0.5)),
            -22.0,
            vec3(2.15, 0.0, -0.35),
        ),
    ] {
        workshop::put(&mut model, thing, degrees, to - Vec3::Y * SINK);
    }
    scene.add_model("garage", model);

    let paint = match values.text("paint") {
        "blue" => vec3(0.04, 0.13, 0.36),
        "green" => vec3(0.08, 0.27, 0.2),
        "cream" => vec3(0.68, 0.6, 0.42),
        _ => vec3(0.42, 0.025, 0.02),
    };
    let parked = DAffine3::from_rotation_translation(
        DQuat::from_rotation_y(0.3),
        DVec3::new(-1.35, 0.0, -1.55),
    );
    for (material, shape) in car(paint).0 {
        let name = material.name.clone();
        let mesh = scene.mesh(material, shape);
        scene.place(&name, mesh, parked);
    }
    let bronze = metal("bronze", vec3(0.75, 0.48, 0.25), 0.3);
    let bust = scene.mesh(bronze, statue::bust(&mut random).map(|p| p * 1.2));
    let on_crate = DAffine3::from_rotation_translation(
        DQuat::from_rotation_y(0.1),
        DVec3::new(1.35, 0.72, -0.9),
    );
    scene.place("bust", bust, on_crate);
    scene.camera(
        DVec3::new(2.1, 1.6, 3.7),
        DVec3::new(-0.2, 0.98, -1.8),
        46.0,
        16.0 / 9.0,
    );
    scene.0
}

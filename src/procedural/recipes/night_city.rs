//! The scene `night-city`: a wet street at night, between buildings with lit windows and neon signs, under street lamps. It
//! tests how a renderer samples thousands of lights. Lengths are in metres; the road is at height 0 and leads along −Z.

use crate::base::random::Random;
use crate::procedural::modelling::{
    Builder, Model, Shape, dielectric, emitter, metal, tessellate_lights,
};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "blocks",
        doc: "Buildings on each side of the street",
        default: "12",
        values: Range::Whole(1, 500),
    },
    Parameter {
        name: "seed",
        doc: "Seed of the city",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
    Parameter {
        name: "tessellation",
        doc: "Parts of each edge of each emissive triangle: one becomes so many squared, and nothing else changes",
        default: "1",
        values: Range::Whole(1, 100),
    },
];

/// Half the width of the road, in metres: the kerbs, where the pavements begin, are at x = ±`KERB`.
const KERB: f32 = 4.5;
/// The distance from the middle of the road to the fronts of the buildings, where the pavements end, in
/// metres.
const FRONT: f32 = 7.5;
/// The z coordinate at which the street begins, in metres. It is behind the camera; buildings follow from
/// there towards −Z.
const START: f32 = 14.0;

/// A rectangle that is parallel to the fronts of the buildings and faces the street, for windows and other flat parts.
/// `side` is −1 for the buildings on the left and 1 for those on the right. `out` is the distance of the rectangle from the
/// fronts, towards the street. `z` and `y` are the smallest z and y coordinates of the rectangle, `width` is its size along
/// z and `height` its size along y, all in metres.
fn on_front(side: f32, out: f32, z: f32, y: f32, width: f32, height: f32) -> Shape {
    let corner = Vec3::new(side * (FRONT - out), y, z);
    let (along, up) = (Vec3::Z * width, Vec3::Y * height);
    if side > 0.0 {
        Shape::quad(corner, along, up)
    } else {
        Shape::quad(corner, up, along)
    }
}

/// Adds one building with its windows, its shop and sometimes a neon sign. `side` is −1 for the left side of
/// the street and 1 for the right. The building begins at the coordinate `z` and continues towards −Z.
/// Returns its width along the street in metres, from which the caller computes where the next building
/// begins.
fn building(model: &mut Model, random: &mut Random, side: f32, z: f32) -> f32 {
    let width = random.between(7.0, 12.0);
    let floors = random.between(4.0, 13.0) as u32;
    let height = 4.2 + floors as f32 * 3.2;
    let wall = random.pick(&[
        [0.32, 0.22, 0.17],
        [0.25, 0.26, 0.30],
        [0.36, 0.32, 0.26],
        [0.20, 0.17, 0.17],
    ]);
    let wall = Material::lambert("wall", Vec3::from(wall));
    let deep = 12.0;
    let middle = Vec3::new(side * (FRONT + deep / 2.0), height / 2.0, z - width / 2.0);
    model.add(&wall, Shape::chunk(middle, Vec3::new(deep, height, width)));
    let cornice = Vec3::new(side * (FRONT - 0.15), height, z - width / 2.0);
    model.add(&wall, Shape::chunk(cornice, Vec3::new(0.6, 0.4, width)));

    let glass = dielectric("dark window", Vec3::splat(0.02), 0.1);
    let tints = [
        Vec3::new(1.3, 0.72, 0.26),
        Vec3::new(1.1, 0.8, 0.42),
        Vec3::new(0.5, 0.75, 1.0),
    ];
    let columns = (width / 1.7) as u32;
    let step = width / columns as f32;
    for floor in 0..floors {
        for column in 0..columns {
            let at = z - width + column as f32 * step + 0.3;
            let up = 4.9 + floor as f32 * 3.2;
            let size = (step - 0.6, 1.7);
            let lit = random.unit() < 0.42;
            let material = if lit {
                let dim = random.pick(&[0.4, 0.7, 1.0]);
                emitter("lit window", random.pick(&tints) * dim)
            } else {
                glass.clone()
            };
            model.add(&material, on_front(side, 0.03, at, up, size.0, size.1));
            let sill = Vec3::new(side * (FRONT - 0.12), up - 0.08, at + size.0 / 2.0);
            model.add(
                &wall,
                Shape::chunk(sill, Vec3::new(0.28, 0.1, size.0 + 0.2)),
            );
        }
    }
    shop(model, random, side, z, width);
    if random.unit() < 0.75 {
        let at = z - random.between(0.2, 0.8) * width;
        neon(model, random, side, at, height);
    }
    width
}

/// Adds the bright shop windows on the ground floor of a building, under an awning. The building reaches from the coordinate
/// `z` to `z` − `width`, in metres; `side` is −1 for the left side of the street and 1 for the right.
fn shop(model: &mut Model, random: &mut Random, side: f32, z: f32, width: f32) {
    let light = random.pick(&[
        Vec3::new(1.5, 1.0, 0.5),
        Vec3::new(0.6, 1.1, 1.4),
        Vec3::new(1.5, 0.5, 0.8),
    ]);
    let panes = 3;
    for pane in 0..panes {
        let step = (width - 1.2) / panes as f32;
        let at = z - width + 0.6 + pane as f32 * step;
        model.add(
            &emitter("shop window", light),
            on_front(side, 0.04, at + 0.1, 0.6, step - 0.2, 2.1),
        );
    }
    let cloth = random.pick(&[
        [0.5, 0.06, 0.06],
        [0.06, 0.25, 0.16],
        [0.08, 0.12, 0.4],
        [0.45, 0.38, 0.2],
    ]);
    let middle = Vec3::new(side * (FRONT - 0.7), 3.1, z - width / 2.0);
    model.add(
        &Material::lambert("awning", Vec3::from(cloth)),
        Shape::chunk(middle, Vec3::new(1.4, 0.08, width - 0.8)),
    );
}

/// Adds a neon sign that is perpendicular to the front of a building: a dark board with rows of glowing bars
/// on both faces. `side` is −1 for the left side of the street and 1 for the right. `z` is the z coordinate
/// of the board's middle, and `height` is the height of the building, above which the sign does not reach;
/// both are in metres. `random` chooses the colour and the size of the sign.
fn neon(model: &mut Model, random: &mut Random, side: f32, z: f32, height: f32) {
    let color = random.pick(&[
        [9.0, 0.7, 2.2],
        [0.7, 5.0, 9.0],
        [8.0, 4.2, 0.6],
        [1.2, 8.0, 2.5],
        [5.5, 1.2, 9.0],
        [9.0, 1.0, 0.6],
    ]);
    let tall = random.between(3.0, 5.5).min(height - 5.0);
    let foot = random.between(4.6, (height - tall).max(4.7));
    let board = Vec3::new(side * (FRONT - 0.9), foot + tall / 2.0, z);
    model.add(
        &metal("sign board", Vec3::splat(0.08), 0.5),
        Shape::chunk(board, Vec3::new(1.3, tall, 0.18)),
    );
    let light = emitter("neon", Vec3::from(color));
    let bars = (tall / 0.55) as u32;
    for bar in 0..bars {
        let y = foot + 0.3 + bar as f32 * (tall - 0.3) / bars as f32;
        let length = random.between(0.5, 1.05);
        for face in [-0.14, 0.14] {
            let middle = Vec3::new(board.x, y, z + face);
            model.add(&light, Shape::chunk(middle, Vec3::new(length, 0.13, 0.08)));
        }
    }
}

/// Adds the wet road, its markings and the pavements, from z = `START` to the z coordinate `end`, in metres,
/// and a dark plane around them.
fn ground(model: &mut Model, end: f32) {
    let length = START - end;
    let strip = |x: f32, width: f32, y: f32| {
        Shape::quad(Vec3::new(x, y, end), Vec3::Z * length, Vec3::X * width)
    };
    model.add(
        &dielectric("wet road", Vec3::splat(0.035), 0.22),
        strip(-KERB, 2.0 * KERB, 0.0),
    );
    let paint = dielectric("road marking", Vec3::splat(0.55), 0.4);
    let mut z = START;
    while z > end {
        model.add(
            &paint,
            Shape::quad(
                Vec3::new(-0.07, 0.006, z - 2.0),
                Vec3::Z * 2.0,
                Vec3::X * 0.14,
            ),
        );
        z -= 5.0;
    }
    let stone = dielectric("pavement", Vec3::new(0.17, 0.165, 0.16), 0.45);
    for side in [-1.0_f32, 1.0] {
        let middle = Vec3::new(side * (KERB + FRONT) / 2.0, 0.07, (START + end) / 2.0);
        model.add(
            &stone,
            Shape::chunk(middle, Vec3::new(FRONT - KERB, 0.14, length)),
        );
    }
    let far = Material::lambert("city floor", Vec3::splat(0.05));
    model.add(
        &far,
        Shape::quad(
            Vec3::new(-300.0, -0.3, end - 300.0),
            Vec3::Z * (length + 400.0),
            Vec3::X * 600.0,
        ),
    );
}

/// Adds the street lamps, alternately on the left and on the right, from the start of the street up to the z
/// coordinate `end` in metres. All are instances of two meshes, a pole and a bulb that emits light.
fn street_lamps(scene: &mut Builder, end: f32) {
    let iron = metal("lamp post", Vec3::splat(0.12), 0.4);
    let mut post = Shape::cylinder(Vec3::ZERO, 0.09, 5.2, 10);
    post.add(Shape::cylinder(Vec3::ZERO, 0.18, 0.5, 10));
    post.add(Shape::chunk(
        Vec3::new(0.55, 5.2, 0.0),
        Vec3::new(1.3, 0.09, 0.09),
    ));
    let post = scene.mesh(iron, post);
    let bulb = scene.mesh(
        emitter("bulb", Vec3::new(190.0, 135.0, 70.0)),
        Shape::sphere(1)
            .flat()
            .map(|p| p * 0.17 + Vec3::new(1.15, 4.95, 0.0)),
    );
    let mut z = START - 5.0;
    let mut index = 0;
    while z > end {
        let side = if index % 2 == 0 { -1.0 } else { 1.0 };
        // Turned by 180° on the right, so that every arm reaches over the road.
        let turn = if side < 0.0 {
            0.0
        } else {
            std::f64::consts::PI
        };
        let transform = DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(turn),
            DVec3::new(f64::from(side * (KERB + 0.5)), 0.14, f64::from(z)),
        );
        scene.place("lamp post", post, transform);
        scene.place("bulb", bulb, transform);
        z -= 4.5;
        index += 1;
    }
}

/// Adds cars parked at the right kerb, up to the z coordinate `end` in metres, and two cars on the road: one
/// comes towards the camera, and one drives away from it. A car consists of instances of shared meshes.
fn cars(scene: &mut Builder, random: &mut Random, end: f32) {
    let mut meshes = Vec::new();
    let mut cabin = Shape::default();
    for paint in [
        [0.35, 0.02, 0.03],
        [0.03, 0.07, 0.22],
        [0.5, 0.5, 0.52],
        [0.03, 0.03, 0.035],
    ] {
        let paint = dielectric("car paint", Vec3::from(paint), 0.15);
        let mut body = Shape::chunk(Vec3::new(0.0, 0.55, 0.0), Vec3::new(1.75, 0.5, 4.2));
        let roof = Shape::chunk(Vec3::new(0.0, 1.05, 0.15), Vec3::new(1.5, 0.55, 2.1));
        // The cabin narrows upwards, under a roof of the body's paint.
        body.add(Shape::chunk(
            Vec3::new(0.0, 1.34, 0.1),
            Vec3::new(1.26, 0.05, 1.5),
        ));
        cabin = roof.map(|p| {
            if p.y > 1.0 {
                p * Vec3::new(0.82, 1.0, 0.7)
            } else {
                p
            }
        });
        meshes.push(scene.mesh(paint, body));
    }
    let cabin = scene.mesh(dielectric("car windows", Vec3::splat(0.02), 0.08), cabin);
    let mut tyres = Shape::default();
    for (x, z) in [(-0.8, -1.3), (0.8, -1.3), (-0.8, 1.3), (0.8, 1.3)] {
        let wheel = Shape::cylinder(Vec3::ZERO, 0.33, 0.22, 16);
        tyres.add(wheel.map(|p| Vec3::new(p.y - 0.11 + x, p.z + 0.33, p.x + z)));
    }
    let tyres = scene.mesh(Material::lambert("tyres", Vec3::splat(0.03)), tyres.flat());
    let pair = |z: f32, size: f32| {
        let mut pair = Shape::default();
        for x in [-0.6, 0.6] {
            pair.add(Shape::chunk(
                Vec3::new(x, 0.62, z),
                Vec3::new(size * 2.0, size, 0.06),
            ));
        }
        pair
    };
    let head = scene.mesh(
        emitter("head lights", Vec3::new(60.0, 56.0, 46.0)),
        pair(2.11, 0.13),
    );
    let tail = scene.mesh(
        emitter("tail lights", Vec3::new(9.0, 0.35, 0.25)),
        pair(-2.11, 0.12),
    );
    let park = |scene: &mut Builder, x: f32, z: f32, turn: f64, lit: bool, random: &mut Random| {
        let transform = DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(turn),
            DVec3::new(f64::from(x), 0.0, f64::from(z)),
        );
        let mesh = random.pick(&meshes);
        scene.place("car", mesh, transform);
        scene.place("cabin", cabin, transform);
        scene.place("tyres", tyres, transform);
        if lit {
            scene.place("head lights", head, transform);
            scene.place("tail lights", tail, transform);
        }
    };
    let mut z = -4.0;
    while z > end {
        if random.unit() < 0.7 {
            park(
                scene,
                KERB - 1.1,
                z + random.between(-0.5, 0.5),
                std::f64::consts::PI,
                random.unit() < 0.25,
                random,
            );
        }
        z -= 6.5;
    }
    park(scene, -1.9, -17.0, 0.06, true, random);
    park(scene, 1.4, -30.0, std::f64::consts::PI, true, random);
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let mut model = Model::default();
    let mut end = START;
    for side in [-1.0, 1.0] {
        let mut z = START;
        for _ in 0..values.whole("blocks") {
            z -= building(&mut model, &mut random, side, z);
            z -= random.pick(&[0.0, 0.0, 1.5]);
        }
        end = end.min(z);
    }
    ground(&mut model, end - 20.0);
    // A tower at the end of the view, with a lit top.
    let wall = Material::lambert("tower", Vec3::new(0.16, 0.17, 0.22));
    let foot = Vec3::new(2.0, 0.0, end - 28.0);
    model.add(
        &wall,
        Shape::chunk(foot + Vec3::Y * 26.0, Vec3::new(16.0, 52.0, 12.0)),
    );
    let crown = emitter("crown", Vec3::new(1.0, 3.2, 4.2));
    for ring in 0..4 {
        let middle = foot + Vec3::Y * (42.0 + ring as f32 * 2.6);
        model.add(&crown, Shape::chunk(middle, Vec3::new(16.6, 0.5, 12.6)));
    }
    for floor in 0..12 {
        for column in 0..9 {
            if random.unit() < 0.5 {
                let corner =
                    foot + Vec3::new(-7.4 + column as f32 * 1.65, 3.0 + floor as f32 * 3.1, 6.04);
                let warm = emitter("tower window", Vec3::new(1.2, 0.8, 0.35));
                model.add(&warm, Shape::quad(corner, Vec3::X * 1.1, Vec3::Y * 1.6));
            }
        }
    }
    scene.add_model("buildings and street", model);
    street_lamps(&mut scene, end);
    cars(&mut scene, &mut random, end);
    scene.camera(
        DVec3::new(-2.6, 1.75, 9.0),
        DVec3::new(0.6, 3.4, -14.0),
        52.0,
        16.0 / 9.0,
    );
    tessellate_lights(&mut scene.0, values.whole("tessellation") as u32);
    scene.0
}

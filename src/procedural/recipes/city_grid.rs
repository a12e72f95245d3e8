//! The scene `city-grid`: a square grid of city blocks at night, seen from above. Lengths are in metres, and the centre of
//! the grid is at the origin.

use crate::base::random::Random;
use crate::procedural::modelling::{Builder, Model, Shape, dielectric, emitter, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::procedural::props::city_house::{STOREY, house};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "blocks",
        doc: "Blocks on each side of the square grid",
        default: "6",
        values: Range::Whole(1, 60),
    },
    Parameter {
        name: "windows",
        doc: "Share of windows that are lit",
        default: "0.1",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "seed",
        doc: "Seed of the city",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
];

/// The width of a square block in metres, including the pavement around its houses. Roads separate the
/// blocks.
const BLOCK: f32 = 38.0;
/// The width of a road between two rows of blocks, in metres. It has one lane for each direction.
const ROAD: f32 = 11.0;
/// The distance from the centre of one block to the centre of the next, in metres. The blocks are placed with
/// this spacing along X and Z.
const PITCH: f32 = BLOCK + ROAD;
/// The height of the pavement above the road, in metres. Houses, lamps and trees stand on the pavement.
const KERB: f32 = 0.15;
/// The width of the pavement between the road and the area of the houses, in metres. The lamps and the trees
/// along the road stand on this strip.
const WALK: f32 = 3.2;

/// The meshes of the objects that the scene has many times (lamp posts, trees and cars), as indices into the
/// scene's meshes. Each mesh is stored once, and every object is an instance of it, so that large cities fit
/// into memory.
struct Stock {
    posts: [(u32, u32); 2],
    tree: [u32; 2],
    cars: Vec<u32>,
    car_parts: [u32; 3],
}

impl Stock {
    fn new(scene: &mut Builder) -> Self {
        let iron = metal("lamp post", Vec3::splat(0.15), 0.45);
        let mut post = Shape::cylinder(Vec3::NEG_Y * 0.05, 0.08, 4.65, 8);
        post.add(Shape::chunk(
            Vec3::new(0.6, 4.6, 0.0),
            Vec3::new(1.4, 0.09, 0.09),
        ));
        post.add(Shape::chunk(
            Vec3::new(1.2, 4.64, 0.0),
            Vec3::new(0.44, 0.06, 0.24),
        ));
        let post = scene.mesh(iron, post);
        let bulb = Shape::sphere(0)
            .flat()
            .map(|p| p * 0.2 + Vec3::new(1.2, 4.37, 0.0));
        let sodium = scene.mesh(
            emitter("sodium lamp", Vec3::new(1150.0, 590.0, 175.0)),
            bulb.clone(),
        );
        let white = scene.mesh(emitter("white lamp", Vec3::new(500.0, 610.0, 730.0)), bulb);

        let bark = Material::lambert("bark", Vec3::new(0.16, 0.1, 0.06));
        let trunk = scene.mesh(bark, Shape::cylinder(Vec3::NEG_Y * 0.05, 0.16, 2.6, 7));
        let leaves = Material::lambert("leaves", Vec3::new(0.2, 0.33, 0.08));
        let mut crown = Shape::default();
        for (x, y, z, r) in [
            (0.0, 3.6, 0.0, 1.5),
            (0.8, 3.0, 0.4, 1.0),
            (-0.7, 3.1, 0.5, 1.0),
            (0.1, 3.1, -0.9, 1.05),
        ] {
            crown.add(Shape::sphere(1).flat().map(|p| p * r + Vec3::new(x, y, z)));
        }
        let crown = scene.mesh(leaves, crown);

        let cars = [
            [0.4, 0.03, 0.03],
            [0.6, 0.6, 0.6],
            [0.04, 0.08, 0.25],
            [0.6, 0.4, 0.03],
        ]
        .map(|paint| {
            let body = Shape::chunk(Vec3::Y * 0.6, Vec3::new(1.8, 0.7, 4.3));
            scene.mesh(dielectric("car paint", Vec3::from(paint), 0.2), body)
        })
        .to_vec();
        let mut dark = Shape::chunk(Vec3::new(0.0, 1.15, -0.2), Vec3::new(1.5, 0.6, 2.1));
        for (x, z) in [(-0.8, -1.3), (0.8, -1.3), (-0.8, 1.3), (0.8, 1.3)] {
            dark.add(Shape::chunk(
                Vec3::new(x, 0.31, z),
                Vec3::new(0.24, 0.6, 0.62),
            ));
        }
        let cabin = scene.mesh(
            dielectric("car glass and tyres", Vec3::splat(0.02), 0.1),
            dark,
        );
        let pair = |z: f32| {
            let mut pair = Shape::chunk(Vec3::new(-0.62, 0.65, z), Vec3::new(0.36, 0.2, 0.08));
            pair.add(Shape::chunk(
                Vec3::new(0.62, 0.65, z),
                Vec3::new(0.36, 0.2, 0.08),
            ));
            pair
        };
        let head = scene.mesh(
            emitter("head lights", Vec3::new(120.0, 112.0, 90.0)),
            pair(2.17),
        );
        let tail = scene.mesh(
            emitter("tail lights", Vec3::new(16.0, 0.6, 0.4)),
            pair(-2.17),
        );
        Self {
            posts: [(post, sodium), (post, white)],
            tree: [trunk, crown],
            cars,
            car_parts: [cabin, head, tail],
        }
    }

    fn lamp_post(&self, scene: &mut Builder, kind: usize, at: Vec3, degrees: f64) {
        let (post, bulb) = self.posts[kind];
        scene.place("lamp post", post, turned(at, degrees, 1.0));
        scene.place("street lamp", bulb, turned(at, degrees, 1.0));
    }

    fn tree(&self, scene: &mut Builder, random: &mut Random, at: Vec3) {
        let (degrees, size) = (random.between(0.0, 360.0), random.between(0.7, 1.25));
        for mesh in self.tree {
            scene.place(
                "tree",
                mesh,
                turned(at, f64::from(degrees), f64::from(size)),
            );
        }
    }

    fn car(&self, scene: &mut Builder, random: &mut Random, at: Vec3, degrees: f64) {
        let transform = turned(at, degrees, 1.0);
        scene.place("car", random.pick(&self.cars), transform);
        for mesh in self.car_parts {
            scene.place("car", mesh, transform);
        }
    }
}

fn turned(at: Vec3, degrees: f64, size: f64) -> DAffine3 {
    let turn = DQuat::from_rotation_y(degrees.to_radians());
    DAffine3::from_scale_rotation_translation(DVec3::splat(size), turn, at.as_dvec3())
}

/// Adds one city block: a pavement with lamps and trees at its edges, and on the pavement either houses or a
/// park, as `random` chooses. `middle` is the centre of the block at the height of the road, in metres. `lit`
/// is the fraction of the houses' windows that emit light. Lamps and trees become instances of the meshes in
/// `stock`; all other objects become parts of `model`.
fn block(
    scene: &mut Builder,
    model: &mut Model,
    stock: &Stock,
    random: &mut Random,
    middle: Vec3,
    lit: f32,
) {
    let stone = dielectric("pavement", Vec3::new(0.34, 0.33, 0.31), 0.6);
    model.add(
        &stone,
        Shape::chunk(
            middle + Vec3::Y * (KERB / 2.0 - 0.05),
            Vec3::new(BLOCK, KERB + 0.1, BLOCK),
        ),
    );
    let ground = middle + Vec3::Y * KERB;
    for (side, (out, along)) in [
        (Vec3::X, Vec3::Z),
        (Vec3::NEG_Z, Vec3::X),
        (Vec3::NEG_X, Vec3::Z),
        (Vec3::Z, Vec3::X),
    ]
    .into_iter()
    .enumerate()
    {
        for t in [-1.0, 0.0, 1.0] {
            let at = ground + out * (BLOCK / 2.0 - 0.6) + along * (t * BLOCK / 3.0);
            // Avenues are lit white, the streets across yellow.
            stock.lamp_post(scene, usize::from(side % 2 == 0), at, 90.0 * side as f64);
        }
        for t in [-0.5, 0.5] {
            if random.unit() < 0.7 {
                let at = ground + out * (BLOCK / 2.0 - 1.0) + along * (t * BLOCK / 3.0);
                stock.tree(scene, random, at);
            }
        }
    }
    let inner = BLOCK - 2.0 * WALK;
    let kind = random.unit();
    if kind < 0.15 {
        let grass = Material::lambert("grass", Vec3::new(0.1, 0.2, 0.05));
        model.add(&grass, Shape::chunk(ground, Vec3::new(inner, 0.1, inner)));
        let path = Shape::chunk(ground, Vec3::new(inner + 0.1, 0.14, 2.0));
        model.add(&stone, path);
        for t in [-0.33, 0.0, 0.33] {
            let at = ground + Vec3::new(t * inner, 0.0, 1.2);
            stock.lamp_post(scene, 0, at, 90.0);
        }
        for _ in 0..16 {
            let (x, z) = (random.between(-0.46, 0.46), random.between(0.08, 0.45));
            let z = if random.unit() < 0.5 { z } else { -z };
            stock.tree(scene, random, ground + Vec3::new(x, 0.0, z) * inner);
        }
        return;
    }
    // A tower takes a whole block, where it hides little; other blocks have four or six lots.
    let (nx, nz) = if kind < 0.4 && middle.z < -PITCH {
        (1, 1)
    } else {
        random.pick(&[(2, 2), (3, 2), (2, 3)])
    };
    let tall = if nx == 1 { (6.0, 12.0) } else { (1.0, 5.0) };
    for i in 0..nx {
        for j in 0..nz {
            let lot = Vec3::new(inner / nx as f32, 0.0, inner / nz as f32);
            let margin = if nx == 1 {
                5.0
            } else {
                random.between(0.6, 1.2)
            };
            let storeys = random.between(tall.0, tall.1) as u32;
            let foot = ground + Vec3::new(i as f32 + 0.5, 0.0, j as f32 + 0.5) * lot
                - Vec3::new(inner, 0.0, inner) / 2.0;
            let size = Vec3::new(
                lot.x - 2.0 * margin,
                storeys as f32 * STOREY + 0.4,
                lot.z - 2.0 * margin,
            );
            house(model, random, foot - Vec3::Y * 0.05, size, lit);
        }
    }
}

/// Adds the paint on the roads: dashes along the middle of each road, and pedestrian crossings. `blocks` is the number of
/// blocks along each side of the grid.
fn paint(model: &mut Model, blocks: u64) {
    let paint = dielectric("road paint", Vec3::splat(0.6), 0.5);
    let origin = -PITCH * blocks as f32 / 2.0;
    let end = PITCH * blocks as f32 - ROAD;
    let mut mark = |swap: bool, across: f32, along: f32, width: f32, length: f32| {
        let (x, z, w, l) = if swap {
            (along, across, length, width)
        } else {
            (across, along, width, length)
        };
        let corner = Vec3::new(origin + x - w / 2.0, 0.012, origin + z - l / 2.0);
        model.add(&paint, Shape::quad(corner, Vec3::Z * l, Vec3::X * w));
    };
    for swap in [false, true] {
        for road in 0..=blocks {
            let middle = road as f32 * PITCH;
            let mut along = ROAD / 2.0 + 6.0;
            while along < end {
                let within = along.rem_euclid(PITCH);
                if within > ROAD / 2.0 + 5.0 && within < PITCH - ROAD / 2.0 - 5.0 {
                    mark(swap, middle, along, 0.14, 2.0);
                }
                along += 4.0;
            }
            for cross in 0..=blocks {
                for side in [-1.0, 1.0] {
                    let along = cross as f32 * PITCH + side * (ROAD / 2.0 + 1.8);
                    for stripe in 0..9 {
                        mark(swap, middle + (stripe as f32 - 4.0) * 1.1, along, 0.5, 2.4);
                    }
                }
            }
        }
    }
}

/// Adds cars at random distances to every road, as instances of the meshes in `stock`. They drive on the
/// right-hand side of the road. `blocks` is the number of blocks along each side of the grid.
fn traffic(scene: &mut Builder, stock: &Stock, random: &mut Random, blocks: u64) {
    let origin = -PITCH * blocks as f32 / 2.0;
    for swap in [false, true] {
        for road in 0..=blocks {
            for lane in [-1.0, 1.0] {
                let mut along = random.between(8.0, 30.0);
                while along < PITCH * blocks as f32 - 8.0 {
                    let within = along.rem_euclid(PITCH);
                    if within > ROAD && within < PITCH - ROAD {
                        let across = road as f32 * PITCH + lane * 2.3;
                        let (x, z) = if swap {
                            (along, across)
                        } else {
                            (across, along)
                        };
                        let back = if lane > 0.0 { 180.0 } else { 0.0 };
                        // Along x the lanes' directions are swapped.
                        let degrees = if swap { 270.0 - back } else { back };
                        let at = Vec3::new(origin + x, 0.0, origin + z);
                        stock.car(scene, random, at, degrees);
                    }
                    along += random.between(9.0, 45.0);
                }
            }
        }
    }
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let stock = Stock::new(&mut scene);
    let mut model = Model::default();
    let blocks = values.whole("blocks");
    let half = PITCH * blocks as f32 / 2.0;
    for i in 0..blocks {
        for j in 0..blocks {
            let middle =
                Vec3::new(i as f32 + 0.5, 0.0, j as f32 + 0.5) * PITCH - Vec3::new(half, 0.0, half);
            block(
                &mut scene,
                &mut model,
                &stock,
                &mut random,
                middle,
                values.real("windows"),
            );
        }
    }
    paint(&mut model, blocks);
    traffic(&mut scene, &stock, &mut random, blocks);
    let asphalt = dielectric("asphalt", Vec3::splat(0.07), 0.4);
    let wide = 2.0 * half + 3.0 * PITCH;
    let corner = Vec3::new(-wide / 2.0, 0.0, -wide / 2.0);
    model.add(
        &asphalt,
        Shape::quad(corner, Vec3::Z * wide, Vec3::X * wide),
    );
    scene.add_model("houses and roads", model);
    let half = f64::from(half);
    scene.camera(
        DVec3::new(-0.4, 0.62, 0.84) * half,
        DVec3::new(-0.01, 0.0, 0.02) * half,
        38.0,
        16.0 / 9.0,
    );
    scene.0
}

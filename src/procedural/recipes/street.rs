//! The scene `street`: an old street on a festival night, with houses, market stalls and paper lanterns. A parameter sets
//! its exact number of emissive triangles, so that the cost of many lights can be measured. Lengths are in metres, the
//! ground is at height 0, and the street leads along −Z and bends.

use crate::base::random::Random;
use crate::procedural::modelling::{Builder, Model, Shape, dielectric};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::procedural::props::festival::{Festival, Spot};
use crate::procedural::props::houses::house;
use crate::scene::Scene;
use glam::{DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "lights",
        doc: "Emissive triangles, exactly; the street is as long as they need, and at least 60 m",
        default: "30000",
        values: Range::Whole(1, 2_000_000),
    },
    Parameter {
        name: "seed",
        doc: "Seed of the street",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
];

/// The distance from the middle of the street to the fronts of the houses, in metres. Cobbles cover the
/// ground between the fronts.
const FRONT: f32 = 4.3;
/// The z coordinate at which the street begins, in metres. It is behind the camera; houses follow from there
/// towards −Z.
const START: f32 = 9.0;
/// The minimum length of the street, in metres. If the parameter `lights` asks for more emissive triangles than a street of
/// this length has, the street is longer.
const SHORTEST: f32 = 60.0;

/// Maps a point of a straight street along −Z to the bent street, in metres: it shifts the point along x by
/// an amount that depends on its z coordinate. The whole scene is first built along the straight street and
/// then mapped.
fn bend(p: Vec3) -> Vec3 {
    let along = (-p.z).max(0.0);
    p + Vec3::X * 5.0 * (1.0 - (along / 24.0).cos())
}

/// Adds the ground up to the z coordinate `end` in metres, and cobbles on it. The cobbles end at z = −90, or
/// at `end` if the street is shorter. Each cobble is a worn block that leans slightly, so that the wet street
/// glitters.
fn ground(street: &mut Festival, random: &mut Random, end: f32) {
    let bed = dielectric("between cobbles", Vec3::splat(0.03), 0.6);
    let wide = FRONT + 12.0;
    let mut z = START;
    // In strips, since the bend moves only vertices.
    while z > end {
        street.model.add(
            &bed,
            Shape::quad(
                Vec3::new(-wide, -0.03, z - 2.0),
                Vec3::Z * 2.0,
                Vec3::X * 2.0 * wide,
            ),
        );
        z -= 2.0;
    }
    let stones = [[0.1, 0.098, 0.1], [0.13, 0.12, 0.11], [0.08, 0.08, 0.09]]
        .map(|color| dielectric("cobble", Vec3::from(color), 0.28));
    let (across, along) = (0.2, 0.26);
    let rows = ((START - end.max(-90.0)) / along) as u32;
    let columns = (2.0 * FRONT / across) as u32;
    for row in 0..rows {
        for column in 0..=columns {
            let shift = if row % 2 == 0 { 0.0 } else { across / 2.0 };
            let x = -FRONT + column as f32 * across - shift;
            let low = Vec3::new(x, -0.06, START - (row + 1) as f32 * along);
            let size = Vec3::new(across - 0.012, 0.06, along - 0.012)
                * Vec3::new(random.between(0.9, 1.0), 1.0, random.between(0.92, 1.0));
            let lean = Vec3::new(
                random.between(-0.05, 0.05),
                random.between(-0.008, 0.006),
                random.between(-0.05, 0.05),
            );
            let stone = Shape::block(low, low + size).map(|p| {
                if p.y < -0.03 {
                    return p;
                }
                let from_middle = p - low - size / 2.0;
                let lift = lean.y + lean.x * from_middle.x + lean.z * from_middle.z;
                low + size / 2.0 + from_middle * Vec3::new(0.84, 1.0, 0.88) + Vec3::Y * lift
            });
            street.model.add(&stones[random.pick(&[0, 1, 2])], stone);
        }
    }
}

/// Adds a church tower behind the houses on the left. Its clock, its belfry and strips on its ledges emit light.
fn tower(street: &mut Festival) {
    let stone = dielectric("tower stone", Vec3::new(0.34, 0.31, 0.27), 0.8);
    let copper = dielectric("copper roof", Vec3::new(0.1, 0.22, 0.17), 0.5);
    let foot = Vec3::new(-9.0, 0.0, -64.0);
    let high = 33.0;
    street.model.add(
        &stone,
        Shape::chunk(foot + Vec3::Y * high / 2.0, Vec3::new(6.0, high, 6.0)),
    );
    for (y, out) in [(17.0, 0.5), (25.0, 0.5), (high, 0.9)] {
        street.model.add(
            &stone,
            Shape::chunk(foot + Vec3::Y * y, Vec3::new(6.0 + out, 0.5, 6.0 + out)),
        );
    }
    let helm = Shape::chunk(foot + Vec3::Y * (high + 5.2), Vec3::new(5.6, 10.0, 5.6)).map(|p| {
        let narrow = if p.y > high + 1.0 { 0.02 } else { 1.0 };
        Vec3::new(
            foot.x + (p.x - foot.x) * narrow,
            p.y,
            foot.z + (p.z - foot.z) * narrow,
        )
    });
    street.model.add(&copper, helm);
    let face = foot + Vec3::new(0.0, 28.8, 3.05);
    let rim = |k: u32, radius: f32| {
        let turn = std::f32::consts::TAU * k as f32 / 24.0;
        face + radius * Vec3::new(turn.cos(), turn.sin(), 0.0)
    };
    let disc: Vec<Vec3> = (0..24)
        .flat_map(|k| [face, rim(k, 1.75), rim(k + 1, 1.75)])
        .collect();
    street.light("clock", Vec3::new(1.9, 1.6, 1.0), Shape::triangles(&disc));
    let hand = dielectric("clock hand", Vec3::splat(0.02), 0.4);
    street.model.add(
        &hand,
        Shape::chunk(face + Vec3::new(0.0, 0.6, 0.04), Vec3::new(0.14, 1.4, 0.04)),
    );
    street.model.add(
        &hand,
        Shape::chunk(face + Vec3::new(0.4, 0.0, 0.05), Vec3::new(1.0, 0.16, 0.04)),
    );
    for k in 0..12 {
        let mark = rim(2 * k, 1.45) + Vec3::Z * 0.02;
        street
            .model
            .add(&hand, Shape::chunk(mark, Vec3::new(0.12, 0.12, 0.03)));
    }
    for y in [17.0, 25.0] {
        // An emissive strip on each ledge lights the wall above.
        let ledge = foot + Vec3::new(-3.0, y + 0.26, 3.05);
        let strip = Shape::quad(ledge, Vec3::Z * 0.16, Vec3::X * 6.0);
        street.light("tower light", Vec3::new(9.0, 5.5, 2.4), strip);
    }
    for x in [-1.3, 1.3] {
        let corner = foot + Vec3::new(x - 0.5, 20.0, 3.03);
        let bay = Shape::quad(corner, Vec3::X, Vec3::Y * 3.4);
        street.light("belfry", Vec3::new(1.6, 0.9, 0.35), bay);
    }
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut street = Festival::new(values.whole("lights"));
    tower(&mut street);
    // Houses on either side, stalls before them, and lanterns above as far as both reach.
    let mut ends = [START, START];
    let (mut cord, mut stalls) = (3.0, [-1.5, -4.0]);
    while street.has_light() || ends[0].max(ends[1]) > START - SHORTEST {
        let side = usize::from(ends[1] > ends[0]);
        let width = random.between(4.6, 6.8);
        let spot = |x: f32, z: f32| Spot {
            foot: Vec3::new(x - FRONT, 0.0, z),
            mirrored: side == 1,
        };
        // No two fronts are in the same plane.
        let front = random.between(-0.1, 0.0);
        house(&mut street, &mut random, spot(front, ends[side]), width);
        ends[side] -= width;
        while stalls[side] - 1.6 > ends[side] {
            street.stall(&mut random, spot(1.25, stalls[side]));
            stalls[side] -= random.between(3.6, 6.5);
        }
        while cord > ends[0].max(ends[1]) {
            let end = |side: f32, random: &mut Random| {
                let (y, z) = (random.between(5.2, 6.6), random.between(-0.9, 0.9));
                Vec3::new(side * (FRONT - 0.4), y, cord + z)
            };
            let (a, b) = (end(-1.0, &mut random), end(1.0, &mut random));
            street.lanterns(&mut random, a, b);
            cord -= 2.0;
        }
    }
    let high = |side: f32| Vec3::new(side * (FRONT - 0.4), 5.0, -9.0);
    street.pennants(&mut random, high(-1.0), high(1.0));
    let end = ends[0].min(ends[1]);
    ground(&mut street, &mut random, end - 30.0);
    let wall = dielectric("end of the street", Vec3::splat(0.2), 0.8);
    street.model.add(
        &wall,
        Shape::chunk(Vec3::new(0.0, 4.0, end - 3.0), Vec3::new(24.0, 8.6, 2.0)),
    );

    let mut scene = Builder::default();
    let bent = street
        .model
        .0
        .into_iter()
        .map(|(material, shape)| (material, shape.map(bend)));
    scene.add_model("street", Model(bent.collect()));
    scene.camera(
        DVec3::new(0.9, 2.0, 3.6),
        DVec3::new(-0.55, 3.7, -10.0),
        55.0,
        16.0 / 9.0,
    );
    scene.0
}

//! The scene `terrain`: a landscape under a low sun. The parameter `triangles` sets its approximate number of
//! triangles, to test scenes with very many triangles. Lengths are in metres.

use crate::procedural::modelling::{Builder, Shape, emitter};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Instance, Material, Mesh, Part, Scene};
use glam::{DAffine3, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "triangles",
        doc: "Triangles of the ground; the nearest 2·n² is taken",
        default: "100000",
        values: Range::Whole(2, 50_000_000),
    },
    Parameter {
        name: "seed",
        doc: "Seed of the landscape",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
];

/// The width and the depth of the landscape, in metres. Its middle is at the origin, and a regular grid of
/// triangles covers it.
const WIDTH: f32 = 100.0;

/// A pseudorandom number in [−1, 1] for the point (x, z) with integer coordinates, from which [`noise`] interpolates. The
/// same point and the same `seed` always give the same number.
fn lattice(x: i32, z: i32, seed: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x8DA6_B343)
        ^ (z as u32).wrapping_mul(0xD816_3841)
        ^ seed.wrapping_mul(0xCB1A_B31F);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    (h ^ (h >> 15)) as f32 / 2_147_483_648.0 - 1.0
}

/// Smooth noise in [−1, 1] at the point (x, z), from which the ridges of the landscape are made. It is an interpolation
/// between the numbers that [`lattice`] returns for the four points with integer coordinates around it.
fn noise(x: f32, z: f32, seed: u32) -> f32 {
    let (i, j) = (x.floor(), z.floor());
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(x - i), fade(z - j));
    let at = |di: i32, dj: i32| lattice(i as i32 + di, j as i32 + dj, seed);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    mix(mix(at(0, 0), at(1, 0), u), mix(at(0, 1), at(1, 1), u), v)
}

/// The height of the ground in metres at the point (x, z), also in metres: a sum of nine octaves of ridges. The ridges get
/// higher towards the back of the landscape (−Z). Each `seed` gives another landscape.
fn height(x: f32, z: f32, seed: u32) -> f32 {
    let (mut sum, mut size, mut wave) = (0.0, 7.0, 32.0);
    for octave in 0..9 {
        let n = noise(x / wave + 17.3, z / wave - 9.1, seed.wrapping_add(octave));
        sum += size * (1.0 - 2.0 * n.abs());
        size *= 0.42;
        wave *= 0.47;
    }
    let back = ((WIDTH * 0.5 - z) / WIDTH).clamp(0.0, 1.0);
    sum * (0.25 + 0.9 * back)
}

pub(super) fn make(values: &Values) -> Scene {
    let mut scene = Builder::default();
    let seed = values.whole("seed") as u32;
    let side = ((values.whole("triangles") as f64 / 2.0).sqrt().round() as u32).max(1);
    let step = WIDTH / side as f32;
    let at = |i: u32, j: u32| {
        let (x, z) = (i as f32 * step - WIDTH / 2.0, j as f32 * step - WIDTH / 2.0);
        Vec3::new(x, height(x, z, seed), z)
    };
    let corners = (side as usize + 1).pow(2);
    let (mut positions, mut normals) = (Vec::with_capacity(corners), Vec::with_capacity(corners));
    for j in 0..=side {
        positions.extend((0..=side).map(|i| at(i, j)));
    }
    let row = side as usize + 1;
    for j in 0..row {
        for i in 0..row {
            let p = |i: usize, j: usize| positions[j * row + i];
            let across = p((i + 1).min(row - 1), j) - p(i.saturating_sub(1), j);
            let along = p(i, (j + 1).min(row - 1)) - p(i, j.saturating_sub(1));
            normals.push(along.cross(across).normalize());
        }
    }
    let mut triangles = Vec::with_capacity(2 * (side as usize).pow(2));
    for j in 0..side {
        for i in 0..side {
            let a = j * (side + 1) + i;
            let (b, c, d) = (a + side + 1, a + side + 2, a + 1);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    scene
        .0
        .materials
        .push(Material::lambert("ground", Vec3::new(0.42, 0.36, 0.28)));
    scene.0.meshes.push(Mesh {
        name: "ground".into(),
        parts: vec![Part {
            first_triangle: 0,
            triangle_count: triangles.len() as u32,
            material: 0,
        }],
        positions,
        normals,
        triangles,
        ..Mesh::default()
    });
    scene.0.instances.push(Instance {
        name: "ground".into(),
        mesh: 0,
        object_to_world: DAffine3::IDENTITY,
    });
    // A low warm sun from the left, and a wide cool sky that fills the shadows.
    let sun = Vec3::new(-140.0, 95.0, -10.0);
    let u = Vec3::Z * 24.0;
    let v = sun.cross(u).normalize() * 24.0;
    scene.add(
        emitter("sun", Vec3::new(150.0, 120.0, 85.0)),
        Shape::quad(sun - (u + v) / 2.0, v, u),
    );
    let sky = Shape::block(
        Vec3::new(-400.0, -100.0, -400.0),
        Vec3::new(400.0, 220.0, 400.0),
    );
    scene.add(
        Material {
            base_color: Vec3::ZERO,
            ..emitter("sky", Vec3::new(0.25, 0.36, 0.55))
        },
        sky.inside_out(),
    );
    let eye = DVec3::new(8.0, 15.0, 52.0);
    scene.camera(eye, DVec3::new(-4.0, 3.0, 0.0), 40.0, 16.0 / 9.0);
    scene.0
}

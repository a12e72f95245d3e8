//! The scene `colourful-mess`: a heap of toys among coloured lamps, in a closed room. It tests how coloured light mixes on
//! coloured surfaces. The toys are matte, satin, glossy or of metal, and a simulation lets them fall onto the heap. Lengths
//! are in metres, and the floor is at height 0.

use crate::base::random::Random;
use crate::procedural::modelling::tumble::{Body, simulate_fall};
use crate::procedural::modelling::{Builder, Model, Profile, Shape, dielectric, emitter, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Material, Scene};
use glam::{DVec3, Mat3, Vec3, vec2, vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "seed",
        doc: "Seed of the heap",
        default: "2",
        values: Range::Whole(0, u32::MAX as u64),
    },
    Parameter {
        name: "things",
        doc: "Things in the heap",
        default: "360",
        values: Range::Whole(1, 1000),
    },
    Parameter {
        name: "lamps",
        doc: "How many of the things are glowing balls",
        default: "28",
        values: Range::Whole(0, 1000),
    },
];

const COLORS: [[f32; 3]; 10] = [
    [0.72, 0.04, 0.03],
    [0.85, 0.28, 0.02],
    [0.85, 0.62, 0.03],
    [0.32, 0.6, 0.05],
    [0.03, 0.38, 0.16],
    [0.02, 0.42, 0.5],
    [0.03, 0.14, 0.6],
    [0.26, 0.06, 0.5],
    [0.7, 0.08, 0.32],
    [0.75, 0.73, 0.68],
];

/// The linear RGB radiances of the glowing balls in the heap, in W/(m²·sr). Each ball gets one of them at
/// random, multiplied by 0.09 m / radius of the ball, but at most by 2. So small balls are brighter, and
/// their light is visible too.
const GLOWS: [[f32; 3]; 6] = [
    [9.0, 0.4, 0.15],
    [9.0, 2.6, 0.2],
    [0.5, 6.5, 0.8],
    [0.25, 2.4, 10.0],
    [3.2, 0.3, 10.0],
    [9.0, 0.35, 2.6],
];

/// The height of the closed room around the heap, in metres. The room is twice as wide and twice as deep. Its
/// walls reflect light of the lamps onto the heap.
const ROOM: f32 = 5.0;

fn finish(random: &mut Random) -> Material {
    let color = Vec3::from(random.pick(&COLORS));
    match random.pick(&[0, 0, 1, 1, 2, 3, 4, 5]) {
        0 => Material::lambert("matte", color),
        1 => dielectric("satin", color, 0.4),
        2 => dielectric("glossy", color, 0.15),
        // Metals that are coloured keep some of every colour, or they would look black.
        n => {
            let roughness = [0.15, 0.3, 0.5][n - 3];
            metal("metal", color * 0.75 + 0.22, roughness)
        }
    }
}

/// One toy of the heap: its shape and material in the scene, and a simpler model of it for the simulation of the fall, which
/// decides where the toy lies. In the simulation, the toy consists of `balls` (the centre and the radius of each, in
/// metres), and its mass is equal to its `volume` in cubic metres.
struct Toy {
    shape: Shape,
    material: Material,
    balls: Vec<(Vec3, f32)>,
    volume: f32,
}

fn ball(random: &mut Random, material: Material, smallest: f32, largest: f32) -> Toy {
    let radius = random.between(smallest, largest);
    Toy {
        shape: Shape::sphere(if material.is_emissive() { 2 } else { 3 }).map(|p| p * radius),
        material,
        balls: vec![(Vec3::ZERO, radius)],
        volume: 4.2 * radius.powi(3),
    }
}

/// Makes a toy of the heap: a block with bevelled edges, centred at the origin. Its size and its material are random.
fn block(random: &mut Random) -> Toy {
    let side = random.between(0.08, 0.15);
    let half = random.pick(&[
        vec3(1.0, 1.0, 1.0),
        vec3(1.0, 1.0, 1.0),
        vec3(0.7, 0.7, 1.6),
        vec3(1.3, 0.5, 0.7),
        vec3(1.5, 0.45, 1.1),
    ]) * side;
    let (edge, inner) = (0.06 * side, half.x.min(half.z));
    let profile = Profile::new(-inner, -half.y)
        .line(inner - edge, 0.0)
        .line(edge, edge)
        .line(0.0, 2.0 * (half.y - edge))
        .line(-edge, edge)
        .line(edge - inner, 0.0);
    // Two balls across if two sides are equally thin, since one row would roll like a log.
    let thin = half.min_element();
    let thinnest = half.to_array().into_iter().filter(|&h| h == thin).count();
    let radius = if thinnest > 1 { thin / 2.0 } else { thin };
    let count = (half / radius).ceil();
    let coordinate = |i: f32, count: f32| (i + 0.5) / count * 2.0 - 1.0;
    let mut balls = Vec::new();
    for i in 0..count.x as u32 {
        for j in 0..count.y as u32 {
            for k in 0..count.z as u32 {
                let [x, y, z] = [
                    coordinate(i as f32, count.x),
                    coordinate(j as f32, count.y),
                    coordinate(k as f32, count.z),
                ];
                balls.push((vec3(x, y, z) * half, radius));
            }
        }
    }
    Toy {
        shape: profile.framed(vec2(half.x, half.z)).flat(),
        material: finish(random),
        balls,
        volume: 8.0 * half.element_product(),
    }
}

/// Six balls (centre, radius) in a horizontal ring around the y axis. The simulation of the fall uses only
/// balls, so such rings represent the horizontal slices of a round toy (cone or drum). `radius` is the radius
/// of the slice, `height` is the height of the balls' centres, and `thick` is the radius of the balls, all in
/// metres.
fn wreath(radius: f32, height: f32, thick: f32) -> impl Iterator<Item = (Vec3, f32)> {
    const HALF_ROOT_3: f32 = 0.866_025_4;
    let points = [(1.0, 0.0), (0.5, HALF_ROOT_3), (-0.5, HALF_ROOT_3)];
    points.into_iter().flat_map(move |(x, z)| {
        let out = vec3(x, 0.0, z) * (radius - thick);
        [out, -out].map(|p| (p + Vec3::Y * height, thick))
    })
}

fn cone(random: &mut Random) -> Toy {
    let (radius, height) = (random.between(0.09, 0.15), random.between(0.22, 0.38));
    let slant = radius.hypot(height);
    let shape = Profile::new(0.0, 0.0)
        .line(radius - 0.006, 0.0)
        .line(0.006, 0.006)
        .line(-radius, height - 0.006)
        .turned(40);
    let sine = radius / slant;
    let mut balls: Vec<_> = wreath(radius, 0.2 * radius, 0.2 * radius).collect();
    // Balls that touch the side and the next ball.
    let mut inner = radius * height / (radius + slant);
    let mut y = inner;
    for _ in 0..3 {
        balls.push((Vec3::Y * y, inner));
        let next = inner * (1.0 - sine) / (1.0 + sine);
        y += inner + next;
        inner = next;
    }
    Toy {
        shape,
        material: finish(random),
        balls,
        volume: 1.05 * radius * radius * height,
    }
}

fn drum(random: &mut Random) -> Toy {
    let (radius, height) = (random.between(0.07, 0.13), random.between(0.12, 0.34));
    let shape = Profile::new(0.0, 0.0)
        .line(radius - 0.008, 0.0)
        .arc(0.008, 0.008, 90.0, 3)
        .line(0.0, height - 0.016)
        .arc(-0.008, 0.008, 90.0, 3)
        .capped()
        .turned(40);
    let thick = 0.4 * radius;
    let rows = (height / (2.0 * thick)).ceil().max(2.0);
    let balls = (0..rows as u32).flat_map(|row| {
        let t = row as f32 / (rows - 1.0);
        wreath(radius, thick + t * (height - 2.0 * thick), thick)
    });
    Toy {
        shape,
        material: finish(random),
        balls: balls.collect(),
        volume: std::f32::consts::PI * radius * radius * height,
    }
}

/// A random rotation as a matrix, with which a toy begins its fall. It is computed without sines and cosines, because their
/// results differ between machines, and the scene must be the same on all of them.
fn any_turn(random: &mut Random) -> Mat3 {
    let mut any = || {
        let point = |r: &mut Random| [(); 3].map(|()| r.between(-1.0, 1.0));
        loop {
            let p = Vec3::from(point(random));
            if (0.1..1.0).contains(&p.length_squared()) {
                break p.normalize();
            }
        }
    };
    let (x, y) = (any(), any());
    let z = x
        .cross(y)
        .try_normalize()
        .unwrap_or(x.any_orthonormal_vector());
    Mat3::from_cols(x, z.cross(x), z)
}

/// Makes `things` toys for the heap; `lamps` of them are glowing balls. Each toy comes with the body that
/// represents it in the simulation of the fall. The bodies start in the air, on a rising spiral around the y
/// axis.
fn heap_of(random: &mut Random, things: u32, lamps: u32) -> Vec<(Toy, Body)> {
    // Rotated by the golden angle each; the spiral is wider for more things.
    let golden = Mat3::from_cols(
        vec3(-0.737_368_9, 0.0, 0.675_490_3),
        Vec3::Y,
        vec3(-0.675_490_3, 0.0, -0.737_368_9),
    );
    let wide = 0.75 * (things as f32 / 360.0).sqrt().max(0.5);
    let mut way = Vec3::X;
    (0..things)
        .map(|i| {
            let glows = u64::from(i + 1) * u64::from(lamps) / u64::from(things)
                != u64::from(i) * u64::from(lamps) / u64::from(things);
            let toy = if glows {
                let glow = Vec3::from(random.pick(&GLOWS));
                let size: f32 = random.pick(&[0.045, 0.07, 0.1, 0.14]);
                // Small ones are brighter, so that their light is visible as well.
                let glow = glow * (0.09 / size).min(2.0);
                ball(random, emitter("glowing ball", glow), size, size)
            } else {
                match random.pick(&[0, 0, 0, 1, 2, 2, 3]) {
                    0 => block(random),
                    1 => drum(random),
                    2 => {
                        let material = finish(random);
                        ball(random, material, 0.06, 0.15)
                    }
                    _ => cone(random),
                }
            };
            way = golden * way;
            let out = wide * random.unit().sqrt();
            let at = way * out + Vec3::Y * (0.4 + i as f32 * 0.035 / (wide / 0.75).powi(2));
            let body = Body::new(toy.balls.clone(), toy.volume, at, any_turn(random));
            (toy, body)
        })
        .collect()
}

fn room(model: &mut Model) {
    let wall = Material::lambert("wall", vec3(0.32, 0.33, 0.36));
    let (low, high) = (vec3(-ROOM, 0.0, -ROOM), vec3(ROOM, ROOM, ROOM));
    let up = Vec3::Y * ROOM;
    let (x, z) = (Vec3::X * 2.0 * ROOM, Vec3::Z * 2.0 * ROOM);
    model.add(
        &dielectric("floor", vec3(0.2, 0.2, 0.22), 0.3),
        Shape::quad(low, z, x),
    );
    for (corner, u, v) in [
        (low, x, up),
        (low, up, z),
        (high - up, up, -x),
        (high - up, -z, up),
        (low + up, x, z),
    ] {
        model.add(&wall, Shape::quad(corner, u, v));
    }
}

/// Adds three glowing globes, which hang on cords over the heap, and a wide soft light under the ceiling.
fn lamps(model: &mut Model) {
    let cord = dielectric("cord", Vec3::splat(0.03), 0.5);
    for (at, radius, glow) in [
        (vec3(-1.2, 1.2, 0.1), 0.19, vec3(11.0, 3.0, 0.3)),
        (vec3(1.25, 1.02, 0.5), 0.09, vec3(0.35, 5.0, 14.0)),
        (vec3(0.55, 1.4, -0.9), 0.13, vec3(14.0, 0.3, 4.0)),
    ] {
        let globe = Shape::sphere(2).flat().map(|p| p * radius + at);
        model.add(&emitter("globe", glow), globe);
        let top = at + Vec3::Y * radius * 0.97;
        model.add(&cord, Shape::cylinder(top, 0.008, ROOM - top.y, 8));
    }
    let (corner, size) = (vec3(-1.4, ROOM - 0.02, -1.0), vec2(2.8, 2.0));
    model.add(
        &emitter("soft light", vec3(7.0, 7.2, 7.8)),
        Shape::quad(corner, Vec3::X * size.x, Vec3::Z * size.y),
    );
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let things = values.whole("things") as u32;
    let lamps_within = (values.whole("lamps") as u32).min(things);
    let toys = heap_of(&mut random, things, lamps_within);
    let (toys, mut bodies): (Vec<_>, Vec<_>) = toys.into_iter().unzip();
    simulate_fall(&mut bodies, 4.5);
    let mut model = Model::default();
    room(&mut model);
    lamps(&mut model);
    for (toy, body) in toys.into_iter().zip(&bodies) {
        model.add(&toy.material, toy.shape.map(|p| body.moved(p)));
    }
    let mut scene = Builder::default();
    scene.add_model("mess", model);
    scene.camera(
        DVec3::new(0.4, 1.35, 3.7),
        DVec3::new(0.0, 0.5, 0.0),
        34.0,
        16.0 / 9.0,
    );
    scene.0
}

//! The scene `figures`: spheres, cones and chessmen (the figures) on a wide plane, between and under coloured spheres that
//! emit light. It tests how a renderer samples many lights. Lengths are in metres, and the plane is at height 0.

use crate::base::random::Random;
use crate::procedural::modelling::{
    Builder, Model, Shape, dielectric, emitter, lathe, metal, soft_box,
};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "figures",
        doc: "Spheres, cones and statues; the ground they stand on grows with them",
        default: "90",
        values: Range::Whole(1, 20_000),
    },
    Parameter {
        name: "lights",
        doc: "Spheres of light; the more, the smaller: all together shine as bright",
        default: "160",
        values: Range::Whole(1, 100_000),
    },
    Parameter {
        name: "seed",
        doc: "Seed of the scatter",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
];

/// The area of ground for each figure, in square metres. The figures are scattered in a disc whose area is
/// about this number times the number of figures, so a larger value spreads them more.
const ROOM: f32 = 3.4;

/// The functions that make the shapes of figures: spheres, cones and chessmen. The first one makes the king, which stands in
/// the middle of the scene. For each other figure, one function of the list is picked at random; `pawn`, `ball` and `cone`
/// occur twice, so they are twice as frequent.
const KINDS: &[fn() -> Shape] = &[
    king, queen, bishop, rook, pawn, ball, cone, pawn, ball, cone,
];

/// Makes a chessman by turning a profile around the y axis. All chessmen have a foot, and a waist with a
/// collar at its upper end. `waist` is the radius of the waist, and `top` is the height of the collar. `more`
/// has the parts of the profile above the collar, each a curve of points (radius, height). All lengths are in
/// metres.
fn lower(waist: f32, top: f32, more: &[&[(f32, f32)]]) -> Shape {
    let rising = [
        (0.28, 0.21),
        (0.55 * waist + 0.13, 0.32),
        (waist, 0.62 * top),
        (waist + 0.025, top),
    ];
    let collar = [
        (waist + 0.025, top),
        (waist + 0.1, top + 0.03),
        (waist + 0.02, top + 0.07),
    ];
    let mut pieces: Vec<&[(f32, f32)]> = vec![
        &[(0.0, 0.0), (0.35, 0.0)],
        &[(0.35, 0.0), (0.35, 0.07)],
        &[(0.35, 0.07), (0.3, 0.1), (0.31, 0.15), (0.28, 0.21)],
        &rising,
        &collar,
    ];
    pieces.extend(more);
    lathe(&pieces, 48)
}

fn pawn() -> Shape {
    let head = [
        (0.12, 0.72),
        (0.185, 0.8),
        (0.2, 0.9),
        (0.165, 1.0),
        (0.09, 1.06),
        (0.0, 1.08),
    ];
    lower(0.1, 0.65, &[&head])
}

fn bishop() -> Shape {
    let mitre = [(0.12, 1.02), (0.18, 1.12), (0.165, 1.27), (0.04, 1.46)];
    let tip = [(0.04, 1.46), (0.065, 1.5), (0.05, 1.55), (0.0, 1.57)];
    lower(0.1, 0.95, &[&mitre, &tip])
}

fn rook() -> Shape {
    let flare = [(0.17, 0.87), (0.2, 0.93), (0.28, 0.99)];
    let mut rook = lower(
        0.15,
        0.8,
        &[
            &flare,
            &[(0.28, 0.99), (0.28, 1.14)],
            &[(0.28, 1.14), (0.19, 1.14)],
            &[(0.19, 1.14), (0.19, 1.05)],
            &[(0.19, 1.05), (0.0, 1.05)],
        ],
    );
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let middle = Vec3::new(0.235 * x, 1.17, 0.235 * z);
        let size = Vec3::new(0.15 - 0.07 * x * x, 0.12, 0.15 - 0.07 * z * z);
        rook.add(soft_box(middle, size, 0.015));
    }
    rook
}

fn queen() -> Shape {
    let crown = [(0.12, 1.32), (0.14, 1.42), (0.2, 1.54), (0.28, 1.64)];
    let dome = [(0.2, 1.62), (0.15, 1.69), (0.0, 1.73)];
    let mut queen = lower(0.1, 1.25, &[&crown, &[(0.28, 1.64), (0.2, 1.62)], &dome]);
    queen.add(Shape::sphere(2).map(|n| n * 0.06 + Vec3::Y * 1.78));
    for k in 0..9 {
        let turn = std::f32::consts::TAU * k as f32 / 9.0;
        let at = Vec3::new(0.255 * turn.cos(), 1.66, 0.255 * turn.sin());
        queen.add(Shape::sphere(2).map(|n| n * 0.045 + at));
    }
    queen
}

fn king() -> Shape {
    let crown = [(0.12, 1.47), (0.15, 1.6), (0.24, 1.8)];
    let dome = [(0.24, 1.8), (0.2, 1.86), (0.0, 1.92)];
    let mut king = lower(0.11, 1.4, &[&crown, &dome]);
    king.add(soft_box(Vec3::Y * 2.04, Vec3::new(0.08, 0.3, 0.07), 0.02));
    king.add(soft_box(Vec3::Y * 2.06, Vec3::new(0.24, 0.08, 0.065), 0.02));
    king
}

fn ball() -> Shape {
    Shape::sphere(4).map(|n| n * 0.4 + Vec3::Y * 0.4)
}

fn cone() -> Shape {
    let side = [(0.4, 0.0), (0.0, 1.1)];
    lathe(&[&[(0.0, 0.0), (0.4, 0.0)], &side], 64)
}

/// The list of materials for the figures. The king gets gold (index 2); each other figure gets one of the
/// materials at random.
fn materials() -> Vec<Material> {
    vec![
        dielectric("white marble", Vec3::new(0.75, 0.73, 0.68), 0.25),
        dielectric("black stone", Vec3::splat(0.025), 0.15),
        metal("gold", Vec3::new(1.0, 0.77, 0.34), 0.25),
        metal("silver", Vec3::new(0.95, 0.94, 0.92), 0.12),
        metal("copper", Vec3::new(0.95, 0.6, 0.48), 0.4),
        Material::lambert("plaster", Vec3::splat(0.7)),
    ]
}

/// The position on the ground below the camera, in units of the radius of the disc in which the figures are
/// scattered. [`make`] clamps this radius to [5.1, 10.9] m before it multiplies. The camera is then among the
/// outer figures, but not too close to the king.
const EYE: Vec3 = Vec3::new(-0.3, 0.0, 1.12);
/// The minimum distance in metres between the figures and the point on the ground below the camera. It keeps figures from
/// blocking the view.
const CLEAR_OF_EYE: f32 = 5.0;

/// A space that a figure or the camera occupies: a disc on the ground with its centre and radius, and the
/// height up to which the space is occupied, in metres. Figures and lights that are placed later stay
/// outside, so that objects do not overlap and the view is free.
struct Taken {
    middle: Vec3,
    radius: f32,
    height: f32,
}

/// Adds the ground: a chessboard of squares of 1 m, which reaches `half` metres from the origin in the directions ±x and ±z,
/// and around it a plane that is 200 m wider on each side.
fn ground(scene: &mut Builder, half: u32) {
    let stones = [
        dielectric("light square", Vec3::new(0.5, 0.47, 0.42), 0.3),
        dielectric("dark square", Vec3::new(0.05, 0.055, 0.065), 0.2),
    ];
    let mut squares = [Shape::default(), Shape::default()];
    let (n, edge) = (half as i32, half as f32);
    for (i, j) in (-n..n).flat_map(|i| (-n..n).map(move |j| (i, j))) {
        let corner = Vec3::new(i as f32, 0.0, j as f32);
        squares[(i + j).rem_euclid(2) as usize].add(Shape::quad(corner, Vec3::Z, Vec3::X));
    }
    let far = edge + 200.0;
    let mut around = Shape::default();
    for (x, z, width, depth) in [
        (-far, -far, 2.0 * far, far - edge),
        (-far, edge, 2.0 * far, far - edge),
        (-far, -edge, far - edge, 2.0 * edge),
        (edge, -edge, far - edge, 2.0 * edge),
    ] {
        around.add(Shape::quad(
            Vec3::new(x, 0.0, z),
            Vec3::Z * depth,
            Vec3::X * width,
        ));
    }
    let mut parts: Vec<_> = stones.into_iter().zip(squares).collect();
    parts.push((dielectric("plane", Vec3::splat(0.12), 0.35), around));
    scene.add_model("ground", Model(parts));
}

/// A random point on the ground, in metres, uniformly distributed in the disc of radius `radius` around the
/// origin. Figures and lights are placed at such points.
fn somewhere(random: &mut Random, radius: f32) -> Vec3 {
    let (turn, out) = (
        random.between(0.0, std::f32::consts::TAU),
        radius * random.unit().sqrt(),
    );
    Vec3::new(out * turn.cos(), 0.0, out * turn.sin())
}

/// Places the king at the origin, and the other of the `count` figures at random positions in a disc around it. Figures do
/// not overlap, and stay away from `eye`, the point on the ground below the camera. `radius` is the radius of the disc in
/// metres; this function increases it until all figures have space. Returns the occupied spaces, in which [`lights`] places
/// no light: first the one around `eye`, then one per figure.
fn scatter(
    scene: &mut Builder,
    random: &mut Random,
    count: u64,
    eye: Vec3,
    radius: &mut f32,
) -> Vec<Taken> {
    let materials = materials();
    let mut meshes: Vec<((usize, usize), u32)> = Vec::new();
    let mut taken = vec![Taken {
        middle: eye,
        radius: CLEAR_OF_EYE,
        height: f32::MAX,
    }];
    for index in 0..count {
        let (kind, size) = if index == 0 {
            (0, 1.7)
        } else {
            (random.index(KINDS.len()), random.between(0.75, 1.35))
        };
        let material = if index == 0 {
            2
        } else {
            random.index(materials.len())
        };
        let foot = 0.42 * size;
        let mut at = if index == 0 {
            Vec3::ZERO
        } else {
            somewhere(random, *radius)
        };
        while taken
            .iter()
            .any(|other| other.middle.distance(at) < other.radius + foot + 0.1)
        {
            *radius *= 1.0005;
            at = somewhere(random, *radius);
        }
        let known = meshes.iter().find(|(key, _)| *key == (kind, material));
        let mesh = known.map(|(_, mesh)| *mesh).unwrap_or_else(|| {
            let mesh = scene.mesh(materials[material].clone(), KINDS[kind]());
            meshes.push(((kind, material), mesh));
            mesh
        });
        let turn = DQuat::from_rotation_y(f64::from(random.between(0.0, std::f32::consts::TAU)));
        // Slightly above the plane, so that no face coincides with it.
        let position = at.as_dvec3() + DVec3::Y * 0.001;
        scene.place(
            "figure",
            mesh,
            DAffine3::from_scale_rotation_translation(
                DVec3::splat(f64::from(size)),
                turn,
                position,
            ),
        );
        taken.push(Taken {
            middle: at,
            radius: foot,
            height: 2.3 * size,
        });
    }
    taken
}

/// Adds `count` coloured spheres that emit light, between and above the figures, within about `radius` metres of the origin.
/// `taken` lists the spaces that figures and the camera occupy, and `eye` is the point on the ground below the camera. No
/// sphere is inside an occupied space, or between the camera and the king.
fn lights(
    scene: &mut Builder,
    random: &mut Random,
    count: u64,
    radius: f32,
    eye: Vec3,
    taken: &[Taken],
) {
    let meshes: Vec<u32> = (0..12)
        .map(|hue| {
            let part = |shift: f32| {
                let t = (hue as f32 / 12.0 + shift).fract();
                // Saturated, so that it can be seen which light a colour comes from.
                (0.5 + 0.5 * (std::f32::consts::TAU * t).cos())
                    .powi(2)
                    .max(0.02)
            };
            let color = Vec3::new(part(0.0), part(2.0 / 3.0), part(1.0 / 3.0));
            // Between equal luminance and equal radiance, so that blue is visible and green is not too bright.
            let bright = color.dot(Vec3::new(0.3, 0.5, 0.2)).sqrt();
            scene.mesh(emitter("light", color / bright), Shape::sphere(2))
        })
        .collect();
    // The size of one of 160, so that the total area is the same for any larger number.
    let usual = (160.0 / count as f32).sqrt();
    let base = 0.165 * usual.min(2.0) * radius / 10.0;
    let strength = 5.0 * (usual / usual.min(2.0)).powi(2);
    for mesh in &meshes {
        let material = scene.0.meshes[*mesh as usize].parts[0].material as usize;
        scene.0.materials[material].emission *= strength;
    }
    for _ in 0..count {
        let size = base * random.between(0.6, 1.4);
        let (mut reach, mut tries) = (radius, 0);
        let at = loop {
            let height = size + 0.05 + 3.6 * random.unit().powi(2);
            let at = somewhere(random, reach) + Vec3::Y * height;
            let inside = |other: &Taken| {
                let away = (other.middle - at) * Vec3::new(1.0, 0.0, 1.0);
                at.y - size < other.height && away.length() < other.radius + size + 0.03
            };
            // And not between the eye and the king.
            let t = (at - eye).dot(-eye) / eye.length_squared();
            let off = (at - eye * (1.0 - t)) * Vec3::new(1.0, 0.0, 1.0);
            if (off.length() > 0.8 || t > 1.0) && !taken.iter().any(inside) {
                break at;
            }
            tries += 1;
            // There is always room further out.
            if tries % 200 == 0 {
                reach *= 1.1;
            }
        };
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::splat(f64::from(size)),
            DQuat::IDENTITY,
            at.as_dvec3(),
        );
        let mesh = random.pick(&meshes);
        scene.place("light", mesh, transform);
    }
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let count = values.whole("figures");
    let mut radius = (count as f32 * ROOM / std::f32::consts::PI).sqrt() + 1.0;
    // Close enough to be among the outer figures, whatever their number, but away from the king if
    // they are few.
    let eye = EYE * radius.clamp(5.1, 10.9);
    let taken = scatter(&mut scene, &mut random, count, eye, &mut radius);
    ground(&mut scene, radius.ceil() as u32 + 2);
    lights(
        &mut scene,
        &mut random,
        values.whole("lights"),
        radius,
        eye,
        &taken,
    );
    let eye = eye.as_dvec3() + DVec3::Y * f64::from(0.34 * eye.length());
    scene.camera(eye, DVec3::new(0.0, 0.7, 0.0), 36.0, 16.0 / 9.0);
    scene.0
}

//! The scene `statue-room`: a marble bust in a niche, under one lamp whose size is a parameter. It tests soft and sharp
//! shadows. Lengths are in metres, the floor is at height 0, and the niche is in the wall at the −Z end of the room.

use crate::base::random::Random;
use crate::procedural::modelling::{Builder, Model, Profile, Shape, dielectric, emitter, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::procedural::props::{Arch, statue};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DVec3, Vec2, Vec3, vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "seed",
        doc: "Seed of the bust's looks",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
    Parameter {
        name: "roughness",
        doc: "Roughness of the bust's marble",
        default: "0.35",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "lamp",
        doc: "Side of the lamp in metres; it gives the same light at any size",
        default: "0.9",
        values: Range::Real(0.01, 2.0),
    },
];

/// Half the width of the room, in metres: the side walls are at x = ±`SIDE`.
const SIDE: f32 = 2.7;
/// The height of the ceiling above the floor, in metres. The walls reach up to it.
const HIGH: f32 = 3.6;
/// The z coordinate of the back wall, in metres. The niche is in this wall.
const BACK: f32 = -2.4;
/// The z coordinate of the front wall, in metres. The wall is behind the camera and closes the room.
const FRONT: f32 = 4.2;
/// The centre of the only lamp, a square that faces down, in metres.
const LAMP: Vec3 = vec3(-1.15, 3.3, 0.1);
/// The factor by which the bust is larger than the model that `statue::bust` makes: 1.3 is 30 % larger.
const LARGER: f32 = 1.3;
/// The width of the stone moulding around the niche, in metres. The skirting and the rails end at the
/// moulding.
const TRIM: f32 = 0.15;

const NICHE: Arch = Arch {
    radius: 0.75,
    spring: 1.6,
    steps: 48,
};

fn walls(model: &mut Model) {
    let plaster = Material::lambert("plaster", vec3(0.62, 0.47, 0.36));
    let to_back = |p: Vec3| p + Vec3::Z * BACK;
    model.add(&plaster, NICHE.wall(SIDE, HIGH).map(to_back));
    let (up, along) = (Vec3::Y * HIGH, Vec3::Z * (FRONT - BACK));
    let left = vec3(-SIDE, 0.0, BACK);
    let right = vec3(SIDE, 0.0, BACK);
    model.add(&plaster, Shape::quad(left, up, along));
    model.add(&plaster, Shape::quad(right, along, up));
    let across = Vec3::X * 2.0 * SIDE;
    model.add(&plaster, Shape::quad(left + along, up, across));

    let blue = Material::lambert("niche", vec3(0.09, 0.2, 0.25));
    // Half a cylinder and a quarter of a sphere with the same vertices on their common edge.
    let drum = Profile::new(-NICHE.radius, 0.0).line(0.0, NICHE.spring);
    model.add(&blue, drum.swung(0.0, 0.5, NICHE.steps).map(to_back));
    let dome = Profile::new(-NICHE.radius, NICHE.spring).arc(
        NICHE.radius,
        NICHE.radius,
        -90.0,
        NICHE.steps / 2,
    );
    model.add(&blue, dome.swung(0.0, 0.5, NICHE.steps).map(to_back));

    let stone = dielectric("limestone", vec3(0.7, 0.64, 0.54), 0.5);
    let trim = Profile::new(0.0, 0.02)
        .line(0.0, -0.06)
        .line(0.05, 0.0)
        .line(0.0, -0.015)
        .line(0.05, 0.0)
        .arc(0.03, 0.03, -90.0, 4)
        .line(TRIM - 0.13, 0.0)
        .line(0.0, 0.06);
    model.add(&stone, NICHE.moulding(&trim, NICHE.spring).map(to_back));
    let cornice = Profile::new(-0.18, HIGH + 0.01)
        .line(0.0, -0.06)
        .arc(0.07, -0.08, -60.0, 5)
        .line(0.0, -0.03)
        .line(0.02, 0.0)
        .arc(0.06, -0.06, 90.0, 5)
        .line(0.0, -0.05)
        .line(0.03, 0.0);
    let room = Vec2::new(SIDE, (FRONT - BACK) / 2.0);
    let middle = Vec3::Z * (FRONT + BACK) / 2.0;
    model.add(&stone, cornice.framed(room).map(|p| p + middle));
}

/// Adds a floor of square tiles in two alternating colours. The first row of tiles is at the front wall; the last two rows
/// are behind the back wall, where they are the floor of the niche.
fn floor(model: &mut Model) {
    let colors = [
        dielectric("dark tiles", vec3(0.05, 0.055, 0.06), 0.22),
        dielectric("pale tiles", vec3(0.55, 0.5, 0.43), 0.22),
    ];
    let (tiles, rows) = (9_u8, 13_u8);
    let step = 2.0 * SIDE / f32::from(tiles);
    let x = |i: u8| (f32::from(i) - f32::from(tiles) / 2.0) * step;
    // Its back edge continues under the niche.
    let z = |j: u8| FRONT - f32::from(j) * step;
    for j in 0..rows {
        for i in 0..tiles {
            let [a, b] = [vec3(x(i), 0.0, z(j)), vec3(x(i + 1), 0.0, z(j))];
            let [c, d] = [vec3(x(i + 1), 0.0, z(j + 1)), vec3(x(i), 0.0, z(j + 1))];
            let mut tile = Shape::triangle([a, b, c]);
            tile.add(Shape::triangle([a, c, d]));
            model.add(&colors[usize::from((i + j) % 2)], tile);
        }
    }
}

/// Adds the ceiling, and under it a square lamp with edges of `side` metres. The power of the lamp is the same for every
/// `side`. The lamp has a frame, which keeps its light off the ceiling.
fn ceiling(model: &mut Model, side: f32) {
    let corner = vec3(-SIDE, HIGH, BACK);
    model.add(
        &Material::lambert("ceiling", Vec3::splat(0.7)),
        Shape::quad(corner, Vec3::X * 2.0 * SIDE, Vec3::Z * (FRONT - BACK)),
    );
    let iron = metal("lamp frame", Vec3::splat(0.1), 0.5);
    let frame = vec3(side + 0.08, 0.1, side + 0.08);
    model.add(&iron, Shape::chunk(LAMP + Vec3::Y * 0.06, frame));
    for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let foot = LAMP + vec3(x, 0.0, z) * side / 2.5 + Vec3::Y * 0.1;
        model.add(&iron, Shape::cylinder(foot, 0.01, HIGH - foot.y, 8));
    }
    let glow = Vec3::new(50.0, 41.0, 30.0) / (side * side);
    let corner = LAMP - vec3(side / 2.0, 0.0, side / 2.0);
    model.add(
        &emitter("lamp", glow),
        Shape::quad(corner, Vec3::X * side, Vec3::Z * side),
    );
}

/// Adds the skirting boards at the foot of the walls and the wooden rails above them. They run along the side walls and, on
/// both sides of the niche, along the back wall.
fn rails(model: &mut Model) {
    let wood = dielectric("dark wood", vec3(0.1, 0.055, 0.03), 0.35);
    let skirting = Profile::new(0.03, 0.0)
        .line(0.0, 0.12)
        .arc(-0.03, 0.03, -90.0, 4);
    let rail = Profile::new(0.0, 0.92)
        .line(0.02, 0.0)
        .line(0.0, 0.02)
        .arc(0.0, 0.045, 180.0, 8)
        .line(0.0, 0.02)
        .line(-0.02, 0.0);
    let opening = NICHE.radius + TRIM;
    for profile in [skirting, rail] {
        let to_back = |p: Vec3| vec3(-p.z, p.y, p.x + BACK);
        for (from, to) in [(-SIDE, -opening), (opening, SIDE)] {
            model.add(&wood, profile.drawn(from, to).map(to_back));
        }
        // In the corners they run into the other one, a little lower: of two faces in the same plane,
        // the visible one would be arbitrary.
        let left = profile.drawn(BACK + 0.01, FRONT);
        model.add(&wood, left.map(|p| p - vec3(SIDE, 0.001, 0.0)));
        let right = profile.drawn(-FRONT, -BACK - 0.01);
        model.add(&wood, right.map(|p| vec3(SIDE - p.x, p.y - 0.001, -p.z)));
    }
}

/// A square pedestal for the bust, 1.05 m high, with its foot at the origin.
fn pedestal() -> Shape {
    Profile::new(0.0, 0.0)
        .line(0.27, 0.0)
        .line(0.0, 0.14)
        .arc(-0.05, 0.05, -90.0, 5)
        .line(-0.02, 0.0)
        .line(0.0, 0.7)
        .line(0.015, 0.0)
        .arc(0.045, 0.05, 80.0, 5)
        .line(0.0, 0.11)
        .capped()
        .framed(Vec2::ZERO)
}

/// A rope between two posts, from the point `from` to the point `to`. Its middle hangs `sag` below the
/// straight line between them. All lengths are in metres.
fn rope(from: Vec3, to: Vec3, sag: f32) -> Shape {
    const LINKS: u32 = 24;
    const SIDES: u32 = 10;
    let point = |t: f32| from.lerp(to, t) - Vec3::Y * sag * 4.0 * t * (1.0 - t);
    let ring = |link: u32, side: u32| {
        let t = link as f32 / LINKS as f32;
        let way = (point(t + 0.01) - point(t - 0.01)).normalize();
        let aside = way.cross(Vec3::Y).normalize();
        let turn = (side % SIDES) as f32 / SIDES as f32 * std::f32::consts::TAU;
        let out = aside * turn.cos() + aside.cross(way) * turn.sin();
        (point(t) + out * 0.018, out)
    };
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for link in 0..LINKS {
        for side in 0..SIDES {
            let [a, b] = [ring(link, side), ring(link + 1, side)];
            let [c, d] = [ring(link + 1, side + 1), ring(link, side + 1)];
            let corners = [a, b, c, a, c, d];
            positions.extend(corners.map(|corner| corner.0));
            normals.extend(corners.map(|corner| corner.1));
        }
    }
    Shape::smooth(positions, normals)
}

/// A brass post, 0.95 m high, with its foot at the origin. Two such posts carry the rope in front of the niche.
fn post() -> Shape {
    Profile::new(0.0, 0.0)
        .line(0.16, 0.0)
        .line(0.0, 0.012)
        .arc(-0.135, 0.05, -70.0, 8)
        .line(-0.006, 0.0)
        .line(0.0, 0.79)
        .arc(0.0, 0.03, 180.0, 6)
        .line(-0.004, 0.008)
        .arc(-0.015, 0.06, 200.0, 10)
        .capped()
        .turned(32)
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let mut model = Model::default();
    walls(&mut model);
    floor(&mut model);
    ceiling(&mut model, values.real("lamp"));
    rails(&mut model);
    let [left, right] = [-0.85, 0.85].map(|x| vec3(x, 0.83, BACK + 1.1));
    let velvet = Material::lambert("velvet", vec3(0.3, 0.015, 0.025));
    model.add(&velvet, rope(left, right, 0.22));
    scene.add_model("room", model);

    // A little into the floor: of two faces in the same plane, the visible one would be arbitrary.
    let stand = DVec3::new(0.0, -0.002, f64::from(BACK) + 0.02);
    let stone = dielectric("pedestal", vec3(0.2, 0.19, 0.18), 0.3);
    let pedestal = scene.mesh(stone, pedestal());
    scene.place("pedestal", pedestal, DAffine3::from_translation(stand));
    let marble = dielectric("marble", vec3(0.84, 0.81, 0.76), values.real("roughness"));
    let bust = scene.mesh(marble, statue::bust(&mut random).map(|p| p * LARGER));
    let on_top = stand + DVec3::Y * 1.048;
    scene.place("bust", bust, DAffine3::from_translation(on_top));
    let brass = metal("brass", vec3(0.91, 0.74, 0.4), 0.25);
    let post = scene.mesh(brass, post());
    for end in [left, right] {
        let position = end.as_dvec3().with_y(stand.y);
        scene.place("post", post, DAffine3::from_translation(position));
    }
    scene.camera(
        DVec3::new(0.6, 1.45, 2.5),
        DVec3::new(-0.03, 1.27, f64::from(BACK)),
        30.0,
        16.0 / 9.0,
    );
    scene.0
}

//! The scenes `cornell` and `cornell-glossy`: the Cornell box, with an open front, a red and a green wall, and one lamp
//! under the ceiling. `cornell` is a well-known picture to compare with, and `cornell-glossy` tests glossy reflections. The
//! box is two metres wide, high and deep, and its floor is at height 0.

use crate::procedural::modelling::{Builder, Shape, brushed, coated, dielectric, emitter, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

/// The linear RGB reflectance, in [0, 1], of the white surfaces: the ceiling, the back wall, the floor, and
/// the blocks of `cornell`.
const WHITE: [f32; 3] = [0.73, 0.73, 0.73];

pub(super) const GLOSSY_PARAMETERS: &[Parameter] = &[Parameter {
    name: "subdivisions",
    doc: "How often the spheres' icosahedra are split; each time four times the triangles",
    default: "4",
    values: Range::Whole(0, 8),
}];

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "finish",
        doc: "What blocks and floor are made of",
        default: "matte",
        values: Range::Words(&["matte", "metal", "lacquer", "coated", "brushed"]),
    },
    Parameter {
        name: "roughness",
        doc: "Roughness of metal, lacquer and clear coat, and across the grain of brushed metal",
        default: "0.3",
        values: Range::Real(0.0, 1.0),
    },
];

/// The empty box with its lamp and its camera, to which both scenes add their objects. The floor has the material `floor`;
/// the other surfaces are matte.
fn room(floor: Material) -> Builder {
    let mut room = Builder::default();
    let wall = |name: &str, color: [f32; 3]| Material::lambert(name, Vec3::from(color));
    let white = WHITE;
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let low = Vec3::new(-1.0, 0.0, -1.0);
    room.add(floor, Shape::quad(low, z, x));
    room.add(wall("ceiling", white), Shape::quad(low + y, x, z));
    room.add(wall("back wall", white), Shape::quad(low, x, y));
    room.add(wall("red wall", [0.65, 0.05, 0.05]), Shape::quad(low, y, z));
    room.add(
        wall("green wall", [0.12, 0.45, 0.15]),
        Shape::quad(low + x, z, y),
    );
    let lamp_corner = Vec3::new(-0.25, 1.99, -0.25);
    let light = emitter("lamp", Vec3::new(17.0, 12.0, 7.0));
    room.add(
        light,
        Shape::quad(lamp_corner, Vec3::X * 0.5, Vec3::Z * 0.5),
    );
    room.camera(
        DVec3::new(0.0, 1.0, 4.4),
        DVec3::new(0.0, 1.0, 0.0),
        35.0,
        1.0,
    );
    room
}

/// The transform that maps the cube of side 1 around the origin to a block on the floor of the box. `size` is the size of
/// the block along x, y and z, in metres. The middle of the block is at the coordinates `x` and `z`, in metres, and the
/// block is rotated by `degrees` around its vertical axis.
fn on_floor(x: f64, z: f64, size: DVec3, degrees: f64) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        size,
        DQuat::from_rotation_y(degrees.to_radians()),
        DVec3::new(x, size.y / 2.0, z),
    )
}

fn unit_cube() -> Shape {
    Shape::block(Vec3::splat(-0.5), Vec3::splat(0.5))
}

/// Makes the scene `cornell`: the box with a tall and a short block. The parameters in `values` decide the material of the
/// floor and the blocks.
pub(super) fn plain(values: &Values) -> Scene {
    let roughness = values.real("roughness");
    let made_of = |name: &str| match values.text("finish") {
        "metal" => metal(name, Vec3::from(WHITE), roughness),
        "lacquer" => dielectric(name, Vec3::from(WHITE), roughness),
        "coated" => coated(metal(name, Vec3::new(0.9, 0.35, 0.2), 0.6), roughness),
        "brushed" => brushed(metal(name, Vec3::from(WHITE), roughness), 0.8),
        _ => Material::lambert(name, Vec3::from(WHITE)),
    };
    let mut room = room(made_of("floor"));
    let block = room.mesh(made_of("block"), unit_cube());
    room.place(
        "tall block",
        block,
        on_floor(-0.36, -0.3, DVec3::new(0.6, 1.2, 0.6), 18.0),
    );
    room.place(
        "short block",
        block,
        on_floor(0.36, 0.3, DVec3::new(0.6, 0.6, 0.6), -16.0),
    );
    room.0
}

pub(super) fn glossy(values: &Values) -> Scene {
    let mut room = room(Material::lambert("floor", Vec3::from(WHITE)));
    let subdivisions = values.whole("subdivisions") as u32;
    let gold = Vec3::new(1.0, 0.77, 0.34);
    let copper = Vec3::new(0.95, 0.64, 0.54);
    let silver = Vec3::new(0.97, 0.96, 0.92);
    for (roughness, color, x, z, radius) in [
        (0.1, silver, -0.6, 0.25, 0.3),
        (0.3, gold, 0.05, 0.45, 0.25),
        (0.6, copper, 0.6, 0.2, 0.3),
    ] {
        let name = format!("sphere of roughness {roughness}");
        let mesh = room.mesh(metal(&name, color, roughness), Shape::sphere(subdivisions));
        let transform = DAffine3::from_scale_rotation_translation(
            DVec3::splat(radius),
            DQuat::IDENTITY,
            DVec3::new(x, radius, z),
        );
        room.place(&name, mesh, transform);
    }
    let glazed = room.mesh(
        dielectric("glazed block", Vec3::new(0.2, 0.35, 0.6), 0.2),
        unit_cube(),
    );
    room.place(
        "glazed block",
        glazed,
        on_floor(0.1, -0.45, DVec3::new(0.7, 1.1, 0.5), 24.0),
    );
    room.0
}

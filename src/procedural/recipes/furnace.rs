//! The scene `furnace`, a white furnace test: a room whose walls emit uniform light and reflect nothing, around one convex
//! body. If the body reflects all light, it has the radiance of the walls and cannot be seen. If it can be seen
//! nevertheless, the BSDF loses or adds energy.

use crate::procedural::modelling::{Builder, Shape};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Layers, Material, Scene};
use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "body",
        doc: "The body: a turned box, or a sphere of flat faces",
        default: "box",
        values: Range::Words(&["box", "sphere"]),
    },
    Parameter {
        name: "roughness",
        doc: "Perceptual roughness of the body",
        default: "0.5",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "metallic",
        doc: "0 dielectric, 1 metal",
        default: "1",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "base_color",
        doc: "Grey level of the body's base colour",
        default: "1",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "specular",
        doc: "Strength of a dielectric's specular lobe",
        default: "1",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "glass",
        doc: "A dielectric that light passes: a thin sheet, or a volume of the index 1.5",
        default: "none",
        values: Range::Words(&["none", "sheet", "volume"]),
    },
];

/// The layers of a body of glass.
fn layers(glass: &str) -> Layers {
    let mut layers = Layers::default();
    layers.transmission.factor = if glass == "none" { 0.0 } else { 1.0 };
    layers.volume.thickness = if glass == "volume" { 1.0 } else { 0.0 };
    layers
}

pub(super) fn make(values: &Values) -> Scene {
    let mut scene = Builder::default();
    // Flat faces: interpolated normals would lose light below the horizon, a loss that is not due to
    // the surface model.
    let shape = match values.text("body") {
        "sphere" => Shape::sphere(3).flat(),
        _ => Shape::block(Vec3::splat(-0.7), Vec3::splat(0.7)),
    };
    let body = Material {
        name: "body".into(),
        base_color: Vec3::splat(values.real("base_color")),
        metallic: values.real("metallic"),
        roughness: values.real("roughness"),
        specular: values.real("specular"),
        layers: layers(values.text("glass")),
        ..Material::default()
    };
    let turn = DQuat::from_euler(EulerRot::YXZ, 0.6, 0.35, 0.1);
    let mesh = scene.mesh(body, shape);
    scene.place("body", mesh, DAffine3::from_quat(turn));
    let room = Material {
        emission: Vec3::ONE,
        ..Material::lambert("room", Vec3::ZERO)
    };
    let walls = Shape::block(Vec3::splat(-10.0), Vec3::splat(10.0));
    scene.add(room, walls.inside_out());
    scene.camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 40.0, 1.0);
    scene.0
}

//! The scene `glass`: a chequered floor and a white wall under a wide lamp, and something of glass. It is a test object for
//! transmission: glass in front of surfaces, in front of the lamp, and around the camera.

use crate::procedural::modelling::{Builder, Model, Shape, emitter};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::layers::{Layers, Transmission, Volume};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "object",
        doc: "A ball of green glass; a thin sheet before the lamp or before the camera; or a block of glass around the camera",
        default: "ball",
        values: Range::Words(&["ball", "lamp", "window", "camera"]),
    },
    Parameter {
        name: "roughness",
        doc: "Roughness of the glass; below 0.01 it is clear",
        default: "0",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "ior",
        doc: "Index of refraction of the glass",
        default: "1.5",
        values: Range::Real(1.0, 3.0),
    },
];

/// The glass: a volume that absorbs red and blue light, or a thin sheet.
fn glass(values: &Values, is_volume: bool) -> Material {
    let volume = Volume {
        thickness: 1.0,
        attenuation_distance: 1.0,
        attenuation_color: Vec3::new(0.4, 0.8, 0.5),
    };
    Material {
        name: "glass".into(),
        metallic: 0.0,
        roughness: values.real("roughness"),
        ior: values.real("ior"),
        layers: Layers {
            transmission: Transmission {
                factor: 1.0,
                texture: None,
            },
            volume: if is_volume { volume } else { Volume::default() },
            ..Layers::default()
        },
        ..Material::default()
    }
}

pub(super) fn make(values: &Values) -> Scene {
    let mut scene = Builder::default();
    let mut floor = Model::default();
    let tiles = [
        Material::lambert("dark tile", Vec3::new(0.6, 0.08, 0.05)),
        Material::lambert("bright tile", Vec3::splat(0.75)),
    ];
    for tile in 0_u8..64 {
        let (x, z) = (f32::from(tile % 8), f32::from(tile / 8));
        let corner = 0.5 * Vec3::new(x - 4.0, 0.0, z - 4.0);
        floor.add(
            &tiles[usize::from((tile % 8 + tile / 8) % 2)],
            Shape::quad(corner, Vec3::Z * 0.5, Vec3::X * 0.5),
        );
    }
    scene.add_model("floor", floor);
    let low = Vec3::new(-2.0, 0.0, -2.0);
    scene.add(
        Material::lambert("wall", Vec3::splat(0.75)),
        Shape::quad(low, Vec3::X * 4.0, Vec3::Y * 3.0),
    );
    scene.add(
        emitter("lamp", Vec3::new(5.0, 4.5, 4.0)),
        Shape::quad(Vec3::new(-1.0, 2.8, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0),
    );
    let (eye, target) = (DVec3::new(0.0, 1.6, 4.4), DVec3::new(0.0, 0.7, 0.0));
    let middle = eye.as_vec3();
    match values.text("object") {
        "lamp" => scene.add(
            glass(values, false),
            Shape::quad(Vec3::new(-1.4, 2.4, -1.4), Vec3::X * 2.8, Vec3::Z * 2.8),
        ),
        "window" => scene.add(
            glass(values, false),
            Shape::quad(Vec3::new(-2.0, 0.2, 2.2), Vec3::X * 4.0, Vec3::Y * 2.0),
        ),
        "camera" => scene.add(
            glass(values, true),
            Shape::block(middle - Vec3::splat(0.2), middle + Vec3::splat(0.2)),
        ),
        _ => {
            let ball = scene.mesh(glass(values, true), Shape::sphere(5));
            let placed = DAffine3::from_scale_rotation_translation(
                DVec3::splat(0.7),
                DQuat::IDENTITY,
                DVec3::new(0.0, 0.75, 0.2),
            );
            scene.place("ball", ball, placed);
        }
    }
    scene.camera(eye, target, 35.0, 1.0);
    scene.0
}

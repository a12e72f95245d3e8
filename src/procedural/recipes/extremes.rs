//! The scene `extremes`: the corner of a room, a floor and a wall with a metal ball. Each parameter can take one quantity to
//! its limit, such as the size of the scene or the radiance of its lamps, to test the range and the precision of the
//! renderer's numbers. The corner is two metres wide, and the floor is at height 0. The large lamps are above the camera's
//! view, and a small lamp is close to the floor.

use crate::procedural::modelling::{Builder, Shape, emitter, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::{Material, Scene};
use glam::{DAffine3, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "size",
        doc: "Units of a metre",
        default: "1",
        values: Range::Real(1e-10, 1e10),
    },
    Parameter {
        name: "away",
        doc: "Metres between the corner and the origin of the world",
        default: "0",
        values: Range::Real(0.0, 1e9),
    },
    Parameter {
        name: "radiance",
        doc: "Radiance of the large lamp, in W/(m²·sr)",
        default: "10",
        values: Range::Real(1e-30, 1e11),
    },
    Parameter {
        name: "contrast",
        doc: "Power of a lamp behind the wall, which lights nothing that the camera sees, over that of the large one; 0 for none",
        default: "0",
        // Up to the largest radiance that a scene may have.
        values: Range::Real(0.0, 6e9),
    },
    Parameter {
        name: "lamps",
        doc: "Number of lamps that the large one is cut into",
        default: "1",
        values: Range::Whole(1, 10_000),
    },
    Parameter {
        name: "height",
        doc: "Height of the small lamp above the floor, in metres; it is as wide as it is high, and as bright as the large one. Below 0.05 the camera looks at its light from the same place, and nothing else shines",
        default: "0.1",
        values: Range::Real(1e-7, 0.3),
    },
    Parameter {
        name: "roughness",
        doc: "Roughness of the ball of metal; below 0.01 a mirror",
        default: "0.3",
        values: Range::Real(0.0, 1.0),
    },
];

/// A limit for the parameter `height`, the height of the small lamp above the floor, in metres. If the small
/// lamp is lower, the scene has no large lamps, and the camera sees only the floor around the small lamp. The
/// picture then shows only light that travels over tiny distances, which is hard to compute precisely.
const LOW: f32 = 0.05;
/// The edge length of the large lamp, a square, in metres. If the parameter `lamps` divides it into several
/// lamps, they are arranged in a square of this edge length.
const SIDE: f32 = 0.4;
/// The height of the large lamps above the floor, in metres. They are above the camera's view there.
const HIGH: f32 = 1.2;

pub(super) fn make(values: &Values) -> Scene {
    let mut corner = Builder::default();
    let white = |name: &str| Material::lambert(name, Vec3::new(0.7, 0.66, 0.6));
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let low = Vec3::new(-1.0, 0.0, -0.5);
    corner.add(white("floor"), Shape::quad(low, z, x));
    corner.add(white("wall"), Shape::quad(low, x, y));
    let behind = low - Vec3::Z * 0.01;
    corner.add(white("back of the wall"), Shape::quad(behind, y, x));
    let ball = corner.mesh(
        metal("ball", Vec3::new(0.9, 0.72, 0.4), values.real("roughness")),
        Shape::sphere(4),
    );
    let transform = |scale: f32, at: Vec3| {
        DAffine3::from_translation(at.as_dvec3()) * DAffine3::from_scale(DVec3::splat(scale.into()))
    };
    corner.place("ball", ball, transform(0.18, Vec3::new(0.3, 0.18, -0.2)));

    let radiance = values.real("radiance");
    let square = Shape::quad(Vec3::new(-0.5, 0.0, -0.5), Vec3::X, Vec3::Z);
    let lamp = corner.mesh(emitter("lamp", Vec3::splat(radiance)), square.clone());
    let height = values.real("height");
    let count = if height < LOW {
        0
    } else {
        values.whole("lamps") as u32
    };
    // In rows, with a part of each cell left dark so that no two of them touch.
    let rows = (count as f32).sqrt().ceil() as u32;
    let side = if count == 1 {
        SIDE
    } else {
        0.9 * SIDE / rows as f32
    };
    for index in 0..count {
        let across = |cell: u32| ((cell as f32 + 0.5) / rows as f32 - 0.5) * SIDE;
        let at = Vec3::new(across(index % rows), HIGH, across(index / rows));
        corner.place("large lamp", lamp, transform(side, at));
    }
    let below = Vec3::new(-0.25, 0.0, 0.1);
    corner.place(
        "small lamp",
        lamp,
        transform(height, below + Vec3::Y * height),
    );
    let contrast = values.real("contrast");
    if contrast > 0.0 {
        let side = 0.1;
        let brighter = radiance * contrast * (SIDE / side).powi(2);
        let hidden = corner.mesh(emitter("hidden lamp", Vec3::splat(brighter)), square);
        corner.place(
            "hidden lamp",
            hidden,
            transform(side, Vec3::new(0.0, 0.5, -0.8)),
        );
    }
    let eye = DVec3::new(0.1, 0.7, 1.6);
    if height < LOW {
        let target = below.as_dvec3();
        // Four heights of the floor to each side.
        let degrees = 2.0
            * (4.0 * f64::from(height) / eye.distance(target))
                .atan()
                .to_degrees();
        corner.camera(eye, target, degrees, 4.0 / 3.0);
    } else {
        corner.camera(eye, DVec3::new(0.0, 0.25, -0.1), 38.0, 4.0 / 3.0);
    }

    // All of it far away, in other units.
    let mut scene = corner.0;
    let metre = f64::from(values.real("size"));
    let away = DVec3::new(0.48, 0.6, 0.64) * f64::from(values.real("away"));
    for instance in &mut scene.instances {
        instance.object_to_world = DAffine3::from_scale(DVec3::splat(metre))
            * DAffine3::from_translation(away)
            * instance.object_to_world;
    }
    for camera in &mut scene.cameras {
        let at = &mut camera.camera_to_world.translation;
        *at = (*at + away) * metre;
    }
    scene
}

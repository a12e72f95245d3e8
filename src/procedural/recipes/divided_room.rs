//! The scene `divided-room`: a room that an opaque partition at x = 0 divides into two halves. It tests how a renderer
//! samples lights of very different brightness. The camera is in the half at +x, which has dim lamps. A far brighter lamp is
//! in the other half, and the camera does not see it.
//!
//! By default (`wall=whole`), the partition reaches from the back wall to the front wall, and the bright lamp lights nothing
//! that the camera sees. With `wall=short`, the partition ends before the front wall. The bright lamp then also lights a
//! part of the camera's half, where the partition casts a shadow.
//!
//! Lengths are in metres, and the floor is at height 0.

use crate::procedural::modelling::stage::{Stage, at, swing};
use crate::procedural::modelling::{Builder, Model, Shape, dielectric};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::scene::Material;
use crate::scene::Scene;
use crate::scene::camera::look_at;
use glam::{DAffine3, DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "contrast",
        // Up to the largest radiance that a scene may have.
        doc: "Power of the bright lamp over that of all dim lamps together",
        default: "10000",
        values: Range::Real(1.0, 4e9),
    },
    Parameter {
        name: "lamps",
        doc: "Number of dim lamps, which have the same power together whatever their number",
        default: "1",
        values: Range::Whole(1, 10_000),
    },
    Parameter {
        name: "wall",
        doc: "A whole wall hides the bright lamp; a short one ends before it meets the front wall",
        default: "whole",
        values: Range::Words(&["whole", "short"]),
    },
    Parameter {
        name: "camera",
        doc: "Speed of the camera's swing around the middle of its half; 0 stands still",
        default: "0",
        values: Range::Real(0.0, 100.0),
    },
];

/// Half the width and half the depth of the room, in metres: the outer walls are at x, z = ±`HALF`.
const HALF: f32 = 2.0;
/// The height of the ceiling above the floor, in metres. The walls and the partition reach up to it.
const HIGH: f32 = 2.4;
/// Half the thickness, in metres, of the partition that divides the room. Its faces are at x = ±`THIN`.
const THIN: f32 = 0.02;
/// The z coordinate, in metres, at which the partition ends with `wall=short`. With `wall=whole`, the partition ends at the
/// front wall, z = `HALF`.
const END: f32 = 0.4;
/// The distance from the ceiling down to the lamps (dim and bright), in metres, so that no lamp lies in the
/// plane of the ceiling.
const BELOW: f32 = 0.02;
/// The total area of the dim lamps, in square metres. Each lamp has an equal part of it, so that their total power does not
/// depend on their number.
const AREA: f32 = 0.36;
/// The radiance of each dim lamp, in W/(m²·sr), equal in red, green and blue. The radiance of the bright lamp is computed
/// from it and from the parameter `contrast`.
const RADIANCE: f32 = 6.0;
/// The edge length of the bright lamp, a square, in metres. It is short, so that the shadows of this lamp have sharp edges.
const BRIGHT_SIDE: f32 = 0.1;

pub(super) fn make(values: &Values) -> Scene {
    let mut room = Builder::default();
    let mut model = Model::default();
    shell(&mut model, values.text("wall") == "whole");
    furnish(&mut model);
    room.add_model("room", model);
    lamps(
        &mut room,
        values.whole("lamps") as u32,
        values.real("contrast"),
    );
    let (eye, target) = (DVec3::new(1.85, 1.6, 1.8), DVec3::new(0.75, 0.7, 0.0));
    room.camera(eye, target, 62.0, 4.0 / 3.0);
    let speed = f64::from(values.real("camera"));
    if speed == 0.0 {
        return room.0;
    }
    let mut stage = Stage::new(room);
    // The eye turns around a point near it, and so does not leave the room.
    let mut pivot = at(1.5, 0.0, 1.4);
    pivot.rotation.track = swing(speed, 8.0, DVec3::Y, 0.2);
    let pivot = stage.moving_node(None, pivot);
    let camera = look_at(
        eye - DVec3::new(1.5, 0.0, 1.4),
        target - DVec3::new(1.5, 0.0, 1.4),
        1.0,
    );
    let node = stage.node(Some(pivot), camera.camera_to_world);
    stage.motion.cameras.push(Some(node));
    stage.scene()
}

/// Adds the floor, the ceiling, the outer walls, and the partition that divides the room. If `whole` is true, the partition
/// reaches the front wall and separates the halves; otherwise it ends at z = `END`.
fn shell(model: &mut Model, whole: bool) {
    let low = Vec3::new(-HALF, 0.0, -HALF);
    let (x, y, z) = (Vec3::X * 2.0 * HALF, Vec3::Y * HIGH, Vec3::Z * 2.0 * HALF);
    let boards = Material::lambert("boards", Vec3::new(0.5, 0.36, 0.24));
    let plaster = Material::lambert("plaster", Vec3::new(0.68, 0.66, 0.62));
    let blue = Material::lambert("blue", Vec3::new(0.3, 0.42, 0.56));
    model.add(&boards, Shape::quad(low, z, x));
    model.add(&plaster, Shape::quad(low + y, x, z));
    model.add(&plaster, Shape::quad(low, x, y));
    model.add(&plaster, Shape::quad(low + z, y, x));
    model.add(&plaster, Shape::quad(low, y, z));
    model.add(&plaster, Shape::quad(low + x, z, y));
    let end = if whole { HALF } else { END };
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let along = Vec3::Z * (end + HALF);
    model.add(&blue, Shape::quad(corner(THIN, -HALF), y, along));
    model.add(&blue, Shape::quad(corner(-THIN, -HALF), along, y));
    if !whole {
        let across = Vec3::X * 2.0 * THIN;
        model.add(&blue, Shape::quad(corner(-THIN, end), across, y));
    }
}

fn furnish(model: &mut Model) {
    let glaze = dielectric("glaze", Vec3::new(0.6, 0.16, 0.1), 0.2);
    let ball = Shape::sphere(3).map(|p| p * 0.28 + Vec3::new(0.75, 0.28, -0.3));
    model.add(&glaze, ball);
    let wood = Material::lambert("box", Vec3::new(0.62, 0.52, 0.36));
    model.add(
        &wood,
        Shape::block(Vec3::new(1.2, 0.0, -1.5), Vec3::new(1.8, 0.9, -0.9)),
    );
}

/// Adds the lamps. `count` dim lamps, at least 1, form a grid under the ceiling of the camera's half, and each is a separate
/// instance. The bright lamp is in the other half. `contrast` is the power of the bright lamp divided by the power of all
/// dim lamps together.
fn lamps(room: &mut Builder, count: u32, contrast: f32) {
    let square = |side: f32| {
        let corner = Vec3::new(-side / 2.0, 0.0, -side / 2.0);
        Shape::quad(corner, Vec3::X * side, Vec3::Z * side)
    };
    let lamp = |name: &str, radiance: f32| Material {
        emission: Vec3::splat(radiance),
        ..Material::lambert(name, Vec3::ZERO)
    };
    let under_the_ceiling =
        |x: f32, z: f32| DAffine3::from_translation(Vec3::new(x, HIGH - BELOW, z).as_dvec3());
    let dim = room.mesh(
        lamp("dim lamp", RADIANCE),
        square((AREA / count as f32).sqrt()),
    );
    let rows = (count as f32).sqrt().ceil() as u32;
    for index in 0..count {
        let coordinate = |cell: u32| (cell as f32 + 0.5) / rows as f32;
        let (x, z) = (coordinate(index % rows), coordinate(index / rows));
        let to_world = under_the_ceiling(THIN + (HALF - THIN) * x, HALF * (2.0 * z - 1.0));
        room.place("dim lamp", dim, to_world);
    }
    let radiance = RADIANCE * contrast * AREA / (BRIGHT_SIDE * BRIGHT_SIDE);
    let bright = room.mesh(lamp("bright lamp", radiance), square(BRIGHT_SIDE));
    room.place("bright lamp", bright, under_the_ceiling(-1.0, -0.6));
}

#[cfg(test)]
mod tests {
    use crate::procedural::generate;

    #[test]
    fn the_bright_lamp_has_the_power_of_all_others_times_the_contrast() {
        for lamps in ["1", "30", "1000"] {
            let settings = [("lamps", lamps), ("contrast", "1e6")];
            let settings = settings.map(|(key, value)| (key.to_owned(), value.to_owned()));
            let scene = generate("divided-room", &settings).unwrap();
            let mut powers = [0.0; 2];
            for instance in &scene.instances {
                let mesh = &scene.meshes[instance.mesh as usize];
                let which = match instance.name.as_str() {
                    "dim lamp" => 0,
                    "bright lamp" => 1,
                    _ => continue,
                };
                for triangle in &mesh.triangles {
                    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
                    let material = mesh.parts[0].material as usize;
                    let radiance = f64::from(scene.materials[material].emission.x);
                    powers[which] += (b - a).cross(c - a).length() / 2.0 * radiance;
                }
            }
            let ratio = powers[1] / powers[0];
            assert!((ratio / 1e6 - 1.0).abs() < 1e-5, "{lamps}: {ratio}");
        }
    }
}

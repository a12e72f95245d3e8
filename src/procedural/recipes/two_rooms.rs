//! The scene `two-rooms`: two furnished rooms with a door in the thin wall between them. The camera is in the front room and
//! the only lamp in the back room, so all light in the front room comes through the door. This tests light that few paths
//! find. Lengths are in metres; the floor is at height 0, the wall is at z = 0, and the front room at +z.

use crate::base::random::Random;
use crate::procedural::modelling::{Builder, Model, Shape, dielectric, emitter, lathe, metal};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::procedural::props::furniture::{self, Piece};
use crate::scene::{Material, Scene};
use glam::{DVec3, Vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "angle",
        doc: "Opening angle of the door in degrees; at 0 it is shut and the front room black",
        default: "60",
        values: Range::Real(0.0, 120.0),
    },
    Parameter {
        name: "seed",
        doc: "Seed of books and pictures",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
];

/// Half the width of both rooms, in metres: the side walls are at x = ±`HALF`.
const HALF: f32 = 2.5;
/// The height of the ceiling of both rooms above the floor, in metres. The lamp of the back room hangs from
/// it.
const HIGH: f32 = 2.6;
/// The z coordinate of the front room's wall opposite the door, in metres. The camera stands close to this
/// wall.
const FRONT: f32 = 5.0;
/// The z coordinate of the back room's wall opposite the door, in metres. The sideboard and a picture are at
/// this wall.
const BACK: f32 = -4.2;
/// The thickness of the wall between the rooms, in metres. The wall reaches from z = 0 to z = −`WALL`.
const WALL: f32 = 0.04;
/// The x coordinates of the left and the right edge of the hole in the thin wall, in metres. The door and its
/// frame stand in the hole.
const HOLE: (f32, f32) = (0.3, 1.26);
/// The height of the upper edge of the hole in the thin wall, in metres. The door and its frame stand in the
/// hole.
const HOLE_TOP: f32 = 2.08;
/// The thickness of the door's frame, in metres. The frame narrows the hole in the wall by this length on the left, on the
/// right and at the top.
const FRAME: f32 = 0.03;

/// Adds the ground under the planks, the ceiling and the outer walls of both rooms: solid boxes that overlap,
/// so that there are no gaps. `front` is the material of the walls in the front room, and `back` is the
/// material of those in the back room.
fn shell(model: &mut Model, front: &Material, back: &Material) {
    let plaster = Material::lambert("ceiling", Vec3::splat(0.75));
    let concrete = Material::lambert("under the floor", Vec3::splat(0.2));
    let (low, high) = (BACK - 0.2, FRONT + 0.2);
    let mut solid = |material: &Material, a: [f32; 3], b: [f32; 3]| {
        model.add(material, Shape::block(Vec3::from(a), Vec3::from(b)));
    };
    solid(
        &concrete,
        [-2.8, -0.3, low - 0.1],
        [2.8, -0.012, high + 0.1],
    );
    solid(
        &plaster,
        [-2.75, HIGH, low - 0.05],
        [2.75, 2.8, high + 0.05],
    );
    for x in [-HALF - 0.1, HALF + 0.1] {
        // The two rooms' side walls meet inside the thin wall.
        solid(front, [x - 0.1, -0.1, -WALL / 2.0], [x + 0.1, 2.7, high]);
        solid(back, [x - 0.1, -0.1, low], [x + 0.1, 2.7, -WALL / 2.0]);
    }
    solid(front, [-2.6, -0.1, FRONT], [2.6, 2.7, high - 0.05]);
    solid(back, [-2.6, -0.1, low + 0.05], [2.6, 2.7, BACK]);
}

/// Adds the thin wall between the rooms, with the hole for the door. The wall has the material `front` on its
/// side in the front room, and the material `back` on its side in the back room. Neighbouring faces of the
/// wall share their corners, so that there are no gaps.
fn thin_wall(model: &mut Model, front: &Material, back: &Material) {
    let xs = [-HALF - 0.1, HOLE.0, HOLE.1, HALF + 0.1];
    let ys = [-0.1, HOLE_TOP, HIGH + 0.1];
    for (i, j) in [(0, 0), (0, 1), (1, 1), (2, 0), (2, 1)] {
        let (u, v) = (Vec3::X * (xs[i + 1] - xs[i]), Vec3::Y * (ys[j + 1] - ys[j]));
        let corner = Vec3::new(xs[i], ys[j], 0.0);
        model.add(front, Shape::quad(corner, u, v));
        model.add(back, Shape::quad(corner - Vec3::Z * WALL, v, u));
    }
    let corner = |x: f32, y: f32| Vec3::new(x, y, -WALL);
    let (deep, up) = (Vec3::Z * WALL, Vec3::Y * (HOLE_TOP - ys[0]));
    model.add(front, Shape::quad(corner(HOLE.0, ys[0]), up, deep));
    model.add(front, Shape::quad(corner(HOLE.1, ys[0]), deep, up));
    let across = Vec3::X * (HOLE.1 - HOLE.0);
    model.add(front, Shape::quad(corner(HOLE.0, HOLE_TOP), across, deep));
}

/// Adds the frame around the door, on the left, on the right and at the top. Narrow bars along the inner edges of the frame,
/// and one on the floor, stop the door when it shuts. They touch the door on all four sides, so that no light leaks through.
fn door_frame(model: &mut Model, paint: &Material) {
    let mut bar = |x: [f32; 2], y: [f32; 2], z: [f32; 2]| {
        let (low, high) = (Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1]));
        model.add(paint, Shape::block(low, high));
    };
    for (x, inwards) in [(HOLE.0, 1.0), (HOLE.1, -1.0)] {
        let span = |a: f32, b: f32| {
            let (a, b) = (x + inwards * a, x + inwards * b);
            [a.min(b), a.max(b)]
        };
        bar(span(-0.01, FRAME), [-0.1, HOLE_TOP + 0.01], [-0.043, 0.02]);
        bar(
            span(FRAME - 0.01, FRAME + 0.015),
            [-0.1, HOLE_TOP - 0.01],
            [-0.005, 0.012],
        );
        bar(span(-0.07, 0.02), [-0.1, HOLE_TOP + 0.071], [-0.02, 0.014]);
        bar(span(-0.07, 0.02), [-0.1, HOLE_TOP + 0.071], [-0.055, -0.02]);
    }
    let top = HOLE_TOP - FRAME;
    let wide = |more: f32| [HOLE.0 - more, HOLE.1 + more];
    bar(wide(0.005), [top, HOLE_TOP + 0.005], [-0.042, 0.019]);
    bar(wide(-0.01), [top - 0.015, top + 0.01], [-0.0045, 0.0115]);
    bar(wide(-0.01), [-0.1, 0.02], [-0.0045, 0.0115]);
    bar(
        wide(0.069),
        [HOLE_TOP - 0.02, HOLE_TOP + 0.07],
        [-0.019, 0.013],
    );
    bar(
        wide(0.069),
        [HOLE_TOP - 0.02, HOLE_TOP + 0.07],
        [-0.054, -0.021],
    );
}

/// Adds the door, opened by the angle `degrees`; 0 is shut, so that no light passes. The door swings into the
/// back room. Its hinge is on its right side, as seen from the front room. `paint` is its material.
fn door(scene: &mut Builder, paint: &Material, degrees: f64) {
    let gap = 0.003;
    let width = HOLE.1 - HOLE.0 - 2.0 * (FRAME + gap);
    let (foot, top) = (0.006, HOLE_TOP - FRAME - gap);
    let mut door = Piece::default();
    // The leaf is deep enough to reach into the stops when it is shut.
    let deep = 0.042;
    door.flat(
        paint,
        Shape::block(Vec3::new(-width, foot, 0.0), Vec3::new(0.0, top, deep)),
    );
    for (low, high) in [(0.16, 0.84), (1.0, 1.9)] {
        for (left, right) in [(-0.78, -0.46), (-0.38, -0.06)] {
            let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
            let panel = Shape::block(corner(left, low, -0.007), corner(right, high, deep + 0.007));
            door.flat(paint, panel);
        }
    }
    let brass = metal("brass", Vec3::new(0.9, 0.68, 0.3), 0.25);
    let knob = [
        (0.012, 0.0),
        (0.012, 0.025),
        (0.029, 0.04),
        (0.026, 0.06),
        (0.0, 0.066),
    ];
    for (z, out) in [(deep, 1.0), (0.0, -1.0)] {
        // Turned around y, then rotated to z; flat, since the rotation does not apply to normals.
        let lying = lathe(
            &[
                &[(0.026, 0.0), (0.024, 0.008)],
                &[(0.024, 0.008), (0.012, 0.008)],
                &knob,
            ],
            24,
        )
        .flat()
        .map(|p| {
            Vec3::new(
                p.x * out - width + 0.055,
                1.02 + p.z,
                z + out * (p.y - 0.001),
            )
        });
        door.flat(&brass, lying.inside_out());
    }
    let hinge = Vec3::new(HOLE.1 - FRAME - gap, 0.0, -0.045);
    door.put(scene, "door", hinge, -degrees);
}

/// Adds the floor of both rooms: planks of random length along z, with narrow grooves between them.
fn floor(model: &mut Model, random: &mut Random) {
    let woods = [[0.34, 0.21, 0.12], [0.29, 0.17, 0.095], [0.38, 0.24, 0.145]]
        .map(|color| dielectric("plank", Vec3::from(color), 0.32));
    let width = 0.125;
    for row in 0..40 {
        let x = -HALF + row as f32 * width;
        let mut z = BACK - random.between(0.0, 1.5);
        while z < FRONT {
            let long = random.between(0.9, 2.2);
            let (low, high) = (z.max(BACK - 0.05), (z + long - 0.002).min(FRONT + 0.05));
            if high > low + 0.01 {
                let plank = Shape::block(
                    Vec3::new(x + 0.001, -0.02, low),
                    Vec3::new(x + width - 0.001, 0.0, high),
                );
                let wood = random.index(3);
                model.add(&woods[wood], plank);
            }
            z += long;
        }
    }
}

/// Adds skirting boards along the foot of the walls of both rooms. There are none in front of the door.
fn skirting(model: &mut Model, paint: &Material) {
    let mut board = |low: [f32; 3], high: [f32; 3]| {
        model.add(paint, Shape::block(Vec3::from(low), Vec3::from(high)));
    };
    let (thick, top) = (0.014, 0.09);
    for (near, far) in [(0.0, FRONT), (BACK, -WALL)] {
        for side in [-1.0_f32, 1.0] {
            let (a, b) = (side * (HALF - thick), side * (HALF + 0.01));
            board([a.min(b), -0.01, near - 0.01], [a.max(b), top, far + 0.01]);
        }
        for (z, inwards) in [(near, thick), (far, -thick)] {
            let (a, b) = (z + inwards, z - inwards.signum() * 0.01);
            let spans = if z.abs() > 1.0 {
                vec![(-HALF, HALF)]
            } else {
                // Not through the door: up to the middle of the frame's boards.
                vec![(-HALF, HOLE.0 - 0.04), (HOLE.1 + 0.04, HALF)]
            };
            for (left, right) in spans {
                board([left, -0.011, a.min(b)], [right, top - 0.001, a.max(b)]);
            }
        }
    }
}

/// Adds the furniture of the front room. It emits no light, and is lit only through the door.
fn furnish_front(scene: &mut Builder, random: &mut Random, walnut: &Material) {
    let cloth = Material::lambert("armchair", Vec3::new(0.12, 0.3, 0.26));
    furniture::armchair(&cloth, walnut).put(scene, "armchair", Vec3::new(1.72, 0.0, 1.75), -62.0);
    furniture::bookcase(walnut, 1.5, 2.05, random).put(
        scene,
        "bookcase",
        Vec3::new(-1.45, 0.0, 0.17),
        0.0,
    );
    let table = Vec3::new(0.2, 0.012, 1.9);
    furniture::round_table(walnut, 0.42, 0.48).put(scene, "low table", table, 0.0);
    let blue = dielectric("blue glaze", Vec3::new(0.05, 0.12, 0.32), 0.15);
    furniture::vase(&blue, 0.3).put(scene, "vase", table + Vec3::new(-0.12, 0.48, -0.08), 0.0);
    for step in 0..3 {
        let mut book = Piece::default();
        let size = Vec3::new(0.24 - 0.02 * step as f32, 0.028, 0.17 - 0.01 * step as f32);
        book.flat(
            &furniture::book(random),
            Shape::chunk(Vec3::Y * 0.0142, size),
        );
        let at = table + Vec3::new(0.14, 0.48 + 0.0285 * step as f32, 0.06);
        book.put(scene, "book", at, 20.0 + 14.0 * f64::from(step));
    }
    let iron = metal("dark iron", Vec3::splat(0.2), 0.4);
    let shade = Material::lambert("shade", Vec3::new(0.65, 0.6, 0.5));
    furniture::dark_lamp(&iron, &shade).put(scene, "dark lamp", Vec3::new(2.1, 0.0, 0.5), 0.0);
    let frame = dielectric("gilt frame", Vec3::new(0.25, 0.16, 0.05), 0.35);
    furniture::picture(&frame, 0.62, 0.8, random).put(
        scene,
        "picture",
        Vec3::new(1.85, 1.55, 0.0),
        0.0,
    );
    let mut rug = Piece::default();
    let rim = Material::lambert("rug's rim", Vec3::new(0.16, 0.04, 0.05));
    let pile = Material::lambert("rug", Vec3::new(0.6, 0.5, 0.38));
    rug.flat(
        &rim,
        Shape::chunk(Vec3::Y * 0.004, Vec3::new(2.5, 0.008, 1.9)),
    );
    rug.flat(
        &pile,
        Shape::chunk(Vec3::Y * 0.0055, Vec3::new(2.2, 0.011, 1.6)),
    );
    rug.put(scene, "rug", Vec3::new(0.35, 0.0005, 2.0), 0.0);
}

/// Adds the furniture of the back room, and the only lamp of the scene, which hangs over the table.
fn furnish_back(scene: &mut Builder, random: &mut Random, walnut: &Material) {
    let oak = dielectric("oak", Vec3::new(0.45, 0.3, 0.16), 0.4);
    let table = Vec3::new(-0.42, 0.0, -2.2);
    furniture::round_table(&oak, 0.55, 0.74).put(scene, "table", table, 0.0);
    furniture::fruit_bowl(random).put(scene, "fruit bowl", table + Vec3::Y * 0.7405, 0.0);
    for (angle, distance) in [(65.0_f64, 0.62_f32), (190.0, 0.75), (-60.0, 0.68)] {
        let (sin, cos) = (
            angle.to_radians().sin() as f32,
            angle.to_radians().cos() as f32,
        );
        let at = table + Vec3::new(sin, 0.0, cos) * distance;
        furniture::chair(&oak).put(scene, "chair", at, angle + 180.0);
    }
    let brass = metal("knob", Vec3::new(0.9, 0.68, 0.3), 0.25);
    let board = Vec3::new(0.35, 0.0, BACK + 0.24);
    furniture::sideboard(walnut, &brass, 1.5).put(scene, "sideboard", board, 0.0);
    let top = board + Vec3::Y * 0.7955;
    let red = dielectric("red glaze", Vec3::new(0.45, 0.06, 0.03), 0.2);
    let white = dielectric("white glaze", Vec3::splat(0.7), 0.25);
    furniture::vase(&red, 0.36).put(scene, "vase", top + Vec3::new(0.38, 0.0, 0.0), 0.0);
    furniture::vase(&white, 0.24).put(scene, "vase", top + Vec3::new(0.1, 0.0, 0.06), 0.0);
    let frame = dielectric("black frame", Vec3::splat(0.03), 0.3);
    furniture::picture(&frame, 1.1, 0.75, random).put(
        scene,
        "picture",
        Vec3::new(0.55, 1.55, BACK),
        0.0,
    );
    let pot = dielectric("pot", Vec3::new(0.5, 0.2, 0.1), 0.6);
    let leaf = dielectric("leaf", Vec3::new(0.08, 0.26, 0.06), 0.45);
    furniture::plant(&pot, &leaf, random).put(scene, "plant", Vec3::new(1.35, 0.0, -3.2), 0.0);

    let hanging = table + Vec3::Y * 1.72;
    let mut pendant = Piece::default();
    let iron = metal("cord", Vec3::splat(0.1), 0.5);
    pendant.flat(
        &iron,
        Shape::cylinder(Vec3::Y * 0.15, 0.006, HIGH - hanging.y - 0.14, 8),
    );
    pendant.smooth(
        &emitter("pendant", Vec3::new(640.0, 500.0, 335.0)),
        Shape::sphere(2).map(|n| n * 0.16),
    );
    pendant.put(scene, "pendant", hanging, 0.0);
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let mut model = Model::default();
    let front = Material::lambert("front room", Vec3::new(0.56, 0.63, 0.64));
    let back = Material::lambert("back room", Vec3::new(0.6, 0.5, 0.35));
    let paint = dielectric("white paint", Vec3::splat(0.7), 0.4);
    shell(&mut model, &front, &back);
    thin_wall(&mut model, &front, &back);
    door_frame(&mut model, &paint);
    floor(&mut model, &mut random);
    skirting(&mut model, &paint);
    scene.add_model("rooms", model);
    door(&mut scene, &paint, f64::from(values.real("angle")));
    let walnut = dielectric("walnut", Vec3::new(0.3, 0.17, 0.09), 0.35);
    furnish_front(&mut scene, &mut random, &walnut);
    furnish_back(&mut scene, &mut random, &walnut);
    scene.camera(
        DVec3::new(0.45, 1.5, 4.8),
        DVec3::new(0.72, 1.02, 0.0),
        48.0,
        16.0 / 9.0,
    );
    scene.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::generate;

    /// The number of lines, out of 4,000 random straight lines from the front room, that the wall, the frame
    /// and the door do not block. It must be 0 if the door is shut, because light would leak along an
    /// unblocked line. `angle` is the opening angle of the door in degrees, as text. Half of the lines end in
    /// the back room, and the other half pass near an edge of the door.
    fn open_lines(angle: &str) -> usize {
        let settings = [("angle".to_owned(), angle.to_owned())];
        let scene = generate("two-rooms", &settings).unwrap();
        let triangles: Vec<[DVec3; 3]> = scene
            .instances
            .iter()
            .flat_map(|instance| {
                let mesh = &scene.meshes[instance.mesh as usize];
                mesh.triangles.iter().map(|t| {
                    t.map(|i| {
                        let corner = mesh.positions[i as usize].as_dvec3();
                        instance.object_to_world.transform_point3(corner)
                    })
                })
            })
            // Without furniture, which could hide leaks: only hits near the wall count.
            .filter(|t| t.iter().any(|p| p.z.abs() < 0.1))
            .collect();
        let mut random = Random::new(7);
        let mut line = |index: u32| {
            let mut at = |x: (f32, f32), y: (f32, f32), z: (f32, f32)| {
                let mut within = |(low, high)| random.between(low, high);
                Vec3::new(within(x), within(y), within(z)).as_dvec3()
            };
            let from = at((-2.4, 2.4), (0.1, 2.5), (0.3, 4.9));
            if index.is_multiple_of(2) {
                return (from, at((-2.4, 2.4), (0.1, 2.5), (BACK, -0.3)) - from);
            }
            let (x, z) = ((HOLE.0, HOLE.1), (-0.045, 0.0));
            let edge = match index % 8 {
                1 => at((x.0 + 0.02, x.0 + 0.04), (0.0, HOLE_TOP), z),
                3 => at((x.1 - 0.04, x.1 - 0.02), (0.0, HOLE_TOP), z),
                5 => at(x, (0.0, 0.01), z),
                _ => at(x, (HOLE_TOP - 0.04, HOLE_TOP - 0.02), z),
            };
            (from, (edge - from) * 1.3)
        };
        let meets = |from: DVec3, way: DVec3, [a, b, c]: [DVec3; 3]| {
            let (u, v, s) = (b - a, c - a, from - a);
            let (p, q) = (way.cross(v), s.cross(u));
            let scale = 1.0 / u.dot(p);
            let (x, y, t) = (s.dot(p) * scale, way.dot(q) * scale, v.dot(q) * scale);
            x >= 0.0 && y >= 0.0 && x + y <= 1.0 && (0.0..=1.0).contains(&t)
        };
        (0..4000)
            .map(&mut line)
            .filter(|&(from, way)| !triangles.iter().any(|&t| meets(from, way, t)))
            .count()
    }

    #[test]
    fn a_shut_door_lets_no_light_through_and_an_open_one_does() {
        assert_eq!(open_lines("0"), 0);
        assert!(open_lines("60") > 20);
    }
}

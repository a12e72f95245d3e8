//! The scene `atrium`: a court between two storeys of arcades. It is lit by three small lamps, which columns mostly hide
//! from the camera. Lengths are in metres, and the court is long along Z.

use crate::base::random::Random;
use crate::procedural::modelling::{
    Builder, Model, Profile, SINK, Shape, dielectric, emitter, metal,
};
use crate::procedural::parameters::{Parameter, Range, Values};
use crate::procedural::props::colonnade::{self, BAY, RAIL, SPRING, STOREY, THICK};
use crate::procedural::props::statue;
use crate::scene::{Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Mat3, Vec2, Vec3, vec2, vec3};

pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "seed",
        doc: "Seed of the bust and the tiles",
        default: "1",
        values: Range::Whole(0, u32::MAX as u64),
    },
    Parameter {
        name: "bays",
        doc: "Arches along each long side of the court",
        default: "5",
        values: Range::Whole(3, 51),
    },
    Parameter {
        name: "sides",
        doc: "Sides of a column, and twice those of a baluster",
        default: "48",
        values: Range::Whole(8, 512),
    },
    Parameter {
        name: "roughness",
        doc: "Roughness of the gilded bust",
        default: "0.2",
        values: Range::Real(0.0, 1.0),
    },
    Parameter {
        name: "lights",
        doc: "Number of lamps",
        default: "3",
        values: Range::Whole(0, 3),
    },
];

/// The number of arches along each short side of the court. The parameter `bays` is this number for the long
/// sides.
const ACROSS: u32 = 3;
/// The depth of a gallery (the passage behind an arcade): the distance from the middle plane of the arcade to
/// the outer wall, in metres.
const GALLERY: f32 = 2.7;
/// The height of the ceiling of a gallery (the passage behind an arcade) above its floor, in metres. Beams
/// and lamps hang from it.
const CEILING: f32 = 4.6;
/// The height of the court's ceiling above the lower floor, in metres: two storeys, and 0.75 m for the
/// cornice above them.
const TOP: f32 = 2.0 * STOREY + 0.75;

/// One side of the court, and the number `bays` of its arches. The parts of an arcade are made at the origin with their
/// front towards +Z. They are rotated by `turn` degrees around +Y, and then moved by `middle` in metres, the middle of the
/// side on the lower floor. They then stand on this side and face the middle of the court.
struct Side {
    turn: f32,
    middle: Vec3,
    bays: u32,
}

impl Side {
    fn all(half: Vec2, bays: u32) -> [Self; 4] {
        let side = |turn: f32, x: f32, z: f32, bays: u32| Self {
            turn,
            middle: vec3(x, 0.0, z),
            bays,
        };
        [
            side(0.0, 0.0, -half.y, ACROSS),
            side(180.0, 0.0, half.y, ACROSS),
            side(90.0, -half.x, 0.0, bays),
            side(-90.0, half.x, 0.0, bays),
        ]
    }

    fn moved(&self, p: Vec3) -> Vec3 {
        Mat3::from_rotation_y(self.turn.to_radians()) * p + self.middle
    }

    fn place(&self, scene: &mut Builder, name: &str, mesh: u32, to: Vec3) {
        let turn = DQuat::from_rotation_y(f64::from(self.turn).to_radians());
        let to = self.moved(to).as_dvec3();
        scene.place(name, mesh, DAffine3::from_rotation_translation(turn, to));
    }

    /// The centres of the side's bays (sections with one arch each): coordinates in metres along the side, from the side's
    /// middle.
    fn bays(&self) -> impl Iterator<Item = f32> + use<> {
        let bays = self.bays;
        (0..bays).map(move |i| (i as f32 - (bays - 1) as f32 / 2.0) * BAY)
    }

    /// The positions of the side's columns: coordinates in metres along the side, from the side's middle. The corners of the
    /// court are left out, because piers stand there.
    fn columns(&self) -> impl Iterator<Item = f32> + use<> {
        self.bays().skip(1).map(|x| x - BAY / 2.0)
    }
}

/// A horizontal ring between an inner and an outer rectangle around the y axis: a floor or a ceiling of the
/// galleries. `inner` and `outer` have half the lengths of the sides of these rectangles along X and Z, and
/// `y` is the height of the ring, all in metres. The ring faces up if `up` is true, and down if it is false.
fn ring(inner: Vec2, outer: Vec2, y: f32, up: bool) -> Shape {
    let corners = |half: Vec2| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(x, z)| vec3(x * half.x, y, z * half.y))
    };
    let (inner, outer) = (corners(inner), corners(outer));
    let mut ring = Shape::default();
    for i in 0..4 {
        let j = (i + 1) % 4;
        for [a, b, c] in [
            [outer[i], outer[j], inner[j]],
            [outer[i], inner[j], inner[i]],
        ] {
            ring.add(Shape::triangle(if up { [a, b, c] } else { [a, c, b] }));
        }
    }
    ring
}

/// Adds a floor of pale, dark and red marble tiles at the height 0, with gaps between the tiles. `half.x` and `half.y` are
/// half the lengths of the floor along X and Z, in metres; its centre is at the origin.
fn floor(model: &mut Model, random: &mut Random, half: Vec2) {
    let ground = Material::lambert("joints", Vec3::splat(0.06));
    let (corner, size) = (vec3(-half.x, -0.012, -half.y), half * 2.0);
    model.add(
        &ground,
        Shape::quad(corner, Vec3::Z * size.y, Vec3::X * size.x),
    );
    let marble = |name: &str, color: Vec3| dielectric(name, color, 0.18);
    let pale = marble("pale marble", vec3(0.62, 0.58, 0.5));
    let dark = marble("dark marble", vec3(0.07, 0.08, 0.085));
    let red = marble("red marble", vec3(0.32, 0.09, 0.06));
    let step = BAY / 5.0;
    let count = (half / step).ceil().as_ivec2();
    for i in -count.x..count.x {
        for j in -count.y..count.y {
            let low = vec2(i as f32, j as f32) * step;
            let high = (low + step).min(half) - 0.004;
            let low = low.max(-half) + 0.004;
            if (high - low).min_element() < 0.05 {
                continue;
            }
            let stone = match (i + j).rem_euclid(2) {
                0 => &pale,
                _ if random.unit() < 0.12 => &red,
                _ => &dark,
            };
            // Without its underside, which is never visible.
            let edge = Profile::new((high.x - low.x) / 2.0, -0.012)
                .line(0.0, 0.009)
                .line(-0.003, 0.003);
            let middle = (low + high) / 2.0;
            let by = vec2(0.0, (high.y - low.y - high.x + low.x) / 2.0);
            let to = vec3(middle.x, 0.0, middle.y);
            model.add(stone, edge.framed(by).flat().map(|p| p + to));
            let low = vec3(low.x + 0.003, 0.0, low.y + 0.003);
            let size = vec3(high.x - 0.003, 0.0, high.y - 0.003) - low;
            model.add(stone, Shape::quad(low, Vec3::Z * size.z, Vec3::X * size.x));
        }
    }
}

/// Adds the parts of the building around the court: the outer walls, the ceilings, the upper floor, the cornices and the
/// beams. `half.x` and `half.y` are half the lengths of the court along X and Z in metres, measured to the middle planes of
/// the arcades. `sides` are the four sides of the court. In both storeys, a beam goes from each column of a side to the
/// outer wall.
fn shell(model: &mut Model, half: Vec2, sides: &[Side; 4]) {
    let outer = half + GALLERY;
    let fresco = Material::lambert("gallery wall", vec3(0.5, 0.3, 0.17));
    let plaster = Material::lambert("plaster", vec3(0.66, 0.6, 0.5));
    let stone = dielectric("dressed stone", vec3(0.6, 0.54, 0.44), 0.5);
    let timber = dielectric("timber", vec3(0.14, 0.08, 0.045), 0.45);
    let walls = Profile::new(0.0, TOP).line(0.0, -TOP - 0.02);
    model.add(&fresco, walls.framed(outer));
    for storey in 0..2_u8 {
        let y = f32::from(storey) * STOREY;
        model.add(&plaster, ring(half, outer, y + CEILING, false));
        let skirting = Profile::new(0.0, y + 0.26)
            .line(-0.02, 0.0)
            .arc(-0.03, -0.04, 60.0, 4)
            .line(0.0, -0.25);
        model.add(&stone, skirting.framed(outer));
        for side in sides {
            for x in side.columns() {
                let beam = vec3(0.16, 0.2, GALLERY - THICK / 2.0 + 0.02);
                let middle = vec3(x, y + CEILING - 0.09, -(GALLERY + THICK / 2.0) / 2.0);
                model.add(&timber, Shape::chunk(middle, beam).map(|p| side.moved(p)));
            }
        }
    }
    let upper = dielectric("upper floor", vec3(0.35, 0.2, 0.13), 0.4);
    let court = half - THICK / 2.0;
    model.add(&upper, ring(court, outer, STOREY, true));
    // A course between the storeys, and the cornice under the court's ceiling.
    let course = Profile::new(0.06, STOREY - 0.02)
        .line(0.0, 0.07)
        .line(-0.16, 0.0)
        .line(0.0, -0.06)
        .arc(-0.0, -0.05, 180.0, 5)
        .line(0.03, 0.0)
        .arc(0.05, -0.06, -80.0, 5)
        .line(0.0, -0.08)
        .line(0.02, 0.0)
        .line(0.0, -0.1)
        .line(0.03, 0.0);
    model.add(&stone, course.framed(court));
    let cornice = Profile::new(0.0, TOP)
        .line(0.0, -0.22)
        .line(-0.34, 0.0)
        .line(0.0, -0.07)
        .arc(0.12, -0.13, 80.0, 6)
        .line(0.02, 0.0)
        .line(0.0, -0.06)
        .arc(0.12, -0.12, -80.0, 6)
        .line(0.02, 0.0)
        .line(0.0, -0.16)
        .line(0.08, 0.0);
    model.add(&stone, cornice.framed(court));
    let corner = vec3(-half.x, TOP, -half.y);
    model.add(
        &plaster,
        Shape::quad(corner, Vec3::X * 2.0 * half.x, Vec3::Z * 2.0 * half.y),
    );
    for side in &sides[2..3] {
        for x in side.columns() {
            let middle = vec3(0.0, TOP - 0.1, side.moved(Vec3::X * x).z);
            let beam = vec3(2.0 * court.x + 0.02, 0.22, 0.24);
            model.add(&timber, Shape::chunk(middle, beam));
        }
    }
    for x in [-BAY / 2.0, BAY / 2.0] {
        let middle = vec3(x, TOP - 0.09, 0.0);
        let beam = vec3(0.2, 0.19, 2.0 * court.y + 0.02);
        model.add(&timber, Shape::chunk(middle, beam));
    }
}

/// Adds the columns, piers, arches and balustrades of both storeys. `half.x` and `half.y` are half the lengths of the court
/// along X and Z in metres, measured to the middle planes of the arcades. `sides` are the four sides of the court. A column
/// has `detail` sides, and a baluster has half as many.
fn arcades(scene: &mut Builder, half: Vec2, sides: &[Side; 4], detail: u32) {
    let marble = dielectric("column", vec3(0.68, 0.65, 0.6), 0.3);
    let stone = dielectric("arcade", vec3(0.66, 0.59, 0.48), 0.5);
    let lower = scene.mesh(
        marble.clone(),
        colonnade::column(SPRING + 0.01, 0.2, detail),
    );
    let short = SPRING - RAIL + 0.01;
    let upper = scene.mesh(marble, colonnade::column(short, 0.16, detail));
    let pedestal = scene.mesh(stone.clone(), colonnade::pedestal());
    let arch = scene.mesh(stone.clone(), colonnade::arch());
    let blind = scene.mesh(stone.clone(), colonnade::blind_arch());
    let balustrade = scene.mesh(stone.clone(), colonnade::balustrade(detail / 2));
    let pier = scene.mesh(stone, colonnade::pier());
    for storey in 0..2_u8 {
        let floor = Vec3::Y * (f32::from(storey) * STOREY);
        for side in sides {
            for x in side.bays() {
                side.place(scene, "arch", arch, Vec3::X * x + floor);
                let wall = vec3(x, floor.y - SINK, -GALLERY);
                side.place(scene, "blind arch", blind, wall);
                if storey == 1 {
                    let low = Vec3::X * x + floor - Vec3::Y * SINK;
                    side.place(scene, "balustrade", balustrade, low);
                }
            }
            for x in side.columns() {
                let foot = Vec3::X * x + floor - Vec3::Y * SINK;
                if storey == 0 {
                    side.place(scene, "column", lower, foot);
                } else {
                    side.place(scene, "pedestal", pedestal, foot);
                    side.place(scene, "column", upper, foot + Vec3::Y * RAIL);
                }
            }
        }
        for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)] {
            let corner = vec3(x * half.x, floor.y - SINK, z * half.y).as_dvec3();
            scene.place("pier", pier, DAffine3::from_translation(corner));
        }
    }
}

/// Adds a lamp that emits the radiance `light` (linear RGB, in W/(m²·sr)). Its centre is at the height `y[0]`, and it hangs
/// from a ceiling at the height `y[1]`, in metres. Seen from above, it is on the line from `eye` through `behind`, `beyond`
/// times as far from `eye` as `behind` is; both are positions in metres. An object that the caller adds at `behind` hides
/// the lamp from `eye`.
fn lantern(model: &mut Model, eye: Vec3, behind: Vec3, beyond: f32, y: [f32; 2], light: Vec3) {
    let [y, ceiling] = y;
    let to = (eye + (behind - eye) * beyond).with_y(y);
    let radius = 0.1;
    model.add(
        &emitter("lamp", light),
        Shape::sphere(2).flat().map(|p| p * radius + to),
    );
    let brass = metal("brass", vec3(0.75, 0.58, 0.3), 0.35);
    let cap = Profile::new(0.07, radius * 0.85)
        .line(0.0, 0.02)
        .arc(-0.06, 0.05, 60.0, 5)
        .line(0.0, ceiling - y - 0.1);
    model.add(&brass, cap.turned(20).map(|p| p + to));
}

/// The base of the bust: two round steps and a drum, 1.41 m high in total, as one shape. Its foot is at the
/// origin, and its largest radius is 1.25 m.
fn drum() -> Shape {
    Profile::new(0.0, 0.0)
        .line(1.25, 0.0)
        .line(0.0, 0.13)
        .arc(-0.03, 0.03, 90.0, 4)
        .line(-0.27, 0.0)
        .line(0.0, 0.13)
        .arc(-0.03, 0.03, 90.0, 4)
        .line(-0.37, 0.0)
        .line(0.0, 0.12)
        .arc(0.0, 0.1, 180.0, 8)
        .line(-0.03, 0.0)
        .arc(-0.08, 0.09, -100.0, 6)
        .line(0.0, 0.55)
        .line(0.02, 0.0)
        .arc(0.09, 0.12, 75.0, 8)
        .line(0.02, 0.0)
        .line(0.0, 0.11)
        .capped()
        .turned(72)
}

pub(super) fn make(values: &Values) -> Scene {
    let mut random = Random::new(values.whole("seed"));
    let mut scene = Builder::default();
    let mut model = Model::default();
    let bays = values.whole("bays") as u32;
    let half = vec2(ACROSS as f32, bays as f32) * BAY / 2.0;
    let sides = Side::all(half, bays);
    floor(&mut model, &mut random, half + GALLERY);
    shell(&mut model, half, &sides);
    let eye = vec3(1.0, 1.65, half.y - 0.55);
    let near = |z: f32| {
        let columns = sides[2].columns();
        let nearest = columns.min_by(|a, b| (a - z).abs().total_cmp(&(b - z).abs()));
        nearest.unwrap_or(0.0)
    };
    let west = vec3(-half.x, 0.0, near(0.2 * half.y));
    let east = vec3(half.x, 0.0, near(-0.2 * half.y));
    let north = vec3(BAY / 2.0, 0.0, -half.y);
    let ground = [2.6, CEILING];
    let above = [STOREY + 3.6, STOREY + CEILING];
    let lamps = [
        (west, 1.27, ground, vec3(1900.0, 1250.0, 640.0)),
        (east, 1.42, above, vec3(2000.0, 1550.0, 1050.0)),
        (north, 1.11, ground, vec3(560.0, 860.0, 1200.0)),
    ];
    for (behind, beyond, y, light) in lamps.into_iter().take(values.whole("lights") as usize) {
        lantern(&mut model, eye, behind, beyond, y, light);
    }
    scene.add_model("hall", model);
    arcades(&mut scene, half, &sides, values.whole("sides") as u32);

    let drum = scene.mesh(dielectric("drum", vec3(0.1, 0.11, 0.1), 0.2), drum());
    let foot = DVec3::new(0.0, f64::from(-SINK), 0.0);
    scene.place("drum", drum, DAffine3::from_translation(foot));
    let gold = metal("gold", vec3(1.0, 0.77, 0.37), values.real("roughness"));
    let bust = statue::bust(&mut random).map(|p| p * 2.0);
    let bust = scene.mesh(gold, bust);
    let top = DVec3::new(0.0, 1.43 - 2.0 * f64::from(SINK), 0.0);
    scene.place("bust", bust, DAffine3::from_translation(top));
    scene.camera(
        eye.as_dvec3(),
        DVec3::new(-0.25, 3.15, f64::from(-half.y)),
        62.0,
        16.0 / 9.0,
    );
    scene.0
}

#[cfg(test)]
mod tests {
    use crate::procedural::generate;

    #[test]
    fn it_has_many_triangles_and_three_small_lamps() {
        let scene = generate("atrium", &[]).unwrap();
        let placed = scene.instances.iter();
        let count = |i: &crate::scene::Instance| scene.meshes[i.mesh as usize].triangles.len();
        assert!(placed.map(count).sum::<usize>() >= 250_000);
        assert_eq!(scene.emissive_triangle_count(), 3 * 320);
    }
}

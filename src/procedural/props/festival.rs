//! Decoration for the scene `street`: strings of paper lanterns, market stalls with bulbs, and pennants. Each
//! emissive triangle is subtracted from a number that is left, so that the street has exactly as many lights
//! as the user asks for.

use crate::base::random::Random;
use crate::procedural::modelling::{Model, Shape, dielectric, emitter, lathe};
use crate::scene::Material;
use glam::Vec3;

/// A place at one side of a street, where a house or a stall is put. Its own coordinates have their origin at its foot; x
/// points from the houses to the middle of the street, and y points up. If `mirrored` is false, the place is on the left
/// side of the street, and `foot` is its foot in metres. If `mirrored` is true, this place is mirrored at the plane x = 0,
/// to the right side.
#[derive(Clone, Copy)]
pub struct Spot {
    pub foot: Vec3,
    pub mirrored: bool,
}

impl Spot {
    /// Moves a shape from the spot's coordinates to its place in the street, and mirrors it if the spot is at the right
    /// side.
    pub fn put(self, shape: Shape) -> Shape {
        let moved = shape.map(|p| p + self.foot);
        if self.mirrored {
            moved.map(|p| p * Vec3::new(-1.0, 1.0, 1.0)).inside_out()
        } else {
            moved
        }
    }
}

/// The model of a decorated street that is still being built, and the number of emissive triangles that may still be added
/// to it. At the end this number is 0, so that the street has exactly the number of lights that the user asks for.
pub struct Festival {
    pub model: Model,
    left: u64,
}

/// The number of emissive triangles that lanterns and bulbs leave for the pennants. A pennant is a single triangle, so that
/// the pennants can use exactly the number that is left at the end. Then the street has as many lights as the user asks for.
const RESERVE: u64 = 60;

impl Festival {
    pub fn new(lights: u64) -> Self {
        let model = Model::default();
        Self {
            model,
            left: lights,
        }
    }

    /// True if enough emissive triangles are left for another lantern, besides those that are reserved for the pennants.
    /// While this is true, the caller makes the street longer, with further houses, stalls and lanterns.
    pub fn has_light(&self) -> bool {
        self.left >= RESERVE + paper(0.17).triangle_count() as u64
    }

    /// Adds a shape that emits `radiance` (linear RGB, in W/(m²·sr)). Its positions are in the street, in metres. Its
    /// triangles are subtracted from the number of emissive triangles that may still be added. If too few would then be left
    /// for the pennants, nothing is subtracted, and the shape gets a dark material instead.
    pub fn light(&mut self, name: &str, radiance: Vec3, shape: Shape) {
        let triangles = shape.triangle_count() as u64;
        if self.left >= RESERVE + triangles {
            self.left -= triangles;
            self.model.add(&emitter(name, radiance), shape);
        } else {
            let unlit = dielectric("unlit", Vec3::splat(0.05), 0.2);
            self.model.add(&unlit, shape);
        }
    }

    /// Adds a cord that hangs from `a` to `b`, positions in the street in metres, with eight lanterns of random sizes and
    /// colours on it. Lanterns for which too few emissive triangles are left stay dark ([`Self::light`]).
    pub fn lanterns(&mut self, random: &mut Random, a: Vec3, b: Vec3) {
        let sag = random.between(0.5, 1.0);
        let hang = |t: f32| a.lerp(b, t) - Vec3::Y * sag * 4.0 * t * (1.0 - t);
        let cord = Material::lambert("cord", Vec3::splat(0.03));
        let caps = dielectric("lantern caps", Vec3::splat(0.04), 0.4);
        let count = 8;
        for step in 0..2 * count {
            let at = |k: u32| hang(k as f32 / (2 * count) as f32);
            self.model.add(&cord, rod(at(step), at(step + 1), 0.008));
        }
        for index in 0..count {
            let t = (index as f32 + 0.5 + random.between(-0.15, 0.15)) / count as f32;
            let radius = random.between(0.13, 0.21);
            let middle = hang(t) - Vec3::Y * (1.15 * radius + 0.1);
            let color = random.pick(&[
                [2.6, 0.09, 0.02],
                [2.6, 0.09, 0.02],
                [2.6, 0.6, 0.03],
                [11.0, 7.0, 3.1],
                [11.0, 7.0, 3.1],
                [1.7, 0.08, 0.55],
                [0.05, 0.6, 1.5],
                [0.2, 1.4, 0.1],
            ]);
            self.light(
                "lantern",
                Vec3::from(color),
                paper(radius).map(|p| p + middle),
            );
            for y in [-1.0, 1.0] {
                let foot = middle + Vec3::Y * (y * 1.1 * radius - 0.02);
                self.model
                    .add(&caps, Shape::cylinder(foot, 0.62 * radius, 0.04, 8));
            }
            let tassel = middle - Vec3::Y * (1.1 * radius + 0.12);
            self.model
                .add(&caps, Shape::chunk(tassel, Vec3::new(0.02, 0.22, 0.02)));
            let hook = hang(t);
            self.model
                .add(&cord, rod(middle + Vec3::Y * 1.1 * radius, hook, 0.004));
        }
    }

    /// Adds a market stall with goods and bulbs at `spot`. It is long along z, and open towards +x, where the middle of the
    /// street is.
    pub fn stall(&mut self, random: &mut Random, spot: Spot) {
        let wood = dielectric("stall wood", Vec3::new(0.24, 0.14, 0.07), 0.5);
        let half = 1.25;
        let mut solid = |a: [f32; 3], b: [f32; 3]| {
            let shape = Shape::block(Vec3::from(a), Vec3::from(b));
            self.model.add(&wood, spot.put(shape));
        };
        solid([-0.05, -0.1, -half], [0.5, 0.86, half]);
        solid([-0.1, 0.86, -half - 0.06], [0.58, 0.9, half + 0.06]);
        for (x, top) in [(-0.65, 2.66), (0.53, 2.26)] {
            for z in [-half - 0.1, half + 0.1] {
                solid([x - 0.035, -0.1, z - 0.035], [x + 0.035, top, z + 0.035]);
            }
        }
        self.awning(random, half, spot);
        self.goods(random, half, spot);
        for index in 0..11 {
            let z = (index as f32 / 10.0 - 0.5) * 2.0 * half;
            let at = Vec3::new(0.72, 2.03 - 0.05 * (index as f32 * 1.3).sin(), z);
            let bulb = Shape::sphere(0).flat().map(|p| p * 0.045 + at);
            self.light("bulb", Vec3::new(105.0, 64.0, 26.0), spot.put(bulb));
        }
    }

    /// Adds the striped cloth that is the roof of the stall at `spot`; `half` is half the length of the stall in metres.
    fn awning(&mut self, random: &mut Random, half: f32, spot: Spot) {
        let color = random.pick(&[
            [0.5, 0.04, 0.04],
            [0.04, 0.22, 0.3],
            [0.1, 0.3, 0.08],
            [0.5, 0.24, 0.03],
            [0.3, 0.06, 0.25],
        ]);
        let cloths = [
            Material::lambert("cloth", Vec3::from(color)),
            Material::lambert("white cloth", Vec3::splat(0.65)),
        ];
        let stripes = 9;
        let (start, wide) = (-half - 0.2, (2.0 * half + 0.4) / stripes as f32);
        for stripe in 0..stripes {
            let (near, far) = (
                start + stripe as f32 * wide,
                start + (stripe + 1) as f32 * wide,
            );
            let edge = |x: f32, y: f32| [Vec3::new(x, y, near), Vec3::new(x, y, far)];
            let ([a, b], [c, d], [e, f]) = (edge(-0.75, 2.72), edge(0.8, 2.2), edge(0.8, 2.08));
            // The flap that hangs down in front ends in a point.
            let tip = (e + f) / 2.0 - Vec3::Y * 0.1;
            let corners = [a, b, d, a, d, c, c, d, f, c, f, e, e, f, tip];
            let cloth = Shape::triangles(&corners);
            self.model.add(&cloths[stripe % 2], spot.put(cloth));
        }
    }

    /// Adds the goods on the counter of the stall at `spot`: crates of fruit, and jars. `half` is half the length of the
    /// stall in metres.
    fn goods(&mut self, random: &mut Random, half: f32, spot: Spot) {
        let crate_wood = dielectric("crate", Vec3::new(0.4, 0.28, 0.14), 0.6);
        let mut z = -half + 0.25;
        while z < half - 0.2 {
            let at = Vec3::new(0.24, 0.9, z);
            let color = Vec3::from(random.pick(&[
                [0.6, 0.06, 0.03],
                [0.65, 0.3, 0.02],
                [0.2, 0.4, 0.04],
                [0.55, 0.45, 0.06],
                [0.25, 0.05, 0.2],
            ]));
            if random.unit() < 0.6 {
                let tray = Shape::chunk(at + Vec3::Y * 0.0505, Vec3::new(0.5, 0.1, 0.4));
                self.model.add(&crate_wood, spot.put(tray));
                let skin = dielectric("fruit", color, 0.35);
                for (i, j) in (0..5).flat_map(|i| (0..4).map(move |j| (i, j))) {
                    let offset = Vec3::new(i as f32 * 0.095 - 0.19, 0.11, j as f32 * 0.095 - 0.14);
                    let middle = at + offset + Vec3::Y * random.between(0.0, 0.03);
                    let fruit = Shape::sphere(1).flat().map(|p| p * 0.047 + middle);
                    self.model.add(&skin, spot.put(fruit));
                }
            } else {
                let glass = dielectric("jar", color * 0.8, 0.08);
                for index in 0..5 {
                    let x = 0.18 * (index % 2) as f32 - 0.1;
                    let foot = at + Vec3::new(x, 0.0005, 0.09 * index as f32 - 0.18);
                    let tall = random.between(0.12, 0.26);
                    self.model
                        .add(&glass, spot.put(Shape::cylinder(foot, 0.045, tall, 10)));
                }
            }
            z += 0.48;
        }
    }

    /// Adds pennants, glowing triangles that face +z, until no emissive triangle is left. They hang on cords, up to 32 on
    /// each. The first cord goes from `a` to `b`, positions in the street in metres. Each further cord is 0.35 m above the
    /// previous one and 3.1 m behind it, towards −z.
    pub fn pennants(&mut self, random: &mut Random, a: Vec3, b: Vec3) {
        let cord = Material::lambert("cord", Vec3::splat(0.03));
        let a_row = 32;
        let mut row = 0.0;
        while self.left > 0 {
            let back = Vec3::new(0.0, 0.35 * row, -3.1 * row);
            let hang = |t: f32| a.lerp(b, t) + back - Vec3::Y * 2.4 * t * (1.0 - t);
            let count = self.left.min(a_row);
            for index in 0..a_row {
                let (from, to) = (
                    index as f32 / a_row as f32,
                    (index + 1) as f32 / a_row as f32,
                );
                self.model.add(&cord, rod(hang(from), hang(to), 0.006));
                if index < count {
                    let (left, right) = (hang(from + 0.006), hang(to - 0.006));
                    let tip = (left + right) / 2.0 - Vec3::Y * 0.27;
                    let color = random.pick(&[
                        [1.6, 0.25, 0.1],
                        [1.5, 0.9, 0.2],
                        [0.2, 0.9, 1.1],
                        [1.2, 1.1, 0.9],
                    ]);
                    let cloth = emitter("pennant", Vec3::from(color));
                    self.model
                        .add(&cloth, Shape::triangles(&[left, tip, right]));
                }
            }
            self.left -= count;
            row += 1.0;
        }
    }
}

/// The paper of a lantern: a barrel around the origin, open above and below, which emits light in the scene.
/// `radius` is its largest radius in metres, and its height is 2.2 times as much.
fn paper(radius: f32) -> Shape {
    let r = radius;
    let side = [
        (0.6, -1.1),
        (0.93, -0.6),
        (1.0, 0.0),
        (0.93, 0.6),
        (0.6, 1.1),
    ]
    .map(|(x, y)| (x * r, y * r));
    let bands: Vec<&[(f32, f32)]> = side.windows(2).collect();
    lathe(&bands, 8).flat()
}

/// A straight bar with a square cross-section from one point to another, for cords. `half` is half its
/// thickness. Lengths are in metres.
fn rod(from: Vec3, to: Vec3, half: f32) -> Shape {
    let along = to - from;
    let side = along.normalize().any_orthonormal_vector();
    let other = along.normalize().cross(side);
    Shape::block(Vec3::new(-half, -half, 0.0), Vec3::new(half, half, 1.0))
        .map(|p| from + side * p.x + other * p.y + along * p.z)
}

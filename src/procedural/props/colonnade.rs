//! The parts of an arcade, for the scene `atrium`: columns, piers, arches with the wall above them, and
//! balustrades. Each part is at the origin, with its front towards +Z. Lengths are in metres.

use super::arches::Arch;
use crate::procedural::modelling::{Profile, Shape};
use glam::{Vec2, Vec3, vec3};

/// The width of a bay in metres. A bay is the section of the arcade with one arch; neighbouring columns are
/// this far apart.
pub const BAY: f32 = 2.6;
/// The thickness of the arcade's wall above the columns, in metres; the wall reaches half of it to both sides
/// of its middle plane.
pub const THICK: f32 = 0.5;
/// The height of a storey of the arcade, from one floor to the next, in metres. The wall above an arch ends
/// at this height.
pub const STOREY: f32 = 4.9;
/// The height above the floor of a storey at which the round part of an arch begins, in metres. The columns
/// under the arch end there.
pub const SPRING: f32 = 3.0;
/// The height of a pedestal of the upper storey, on which a column stands, in metres. The balustrade between
/// two pedestals is 3 cm lower.
pub const RAIL: f32 = 0.95;

/// A square slab around the y axis, between the heights `from` and `to`, for example as the foot of a column.
/// `half` is half the length of its sides. Lengths are in metres.
fn slab(half: f32, from: f32, to: f32) -> Shape {
    Shape::block(vec3(-half, from, -half), vec3(half, to, half))
}

/// A round column with `sides` flat sides around its axis, which stands at the origin. `radius` is the radius
/// of the shaft at its foot. The abacus (the slab on top) reaches slightly above `height`, so that it can
/// enter the wall that the column carries. Both lengths are in metres.
pub fn column(height: f32, radius: f32, sides: u32) -> Shape {
    let r = radius;
    let (foot, head) = (0.6 * r, height - 0.55 * r);
    let mut turned = Profile::new(1.25 * r, foot - 0.02)
        .line(0.0, 0.02)
        .arc(0.0, 0.42 * r, 180.0, 10)
        .line(-0.1 * r, 0.0)
        .arc(-0.08 * r, 0.24 * r, -150.0, 8)
        .line(0.05 * r, 0.0)
        .arc(0.0, 0.22 * r, 180.0, 8)
        .line(-0.06 * r, 0.0)
        .arc(-0.06 * r, 0.12 * r, -80.0, 4);
    let from = foot + 1.0 * r;
    let long = head - 1.05 * r - from;
    // The shaft swells a little (entasis): a straight one looks concave.
    for step in 0..8 {
        let width = |t: f32| r * (1.0 - 0.16 * t.powf(1.8));
        let (a, b) = (step as f32 / 8.0, (step + 1) as f32 / 8.0);
        turned = turned.line(width(b) - width(a), long / 8.0);
    }
    let turned = turned
        .line(0.05 * r, 0.03 * r)
        .arc(0.0, 0.14 * r, 180.0, 8)
        .line(-0.05 * r, 0.03 * r)
        .line(0.0, 0.3 * r)
        .line(0.04 * r, 0.0)
        .line(0.0, 0.08 * r)
        .line(0.04 * r, 0.0)
        .line(0.0, 0.08 * r)
        .arc(0.3 * r, 0.34 * r, 75.0, 10)
        .line(-0.02 * r, 0.06 * r);
    let mut column = turned.turned(sides);
    column.add(slab(1.42 * r, 0.0, foot));
    let abacus = Profile::new(0.0, head)
        .line(1.24 * r, 0.0)
        .line(0.0, 0.3 * r)
        .arc(0.1 * r, 0.1 * r, -90.0, 4)
        .line(0.0, 0.16 * r)
        .capped();
    column.add(abacus.framed(Vec2::ZERO));
    column
}

/// A square pier at the origin, [`STOREY`] metres high and at most 0.76 m wide. It stands where two arcades
/// meet in a corner of the court.
pub fn pier() -> Shape {
    Profile::new(0.0, 0.0)
        .line(0.38, 0.0)
        .line(0.0, 0.16)
        .arc(-0.05, 0.05, -90.0, 5)
        .line(-0.02, 0.0)
        .line(0.0, SPRING - 0.49)
        .line(0.015, 0.0)
        .line(0.0, 0.04)
        .line(-0.005, 0.0)
        .line(0.0, 0.06)
        .arc(0.06, 0.07, -90.0, 6)
        .line(0.0, 0.1)
        .line(-0.07, 0.01)
        .line(0.0, STOREY - SPRING)
        .capped()
        .framed(Vec2::ZERO)
}

/// The wall above the columns of one bay, around the round part of its arch, with mouldings on both faces. It begins at the
/// height [`SPRING`], where the round part of the arch begins, and ends at the floor of the next storey. The origin is on
/// the floor of the bay, in the middle between its two columns and in the middle plane of the wall.
pub fn arch() -> Shape {
    let arch = Arch {
        radius: BAY / 2.0 - 0.26,
        spring: SPRING,
        steps: 40,
    };
    let moulding = Profile::new(0.0, THICK / 2.0)
        .line(0.0, -THICK / 2.0 - 0.02)
        .line(0.06, 0.0)
        .line(0.0, -0.015)
        .line(0.07, 0.0)
        .line(0.0, -0.015)
        .arc(0.0, -0.035, -180.0, 6)
        .arc(0.05, 0.05, 90.0, 5)
        .line(0.0, 0.035);
    let mut face = arch.spandrel(BAY / 2.0, STOREY);
    face.add(arch.moulding(&moulding, 0.0));
    // A keystone, wider at its top.
    let top = SPRING + arch.radius;
    let stone = Shape::block(vec3(-0.5, 0.0, -0.2), vec3(0.5, 0.34, 0.1));
    face.add(stone.map(|p| vec3(p.x * (0.17 + 0.2 * p.y), top - 0.05 + p.y, p.z)));
    let to_front = Vec3::Z * THICK / 2.0;
    let mut both = face.clone().map(|p| p + to_front);
    both.add(face.map(|p| vec3(-p.x, p.y, -p.z) - to_front));
    for from in [-BAY / 2.0, arch.radius] {
        let corner = vec3(from, SPRING, -THICK / 2.0);
        let width = Vec3::X * (BAY / 2.0 - arch.radius);
        both.add(Shape::quad(corner, width, Vec3::Z * THICK));
    }
    both
}

/// The moulding of a blind arch, which decorates a wall without an opening. It is 2.5 m high up to the round
/// part, whose radius is 0.8 m. The wall is not part of the shape; its face is the plane z = 0. The origin is
/// at the foot of the wall, in the middle of the arch.
pub fn blind_arch() -> Shape {
    let arch = Arch {
        radius: 0.8,
        spring: 2.5,
        steps: 32,
    };
    let moulding = Profile::new(0.0, 0.02)
        .line(0.0, -0.06)
        .line(0.05, 0.0)
        .line(0.0, -0.02)
        .line(0.05, 0.0)
        .arc(0.03, 0.03, -90.0, 5)
        .line(0.0, 0.03);
    arch.moulding(&moulding, arch.spring)
}

fn baluster(sides: u32) -> Shape {
    let mut turned = Profile::new(0.05, 0.04)
        .arc(0.0, 0.04, 180.0, 6)
        .line(-0.012, 0.0)
        .arc(-0.006, 0.03, -90.0, 4)
        .arc(0.012, 0.2, 75.0, 10)
        .arc(-0.018, 0.12, -50.0, 6)
        .line(0.012, 0.0)
        .arc(0.0, 0.025, 180.0, 5)
        .line(-0.008, 0.0)
        .line(0.0, 0.03)
        .arc(0.02, 0.035, -80.0, 4)
        .turned(sides);
    turned.add(slab(0.066, 0.0, 0.04));
    turned.add(slab(0.062, 0.52, 0.56));
    turned
}

/// The balustrade of one bay, 0.92 m high: nine balusters between a rail and a foot. It fills the space
/// between the two pedestals on which the columns of the bay stand. Each baluster has `sides` flat sides
/// around its axis.
pub fn balustrade(sides: u32) -> Shape {
    let long = BAY - 0.56;
    let mut all = Shape::default();
    let rail = Profile::new(-0.11, RAIL - 0.19)
        .line(0.22, 0.0)
        .line(0.0, 0.03)
        .arc(0.04, 0.04, -90.0, 5)
        .line(0.0, 0.05)
        .arc(-0.05, 0.04, 80.0, 5)
        .line(-0.2, 0.0)
        .arc(-0.05, -0.04, 80.0, 5)
        .line(0.0, -0.05)
        .arc(0.04, -0.04, -90.0, 5)
        .line(0.0, -0.03);
    let foot = Profile::new(-0.16, 0.0)
        .line(0.32, 0.0)
        .line(0.0, 0.15)
        .arc(-0.04, 0.05, 80.0, 4)
        .line(-0.24, 0.0)
        .arc(-0.04, -0.05, 80.0, 4)
        .line(0.0, -0.15);
    for profile in [rail, foot] {
        let drawn = profile.drawn(-long / 2.0, long / 2.0);
        all.add(drawn.map(|p| vec3(p.z, p.y, -p.x)));
    }
    let baluster = baluster(sides);
    let count = 9_u8;
    for i in 0..count {
        let x = (f32::from(i) + 0.5) / f32::from(count) - 0.5;
        all.add(baluster.clone().map(|p| p + vec3(x * long, 0.2, 0.0)));
    }
    all
}

/// The square pedestal under a column of the upper storey, [`RAIL`] metres high and 0.6 m wide. The
/// balustrades on both sides end at it.
pub fn pedestal() -> Shape {
    Profile::new(0.0, 0.0)
        .line(0.3, 0.0)
        .line(0.0, 0.16)
        .arc(-0.03, 0.04, -90.0, 4)
        .line(0.0, RAIL - 0.35)
        .arc(0.03, 0.04, -90.0, 4)
        .line(0.0, 0.11)
        .capped()
        .framed(Vec2::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_stand_alone_are_closed() {
        for part in [pier(), pedestal()] {
            assert!(part.is_closed());
            assert!(part.signed_volume() > 0.0);
        }
    }
}

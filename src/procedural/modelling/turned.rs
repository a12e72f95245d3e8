//! Surfaces swept from profiles: turned around an axis, extruded along a line, or swept around a rectangle. Props such as
//! columns, mouldings and wheels are made from them.

use super::shape::Shape;
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::TAU;

/// A polyline of (radius, height) points in metres, from which surfaces are swept. If the radius is drawn to the right and
/// the height upwards, the body is on the left side of the polyline as it runs from its first point to its last. So the
/// surface of a rising line faces outwards, away from the axis.
#[derive(Clone)]
pub struct Profile(Vec<Vec2>);

impl Profile {
    pub fn new(radius: f32, height: f32) -> Self {
        Self(vec![vec2(radius, height)])
    }

    /// A profile through these points (radius, height) in metres, in this order; a straight line joins each
    /// point to the next. Surfaces are swept from it.
    pub fn through(points: &[(f32, f32)]) -> Self {
        Self(points.iter().map(|p| vec2(p.0, p.1)).collect())
    }

    fn last(&self) -> Vec2 {
        self.0.last().copied().unwrap_or_default()
    }

    /// The profile with all radii increased by `by` metres, so that the surface swept from it is wider. It
    /// becomes narrower if `by` is negative.
    pub fn widened(mut self, by: f32) -> Self {
        self.0.iter_mut().for_each(|p| p.x += by);
        self
    }

    /// Adds a straight line to the profile, from its last point to a new point, which is `out` farther along
    /// the radius and `up` farther along the height, in metres.
    pub fn line(mut self, out: f32, up: f32) -> Self {
        self.0.push(self.last() + vec2(out, up));
        self
    }

    /// Adds an arc to the profile, from its last point to a new point, which is `out` farther along the
    /// radius and `up` farther along the height, in metres. The arc consists of `steps` straight pieces, and
    /// turns by `degrees` in total. It bulges to the right of its direction, or to the left if `degrees` is
    /// negative.
    pub fn arc(mut self, out: f32, up: f32, degrees: f32, steps: u32) -> Self {
        let (from, way) = (self.last(), vec2(out, up));
        let half = degrees.to_radians() / 2.0;
        for step in 1..steps {
            let turn = half * (2.0 * step as f32 / steps as f32 - 1.0);
            // On a circle around the chord's middle, in units of half the chord.
            let along = turn.sin() / half.sin();
            let aside = (turn.cos() - half.cos()) / half.sin();
            let middle = from + way / 2.0;
            self.0
                .push(middle + way / 2.0 * along + vec2(way.y, -way.x) / 2.0 * aside);
        }
        self.0.push(from + way);
        self
    }

    /// Adds a horizontal line from the last point to the axis, which closes the end of a turned body.
    pub fn capped(mut self) -> Self {
        self.0.push(vec2(0.0, self.last().y));
        self
    }

    /// The surface that arises when the profile turns around the y axis by a full turn. `sides` is the number of straight
    /// steps of the turn.
    pub fn turned(&self, sides: u32) -> Shape {
        let turn = |i: u32, p: Vec2| at_turn((i % sides) as f32 / sides as f32, p);
        self.swept(sides, turn, |_, end, n| turn(end, n))
    }

    /// The surface that arises when the profile turns around the y axis from the angle `from` to the angle `to`, in `sides`
    /// steps. The angles are in full turns, and grow from +X towards +Z.
    pub fn swung(&self, from: f32, to: f32, sides: u32) -> Shape {
        let turn = |i: u32, p: Vec2| at_turn(from + (to - from) * i as f32 / sides as f32, p);
        self.swept(sides, turn, |_, end, n| turn(end, n))
    }

    /// The surface that arises when the profile is extruded along Z from the coordinate `from` to the coordinate `to`, in
    /// metres. The profile's radius is measured along X, and its height along Y.
    pub fn drawn(&self, from: f32, to: f32) -> Shape {
        let point = |i: u32, p: Vec2| Vec3::new(p.x, p.y, if i == 0 { from } else { to });
        self.swept(1, point, |_, _, n| n.extend(0.0))
    }

    /// The surface that arises when the profile is swept around a horizontal rectangle with mitred corners. `half.x` and
    /// `half.y` are half the lengths of the rectangle's sides along X and Z, in metres. The centre of the rectangle is on
    /// the y axis. The profile's radius is measured outwards from the rectangle's sides.
    pub fn framed(&self, half: Vec2) -> Shape {
        let point = |i: u32, p: Vec2| {
            let x = if matches!(i % 4, 0 | 1) { 1.0 } else { -1.0 };
            let z = if matches!(i % 4, 1 | 2) { 1.0 } else { -1.0 };
            Vec3::new(x * (half.x + p.x), p.y, z * (half.y + p.x))
        };
        let out = [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z];
        self.swept(4, point, |side, _, n| {
            out[side as usize] * n.x + Vec3::Y * n.y
        })
    }

    /// Sweeps the profile in `sides` straight steps, and returns the triangles of the surface. The profile passes the stops
    /// 0 to `sides`; step i goes from the stop i to the stop i + 1. `point` takes a stop and a point of the profile, and
    /// returns the position of this point at the stop. `normal` takes a step, a stop at one of its ends and a normal of the
    /// profile, and returns the normal of the surface there.
    fn swept(
        &self,
        sides: u32,
        point: impl Fn(u32, Vec2) -> Vec3,
        normal: impl Fn(u32, u32, Vec2) -> Vec3,
    ) -> Shape {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for (p, n) in self.0.windows(2).zip(self.normals()) {
            for side in 0..sides {
                let corner = |end, i: usize| (point(end, p[i]), normal(side, end, n[i]));
                let (low, high) = (corner(side, 0), corner(side, 1));
                let (next_low, next_high) = (corner(side + 1, 0), corner(side + 1, 1));
                for face in [[next_low, low, high], [next_low, high, next_high]] {
                    let [a, b, c] = face.map(|corner| corner.0);
                    // On the axis two corners coincide, which leaves a triangle without area.
                    if a != b && b != c && c != a {
                        positions.extend([a, b, c]);
                        normals.extend(face.map(|corner| corner.1));
                    }
                }
            }
        }
        Shape::smooth(positions, normals)
    }

    /// The unit normals at the two ends of every segment of the profile, one pair per segment, for smooth
    /// shading. Where two segments meet at a bend of less than about 45°, both get the mean of their normals.
    /// At a sharper edge, each keeps its own normal, so that the edge stays visible.
    fn normals(&self) -> Vec<[Vec2; 2]> {
        let flat: Vec<Vec2> = self
            .0
            .windows(2)
            .map(|p| (p[1] - p[0]).normalize())
            .map(|way| vec2(way.y, -way.x))
            .collect();
        let blend = |i: usize, other: Option<&Vec2>| match other {
            Some(n) if n.dot(flat[i]) > 0.7 => (*n + flat[i]).normalize(),
            _ => flat[i],
        };
        (0..flat.len())
            .map(|i| {
                [
                    blend(i, i.checked_sub(1).and_then(|before| flat.get(before))),
                    blend(i, flat.get(i + 1)),
                ]
            })
            .collect()
    }
}

/// The position of the point `p` (radius, height) of a profile that is turned around the y axis by `turn`
/// full turns, from +X towards +Z; in metres. Directions in the plane of the profile are converted in the
/// same way.
fn at_turn(turn: f32, p: Vec2) -> Vec3 {
    let (sin, cos) = (turn * TAU).sin_cos();
    Vec3::new(p.x * cos, p.y, p.x * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_circle_turns_into_a_ball() {
        let ball = Profile::new(0.0, -1.0).arc(0.0, 2.0, 180.0, 16).turned(32);
        let volume = ball.signed_volume() / 6.0;
        assert!((volume - 4.19).abs() < 0.1, "{volume}");
        assert!(ball.is_closed());
    }

    #[test]
    fn a_frame_around_nothing_is_a_box() {
        let square = Profile::new(0.0, 0.0).line(0.5, 0.0).line(0.0, 1.0);
        let block = square.capped().framed(Vec2::ZERO);
        assert!((block.signed_volume() / 6.0 - 1.0).abs() < 1e-6);
        assert!(block.is_closed());
        assert_eq!(block.triangle_count(), 16);
    }

    #[test]
    fn an_arc_the_other_way_is_hollow() {
        let middle = |degrees| Profile::new(1.0, 0.0).arc(0.0, 1.0, degrees, 2).0[1].x;
        assert!(middle(90.0) > 1.1 && middle(-90.0) < 0.9);
    }
}

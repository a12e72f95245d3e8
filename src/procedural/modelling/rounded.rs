//! Bodies with smooth normals, from which furniture and other props are made: bodies turned on a lathe, and boxes with round
//! edges.

use super::shape::Shape;
use super::turned::Profile;
use glam::Vec3;

/// The number of straight segments between two neighbouring points of a curved profile ([`lathe`]). More
/// segments give smoother bodies with more triangles.
const STEPS: usize = 4;

/// The body that a profile forms when it turns around the y axis; `sides` is the number of straight steps of
/// a full turn. The profile consists of pieces, from the bottom upwards. Each piece is a smooth curve through
/// points (radius, height) in metres, and two pieces meet at a sharp edge.
pub fn lathe(pieces: &[&[(f32, f32)]], sides: u32) -> Shape {
    let mut body = Shape::default();
    for piece in pieces {
        body.add(Profile::through(&curve(piece)).turned(sides));
    }
    body
}

/// A Catmull-Rom curve through the points (radius, height) in metres, as the corners of a polyline with [`STEPS`] segments
/// from one point to the next. Two points give a straight line. The pieces of the profile of [`lathe`] are such curves.
fn curve(points: &[(f32, f32)]) -> Vec<(f32, f32)> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let last = points.len() - 1;
    let beyond = |p: (f32, f32), q: (f32, f32)| (2.0 * p.0 - q.0, 2.0 * p.1 - q.1);
    let mut line = Vec::with_capacity(last * STEPS + 1);
    for k in 0..last {
        let (b, c) = (points[k], points[k + 1]);
        let a = if k > 0 { points[k - 1] } else { beyond(b, c) };
        let d = if k + 2 <= last {
            points[k + 2]
        } else {
            beyond(c, b)
        };
        for step in 0..STEPS {
            let t = step as f32 / STEPS as f32;
            let blend = |a: f32, b: f32, c: f32, d: f32| {
                b + t / 2.0
                    * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
            };
            line.push((
                blend(a.0, b.0, c.0, d.0).max(0.0),
                blend(a.1, b.1, c.1, d.1),
            ));
        }
    }
    line.push(points[last]);
    line
}

/// An axis-aligned box with rounded edges and smooth normals, for cushions and other soft objects. `middle`
/// is its centre, `size` has its lengths along x, y and z, and `radius` is the radius of the edges, all in
/// metres.
pub fn soft_box(middle: Vec3, size: Vec3, radius: f32) -> Shape {
    let inner = size / 2.0 - radius;
    // A sphere cut into octants that are moved apart, which keeps its normals.
    Shape::sphere(3).map(|n| middle + n * radius + n.signum() * inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_bodies_face_outwards_and_have_their_volume() {
        let cone: &[&[(f32, f32)]] = &[&[(0.0, 0.0), (1.0, 0.0)], &[(1.0, 0.0), (0.0, 3.0)]];
        let body = lathe(cone, 64);
        assert_eq!(body.triangle_count(), 128);
        let volume = body.signed_volume() / 6.0;
        assert!((volume - std::f32::consts::PI).abs() < 0.01, "{volume}");

        let ball: &[(f32, f32)] = &[
            (0.0, -1.0),
            (0.707, -0.707),
            (1.0, 0.0),
            (0.707, 0.707),
            (0.0, 1.0),
        ];
        let volume = lathe(&[ball], 48).signed_volume() / 6.0;
        assert!((volume - 4.19).abs() < 0.2, "{volume}");

        let volume = soft_box(Vec3::ONE, Vec3::new(2.0, 3.0, 4.0), 0.1).signed_volume() / 6.0;
        assert!((23.0..24.0).contains(&volume), "{volume}");
    }
}

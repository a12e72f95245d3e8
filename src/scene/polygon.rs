//! Triangulation of polygons.

use glam::{DVec2, DVec3, Vec3};

/// Concave polygons with more corners are cut as a fan, since ear clipping would take too long.
const MAX_EAR_CLIPPING_CORNERS: usize = 512;

/// Cuts a polygon into triangles, given as indices of its corners: a convex one as a fan around its
/// first corner, a concave one by ear clipping. A polygon that crosses itself or is far from planar
/// has no correct triangulation; it is cut into the same number of triangles.
pub(super) fn triangulate(points: &[Vec3], mut triangle: impl FnMut([usize; 3])) {
    let count = points.len();
    let corners = flatten(points);
    let turns_left = |[a, b, c]: [usize; 3]| turn(corners[a], corners[b], corners[c]) >= 0.0;
    let convex = (0..count).all(|i| turns_left([i, (i + 1) % count, (i + 2) % count]));
    let mut left: Vec<usize> = (0..count).collect();
    if !convex && count <= MAX_EAR_CLIPPING_CORNERS {
        while left.len() > 3 {
            let Some(ear) = (0..left.len()).find(|&i| is_ear(&corners, &left, i)) else {
                break;
            };
            triangle(around(&left, ear));
            left.remove(ear);
        }
    }
    for pair in left.get(1..).unwrap_or_default().windows(2) {
        triangle([left[0], pair[0], pair[1]]);
    }
}

/// The corner at `i` between its neighbours.
fn around(left: &[usize], i: usize) -> [usize; 3] {
    let count = left.len();
    [
        left[(i + count - 1) % count],
        left[i],
        left[(i + 1) % count],
    ]
}

fn is_ear(corners: &[DVec2], left: &[usize], i: usize) -> bool {
    let [a, b, c] = around(left, i).map(|corner| corners[corner]);
    let inside = |p: DVec2| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    turn(a, b, c) > 0.0
        && left
            .iter()
            .map(|&corner| corners[corner])
            .all(|p| p == a || p == b || p == c || !inside(p))
}

/// Twice the area of a triangle, positive if it turns left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The polygon projected along the axis that gives the largest area, in counter-clockwise order.
fn flatten(points: &[Vec3]) -> Vec<DVec2> {
    let origin = points.first().map_or(DVec3::ZERO, |p| p.as_dvec3());
    let points: Vec<DVec3> = points.iter().map(|p| p.as_dvec3() - origin).collect();
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    let size = normal.abs();
    let project = |p: &DVec3| {
        let (flat, along) = if size.x >= size.y && size.x >= size.z {
            (DVec2::new(p.y, p.z), normal.x)
        } else if size.y >= size.z {
            (DVec2::new(p.z, p.x), normal.y)
        } else {
            (DVec2::new(p.x, p.y), normal.z)
        };
        if along < 0.0 {
            DVec2::new(-flat.x, flat.y)
        } else {
            flat
        }
    };
    points.iter().map(project).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[Vec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        triangulate(points, |t| triangles.push(t));
        triangles
    }

    /// The triangles' areas along the polygon's normal: all positive if none lies outside.
    fn areas(points: &[Vec3], normal: Vec3) -> Vec<f32> {
        cut(points)
            .into_iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i]);
                (b - a).cross(c - a).dot(normal) / 2.0
            })
            .collect()
    }

    /// An L of area 3, its inner corner first.
    const L: [[f32; 2]; 6] = [
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
    ];

    #[test]
    fn convex_polygons_are_fans() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        assert_eq!(cut(&square), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&square[..3]), [[0, 1, 2]]);
        for few in 0..3 {
            assert!(cut(&square[..few]).is_empty());
        }
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        type Frame = (fn(f32, f32) -> Vec3, Vec3);
        let frames: [Frame; 3] = [
            (|x, y| Vec3::new(x, y, 5.0), Vec3::Z),
            (|x, y| Vec3::new(5.0, x, y), Vec3::X),
            (|x, y| Vec3::new(y, 5.0, x), Vec3::Y),
        ];
        for start in 0..L.len() {
            for (place, normal) in frames {
                let mut points = L.map(|[x, y]| place(x, y));
                points.rotate_left(start);
                let front = areas(&points, normal);
                assert_eq!(front.len(), 4);
                assert!(front.iter().all(|&area| area >= 0.0), "{front:?}");
                assert_eq!(front.iter().sum::<f32>(), 3.0);
                points.reverse();
                let back = areas(&points, -normal);
                assert!(back.iter().all(|&area| area >= 0.0), "{back:?}");
                assert_eq!(back.iter().sum::<f32>(), 3.0);
            }
        }
    }

    #[test]
    fn nonsense_still_ends() {
        let bow = [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::X, Vec3::Y];
        assert_eq!(cut(&bow).len(), 2);
        assert_eq!(cut(&[Vec3::ONE; 9]).len(), 7);
        let star: Vec<Vec3> = (0..1000)
            .map(|i| Vec3::new((i as f32 * 2.0).sin(), (i as f32 * 3.0).cos(), 0.0))
            .collect();
        assert_eq!(cut(&star).len(), 998);
    }
}

//! Cuts polygons, such as the faces of an OBJ file, into triangles, because meshes of a scene consist only of triangles.

use glam::{DVec2, DVec3, Vec3};

/// The maximum number of corners of a concave polygon that is cut by ear clipping. For more corners, ear clipping would take
/// too long: such a polygon is cut as a fan, whose triangles may overlap or lie outside of the polygon.
const MAX_EAR_CLIPPING_CORNERS: usize = 512;

/// Cuts a polygon of n corners into n − 2 triangles, or into none if n is below 3. `points` are the corners in their order
/// around the polygon; for each triangle, `triangle` is called with three indices into `points`. A convex polygon is cut as
/// a fan around its first corner, a concave one by ear clipping, unless it has more than [`MAX_EAR_CLIPPING_CORNERS`]
/// corners. A polygon that crosses itself or is far from planar has no correct triangulation, but still yields n − 2
/// triangles.
pub(super) fn triangulate(points: &[Vec3], mut triangle: impl FnMut([usize; 3])) {
    let count = points.len();
    if (4..=MAX_EAR_CLIPPING_CORNERS).contains(&count) {
        let corners = flatten(points);
        if !is_convex(&corners) {
            let mut ears = Ears::of(&corners);
            while ears.left.len() > 3
                && let Some(ear) = ears.cut_first()
            {
                triangle(ear);
            }
            let left = ears.left;
            for pair in left[1..].windows(2) {
                triangle([left[0], pair[0], pair[1]]);
            }
            return;
        }
    }
    for second in 1..count.saturating_sub(1) {
        triangle([0, second, second + 1]);
    }
}

fn is_convex(corners: &[DVec2]) -> bool {
    let count = corners.len();
    let turns_left = |[a, b, c]: [usize; 3]| turn(corners[a], corners[b], corners[c]) >= 0.0;
    (0..count).all(|i| turns_left([i, (i + 1) % count, (i + 2) % count]))
}

/// A search for the ears of a polygon. A corner is an ear, and can be cut off as a triangle, if its inner
/// angle is below 180° and no other corner lies in the triangle that it forms with its two neighbours. The
/// result of the test of a corner is stored until a cut can change it. Without this, each cut would test all
/// pairs of corners again, which takes too long in a file with thousands of polygons.
struct Ears<'a> {
    corners: &'a [DVec2],
    /// The indices, into `corners`, of the corners that are not cut off yet, in their order around the polygon.
    left: Vec<usize>,
    is_left: Vec<bool>,
    known: Vec<Known>,
}

/// The stored result of the last test whether a corner is an ear, which means that it can be cut off as a
/// triangle. With it, the corner is not tested again after each cut.
#[derive(Clone, Copy)]
enum Known {
    Nothing,
    Ear,
    /// The corner is not an ear, because its inner angle in the remaining polygon is at least 180°. This is tested again
    /// after one of its neighbours is cut off, because the angle then changes.
    Reflex,
    /// The corner is not an ear, because another corner lies in the triangle that this corner forms with its neighbours. The
    /// number is the index of the other corner; if several corners lie in the triangle, it is the smallest index of them.
    /// This is tested again after the other corner or a neighbour is cut off.
    Blocked(usize),
}

impl<'a> Ears<'a> {
    fn of(corners: &'a [DVec2]) -> Self {
        Self {
            corners,
            left: (0..corners.len()).collect(),
            is_left: vec![true; corners.len()],
            known: vec![Known::Nothing; corners.len()],
        }
    }

    /// Cuts off the first ear in the order of [`Self::left`]. Returns the indices of the corner before the ear, of the ear,
    /// and of the corner after it: the triangle that is cut off. `None` if no corner is an ear.
    fn cut_first(&mut self) -> Option<[usize; 3]> {
        let position = (0..self.left.len()).find(|&position| self.is_ear(position))?;
        let [before, ear, after] = self.around(position);
        self.left.remove(position);
        self.is_left[ear] = false;
        self.known[before] = Known::Nothing;
        self.known[after] = Known::Nothing;
        Some([before, ear, after])
    }

    /// Returns the indices of three corners: the corner before the one at `position` in [`Self::left`], the one at
    /// `position`, and the corner after it.
    fn around(&self, position: usize) -> [usize; 3] {
        let count = self.left.len();
        [
            self.left[(position + count - 1) % count],
            self.left[position],
            self.left[(position + 1) % count],
        ]
    }

    fn is_ear(&mut self, position: usize) -> bool {
        let corner = self.left[position];
        let begin = match self.known[corner] {
            Known::Ear => return true,
            Known::Reflex => return false,
            Known::Blocked(by) if self.is_left[by] => return false,
            Known::Blocked(by) => by,
            Known::Nothing => 0,
        };
        let [a, b, c] = self.around(position).map(|corner| self.corners[corner]);
        let inside =
            |p: DVec2| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
        let blocks = |&other: &usize| {
            let p = self.corners[other];
            self.is_left[other] && p != a && p != b && p != c && inside(p)
        };
        self.known[corner] = if turn(a, b, c) <= 0.0 {
            Known::Reflex
        } else {
            (begin..self.corners.len())
                .find(blocks)
                .map_or(Known::Ear, Known::Blocked)
        };
        matches!(self.known[corner], Known::Ear)
    }
}

/// Twice the signed area of the triangle `a`, `b`, `c`: positive if the corners run counter-clockwise,
/// negative if they run clockwise, 0 if they lie on a line. Its sign shows on which side of the line from `a`
/// to `b` the point `c` is.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The polygon's corners projected to two dimensions, where convexity and ears are tested. They are in the order of
/// `points`, relative to the first corner. The polygon is projected along the coordinate axis that makes its projected area
/// the largest, and mirrored if needed, so that its corners run counter-clockwise.
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

    /// The signed area of each triangle that the polygon `points` is cut into, as seen from the direction to which `normal`
    /// points. If all areas are positive and their sum is the polygon's area, no triangle lies outside of the polygon.
    fn areas(points: &[Vec3], normal: Vec3) -> Vec<f32> {
        cut(points)
            .into_iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i]);
                (b - a).cross(c - a).dot(normal) / 2.0
            })
            .collect()
    }

    /// The six corners of an L-shaped polygon with the area 3, counter-clockwise in 2D, as a test of concave polygons. The
    /// first corner is the one whose inner angle is above 180°, so a fan around most of the corners would be wrong.
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
            for (point, normal) in frames {
                let mut points = L.map(|[x, y]| point(x, y));
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

    /// The triangles, as indices into `points`, that a simple and slow ear clipping makes: after each cut it tests all
    /// corners again, from the first one on. The tests compare [`cut`] with it, which must return the same triangles.
    fn cut_plainly(points: &[Vec3]) -> Vec<[usize; 3]> {
        let corners = flatten(points);
        let mut left: Vec<usize> = (0..points.len()).collect();
        let mut triangles = Vec::new();
        while left.len() > 3 {
            let around = |i: usize| {
                let count = left.len();
                [i + count - 1, i, i + 1].map(|i| left[i % count])
            };
            let is_ear = |i: &usize| {
                let [a, b, c] = around(*i).map(|corner| corners[corner]);
                let out =
                    |p: DVec2| turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
                let mut others = left.iter().map(|&corner| corners[corner]);
                turn(a, b, c) > 0.0 && others.all(|p| p == a || p == b || p == c || out(p))
            };
            let Some(ear) = (0..left.len()).find(is_ear) else {
                break;
            };
            triangles.push(around(ear));
            left.remove(ear);
        }
        let fan = left[1..].windows(2);
        triangles.extend(fan.map(|pair| [left[0], pair[0], pair[1]]));
        triangles
    }

    #[test]
    fn what_is_kept_of_corners_changes_no_cut() {
        let mut random = crate::base::random::Random::new(3);
        let mut unit = || f64::from(random.index(1 << 20) as u32) / f64::from(1 << 20);
        let mut concave = 0;
        for round in 0..300 {
            let count = 4 + round % 60;
            // Stars with random rays, and in every third round corners anywhere.
            let points: Vec<Vec3> = (0..count)
                .map(|i| {
                    let angle = std::f64::consts::TAU * i as f64 / count as f64;
                    let (x, y) = match round % 3 {
                        0 => (unit(), unit()),
                        _ => (angle.cos() * unit(), angle.sin() * unit()),
                    };
                    Vec3::new(x as f32, y as f32, 0.0)
                })
                .collect();
            if !is_convex(&flatten(&points)) {
                concave += 1;
                assert_eq!(cut(&points), cut_plainly(&points), "{points:?}");
            }
        }
        assert!(concave > 100, "{concave}");
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

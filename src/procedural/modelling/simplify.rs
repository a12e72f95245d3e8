//! Simplifies a mesh by collapsing edges. The edges that change the surface least are collapsed first
//! (quadrics, Garland and Heckbert 1997).

use glam::{DMat3, DVec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A weighted sum of squared distances from a point p to planes, as the quadratic function pᵀAp + 2b·p + c. Each point of
/// the mesh has a quadric for the planes of the faces around it. The weight of a plane is twice the area of its face in
/// square metres, times the weight that the caller of [`simplify`] gives to the region. The sum is the error that arises if
/// the point is moved to p.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    const NOTHING: Self = Self {
        a: DMat3::ZERO,
        b: DVec3::ZERO,
        c: 0.0,
    };

    fn plane(point: DVec3, normal: DVec3, weight: f64) -> Self {
        let distance = -normal.dot(point);
        let n = normal * weight;
        Self {
            a: DMat3::from_cols(normal * n.x, normal * n.y, normal * n.z),
            b: n * distance,
            c: weight * distance * distance,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            a: self.a + other.a,
            b: self.b + other.b,
            c: self.c + other.c,
        }
    }

    fn at(&self, p: DVec3) -> f64 {
        p.dot(self.a * p) + 2.0 * self.b.dot(p) + self.c
    }
}

/// An edge that may be collapsed, as a tuple of three values: its cost, the indices of its two points, and the values that
/// [`Net::changes`] had for these points when the cost was computed. The cost is stored as the bits of an f64, because a
/// heap can order integers but no floats, and costs are not negative. The edge of the lowest cost is collapsed first.
type Candidate = (u64, [usize; 2], [u32; 2]);

/// A closed surface that is being simplified, with the edges that may still be collapsed. Its positions are in metres.
struct Net<'a> {
    points: &'a mut [DVec3],
    faces: &'a mut [[usize; 3]],
    /// For each point, the indices of the faces that have it as a corner; empty for a removed point.
    around: Vec<Vec<usize>>,
    quadrics: Vec<Quadric>,
    /// For each point, how often it was moved or removed. A [`Candidate`] stores these numbers of its two points when its
    /// cost is computed. If they have changed since then, the cost is outdated, and the candidate is skipped.
    changes: Vec<u32>,
    candidates: BinaryHeap<Reverse<Candidate>>,
}

impl Net<'_> {
    fn cross(&self, [a, b, c]: [usize; 3]) -> DVec3 {
        let p = &self.points;
        (p[b] - p[a]).cross(p[c] - p[a])
    }

    fn neighbours(&self, point: usize) -> Vec<usize> {
        let faces = self.around[point].iter().flat_map(|&f| self.faces[f]);
        let mut found: Vec<usize> = faces.filter(|&i| i != point).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The position in metres to which the edge between the points `i` and `j` should be collapsed, and the error at this
    /// position. The error is the sum of the values of the two points' [`Quadric`]s there. Each quadric holds the planes of
    /// the original faces around its point, and around all points that were collapsed into it before.
    fn target(&self, [i, j]: [usize; 2]) -> (DVec3, f64) {
        let (p, q) = (self.points[i], self.points[j]);
        let sum = self.quadrics[i].plus(self.quadrics[j]);
        let middle = (p + q) / 2.0;
        let mut best = (middle, sum.at(middle));
        // If the planes are nearly parallel, the best point may be far away along them.
        let scale = sum.a.x_axis.x + sum.a.y_axis.y + sum.a.z_axis.z;
        if sum.a.determinant() > 1e-6 * scale.powi(3) {
            let there = -(sum.a.inverse() * sum.b);
            if there.distance(middle) < p.distance(q) && sum.at(there) < best.1 {
                best = (there, sum.at(there));
            }
        }
        best
    }

    fn add_candidate(&mut self, i: usize, j: usize) {
        let edge = [i.min(j), i.max(j)];
        let [p, q] = edge.map(|i| self.points[i]);
        // The length counts a little: on a plane all edges would cost the same, and collapsing short
        // edges first avoids slivers.
        let cost = self.target(edge).1.max(0.0) + 1e-9 * p.distance_squared(q).powi(2);
        let changes = edge.map(|i| self.changes[i]);
        // Costs are not negative, so their bits sort like the costs.
        self.candidates
            .push(Reverse((cost.to_bits(), edge, changes)));
    }

    /// Collapses the edge between the points `i` and `j` to the position that [`Self::target`] computes: `i` is moved there,
    /// and `j` is removed. Does nothing if that would fold the surface or make it non-manifold. Returns true if the edge was
    /// collapsed.
    fn collapse(&mut self, [i, j]: [usize; 2]) -> bool {
        let others = self.neighbours(j);
        let shared = self.neighbours(i);
        let shared = shared.iter().filter(|n| others.contains(n)).count();
        if shared != 2 {
            return false;
        }
        let (there, _) = self.target([i, j]);
        for end in [i, j] {
            for &face in &self.around[end] {
                let corners = self.faces[face];
                if corners.contains(&i) && corners.contains(&j) {
                    continue;
                }
                let before = self.cross(corners).normalize_or_zero();
                let [a, b, c] = corners.map(|n| if n == end { there } else { self.points[n] });
                let after = (b - a).cross(c - a);
                let longest = (b - a).length().max((c - b).length()).max((a - c).length());
                let flat = after.length() < 0.1 * longest * longest;
                if flat || after.normalize_or_zero().dot(before) < 0.4 {
                    return false;
                }
            }
        }
        self.points[i] = there;
        self.quadrics[i] = self.quadrics[i].plus(self.quadrics[j]);
        for face in std::mem::take(&mut self.around[j]) {
            if self.faces[face].contains(&i) {
                for corner in self.faces[face] {
                    self.around[corner].retain(|&f| f != face);
                }
            } else {
                self.faces[face] = self.faces[face].map(|n| if n == j { i } else { n });
                self.around[i].push(face);
            }
        }
        self.changes[i] += 1;
        self.changes[j] += 1;
        for n in self.neighbours(i) {
            self.add_candidate(i, n);
        }
        true
    }
}

/// Reduces a closed surface to about `target` faces by collapsing edges. It keeps more faces if further collapses would fold
/// the surface or make it non-manifold. `faces` has three indices into `points` per face. Some faces are deleted, and some
/// points are moved. `weight` gives a weight > 0 for a position; where it is higher, more faces are kept.
pub fn simplify(
    points: &mut Vec<DVec3>,
    faces: &mut Vec<[usize; 3]>,
    target: usize,
    weight: impl Fn(DVec3) -> f64,
) {
    let mut left = faces.len();
    let mut net = Net {
        around: vec![Vec::new(); points.len()],
        quadrics: vec![Quadric::NOTHING; points.len()],
        changes: vec![0; points.len()],
        candidates: BinaryHeap::new(),
        points,
        faces,
    };
    for face in 0..net.faces.len() {
        let corners = net.faces[face];
        let (cross, point) = (net.cross(corners), net.points[corners[0]]);
        let weight = cross.length() * weight(point);
        let plane = Quadric::plane(point, cross.normalize_or_zero(), weight);
        for corner in corners {
            net.around[corner].push(face);
            net.quadrics[corner] = net.quadrics[corner].plus(plane);
        }
    }
    for i in 0..net.points.len() {
        for j in net.neighbours(i) {
            if i < j {
                net.add_candidate(i, j);
            }
        }
    }
    while left > target {
        let Some(Reverse((_, edge, changes))) = net.candidates.pop() else {
            break;
        };
        if edge.map(|i| net.changes[i]) == changes && net.collapse(edge) {
            left -= 2;
        }
    }
    let alive: Vec<bool> = (0..net.faces.len())
        .map(|face| net.around[net.faces[face][0]].contains(&face))
        .collect();
    let mut alive = alive.into_iter();
    faces.retain(|_| alive.next().unwrap_or(false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finely_split_box_keeps_its_form() {
        // An octahedron whose faces are each split into four stays an octahedron.
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let mut points = Vec::new();
        let mut faces = Vec::new();
        let mut number = |p: DVec3| {
            points.iter().position(|&q| q == p).unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            })
        };
        for sign in 0..8 {
            let [a, b, c] = [0, 1, 2].map(|i| axes[i] * [1.0, -1.0][sign >> i & 1]);
            let [d, e, f] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            for face in [[a, d, f], [d, b, e], [f, e, c], [d, e, f]] {
                let [i, j, k] = face.map(&mut number);
                let odd = sign.count_ones() % 2 == 1;
                faces.push(if odd { [i, k, j] } else { [i, j, k] });
            }
        }
        simplify(&mut points, &mut faces, 8, |_| 1.0);
        let p = |i: usize| points[i];
        let volume: f64 = faces
            .iter()
            .map(|f| p(f[0]).dot(p(f[1]).cross(p(f[2]))) / 6.0)
            .sum();
        assert!(faces.len() < 16, "{}", faces.len());
        assert!((volume - 4.0 / 3.0).abs() < 1e-9, "{volume}");
    }
}

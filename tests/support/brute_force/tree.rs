//! A binary tree of boxes over the triangles, and the search for intersections in it.

use super::Tracer;
use super::geometry::Triangle;
use glam::DVec3;

/// The maximum number of triangles of a leaf.
const LEAF: usize = 4;

pub struct Node {
    pub low: DVec3,
    pub high: DVec3,
    /// For a leaf, the index of its first triangle; for an inner node, the index of the first child. The second child is the
    /// next node.
    first: u32,
    /// Number of triangles of a leaf; 0 for an inner node.
    count: u32,
}

/// Builds the tree and returns its nodes, with the root first; empty without triangles. It splits at the median along the
/// widest axis of the centres, and sorts `triangles` by leaf.
pub fn build(triangles: &mut [Triangle]) -> Vec<Node> {
    let mut nodes = Vec::new();
    if triangles.is_empty() {
        return nodes;
    }
    let node = |triangles: &[Triangle], first: usize| {
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let low = corners().reduce(DVec3::min).unwrap();
        let high = corners().reduce(DVec3::max).unwrap();
        // Room for the rounding of the slabs.
        let pad = DVec3::splat(1e-13 * (low.abs().max_element() + high.abs().max_element()));
        Node {
            low: low - pad,
            high: high + pad,
            first: first as u32,
            count: triangles.len() as u32,
        }
    };
    nodes.push(node(triangles, 0));
    let mut open = vec![0];
    while let Some(at) = open.pop() {
        let (first, count) = (nodes[at].first as usize, nodes[at].count as usize);
        if count <= LEAF {
            continue;
        }
        let own = &mut triangles[first..first + count];
        let centre = |t: &Triangle| t.corners[0] + t.corners[1] + t.corners[2];
        let low = own.iter().map(centre).reduce(DVec3::min).unwrap();
        let high = own.iter().map(centre).reduce(DVec3::max).unwrap();
        let axis = (high - low).max_position();
        let half = count / 2;
        own.select_nth_unstable_by(half, |a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
        let (left, right) = own.split_at(half);
        let children = [node(left, first), node(right, first + half)];
        nodes[at].first = nodes.len() as u32;
        nodes[at].count = 0;
        open.extend([nodes.len(), nodes.len() + 1]);
        nodes.extend(children);
    }
    nodes
}

impl Node {
    /// The ray parameter at which a ray enters the node's box before `t_max`; infinite if it misses the box. `inverse` is
    /// the inverse of each component of the direction.
    #[inline]
    fn entered(&self, origin: DVec3, inverse: DVec3, t_max: f64) -> f64 {
        let (to_low, to_high) = (
            (self.low - origin) * inverse,
            (self.high - origin) * inverse,
        );
        // Not f64::min and max, which are slower since they pass over what is not a number.
        let lower = |a: f64, b: f64| if a < b { a } else { b };
        let higher = |a: f64, b: f64| if a > b { a } else { b };
        let (mut enter, mut leave) = (0.0, t_max);
        for axis in 0..3 {
            let (a, b) = (to_low[axis], to_high[axis]);
            enter = higher(lower(a, b), enter);
            leave = lower(higher(a, b), leave);
        }
        if enter * (1.0 - 1e-12) <= leave {
            enter * (1.0 - 1e-12)
        } else {
            f64::INFINITY
        }
    }
}

impl Tracer {
    /// The closest intersection with `t_min` < t < `t_max`, or with `any` the first one that is found, as (triangle, t, u,
    /// v). The triangle with the index `skip`, where the ray begins, is left out.
    pub(super) fn crossing(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_min: f64,
        t_max: f64,
        skip: usize,
        any: bool,
    ) -> Option<(usize, f64, f64, f64)> {
        // A tiny component instead of 0 keeps 0 · ∞ out of the slabs.
        let safe = |d: f64| {
            if d.abs() < 1e-150 {
                1e-150_f64.copysign(d)
            } else {
                d
            }
        };
        let inverse = DVec3::new(safe(direction.x), safe(direction.y), safe(direction.z)).recip();
        let mut best = None;
        let mut t_max = t_max;
        let enter = |n: u32, t_max: f64| self.nodes[n as usize].entered(origin, inverse, t_max);
        let mut stack = [(0_u32, 0.0); 64];
        let mut height = 0;
        if !self.nodes.is_empty() && enter(0, t_max) < f64::INFINITY {
            height = 1;
        }
        while height > 0 {
            height -= 1;
            let (number, entered) = stack[height];
            if entered > t_max {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.count == 0 {
                let mut near = (node.first, enter(node.first, t_max));
                let mut far = (node.first + 1, enter(node.first + 1, t_max));
                if far.1 < near.1 {
                    (near, far) = (far, near);
                }
                for child in [far, near] {
                    if child.1 < f64::INFINITY {
                        stack[height] = child;
                        height += 1;
                    }
                }
                continue;
            }
            for index in node.first as usize..(node.first + node.count) as usize {
                if index == skip {
                    continue;
                }
                if let Some((t, u, v)) = self.triangles[index].meets(origin, direction)
                    && t > t_min
                    && t < t_max
                {
                    best = Some((index, t, u, v));
                    t_max = t;
                    if any {
                        return best;
                    }
                }
            }
        }
        best
    }
}

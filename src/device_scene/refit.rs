//! Fits the boxes of a tree over triangles to triangles that have moved. The tree keeps its structure, so the triangles keep
//! their order.

use glam::{DVec3, Vec3};
use obvhs::cwbvh::node::CwBvhNode;

/// The box (smallest, largest corner) around nothing.
const EMPTY: (Vec3, Vec3) = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// Fits the boxes of all nodes to `triangles`, the corners of the triangles in the order of the leaves. In `nodes`, indices of
/// children and triangles count from the start of their arrays, and a parent comes before its children. Returns the box around
/// all triangles.
pub fn refit(nodes: &mut [CwBvhNode], triangles: &[[Vec3; 3]]) -> (Vec3, Vec3) {
    let mut boxes = vec![EMPTY; nodes.len()];
    for index in (0..nodes.len()).rev() {
        let children = children(&nodes[index], &boxes, triangles);
        boxes[index] = children.iter().flatten().copied().fold(EMPTY, union);
        if boxes[index] != EMPTY {
            set_boxes(&mut nodes[index], boxes[index], &children);
        }
    }
    boxes.first().copied().unwrap_or(EMPTY)
}

/// The boxes of a node's children by their slots; `None` for an empty slot. `boxes` has those of all nodes after this one.
fn children(
    node: &CwBvhNode,
    boxes: &[(Vec3, Vec3)],
    triangles: &[[Vec3; 3]],
) -> [Option<(Vec3, Vec3)>; 8] {
    std::array::from_fn(|slot| {
        let meta = node.child_meta[slot];
        if node.imask >> slot & 1 != 0 {
            let before = (node.imask & ((1 << slot) - 1)).count_ones();
            return Some(boxes[(node.child_base_idx + before) as usize]);
        }
        let first = node.primitive_base_idx as usize + usize::from(meta & 31);
        let count = (meta >> 5).count_ones() as usize;
        let corners = triangles.get(first..first + count)?.as_flattened();
        (count > 0).then(|| corners.iter().map(|p| (*p, *p)).fold(EMPTY, union))
    })
}

fn union(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Stores the box of a node and, in steps of a power of two from its lowest corner, the boxes of its children, rounded
/// outwards.
fn set_boxes(node: &mut CwBvhNode, around: (Vec3, Vec3), children: &[Option<(Vec3, Vec3)>; 8]) {
    let (low, size) = (
        around.0.as_dvec3(),
        (around.1.as_dvec3() - around.0.as_dvec3()),
    );
    node.p = around.0;
    let mut scale = DVec3::ZERO;
    for axis in 0..3 {
        let exponent = (size[axis] / 255.0).log2().ceil().clamp(-126.0, 127.0);
        // Of a flat box: its planes are all at the lowest corner.
        let is_flat = size[axis] <= 0.0;
        node.e[axis] = if is_flat { 0 } else { (exponent + 127.0) as u8 };
        scale[axis] = if is_flat { 1.0 } else { exponent.exp2() };
    }
    for (slot, child) in children.iter().enumerate() {
        let Some((child_low, child_high)) = child else {
            continue;
        };
        let first = ((child_low.as_dvec3() - low) / scale)
            .floor()
            .clamp(DVec3::ZERO, DVec3::splat(255.0));
        let last = ((child_high.as_dvec3() - low) / scale)
            .ceil()
            .clamp(DVec3::ZERO, DVec3::splat(255.0));
        node.child_min_x[slot] = first.x as u8;
        node.child_min_y[slot] = first.y as u8;
        node.child_min_z[slot] = first.z as u8;
        node.child_max_x[slot] = last.x as u8;
        node.child_max_y[slot] = last.y as u8;
        node.child_max_z[slot] = last.z as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::super::compute_bvh::Tree;
    use super::*;
    use crate::base::random::Random;
    use glam::Vec3Swizzles;

    /// The box that a node stores for a child.
    fn stored(node: &CwBvhNode, slot: usize) -> (DVec3, DVec3) {
        let scale = node
            .e
            .map(|e| f64::from(f32::from_bits(u32::from(e) << 23)));
        let at = |bytes: [u8; 3]| {
            node.p.as_dvec3() + DVec3::from_array(scale) * DVec3::from_array(bytes.map(f64::from))
        };
        let low = [
            node.child_min_x[slot],
            node.child_min_y[slot],
            node.child_min_z[slot],
        ];
        let high = [
            node.child_max_x[slot],
            node.child_max_y[slot],
            node.child_max_z[slot],
        ];
        (at(low), at(high))
    }

    /// True if each box contains all triangles below it, and no box is larger than the steps of its node require.
    fn fits(nodes: &[CwBvhNode], triangles: &[[Vec3; 3]]) -> bool {
        let mut boxes = vec![EMPTY; nodes.len()];
        let mut all = true;
        for index in (0..nodes.len()).rev() {
            let node = &nodes[index];
            let exact = children(node, &boxes, triangles);
            boxes[index] = exact.iter().flatten().copied().fold(EMPTY, union);
            let step = DVec3::from_array(
                node.e
                    .map(|e| f64::from(f32::from_bits(u32::from(e) << 23))),
            );
            for (slot, exact) in exact.iter().enumerate() {
                let Some((low, high)) = exact else { continue };
                let (stored_low, stored_high) = stored(node, slot);
                let (low, high) = (low.as_dvec3(), high.as_dvec3());
                all &= stored_low.cmple(low).all() && stored_high.cmpge(high).all();
                all &=
                    (stored_low + step).cmpge(low).all() && (stored_high - step).cmple(high).all();
            }
        }
        all
    }

    #[test]
    fn boxes_follow_their_triangles() {
        let mut random = Random::new(3);
        let mut unit = || random.index(1 << 20) as f32 / (1 << 20) as f32;
        let mut point = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
        for count in [1_usize, 2, 9, 1000] {
            let corners: Vec<[Vec3; 3]> = (0..count)
                .map(|_| {
                    let at = point(10.0);
                    [at, at + point(1.0), at + point(1.0)]
                })
                .collect();
            let tree = Tree::over_triangles(count, |index| corners[index]);
            let mut nodes = tree.nodes.clone();
            for scale in [Vec3::ONE, Vec3::new(3.0, 0.0, 0.2), Vec3::splat(1e-30)] {
                let moved: Vec<[Vec3; 3]> = (tree.order.iter())
                    .map(|&triangle| {
                        corners[triangle as usize].map(|p| (p + p.yzx() * 0.3) * scale)
                    })
                    .collect();
                if count > 1 {
                    assert!(
                        !fits(&nodes, &moved),
                        "a tree of another shape was taken for a good one"
                    );
                }
                let (low, high) = refit(&mut nodes, &moved);
                assert!(fits(&nodes, &moved), "{count} triangles, {scale}");
                let all = moved
                    .as_flattened()
                    .iter()
                    .map(|p| (*p, *p))
                    .fold(EMPTY, union);
                assert_eq!((low, high), all);
            }
        }
    }
}

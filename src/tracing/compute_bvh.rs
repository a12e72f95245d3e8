//! Trees for the BVH traversed in compute: one for each mesh, one over the instances, as one array
//! of eight-wide compressed nodes with absolute indices.

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::{build_cwbvh, build_cwbvh_from_tris};
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::triangle::Triangle;
use std::time::Duration;

/// A tree of eight-wide compressed nodes; node 0 is the root.
pub struct Tree {
    /// Nodes with indices relative to this tree.
    pub nodes: Vec<CwBvhNode>,
    /// The primitive at each leaf position.
    pub order: Vec<u32>,
    /// Levels of inner nodes.
    pub depth: u32,
}

/// The builder's settings. Triangles are not split: each stands in one leaf, so that the leaf order
/// is a permutation and a hit names its triangle.
const TRIANGLES: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 3,
    ..BvhBuildParams::medium_build()
};
/// One instance a leaf: entering one costs a ray transform.
const INSTANCES: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 1,
    ..BvhBuildParams::medium_build()
};

impl Tree {
    /// The tree of a mesh, given its triangles' corners.
    pub fn over_triangles(corners: &[[Vec3; 3]]) -> Self {
        let triangles: Vec<Triangle> = corners
            .iter()
            .map(|[a, b, c]| Triangle {
                v0: (*a).into(),
                v1: (*b).into(),
                v2: (*c).into(),
            })
            .collect();
        if triangles.is_empty() {
            return Self::empty();
        }
        Self::from_built(build_cwbvh_from_tris(
            &triangles,
            TRIANGLES,
            &mut Duration::default(),
        ))
    }

    /// The tree over boxes (min, max), such as those of instances.
    pub fn over_boxes(boxes: &[(Vec3, Vec3)]) -> Self {
        if boxes.is_empty() {
            return Self::empty();
        }
        let boxes: Vec<Aabb> = boxes
            .iter()
            .map(|(min, max)| Aabb::new((*min).into(), (*max).into()))
            .collect();
        Self::from_built(build_cwbvh(&boxes, INSTANCES, &mut Duration::default()))
    }

    /// A tree in which nothing is ever hit.
    fn empty() -> Self {
        Self {
            nodes: vec![CwBvhNode::default()],
            order: Vec::new(),
            depth: 1,
        }
    }

    fn from_built(built: CwBvh) -> Self {
        let depth = depth(&built.nodes);
        Self {
            nodes: built.nodes,
            order: built.primitive_indices,
            depth,
        }
    }

    /// The nodes for a place in a larger array: children counted from `first_node`, primitives from
    /// `first_primitive`.
    pub fn placed(&self, first_node: u32, first_primitive: u32) -> impl Iterator<Item = CwBvhNode> {
        self.nodes.iter().map(move |node| CwBvhNode {
            child_base_idx: node.child_base_idx + first_node,
            primitive_base_idx: node.primitive_base_idx + first_primitive,
            ..*node
        })
    }
}

/// Levels of inner nodes below and including the root. Parents stand before their children.
fn depth(nodes: &[CwBvhNode]) -> u32 {
    let mut levels = vec![1_u32; nodes.len()];
    let mut deepest = 1;
    for index in 0..nodes.len() {
        let children = nodes[index].imask.count_ones();
        for child in 0..children {
            let child = (nodes[index].child_base_idx + child) as usize;
            levels[child] = levels[index] + 1;
            deepest = deepest.max(levels[child]);
        }
    }
    deepest
}

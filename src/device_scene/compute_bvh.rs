//! The trees (bounding volume hierarchies) that a compute shader traverses to find what a ray hits: one over the
//! triangles of each mesh and one over the instances. The nodes have up to eight children and are compressed. On the
//! device, one array holds the nodes of all trees, and the indices in a node count from the start of the whole array.
//! Light BVHs are made from the binary trees that are also built here.

use crate::shader_interface::NONE;
use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ploc::PlocBuilder;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::time::Duration;

/// A bounding volume hierarchy that compute shaders traverse to trace rays: compressed nodes with up to eight children. Its
/// leaves are triangles of meshes, or bounding boxes of instances. Node 0 is the root.
#[derive(Clone)]
pub struct Tree {
    /// The nodes of the tree, which are uploaded for shaders that traverse it. In a node, indices of children count from the
    /// start of this array, and indices of primitives from the start of `order`.
    pub nodes: Vec<CwBvhNode>,
    /// For each position in the order of the leaves, the index in the input of the primitive (triangle or box) at this
    /// position. The device stores the triangles of a mesh in this order; for a tree over instances, the buffer
    /// `top_instances` is made from it.
    pub order: Vec<u32>,
    /// The number of levels of inner nodes, including the root; 1 for a tree without primitives. It decides the size of
    /// the stack that a traversal needs.
    pub depth: u32,
}

/// Options of the builder for trees over triangles. Triangles are not split: each is in exactly one leaf, so that the order
/// of the leaves is a permutation of the triangles, and a hit identifies its triangle.
///
/// The build of a tree over 57,000 triangles takes 0.01 s longer with the preset `slow_build` than with `medium_build`, and
/// path tracing of the scenes `atrium`, `garage` and `night-city` then spends 3 to 6 % less time on rays. With
/// `very_slow_build`, the build takes another 0.05 s, and rays take another 1 to 5 % less time.
///
/// A leaf holds at most two triangles. With larger leaves, a ray tests more triangles, while most lanes of
/// the GPU are idle; smaller leaves make more nodes. In the scenes `atrium`, `garage` and `cornell`, path
/// tracing with a limit of 2 takes 0 to 5 % less time than with a limit of 3, and 2 to 19 % less than with a
/// limit of 1.
const TRIANGLES: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 2,
    ..BvhBuildParams::slow_build()
};
/// Options of the builder for trees over at least [`MANY`] triangles. The tree over ten million triangles takes three fifths
/// of the time that it takes with [`TRIANGLES`], because fewer nodes are moved to better places.
///
/// The price: path tracing of a landscape of 1.6 million triangles takes 8 to 19 % more CPU time (three alternating pairs of 30
/// frames). At 1280 × 720 pixels the shorter build pays for itself in the first fifty frames or so, which is what most views of
/// such a mesh render.
const MANY_TRIANGLES: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 2,
    ..BvhBuildParams::medium_build()
};
/// The number of triangles from which on a tree is built with [`MANY_TRIANGLES`].
const MANY: usize = 1 << 20;
/// Options of the builder for trees over boxes: those over instances, and the binary trees of light BVHs. A leaf holds one
/// box. With more instances in a leaf, a ray would enter instances whose boxes it misses, and transforming the ray into an
/// instance is expensive.
const INSTANCES: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 1,
    ..BvhBuildParams::medium_build()
};

/// If more boxes than this are equal, [`halved`] builds the tree instead of the builder of the library `obvhs`. That builder
/// merges pairs of nearest boxes. Among equal boxes it finds few pairs per round, so that its time is quadratic in their
/// number (hours for a million boxes). A tree of [`halved`] is slower to traverse.
const MAX_EQUAL_BOXES: usize = 1000;

impl Tree {
    /// Builds the tree over the `count` triangles of a mesh; `corners` returns the three corner positions of a triangle. Without
    /// triangles, the tree is a root without children.
    pub fn over_triangles(count: usize, corners: impl Fn(usize) -> [Vec3; 3] + Sync) -> Self {
        if count == 0 {
            return Self::empty();
        }
        let triangles = (0..count).into_par_iter().map(|index| {
            let [v0, v1, v2] = corners(index).map(Into::into);
            Triangle { v0, v1, v2 }.aabb()
        });
        let options = if count < MANY {
            TRIANGLES
        } else {
            MANY_TRIANGLES
        };
        Self::over(triangles.collect(), options)
    }

    /// Builds the tree over `boxes`, of which there is at least one.
    fn over(boxes: Vec<Aabb>, options: BvhBuildParams) -> Self {
        if many_are_equal(&boxes) {
            return Self::balanced(&boxes);
        }
        let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
            options.ploc_search_distance,
            &boxes,
            (0..boxes.len() as u32).collect(),
            options.sort_precision,
            options.search_depth_threshold,
        );
        // The conversion takes the most memory, and does not need the boxes.
        drop(boxes);
        let ratio = options.reinsertion_batch_ratio;
        ReinsertionOptimizer::default().run(&mut binary, ratio, None);
        Self::from_built(bvh2_to_cwbvh(
            &binary,
            options.max_prims_per_leaf,
            true,
            false,
        ))
    }

    /// Builds the tree over boxes, each given as (smallest corner, largest corner), such as those of instances. Without
    /// boxes, the tree is a root without children.
    pub fn over_boxes(boxes: &[(Vec3, Vec3)]) -> Self {
        if boxes.is_empty() {
            return Self::empty();
        }
        Self::over(aabbs(boxes), INSTANCES)
    }

    /// Builds the tree over boxes (smallest corner, largest corner) with at most `max_depth` levels of inner nodes, because
    /// the stack of the traversal is limited. If the tree of [`Self::over_boxes`] has more levels, a balanced tree replaces
    /// it, which is slower to traverse. `max_depth` must be at least [`balanced_depth`] of the number of boxes.
    pub fn over_boxes_within(boxes: &[(Vec3, Vec3)], max_depth: u32) -> Self {
        let tree = Self::over_boxes(boxes);
        if tree.depth <= max_depth {
            return tree;
        }
        Self::balanced(&aabbs(boxes))
    }

    /// Builds the eight-wide tree over boxes, those of triangles or of instances, from the binary tree of [`halved`], which
    /// has the minimum number of levels. It is used where the builder of the library `obvhs` is too slow or makes a tree
    /// that is too deep.
    fn balanced(boxes: &[Aabb]) -> Self {
        Self::from_built(bvh2_to_cwbvh(&halved(boxes), 1, true, false))
    }

    /// Returns a tree without primitives, which every ray misses: a root without children.
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

    /// The nodes of this tree, prepared for an array that holds several trees: `first_node` is added to the indices of
    /// children, and `first_primitive` to the indices of primitives.
    pub fn placed(&self, first_node: u32, first_primitive: u32) -> impl Iterator<Item = CwBvhNode> {
        self.nodes.iter().map(move |node| CwBvhNode {
            child_base_idx: node.child_base_idx + first_node,
            primitive_base_idx: node.primitive_base_idx + first_primitive,
            ..*node
        })
    }
}

/// A node of a binary tree over boxes, whose nodes are stored in depth-first order: the first child of an inner node
/// directly follows it in the array. Light BVHs, whose leaves are clusters (lights so close together that they count as
/// one), are made from such trees; no rays are traced through them.
#[derive(Clone, Copy, Debug)]
pub struct BinaryNode {
    /// The smallest x, y and z of the node's box, in the space of the input boxes. The box contains the boxes
    /// of all leaves below the node.
    pub low: Vec3,
    /// The largest x, y and z of the node's box, in the space of the input boxes. The box contains the boxes
    /// of all leaves below the node.
    pub high: Vec3,
    /// The index in the array of the first node after this one that is not its descendant, or the number of nodes if there
    /// is none. A traversal that skips the descendants continues there. For a first child, it is the index of the second
    /// child.
    pub next: u32,
    /// For a leaf, the index of its box in the input, with which the builder of the light BVH finds the lights in the box;
    /// NONE for an inner node.
    pub primitive: u32,
}

/// Builds a binary tree over boxes (smallest corner, largest corner), with one box per leaf, from which a light BVH or
/// its clusters of lights are made. Returns the nodes in depth-first order; there are none without boxes.
pub fn binary_tree(boxes: &[(Vec3, Vec3)]) -> Vec<BinaryNode> {
    if boxes.is_empty() {
        return Vec::new();
    }
    let boxes = aabbs(boxes);
    let built = match many_are_equal(&boxes) {
        true => halved(&boxes),
        false => build_bvh2(&boxes, INSTANCES, &mut Duration::default()),
    };
    let mut nodes: Vec<BinaryNode> = Vec::with_capacity(built.nodes.len());
    // Pairs: a node to be visited and NONE, or 0 and the index of a node whose descendants were all visited.
    let mut stack = vec![(0, NONE)];
    while let Some((index, done)) = stack.pop() {
        if done != NONE {
            nodes[done as usize].next = nodes.len() as u32;
            continue;
        }
        let node: &Bvh2Node = &built.nodes[index];
        let node_index = nodes.len() as u32;
        let mut primitive = NONE;
        if node.is_leaf() {
            primitive = built.primitive_indices[node.first_index as usize];
        } else {
            let first = node.first_index as usize;
            stack.extend([(0, node_index), (first + 1, NONE), (first, NONE)]);
        }
        nodes.push(BinaryNode {
            low: node.aabb().min.into(),
            high: node.aabb().max.into(),
            next: node_index + 1,
            primitive,
        });
    }
    nodes
}

/// True if one and the same box occurs more than [`MAX_EQUAL_BOXES`] times, so that the builder of the library `obvhs` would
/// be too slow. The hashes of the boxes are sorted, because this is faster than counting the boxes in a map.
fn many_are_equal(boxes: &[Aabb]) -> bool {
    if boxes.len() <= MAX_EQUAL_BOXES {
        return false;
    }
    let hasher = BuildHasherDefault::<DefaultHasher>::default();
    let mut hashes: Vec<u64> = boxes
        .par_iter()
        .map(|around| [around.min, around.max].map(|corner| corner.to_array().map(f32::to_bits)))
        .map(|bits| hasher.hash_one(bits))
        .collect();
    hashes.par_sort_unstable();
    let mut pairs = hashes.iter().zip(&hashes[MAX_EQUAL_BOXES..]);
    pairs.any(|(first, last)| first == last)
}

fn aabbs(boxes: &[(Vec3, Vec3)]) -> Vec<Aabb> {
    let boxes = boxes.iter();
    boxes
        .map(|(min, max)| Aabb::new((*min).into(), (*max).into()))
        .collect()
}

/// The maximum number of nodes of an eight-wide tree over `count` boxes, for which the program reserves memory in a moving
/// scene. It is `count` − 1, because each node has at least two children and the boxes themselves need no nodes; but at
/// least 1, for the root.
pub fn max_nodes(count: usize) -> usize {
    count.saturating_sub(1).max(1)
}

/// The maximum number of levels of inner nodes in a balanced eight-wide tree over `count` boxes. For a moving scene, the
/// stack of the traversal has room for at least this number of levels of the tree over the instances.
pub fn balanced_depth(count: usize) -> u32 {
    count.next_power_of_two().ilog2().max(1)
}

/// Builds a binary tree over boxes with the minimum number of levels: the boxes of each inner node are divided into two
/// halves, whose numbers of boxes differ by at most one.
fn halved(boxes: &[Aabb]) -> Bvh2 {
    let mut nodes = vec![Bvh2Node::default()];
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    halve(&mut nodes, 0, boxes, &mut order, 0);
    Bvh2 {
        nodes,
        primitive_indices: order,
        ..Bvh2::default()
    }
}

/// Fills the node `nodes[at]` of a binary tree, and appends all nodes below it to `nodes`. `items` are the indices in
/// `boxes` of the boxes below this node. They are sorted by the centres of their boxes along the longest axis and then
/// halved, one half for each child. `first` is the position of the first item in the order of all leaves.
fn halve(nodes: &mut Vec<Bvh2Node>, at: usize, boxes: &[Aabb], items: &mut [u32], first: u32) {
    let around = |bounds: Aabb, item: &u32| bounds.union(&boxes[*item as usize]);
    let bounds = items.iter().fold(Aabb::empty(), around);
    if items.len() == 1 {
        nodes[at] = Bvh2Node::new(bounds, 1, first);
        return;
    }
    let axis = bounds.largest_axis();
    let middle = |item: &u32| boxes[*item as usize].center()[axis];
    items.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let children = nodes.len();
    nodes.extend([Bvh2Node::default(); 2]);
    nodes[at] = Bvh2Node::new(bounds, 0, children as u32);
    let (low, high) = items.split_at_mut(items.len() / 2);
    halve(nodes, children, boxes, low, first);
    halve(nodes, children + 1, boxes, high, first + low.len() as u32);
}

/// The number of levels of inner nodes in an eight-wide tree, including the root, for [`Tree::depth`]. In `nodes`, a
/// parent must come before its children.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Each box is 1.7 times as large and as far away as the previous one, so that a tree built by the surface area
    /// heuristic has many levels.
    #[test]
    fn a_tree_over_boxes_is_no_deeper_than_it_may_be() {
        for count in [1_usize, 2, 3, 9, 60] {
            let boxes: Vec<(Vec3, Vec3)> = (0..count)
                .map(|i| {
                    let at = Vec3::splat(1.7_f32.powi(i as i32));
                    (at, at * 1.5)
                })
                .collect();
            let most = balanced_depth(count);
            for tree in [
                Tree::over_boxes_within(&boxes, most),
                Tree::balanced(&aabbs(&boxes)),
            ] {
                assert!(tree.depth <= most, "{count}: {}", tree.depth);
                assert!(
                    tree.nodes.len() <= max_nodes(count),
                    "{count}: {}",
                    tree.nodes.len()
                );
                let mut order = tree.order.clone();
                order.sort_unstable();
                assert_eq!(order, (0..count as u32).collect::<Vec<_>>());
            }
        }
    }

    /// The builder works in parallel from thousands of triangles on, and in further steps from half a million on.
    #[test]
    fn a_tree_is_the_same_with_any_number_of_threads() {
        let mut random = crate::base::random::Random::new(7);
        let mut point = |size: f32| {
            let mut unit = || random.index(1 << 20) as f32 / (1 << 20) as f32;
            Vec3::new(unit(), unit(), unit()) * size
        };
        let corners: Vec<[Vec3; 3]> = (0..510_000)
            .map(|_| {
                let at = point(100.0);
                [at, at + point(1.0), at + point(1.0)]
            })
            .collect();
        let built = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let build = || Tree::over_triangles(corners.len(), |index| corners[index]);
            pool.build().unwrap().install(build)
        };
        let expected = built(1);
        for threads in [2, 5] {
            let tree = built(threads);
            let bytes = |tree: &Tree| bytemuck::cast_slice::<_, u8>(&tree.nodes).to_vec();
            assert!(bytes(&tree) == bytes(&expected) && tree.order == expected.order);
        }
    }

    /// A million equal boxes must be built by halving, since the library's builder would take hours.
    #[test]
    fn a_million_equal_triangles_have_a_tree() {
        let mut corners = vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; 1_000_000];
        corners.push([Vec3::Z, Vec3::X, Vec3::Y]);
        let boxes: Vec<(Vec3, Vec3)> = vec![(Vec3::ZERO, Vec3::ONE); 1_000_000];
        for (tree, count) in [
            (
                Tree::over_triangles(corners.len(), |index| corners[index]),
                corners.len(),
            ),
            (Tree::over_boxes(&boxes), boxes.len()),
        ] {
            let mut order = tree.order.clone();
            order.sort_unstable();
            assert!(order.into_iter().eq(0..count as u32));
            assert!(tree.depth <= balanced_depth(count));
        }
        let nodes = binary_tree(&boxes);
        assert_eq!(nodes.len(), 2 * boxes.len() - 1);
        let leaves = nodes.iter().filter(|node| node.primitive != NONE);
        let mut found: Vec<u32> = leaves.map(|leaf| leaf.primitive).collect();
        found.sort_unstable();
        assert!(found.into_iter().eq(0..boxes.len() as u32));
        // From the end, the node after the last descendant is known of both children.
        for (index, node) in nodes.iter().enumerate().rev() {
            let after = match node.primitive {
                NONE => nodes[nodes[index + 1].next as usize].next,
                _ => index as u32 + 1,
            };
            assert_eq!(node.next, after, "{index}");
            assert_eq!((node.low, node.high), (Vec3::ZERO, Vec3::ONE));
        }
    }
}

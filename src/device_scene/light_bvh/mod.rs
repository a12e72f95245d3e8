//! The light BVH, a tree that finds the lights that matter at a point, so that candidates are drawn from these (Gardishyan,
//! "A Better Light Candidate Generation Algorithm for ReSTIR Ray Tracing Using an Acceleration Structure to Identify
//! Relevant Lights", 2025).
//!
//! Lights that are close to each other form a cluster, and a tree is built over the clusters. A *walk* through the tree
//! searches for the lights that matter at one point. It works in one of two ways:
//!
//! - *Boxes of influence*, as published: the box of a cluster is the one around its lights, enlarged on each side by a
//!   radius of `scale` · √power. At this distance, the irradiance from the cluster falls to about 1 / `scale`². The walk
//!   finds the clusters whose boxes contain the point.
//! - *A cut*: the box of a node is the one around its lights, enlarged on each side by `scale` times half the diagonal of
//!   the box. If the enlarged box contains the point, the walk continues with the node's children. Otherwise the node is so
//!   far away that the walk finds all its lights as one. Thus every light is found at every point: near clusters one by one,
//!   far ones in groups.
//!
//! Directional lights and the environment are not in the tree. Rare lights (far dimmer than the others) are not in it either
//! if separate candidates are drawn from them wherever candidates are drawn from the tree. The tree and the clusters are
//! made once; where lights move or change, only boxes and powers are updated.

mod clusters;
pub mod connected;
mod light_sum;
mod scale;
mod visibility;

use super::compute_bvh::binary_tree;
use super::lights::Lights;
use crate::shader_interface::{GpuLightEntry, GpuLightNode, LIGHT_SPOT, NODE_ENTRIES, NONE};
use glam::Vec3;
use light_sum::LightSum;

/// Options for the construction of a light BVH. They decide which lights are in the tree, which of them a walk (the search
/// of the tree for one point) finds, and how likely it is that one of these is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBvhOptions {
    /// The factor that decides how far the box of a node extends beyond the box around its lights. With `cut`, the distance
    /// is scale times half the diagonal of that box; otherwise it is scale · √power, with the power of the lights in the
    /// device's units. With larger boxes, a walk (the search of the tree for one point) finds more lights, or far lights in
    /// smaller groups, and takes longer. `None`: it is 1 with `cut`; otherwise it is chosen so that a point on a surface is
    /// in about eight boxes, or in fewer if there are at most ten clusters.
    pub scale: Option<f32>,
    /// True if a walk (the search of the tree for one point) finds all lights at every point: near clusters one by one, and
    /// far clusters joined in groups. False if it finds only the clusters whose boxes of influence contain the point.
    pub cut: bool,
    /// True if lights that are close to each other form one cluster, that is, one leaf of the tree, so that a walk finds all
    /// of them or none. False if each light is a separate cluster.
    pub clusters: bool,
    /// True if lights are drawn in proportion to their power from the node that a walk (the search of the tree for one
    /// point) has selected. False if all lights that the walk finds are equally likely.
    pub by_power: bool,
    /// True to leave rare lights (far dimmer than the others) out of the tree, false to include them like other lights. Leave
    /// them out only if all passes that draw candidates from the tree also draw separate candidates from the rare lights;
    /// otherwise the picture loses the light of the rare ones.
    pub leaves_out_rare: bool,
}

impl LightBvhOptions {
    /// True if [`LightBvh::new`] needs points on the scene's surfaces, from which it chooses the scale of the
    /// boxes of influence (a cluster is not found at points outside of its box). This is the case if `scale`
    /// is `None` and `cut` is false.
    pub fn needs_surfaces(&self) -> bool {
        self.scale.is_none() && !self.cut
    }
}

/// A light with a position, in the device's world space and units; directional lights and the environment have none. The
/// tree can contain only such lights. Its clusters, boxes and powers are computed from a list of these values.
#[derive(Clone, Copy, Debug)]
pub struct NearLight {
    /// The index of the light among the lights of all kinds: triangles first, then punctual lights. Shaders
    /// find the light by it.
    pub index: u32,
    /// The number of the group to which the light belongs. Emissive triangles that are connected by common corners have the
    /// same number, and each other light has its own. When clusters are made, the triangles of a group stay together if the
    /// sum of their areas is large enough for the box around them.
    pub group: u32,
    /// The smallest x, y and z of the box around the light, in the device's world space. The boxes of
    /// clusters and nodes are computed from it.
    pub low: Vec3,
    /// The largest x, y and z of the box around the light, in the device's world space. The boxes of clusters
    /// and nodes are computed from it.
    pub high: Vec3,
    /// The unit normal, in world space, of the half space into which a one-sided triangle or a spot emits; zero for other
    /// lights, which emit into all directions.
    pub normal: Vec3,
    /// The light's entry of [`Lights::powers`]: its power divided by π, in the device's units of radiance × squared length.
    /// For a triangle, it is area × luminance, doubled if both sides emit, as in [`crate::scene::lights::power`]. The radius
    /// of the box of influence follows from it and, with [`LightBvhOptions::by_power`], the weight of the light in draws.
    pub power: f64,
    /// The area of the light, in the square of the device's unit of length; 0 for a punctual light. Lights at different
    /// places form a cluster only if the sum of their areas is at least a fixed fraction of the squared diagonal of the box
    /// around them.
    pub area: f64,
}

impl NearLight {
    /// The lights of a scene that the tree contains, in the order of their indices: all that have a position, but without
    /// rare lights if `options` leave these out. `groups` lists the group of each emissive triangle, as [`connected`]
    /// returns it. If it is empty, each light is a separate group.
    ///
    /// [`connected`]: connected::connected
    fn of(lights: &Lights, groups: &[u32], options: LightBvhOptions) -> Vec<Self> {
        let triangles = lights.triangles.iter().map(|light| {
            let corners = [
                light.corner,
                light.corner + light.edge1,
                light.corner + light.edge2,
            ];
            let normal = match light.double_sided {
                0 => light.normal,
                _ => Vec3::ZERO,
            };
            let low = corners[0].min(corners[1]).min(corners[2]);
            let high = corners[0].max(corners[1]).max(corners[2]);
            (low, high, normal, f64::from(light.area))
        });
        let punctual = lights.punctual.iter().map(|light| {
            let normal = match light.kind {
                LIGHT_SPOT => light.direction,
                _ => Vec3::ZERO,
            };
            (light.position, light.position, normal, 0.0)
        });
        let all = triangles.chain(punctual).zip(&lights.powers);
        (all.enumerate())
            .filter(|(index, _)| !lights.is_distant(*index))
            .filter(|(index, _)| !(options.leaves_out_rare && lights.is_rare(*index)))
            .map(|(index, ((low, high, normal, area), power))| Self {
                index: index as u32,
                group: groups.get(index).copied().unwrap_or(index as u32),
                low,
                high,
                normal,
                power: *power,
                area,
            })
            .collect()
    }
}

/// The data that shaders read from a light BVH, computed for the lights at one time. With it, shaders find the lights that
/// matter at a point, and draw light candidates from these lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBvhContents {
    /// The nodes of the tree in depth-first order, with their current boxes and powers. Shaders walk through
    /// them to find the lights that matter at a point.
    pub nodes: Vec<GpuLightNode>,
    /// Two arrays in one: entry `i` has element `i` of both. The first (fields `light` and `before`) lists the lights of the
    /// tree in the order of its leaves. `before` is the sum of the integer weights of all lights before this one; one more
    /// element has the total. Shaders use these sums to draw a light of a node. The second (fields `leaf` and `index`) has
    /// one element per light of the scene, of any kind. `leaf` is the index in `nodes` of the leaf that contains the light
    /// (NONE if the tree lacks it), and `index` is the light's index in the first array. Shaders use both to compute the
    /// probability with which the light is drawn.
    pub entries: Vec<GpuLightEntry>,
}

const _: () =
    assert!(size_of::<GpuLightNode>() == NODE_ENTRIES as usize * size_of::<GpuLightEntry>());

impl LightBvhContents {
    /// The content of the device buffer `light_bvh`, in groups of four words: the nodes, five groups each, then the entries,
    /// one group each.
    pub fn words(&self) -> Vec<[u32; 4]> {
        let nodes: &[[u32; 4]] = bytemuck::cast_slice(&self.nodes);
        [nodes, bytemuck::cast_slice(&self.entries)].concat()
    }
}

/// A node that a walk (the search of the tree for one point) has visited. The visits are counted to choose
/// [`LightBvh::scale`]: it depends on how many clusters have boxes that contain the point.
#[derive(Clone, Copy, Debug)]
pub struct Visit {
    /// True if the point for which the walk searches is inside the node's box, which extends beyond the
    /// node's lights. Otherwise the walk skips the node's descendants.
    pub inside: bool,
    /// True if the node is a cluster of lights, which has no child nodes. Only clusters are counted when the scale is
    /// chosen.
    pub is_leaf: bool,
}

/// The nodes that a walk (the search of the tree for `point`) visits, in depth-first order. A node whose box does not
/// contain the point is visited, but its descendants are skipped. Shaders do the same search
/// (`glsl/lights/samplers/light_bvh/light_bvh.glsl`); here, the visited nodes are only counted. `point` is in the device's
/// world space.
pub fn walk(nodes: &[GpuLightNode], point: Vec3) -> impl Iterator<Item = Visit> {
    let mut next = 0;
    std::iter::from_fn(move || {
        let node = nodes.get(next as usize)?;
        let inside = point.cmpge(node.low).all() && point.cmple(node.high).all();
        let is_leaf = node.next == next + 1;
        next = if inside { next + 1 } else { node.next };
        Some(Visit { inside, is_leaf })
    })
}

/// The light BVH of a scene: clusters of its lights, and a tree over them. It stays on the host. When lights
/// move or change, [`LightBvh::contents`] computes the data for shaders again from it.
pub struct LightBvh {
    options: LightBvhOptions,
    /// The factor that decides how far the box of a node extends beyond the box around its lights. With
    /// [`LightBvhOptions::cut`], the distance is scale times half the diagonal of that box; otherwise it is scale · √power,
    /// with the power of the lights in the device's units.
    pub scale: f32,
    /// The lights in the order of the tree's leaves, each as its index in the list that [`NearLight::of`] makes. The lights
    /// of a node are consecutive here.
    order: Vec<u32>,
    tree: Vec<Topology>,
    /// For each node, the distances, in the device's unit of length, by which its box of influence extends beyond the box
    /// around its lights: first towards −x, −y and −z, then towards +x, +y and +z. Rays measure them for clusters with power
    /// ([`LightBvh::limit`]). `None` for other nodes, and if no rays were traced; the box then follows from power or from
    /// the child nodes.
    margins: Vec<Option<(Vec3, Vec3)>>,
}

/// The part of a node that stays the same when lights move or change: its place in the tree, and its lights. The node's box
/// and power are computed from these lights in their current state.
#[derive(Clone, Copy)]
struct Topology {
    /// The index of the node after the last descendant of this node, at which a walk (the search of the tree
    /// for one point) continues if it skips the descendants.
    next: u32,
    is_leaf: bool,
    /// The index in [`LightBvh::order`] of the node's first light. The node's other lights follow it there.
    first: u32,
    /// The number of lights in the node and its descendants. With `first`, it gives the node's lights in
    /// [`LightBvh::order`].
    count: u32,
}

/// The value of [`LightBvh::scale`] with [`LightBvhOptions::cut`] if [`LightBvhOptions::scale`] is `None`.
/// With this value, the box around a node's lights is enlarged on each side by half its diagonal. If the
/// enlarged box contains the point of a walk (the search of the tree for one point), the walk continues with
/// the node's children. A larger value divides far lights into smaller groups. Each group then has a more
/// exact estimate of the light that arrives at the point, but walks take longer.
const CUT_SCALE: f32 = 1.0;

impl LightBvh {
    /// Builds the light BVH for `lights`. `groups` lists the group of each emissive triangle, as
    /// [`connected`](connected::connected) returns it. `surfaces` lists points on the scene's surfaces in the device's world
    /// space, from which [`LightBvh::scale`] is chosen. They are used only if [`LightBvhOptions::needs_surfaces`] is true;
    /// otherwise the list may be empty.
    pub fn new(
        lights: &Lights,
        groups: &[u32],
        surfaces: &[Vec3],
        options: LightBvhOptions,
    ) -> Self {
        let near = NearLight::of(lights, groups, options);
        let clusters = match options.clusters {
            true => clusters::clusters(&near),
            false => (0..near.len() as u32).map(|light| vec![light]).collect(),
        };
        let made = |scale: f32| Self::with_scale(&near, &clusters, options, scale);
        match (options.scale, options.cut) {
            (Some(scale), _) => made(scale),
            (None, true) => made(CUT_SCALE),
            (None, false) => {
                // The boxes decide the tree, and the tree the time it takes to find the scale.
                let scale = scale::fitting(&mut made(1.0), &near, surfaces);
                made(scale)
            }
        }
    }

    fn with_scale(
        near: &[NearLight],
        clusters: &[Vec<u32>],
        options: LightBvhOptions,
        scale: f32,
    ) -> Self {
        let boxes: Vec<(Vec3, Vec3)> = (clusters.iter())
            .map(|cluster| {
                let sum = LightSum::of(cluster.iter().map(|light| &near[*light as usize]));
                match options.cut {
                    true => (sum.low, sum.high),
                    false => sum.influence(scale),
                }
            })
            .map(|(low, high)| {
                if low.x > high.x {
                    (Vec3::ZERO, Vec3::ZERO)
                } else {
                    (low, high)
                }
            })
            .collect();
        let nodes = binary_tree(&boxes);
        let mut order = Vec::with_capacity(near.len());
        let mut tree: Vec<Topology> = (nodes.iter())
            .map(|node| {
                let first = order.len() as u32;
                if node.primitive != NONE {
                    order.extend(&clusters[node.primitive as usize]);
                }
                Topology {
                    next: node.next,
                    is_leaf: node.primitive != NONE,
                    first,
                    count: order.len() as u32 - first,
                }
            })
            .collect();
        for index in (0..tree.len()).rev() {
            if !tree[index].is_leaf {
                let left = tree[index + 1];
                tree[index].count = left.count + tree[left.next as usize].count;
            }
        }
        Self {
            options,
            scale,
            order,
            tree,
            margins: vec![None; nodes.len()],
        }
    }

    /// The lights of a node and of its descendants, from which the node's box and power are computed. Each light is given by
    /// its index in the list that [`NearLight::of`] makes.
    fn lights_of(&self, node: &Topology) -> &[u32] {
        &self.order[node.first as usize..][..node.count as usize]
    }

    /// The number of lights in the tree, for the log. Lights without a position are not counted, nor are rare lights that
    /// the tree leaves out.
    pub fn light_count(&self) -> usize {
        self.order.len()
    }

    /// The number of clusters of lights, which are the leaves of the tree. With at most ten clusters, [`LightBvh::scale`] is
    /// chosen for a smaller mean number of boxes around a surface point: three quarters of the number of clusters.
    pub fn cluster_count(&self) -> usize {
        self.tree.iter().filter(|node| node.is_leaf).count()
    }

    /// The data that shaders read, for the current state of the lights. `lights` must have the lights from which the tree
    /// was built, in the same order; their positions and powers may differ.
    pub fn contents(&self, lights: &Lights) -> LightBvhContents {
        // Clusters are made, so groups do not matter any more.
        let near = NearLight::of(lights, &[], self.options);
        let nodes = self.nodes(&near);
        let weights = self.order.iter().map(|light| match self.options.by_power {
            true => near[*light as usize].power,
            false => 1.0,
        });
        let bounds = integer_sums(&weights.collect::<Vec<_>>());
        let nowhere = GpuLightEntry {
            light: NONE,
            leaf: NONE,
            ..Default::default()
        };
        // The tree contains at most all lights, and one more entry has the total of the weights.
        let mut entries = vec![nowhere; lights.choices.len() + 1];
        for (entry, before) in entries.iter_mut().zip(bounds) {
            entry.before = before;
        }
        for (leaf, node) in self
            .tree
            .iter()
            .enumerate()
            .filter(|(_, node)| node.is_leaf)
        {
            for index in node.first..node.first + node.count {
                let light = near[self.order[index as usize] as usize].index;
                entries[index as usize].light = light;
                let own = &mut entries[light as usize];
                (own.leaf, own.index) = (leaf as u32, index);
            }
        }
        LightBvhContents { nodes, entries }
    }

    /// The nodes of the tree in depth-first order, as shaders read them. Boxes and powers are computed from `near`, the list
    /// that [`NearLight::of`] makes of the lights in their current state.
    fn nodes(&self, near: &[NearLight]) -> Vec<GpuLightNode> {
        let mut sums = vec![LightSum::NOTHING; self.tree.len()];
        let mut nodes = vec![GpuLightNode::default(); self.tree.len()];
        // Children come after their parents.
        for (index, node) in self.tree.iter().enumerate().rev() {
            let children = (!node.is_leaf).then(|| [index + 1, self.tree[index + 1].next as usize]);
            let sum = match children {
                Some([left, right]) => sums[left].and(&sums[right]),
                None => {
                    let own = self.lights_of(node).iter();
                    LightSum::of(own.map(|light| &near[*light as usize]))
                }
            };
            let (low, high) = match (self.options.cut, children) {
                (true, _) => sum.surroundings(self.scale),
                (false, None) => match self.margins[index] {
                    Some((down, up)) if sum.power > 0.0 => (sum.low - down, sum.high + up),
                    _ => sum.influence(self.scale),
                },
                (false, Some([left, right])) => (
                    nodes[left].low.min(nodes[right].low),
                    nodes[left].high.max(nodes[right].high),
                ),
            };
            let normal = match sum.power > 0.0 {
                true => (sum.normal / sum.power).as_vec3(),
                false => Vec3::ZERO,
            };
            nodes[index] = GpuLightNode {
                low,
                next: node.next,
                high,
                first: node.first,
                center: 0.5 * (sum.low + sum.high),
                weight: match self.options.by_power {
                    true => sum.power as f32,
                    false => node.count as f32,
                },
                normal,
                size: 0.5 * (sum.high - sum.low).length(),
                count: node.count,
                facing: normal.length().min(1.0),
                ..Default::default()
            };
            sums[index] = sum;
        }
        nodes
    }
}

/// The sums by which shaders draw lights: for each of the lights' `weights`, the sum of the weights before it, and at the
/// end the sum of all weights. The sums are scaled and rounded to strictly increasing integers below 2³². To draw a light
/// from a node, shaders take a random integer between the sums at the two ends of the node's lights. A light is drawn if the
/// integer is at least its own sum and below the next sum, so its probability is about in proportion to its weight.
fn integer_sums(weights: &[f64]) -> Vec<u32> {
    let total: f64 = weights.iter().sum();
    let room = f64::from(u32::MAX) - 1.0 - weights.len() as f64;
    let (mut sum, mut index) = (0.0, 0.0);
    let mut sums = vec![0];
    for weight in weights {
        sum += if total > 0.0 { weight / total } else { 0.0 };
        index += 1.0;
        sums.push((sum.min(1.0) * room + index) as u32);
    }
    sums
}

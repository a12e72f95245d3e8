//! The light BVH, a tree from which lights are drawn that matter at a point (Gardishyan, "A Better Light Candidate
//! Generation Algorithm for ReSTIR Ray Tracing Using an Acceleration Structure to Identify Relevant Lights", 2025).
//!
//! Lights that are close to each other form a cluster, and a tree is built over the clusters. A walk through it finds the
//! lights that matter at a point, in one of two ways:
//!
//! - *Boxes of influence*, as published: the box of a cluster is the one around its lights, enlarged by a radius of `scale`
//!   · √power. At this distance, its irradiance falls to about 1 / `scale`². The walk finds the clusters whose boxes hold
//!   the point.
//! - *A cut*: the box of a node is the one around its lights, enlarged by `scale` times half its diagonal. Where it holds
//!   the point, the walk goes on to the node's children; elsewhere the node is so far away that the walk finds all its
//!   lights as one. Thus every light is found at every point: near clusters one by one, far ones in groups.
//!
//! The tree does not contain directional lights and the environment. It contains no rare lights if every user of the tree
//! samples them separately. The tree and the clusters are made once; where lights move or change, only the boxes are
//! updated.

mod clusters;
pub mod connected;
mod scale;
mod visibility;

use super::compute_bvh::binary_tree;
use super::lights::Lights;
use crate::shader_interface::{GpuLightEntry, GpuLightNode, LIGHT_SPOT, NODE_ENTRIES, NONE};
use glam::{DVec3, Vec3};

/// Options for the construction of a light BVH.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBvhOptions {
    /// The factor by which boxes are enlarged beyond their lights; with `None`, the construction chooses one. With larger
    /// boxes a walk finds more lights at a point, or finds far lights in smaller groups, and takes longer.
    pub scale: Option<f32>,
    /// True if a walk finds all lights at every point: near clusters one by one, and far ones joined in groups (a cut of the
    /// tree). False if it finds only the clusters whose boxes of influence hold the point.
    pub cut: bool,
    /// True if lights that are close to each other form clusters; false if each light is a separate cluster.
    pub clusters: bool,
    /// True if the lights of a node are drawn in proportion to their power; false if they are drawn uniformly.
    pub by_power: bool,
    /// True if the tree contains no rare lights (far dimmer than the others), because they have separate candidates.
    pub leaves_out_rare: bool,
}

impl LightBvhOptions {
    /// True if [`LightBvh::new`] needs points on surfaces, from which it chooses the scale of boxes of influence.
    pub fn needs_surfaces(&self) -> bool {
        self.scale.is_none() && !self.cut
    }
}

/// A light at a finite distance, which the tree can contain, in the device's units.
#[derive(Clone, Copy, Debug)]
pub struct NearLight {
    /// The index of the light among the lights of all kinds.
    pub index: u32,
    /// The index of the group of connected lights: equal for triangles that are connected by common corners.
    pub group: u32,
    /// The smallest x, y and z of the light's box.
    pub low: Vec3,
    /// The largest x, y and z of the light's box.
    pub high: Vec3,
    /// The unit direction of the half space into which a one-sided triangle or a spot emits; zero for other lights.
    pub normal: Vec3,
    /// The power of the light divided by π: area × luminance for a triangle, as in [`crate::scene::lights::power`].
    pub power: f64,
    /// The area of the light; 0 for a punctual light.
    pub area: f64,
}

impl NearLight {
    /// The lights of a scene that the tree contains, in the order of their indices. `groups` has the group of each triangle
    /// ([`connected`]); if it is empty, each light is a separate group.
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

/// The data of a light BVH that shaders read, for the lights at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBvhContents {
    /// The nodes of the tree in depth-first order, with their current boxes and powers.
    pub nodes: Vec<GpuLightNode>,
    /// Two arrays that share their index. The first one (`light`, `before`) has the lights in the order of the leaves, and
    /// one more entry after the last light. The second one (`leaf`, `index`) has the place of each light in the tree, by
    /// index among the lights of all kinds.
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

/// A node that a walk through the tree looks at.
#[derive(Clone, Copy, Debug)]
pub struct Visit {
    /// True if the box of the node holds the point of the walk.
    pub inside: bool,
    /// True if the node is a cluster, so that it has no children.
    pub is_leaf: bool,
}

/// The nodes that a walk for `point` visits, in order, as in `glsl/lights/samplers/light_bvh/light_bvh.glsl`. A node whose
/// box does not hold the point is visited, but its descendants are skipped.
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

/// The light BVH of a scene: clusters of its lights, and a tree over them.
pub struct LightBvh {
    options: LightBvhOptions,
    /// The factor by which boxes are enlarged beyond their lights.
    pub scale: f32,
    /// Indices of lights in the order of the tree's leaves, as positions in the list that [`NearLight::of`] makes.
    order: Vec<u32>,
    tree: Vec<Topology>,
    /// For each node, the distances by which its box of influence extends beyond its lights in the negative and in the
    /// positive directions, as rays have measured them; `None` if no ray has.
    margins: Vec<Option<(Vec3, Vec3)>>,
}

/// The part of a node that stays the same when lights move or change.
#[derive(Clone, Copy)]
struct Topology {
    /// The index of the node after its last descendant.
    next: u32,
    is_leaf: bool,
    /// The position in `order` of the node's first light; `count` lights follow from there.
    first: u32,
    /// The number of the node's lights.
    count: u32,
}

/// The scale of a cut of the tree, if the options set none. A walk goes on to a node's children if the point is closer to
/// the node's box than this scale times half the diagonal of the box. A larger scale draws lights more precisely, and makes
/// walks longer.
const CUT_SCALE: f32 = 1.0;

impl LightBvh {
    /// Builds the light BVH. `groups` has the group of each emissive triangle ([`connected`](connected::connected)), and
    /// `surfaces` has points on surfaces, from which the scale of boxes of influence is chosen if the options leave it open.
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

    /// The lights of a node, as positions in the list that [`NearLight::of`] makes.
    fn lights_of(&self, node: &Topology) -> &[u32] {
        &self.order[node.first as usize..][..node.count as usize]
    }

    /// The number of lights in the tree.
    pub fn light_count(&self) -> usize {
        self.order.len()
    }

    /// The number of clusters of lights, which are the leaves of the tree.
    pub fn cluster_count(&self) -> usize {
        self.tree.iter().filter(|node| node.is_leaf).count()
    }

    /// The data that shaders read, for the current state of the lights. Their number must be the same as in the
    /// construction.
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
        // The BVH has at most all lights, and one entry ends the last.
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

    /// The nodes of the tree, with boxes and powers for the current state `near` of its lights.
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

/// For each weight, the sum of the weights before it, and at the end the sum of all weights. The sums are scaled to strictly
/// increasing integers below 2³². Shaders draw an entry by a random integer between two of these sums, so the differences
/// are in proportion to the probabilities.
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

/// A box (min, max) that holds no point: the neutral element of the union of boxes.
const NOWHERE: (Vec3, Vec3) = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// The union of the boxes of some lights, and the sums of their powers and of their normals. Boxes of nodes are made from
/// it.
#[derive(Clone, Copy)]
struct LightSum {
    low: Vec3,
    high: Vec3,
    power: f64,
    /// The sum of the lights' normals, each times its power.
    normal: DVec3,
}

impl LightSum {
    const NOTHING: Self = Self {
        low: NOWHERE.0,
        high: NOWHERE.1,
        power: 0.0,
        normal: DVec3::ZERO,
    };

    fn of<'a>(lights: impl Iterator<Item = &'a NearLight>) -> Self {
        lights.fold(Self::NOTHING, |sum, light| {
            sum.and(&Self {
                low: light.low,
                high: light.high,
                power: light.power,
                normal: light.power * light.normal.as_dvec3(),
            })
        })
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            power: self.power + other.power,
            normal: self.normal + other.normal,
        }
    }

    /// The box of influence (min, max), outside of which the lights contribute little; it holds no point if they have no
    /// power.
    fn influence(&self, scale: f32) -> (Vec3, Vec3) {
        if self.power == 0.0 {
            return NOWHERE;
        }
        let radius = Vec3::splat(Self::radius(self.power, scale));
        (self.low - radius, self.high + radius)
    }

    /// The distance in the device's units by which the box of influence extends beyond lights with this total power.
    fn radius(power: f64, scale: f32) -> f32 {
        scale * power.sqrt() as f32
    }

    /// For a cut of the tree, the box (min, max) of a node with these lights. Where the box holds the point, a walk goes on
    /// to the node's children; elsewhere it takes the lights as one.
    fn surroundings(&self, scale: f32) -> (Vec3, Vec3) {
        let radius = Vec3::splat(scale * 0.5 * (self.high - self.low).length());
        (self.low - radius, self.high + radius)
    }
}

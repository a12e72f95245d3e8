//! The light BVH, which finds the lights that matter at a point (Gardishyan, "A Better Light Candidate Generation Algorithm for
//! ReSTIR Ray Tracing Using an Acceleration Structure to Identify Relevant Lights", 2025).
//!
//! Lights that are close to each other form a cluster, and a tree is built over the clusters. A walk through it finds those
//! that matter at a point, in one of two ways:
//!
//! - *Boxes of influence*, as published: each cluster has a box, the one around its lights enlarged by a radius of `scale` ·
//!   √power, at whose distance its irradiance falls to about 1 / `scale`². Clusters whose boxes hold the point are found.
//! - *A cut*: the box of a node is the one around its lights, enlarged by `scale` times its size. Where it holds the point,
//!   its children are looked at one by one; elsewhere it is so far away that its lights are found as one. Every light is in
//!   the cut at every point, near ones by themselves and far ones in company.
//!
//! Directional lights and the environment are not in the tree, nor are rare lights if every user of the tree samples them
//! separately. The tree and the clusters are made once; where lights move or change, the boxes follow.

mod clusters;
pub mod connected;
mod scale;
mod visibility;

use super::compute_bvh::binary_tree;
use super::lights::Lights;
use crate::shader_interface::{GpuLightEntry, GpuLightNode, LIGHT_SPOT, NODE_ENTRIES, NONE};
use glam::{DVec3, Vec3};

/// Options of the construction of a light BVH.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBvhOptions {
    /// The scale of boxes; `None`: a scale that suits the scene.
    pub scale: Option<f32>,
    /// True if points find a cut of the tree; otherwise they find the clusters whose boxes of influence hold them.
    pub cut: bool,
    /// True if lights that are close to each other form clusters; otherwise each light is a cluster.
    pub clusters: bool,
    /// True if the lights of a node are drawn by their power; otherwise uniformly.
    pub by_power: bool,
    /// True if rare lights are left out, because they have separate candidates.
    pub leaves_out_rare: bool,
}

impl LightBvhOptions {
    /// True if the construction needs points on surfaces.
    pub fn needs_surfaces(&self) -> bool {
        self.scale.is_none() && !self.cut
    }
}

/// A light at a finite distance, in the device's units.
#[derive(Clone, Copy, Debug)]
pub struct NearLight {
    /// The index among the lights of all kinds.
    pub index: u32,
    /// The index of the light's group: equal for triangles that are connected by common corners.
    pub group: u32,
    /// The smallest coordinates of the light.
    pub low: Vec3,
    /// The largest coordinates of the light.
    pub high: Vec3,
    /// The direction into which it emits; zero if it emits in all directions or to both sides.
    pub normal: Vec3,
    /// Area × luminance, as in [`crate::scene::lights::power`].
    pub power: f64,
    /// Area; 0 for a punctual light.
    pub area: f64,
}

impl NearLight {
    /// The lights of a scene that the tree holds, in the order of their indices. `groups` are those of triangles
    /// ([`connected`]).
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

/// The data of a light BVH that shaders read, for lights at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBvhContents {
    /// The tree, in depth-first order.
    pub nodes: Vec<GpuLightNode>,
    /// The lights of its leaves, in leaf order, with one more entry that ends the last leaf; and for the lights of all kinds,
    /// by index, their location in both arrays.
    pub entries: Vec<GpuLightEntry>,
}

const _: () =
    assert!(size_of::<GpuLightNode>() == NODE_ENTRIES as usize * size_of::<GpuLightEntry>());

impl LightBvhContents {
    /// The content of the buffer: the nodes, then the entries, in four words each.
    pub fn words(&self) -> Vec<[u32; 4]> {
        let nodes: &[[u32; 4]] = bytemuck::cast_slice(&self.nodes);
        [nodes, bytemuck::cast_slice(&self.entries)].concat()
    }
}

/// A node on a walk.
#[derive(Clone, Copy, Debug)]
pub struct Visit {
    /// True if its box holds the point.
    pub inside: bool,
    /// True if the node has no children.
    pub is_leaf: bool,
}

/// The nodes that a walk visits at a point, as in `glsl/lights/samplers/light_bvh/light_bvh.glsl`. A node whose box does not
/// hold the point is visited, but its descendants are skipped.
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

/// Clusters of a scene's lights, and a tree over them.
pub struct LightBvh {
    options: LightBvhOptions,
    /// The factor of the sizes of boxes.
    pub scale: f32,
    /// Indices into the near lights, in the order of the tree's leaves.
    order: Vec<u32>,
    tree: Vec<Topology>,
    /// The distances by which the box of influence of each node extends beyond its lights, downwards and upwards, if rays have
    /// measured them.
    margins: Vec<Option<(Vec3, Vec3)>>,
}

/// The constant part of a node.
#[derive(Clone, Copy)]
struct Topology {
    /// The index of the node after its last descendant.
    next: u32,
    is_leaf: bool,
    /// The range of its lights in `order`.
    first: u32,
    count: u32,
}

/// The scale of a cut: a node is opened up to this many times half its diagonal from it.
const CUT_SCALE: f32 = 1.0;

impl LightBvh {
    /// Builds the light BVH for lights, the groups of those that are triangles ([`connected`](connected::connected)), and
    /// points on surfaces, from which the scale of boxes of influence follows.
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

    /// The lights of a node, as indices into the near lights.
    fn lights_of(&self, node: &Topology) -> &[u32] {
        &self.order[node.first as usize..][..node.count as usize]
    }

    /// Number of lights in clusters.
    pub fn light_count(&self) -> usize {
        self.order.len()
    }

    /// Number of clusters.
    pub fn cluster_count(&self) -> usize {
        self.tree.iter().filter(|node| node.is_leaf).count()
    }

    /// The data that shaders read, for the lights at any time.
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

    /// The tree, with boxes for lights at any time.
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

/// The sum of all weights before each entry, and of all weights, as increasing integers; the last one is below 2³².
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

/// A box that holds no point.
const NOWHERE: (Vec3, Vec3) = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// Sums over lights.
#[derive(Clone, Copy)]
struct LightSum {
    low: Vec3,
    high: Vec3,
    power: f64,
    /// The sum of normals, weighted by power.
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

    /// The box of influence; empty without power.
    fn influence(&self, scale: f32) -> (Vec3, Vec3) {
        if self.power == 0.0 {
            return NOWHERE;
        }
        let radius = Vec3::splat(Self::radius(self.power, scale));
        (self.low - radius, self.high + radius)
    }

    /// The radius of influence of lights with some power.
    fn radius(power: f64, scale: f32) -> f32 {
        scale * power.sqrt() as f32
    }

    /// The box inside of which the lights are visited one by one.
    fn surroundings(&self, scale: f32) -> (Vec3, Vec3) {
        let radius = Vec3::splat(scale * 0.5 * (self.high - self.low).length());
        (self.low - radius, self.high + radius)
    }
}

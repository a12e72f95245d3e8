//! Boxes of influence that follow what the lights see (algorithm 4 of the publication): rays from each cluster's lights tell
//! how far its light goes.

use super::{LightBvh, LightSum, NearLight};
use crate::layouts::{LIGHT_SPOT, RayQuery};
use crate::random::Random;
use crate::tracing::lights::Lights;
use glam::Vec3;
use std::f32::consts::TAU;

/// Rays of each cluster.
const RAYS: u32 = 256;
/// Where a ray starts off its light: this share of the coordinates' size, which is some of their rounding errors.
const OFFSET: f32 = 4e-6;

/// Rays from lights, in the device's units.
pub struct Probes {
    /// With unit directions, to the radius of influence.
    pub rays: Vec<RayQuery>,
    /// For each of them the node.
    leaves: Vec<u32>,
}

impl LightBvh {
    /// The rays that tell what the clusters' lights see; those that light something, from points on them, uniform by area in a
    /// light and equal among lights.
    pub fn probes(&self, lights: &Lights) -> Probes {
        let near = NearLight::of(lights, &[]);
        let mut random = Random::new(0);
        let mut probes = Probes {
            rays: Vec::new(),
            leaves: Vec::new(),
        };
        for (leaf, node) in (0..).zip(&self.tree).filter(|(_, node)| node.is_leaf) {
            let own = &self.order[node.first as usize..][..node.count as usize];
            let power = own.iter().map(|index| near[*index as usize].power);
            let radius = LightSum::radius(power.sum(), self.scale);
            for _ in 0..if radius > 0.0 { RAYS } else { 0 } {
                let light = near[random.pick(own) as usize].index as usize;
                let (position, axis) = point(lights, light, &mut random);
                let mut direction = direction(&mut random);
                if direction.dot(axis) < 0.0 {
                    direction = -direction;
                }
                let clear = OFFSET * position.abs().max_element();
                probes.rays.push(RayQuery {
                    origin: position + clear * direction,
                    t_max: radius,
                    direction,
                    any: 0,
                });
                probes.leaves.push(leaf);
            }
        }
        probes
    }

    /// Limits boxes to the points that rays reached, given for each of `probes` its parameter, or less than 0 for a miss.
    pub fn limit(&mut self, lights: &Lights, probes: &Probes, reached: &[f32]) {
        let near = NearLight::of(lights, &[]);
        let mut margins = vec![(Vec3::ZERO, Vec3::ZERO); self.tree.len()];
        let sum_of = |node: &super::Topology| {
            let own = &self.order[node.first as usize..][..node.count as usize];
            LightSum::of(own.iter().map(|index| &near[*index as usize]))
        };
        let sums: Vec<LightSum> = self.tree.iter().map(sum_of).collect();
        for ((ray, leaf), t) in probes.rays.iter().zip(&probes.leaves).zip(reached) {
            let t = if *t < 0.0 { ray.t_max } else { *t };
            let point = ray.origin + t * ray.direction;
            let (sum, margin) = (&sums[*leaf as usize], &mut margins[*leaf as usize]);
            margin.0 = margin.0.max(sum.low - point);
            margin.1 = margin.1.max(point - sum.high);
        }
        self.margins = Some(margins);
    }
}

/// A point of a light, by its index among all, and the normal of the half space that it lights; zero if that is all.
fn point(lights: &Lights, index: usize, random: &mut Random) -> (Vec3, Vec3) {
    if let Some(light) = lights.triangles.get(index) {
        let root = random.unit().sqrt();
        let across = random.unit() * root;
        let position = light.corner + (root - across) * light.edge1 + across * light.edge2;
        return match light.double_sided {
            0 => (position, light.normal),
            _ => (position, Vec3::ZERO),
        };
    }
    let light = &lights.punctual[index - lights.triangles.len()];
    match light.kind {
        LIGHT_SPOT => (light.position, light.direction),
        _ => (light.position, Vec3::ZERO),
    }
}

/// A direction, uniform over the sphere.
fn direction(random: &mut Random) -> Vec3 {
    let z = random.between(-1.0, 1.0);
    let (sine, cosine) = (TAU * random.unit()).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cosine, radius * sine, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::procedural;
    use crate::tracing::Units;
    use crate::tracing::light_bvh::LightBvhOptions;
    use crate::tracing::lights::gpu_lights;
    use glam::DVec3;

    #[test]
    fn boxes_end_where_rays_do() {
        let scene = procedural::generate("colourful-mess", &[]).unwrap();
        let lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
        let options = LightBvhOptions {
            scale: Some(2.0),
            cut: false,
            clusters: true,
            by_power: true,
        };
        let mut bvh = LightBvh::new(&lights, &[], &[], options);
        let simple = bvh.contents(&lights).nodes;
        let probes = bvh.probes(&lights);
        assert_eq!(probes.rays.len(), RAYS as usize * bvh.cluster_count());
        // Some rays end at once, the others go all the way.
        let reached: Vec<f32> = (probes.rays.iter())
            .map(|ray| if ray.direction.y > 0.0 { 0.0 } else { -1.0 })
            .collect();
        bvh.limit(&lights, &probes, &reached);
        let leaves = (1..).zip(&simple).map(|(next, node)| node.next == next);
        let nodes = bvh.contents(&lights).nodes;
        for ((limited, node), is_leaf) in nodes.iter().zip(&simple).zip(leaves) {
            if !is_leaf {
                continue;
            }
            let (height, whole) = (limited.high.y - limited.low.y, node.high.y - node.low.y);
            assert!(height < 0.8 * whole, "{limited:?} {node:?}");
            // Panels send light to one side only.
            if node.facing < 0.5 {
                assert!(limited.low.y < node.low.y + 0.2 * whole);
            }
        }
    }
}

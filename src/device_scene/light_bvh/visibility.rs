//! Boxes of influence that are limited by visibility: rays from the lights of each cluster measure how far the cluster's
//! light reaches before surfaces block it. A box of influence is the box around a cluster (lights that are close to each
//! other) outside of which the light BVH does not find the cluster. Limited boxes leave out many points that walls hide from
//! the cluster. The method is algorithm 4 of the publication of the light BVH (Gardishyan, "A Better Light Candidate
//! Generation Algorithm for ReSTIR Ray Tracing Using an Acceleration Structure to Identify Relevant Lights", 2025).

use super::light_sum::LightSum;
use super::{LightBvh, NearLight};
use crate::base::random::Random;
use crate::device_scene::lights::Lights;
use crate::shader_interface::{LIGHT_SPOT, RayQuery};
use glam::Vec3;
use std::f32::consts::TAU;

/// The number of rays that are traced from the lights of each cluster. More rays find more exactly how far the cluster's
/// light reaches, and take longer.
const RAYS: usize = 256;
/// The maximum number of clusters whose rays are traced in one call. It limits the host memory for these rays to 64 MiB.
const CLUSTERS_AT_ONCE: usize = 4096;
/// The distance from the random point on a light to the start of its ray, as a fraction of the point's coordinate with the
/// largest absolute value. It is several times the rounding error of f32, so that the ray does not hit the emitter itself.
/// Such a hit would end the ray at once, and make the cluster's box of influence too small.
const OFFSET: f32 = 4e-6;

impl LightBvh {
    /// Limits the box of influence of each cluster (the box outside of which the cluster is not found) to the
    /// surfaces that rays from its lights reach. `RAYS` rays per cluster start at random points of its
    /// lights, in random directions. Their maximum length is the cluster's radius of influence. `trace`
    /// returns the distance to each ray's hit in the device's units, or a negative value for a ray without a
    /// hit. A cluster without power gets no rays; if it is switched on later, its box has the full radius on
    /// every side.
    ///
    /// # Errors
    /// `trace` returns an error.
    pub fn limit<E>(
        &mut self,
        lights: &Lights,
        mut trace: impl FnMut(Vec<RayQuery>) -> Result<Vec<f32>, E>,
    ) -> Result<(), E> {
        let near = NearLight::of(lights, &[], self.options);
        let mut random = Random::new(0);
        let mut margins = vec![None; self.tree.len()];
        let shining: Vec<(usize, LightSum, f32)> = (self.tree.iter().enumerate())
            .filter(|(_, node)| node.is_leaf)
            .map(|(leaf, node)| {
                let sum = LightSum::of(self.lights_of(node).iter().map(|i| &near[*i as usize]));
                let radius = LightSum::radius(sum.power, self.scale);
                (leaf, sum, radius)
            })
            .filter(|(_, _, radius)| *radius > 0.0)
            .collect();
        for part in shining.chunks(CLUSTERS_AT_ONCE) {
            let mut rays = Vec::with_capacity(RAYS * part.len());
            for (leaf, _, radius) in part {
                let own = self.lights_of(&self.tree[*leaf]);
                rays.extend((0..RAYS).map(|_| {
                    let light = near[random.pick(own) as usize].index as usize;
                    probe(lights, light, *radius, &mut random)
                }));
            }
            let reached = trace(rays.clone())?;
            let each = rays.chunks(RAYS).zip(reached.chunks(RAYS));
            for ((leaf, sum, _), (rays, reached)) in part.iter().zip(each) {
                let (mut down, mut up) = (Vec3::ZERO, Vec3::ZERO);
                for (ray, t) in rays.iter().zip(reached) {
                    let t = if *t < 0.0 { ray.t_max } else { *t };
                    let point = ray.origin + t * ray.direction;
                    (down, up) = (down.max(sum.low - point), up.max(point - sum.high));
                }
                margins[*leaf] = Some((down, up));
            }
        }
        self.margins = margins;
        Ok(())
    }
}

/// A ray in the device's world space, for [`LightBvh::limit`]: it starts next to a random point of a light, and goes in a
/// random direction into which the light emits. `light` is the index of this light among the lights of all kinds. `radius`
/// is the maximum length of the ray, in the device's units.
fn probe(lights: &Lights, light: usize, radius: f32, random: &mut Random) -> RayQuery {
    let (position, axis) = point(lights, light, random);
    let mut direction = direction(random);
    if direction.dot(axis) < 0.0 {
        direction = -direction;
    }
    let clear = OFFSET * position.abs().max_element();
    RayQuery {
        origin: position + clear * direction,
        t_max: radius,
        direction,
        any: 0,
    }
}

/// A random point of a light, uniform by area, near which [`probe`] starts a ray, and the unit normal of the half space into
/// which the light emits. Both are in the device's world space. The normal is zero for a light that emits into all
/// directions. A punctual light has only one point. `index` is the index of the light among the lights of all kinds.
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

/// A random unit vector, distributed uniformly over the sphere, for the direction of a ray from a light.
fn direction(random: &mut Random) -> Vec3 {
    let z = random.between(-1.0, 1.0);
    let (sine, cosine) = (TAU * random.unit()).sin_cos();
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cosine, radius * sine, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device_scene::Units;
    use crate::device_scene::light_bvh::LightBvhOptions;
    use crate::device_scene::lights::gpu_lights;
    use crate::procedural;
    use glam::DVec3;

    const OPTIONS: LightBvhOptions = LightBvhOptions {
        scale: Some(2.0),
        cut: false,
        clusters: true,
        by_power: true,
        leaves_out_rare: false,
    };

    /// The box of an emitter that is off while rays are traced must not shrink. Otherwise the emitter would not be found
    /// everywhere when it is switched on later.
    #[test]
    fn dark_clusters_keep_their_boxes() {
        let scene = procedural::generate("colourful-mess", &[]).unwrap();
        let shining = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
        let mut dark = shining.clone();
        dark.powers.fill(0.0);
        let mut bvh = LightBvh::new(&dark, &[], &[], OPTIONS);
        let unlimited = bvh.contents(&shining);
        let trace = |rays: Vec<RayQuery>| Ok::<_, ()>(vec![0.0; rays.len()]);
        bvh.limit(&dark, trace).unwrap();
        assert_eq!(bvh.contents(&shining), unlimited);
    }

    #[test]
    fn boxes_end_where_rays_do() {
        let scene = procedural::generate("colourful-mess", &[]).unwrap();
        let lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
        let mut bvh = LightBvh::new(&lights, &[], &[], OPTIONS);
        let simple = bvh.contents(&lights).nodes;
        let mut count = 0;
        // Some rays end at once, the others go all the way.
        let trace = |rays: Vec<RayQuery>| {
            count += rays.len();
            let reached = rays
                .iter()
                .map(|ray| if ray.direction.y > 0.0 { 0.0 } else { -1.0 });
            Ok::<Vec<f32>, ()>(reached.collect())
        };
        bvh.limit(&lights, trace).unwrap();
        assert_eq!(count, RAYS * bvh.cluster_count());
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

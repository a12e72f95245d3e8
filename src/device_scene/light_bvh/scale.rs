//! The choice of the scale of boxes of influence. These are boxes around clusters of lights; at a point outside of a
//! cluster's box, the light BVH does not find the cluster. The scale is chosen so that a point on a surface is inside
//! [`OVERLAP`] boxes on average, or inside fewer in a scene with at most ten clusters.

use super::{LightBvh, NearLight, walk};
use crate::shader_interface::GpuLightNode;
use glam::Vec3;

/// The mean number of boxes of influence around a point on a surface for which [`fitting`] chooses the scale, in a scene
/// with more than ten clusters. Points outside of all boxes do not count in the mean. A higher number finds better light
/// candidates where many lights matter, and makes the search of the tree longer.
const OVERLAP: f64 = 8.0;

/// Finds the smallest scale of boxes of influence at which a point of `surfaces` (in the device's world
/// space) is inside enough boxes on average. Enough is [`OVERLAP`], in the mean over the points that are
/// inside any box. With at most ten clusters of lights, it is three quarters of the number of clusters, in
/// the mean over all points. Scales between 2⁻³⁰ and 2³⁰ are tried, in steps of a factor 2^¼; if none is
/// sufficient, the result is 2³⁰. Each try changes the scale of `bvh`, so that the caller must not use the
/// scale that remains in it.
pub fn fitting(bvh: &mut LightBvh, lights: &[NearLight], surfaces: &[Vec3]) -> f32 {
    // With at most ten clusters, three quarters of them are wanted, in the mean over all points. In a mean
    // over only the points inside some box, points on the emitters themselves would be enough.
    let three_quarters = 0.75 * bvh.cluster_count() as f64;
    let wanted = OVERLAP.min(three_quarters);
    let mut overlap = |scale: f32| {
        bvh.scale = scale;
        let nodes = bvh.nodes(lights);
        let (mut held, mut boxes) = (0_u64, 0_u64);
        for point in surfaces {
            let before = boxes;
            boxes += boxes_around(&nodes, *point);
            held += u64::from(boxes > before);
        }
        let points = match three_quarters < OVERLAP {
            true => surfaces.len() as u64,
            false => held,
        };
        boxes as f64 / points.max(1) as f64
    };
    // The exponent of two, in quarters. In the device's units, scenes have sizes and radiances around 1.
    let (mut low, mut high) = (-120_i32, 120_i32);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if overlap(scale_of(middle)) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    scale_of(high)
}

/// The number of clusters of lights whose boxes of influence contain `point`, which is in the device's world space. It is
/// the number of clusters that a walk for this point finds.
fn boxes_around(nodes: &[GpuLightNode], point: Vec3) -> u64 {
    let held = walk(nodes, point).filter(|visit| visit.inside && visit.is_leaf);
    held.count() as u64
}

fn scale_of(quarters: i32) -> f32 {
    2.0_f32.powf(quarters as f32 / 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;
    use crate::device_scene::Units;
    use crate::device_scene::light_bvh::LightBvhOptions;
    use crate::device_scene::lights::gpu_lights;
    use crate::procedural;
    use glam::DVec3;

    /// With a single emitter, the chosen scale must be so large that the emitter's box contains most points of the scene.
    /// Points on the emitter itself are in its box at any scale; a search that ended with these alone would choose too small
    /// a scale.
    #[test]
    fn one_emitter_lights_most_points() {
        let scene = procedural::generate("statue-room", &[]).unwrap();
        let lights = gpu_lights(&scene, &Units::of(&scene, DVec3::ZERO));
        let corner = lights.triangles[0].corner;
        let mut random = Random::new(0);
        let mut coordinate = || random.between(-3.0, 3.0);
        let mut surfaces = vec![corner];
        surfaces.extend((0..100).map(|_| Vec3::new(coordinate(), coordinate(), coordinate())));
        let options = LightBvhOptions {
            scale: None,
            cut: false,
            clusters: true,
            by_power: false,
            leaves_out_rare: false,
        };
        let bvh = LightBvh::new(&lights, &[], &surfaces, options);
        let nodes = bvh.contents(&lights).nodes;
        let lit = surfaces.iter().filter(|p| boxes_around(&nodes, **p) > 0);
        assert!(4 * lit.count() >= 3 * surfaces.len(), "{}", bvh.scale);
    }
}

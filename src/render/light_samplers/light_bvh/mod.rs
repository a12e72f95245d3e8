//! The buffer of the light BVH, a tree of lights. Shaders walk through the tree to compute the probabilities of lights for a
//! shading point, and draw light candidates with these probabilities. The buffer is empty if the settings draw no candidates
//! from the tree.

pub mod lists;
pub mod settings;

use crate::device_scene::GpuScene;
use crate::device_scene::buffers::usage;
use crate::device_scene::light_bvh::{LightBvh, LightBvhOptions};
use crate::device_scene::sizes::check_buffer;
use crate::gpu::{Buffer, Device, Resource};
use crate::render::ray_list::RayTracer;
use crate::render::scene_bindings::SceneResource;
use crate::shader_interface::{Fetch, LIGHT_BVH, Variant};
use crate::{Error, Result};
use glam::Vec3;
use settings::{Boxes, Far, LightBvhSettings};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// The number of points on surfaces from which the scale of the boxes of influence is chosen. With `far=skipped`, a light is
/// drawn from the tree only at points inside its box. The scale is such that a point on a surface is inside about 8 boxes on
/// average. Higher: a more exact scale, but a longer start.
const SURFACE_POINTS: usize = 1024;

/// The light BVH (a tree of lights): a buffer on the device, from which shaders draw light candidates, and the tree on the
/// CPU, from which the buffer is written again when lights move or change. The buffer is empty if no candidates are drawn
/// from the tree.
pub struct LightBvhBuffer {
    /// The number of nodes of the tree, inner nodes and leaves, for the constants of shaders; 0 if there is no tree.
    pub node_count: u32,
    buffer: Buffer,
    /// The tree on the CPU, and a time in seconds: the buffer was last written with the lights as they are at this time.
    /// When the scene is posed at another time, the buffer is written again from the tree. `None` if there is no tree.
    source: Option<(LightBvh, Mutex<f64>)>,
}

impl LightBvhBuffer {
    /// Builds the tree for the lights that `scene` has at time 0, and uploads it. If `options` are `None`, there is no tree,
    /// and the buffer is empty.
    ///
    /// # Errors
    /// The buffer exceeds a limit or the free memory of the device, or the rays that limit the boxes of influence (outside
    /// its box, a light is not drawn from the tree) cannot be traced.
    pub fn new(
        device: &Arc<Device>,
        scene: &Arc<GpuScene>,
        settings: &LightBvhSettings,
        options: Option<LightBvhOptions>,
    ) -> Result<Self> {
        let lights = scene.first_lights();
        let start = Instant::now();
        let bvh = options.map(|options| build(device, scene, settings, options));
        let bvh = bvh.transpose()?;
        let contents = bvh.as_ref().map(|bvh| bvh.contents(lights));
        let contents = contents.unwrap_or_default();
        if let Some(bvh) = &bvh {
            log::info!(
                "light BVH: {} clusters of {} lights, scale {}, built in {:.1} ms",
                bvh.cluster_count(),
                bvh.light_count(),
                bvh.scale,
                1e3 * start.elapsed().as_secs_f64()
            );
        }
        let words = contents.words();
        check_buffer(
            &device.info,
            scene.variant,
            LIGHT_BVH,
            size_of_val(&words[..]) as u64,
        )?;
        let used = usage(LIGHT_BVH, scene.variant);
        Ok(Self {
            node_count: contents.nodes.len() as u32,
            buffer: Buffer::from_slice(device, LIGHT_BVH, &words, used)?,
            source: bvh.map(|bvh| (bvh, Mutex::new(0.0))),
        })
    }
}

impl SceneResource for LightBvhBuffer {
    /// The name and the size in bytes of the light BVH's buffer, for reports of memory; `None` if the buffer is empty.
    fn memory(&self) -> Option<(&'static str, u64)> {
        (self.node_count > 0).then(|| (LIGHT_BVH, self.buffer.size()))
    }

    /// The name of the binding in the shaders, and the buffer of the light BVH. Shaders that are compiled for `variant` (a
    /// combination of tracer and access to memory) read the buffer as texels or as a storage buffer, and it is bound in this
    /// form.
    fn resource(&self, variant: Variant) -> (&'static str, Resource<'_>) {
        let resource = match variant.fetch {
            Fetch::Texels => Resource::Texels(&self.buffer),
            _ => Resource::Read(&self.buffer),
        };
        (LIGHT_BVH, resource)
    }

    /// Writes the tree to the buffer again, with the boxes and powers that the lights have in the current pose of `scene`
    /// (its state at one time). The structure of the tree stays the same. Does nothing if the buffer was already written for
    /// the time of this pose, if neither instances nor lights change with time, or if there is no tree.
    ///
    /// # Errors
    /// The device fails, or an earlier update failed in another thread.
    fn follow(&self, scene: &GpuScene) -> Result<()> {
        let Some((bvh, time)) = &self.source else {
            return Ok(());
        };
        let mut time = (time.lock())
            .map_err(|_| Error::failed("fitting the light BVH failed in another thread"))?;
        if let Some((lights, now)) = scene.moved_lights(*time)? {
            self.buffer.write(&bvh.contents(&lights).words())?;
            *time = now;
        }
        Ok(())
    }
}

/// Builds the tree for the lights at time 0. With `far=skipped` and `boxes=visibility`, it then traces rays from the lights,
/// and limits each box of influence to the surfaces that the rays hit. A light is drawn from the tree only at points inside
/// its box, so hidden lights are drawn less often.
fn build(
    device: &Arc<Device>,
    scene: &Arc<GpuScene>,
    settings: &LightBvhSettings,
    options: LightBvhOptions,
) -> Result<LightBvh> {
    let lights = scene.first_lights();
    let surfaces = match options.needs_surfaces() {
        true => scene.surface_points(SURFACE_POINTS)?,
        false => Vec::new(),
    };
    let surfaces: Vec<Vec3> = surfaces.iter().map(|point| point.position).collect();
    let mut bvh = LightBvh::new(lights, &scene.light_groups, &surfaces, options);
    if settings.boxes == Boxes::Visibility && settings.far == Far::Skipped {
        let unit = scene.units.length as f32;
        bvh.limit(lights, |mut rays| {
            // Lists of rays are in the scene's units.
            for ray in &mut rays {
                ray.origin *= unit;
                ray.direction *= unit;
            }
            let tracer = RayTracer::new(device, scene.clone(), &rays)?;
            tracer.run()?;
            Ok::<_, Error>(tracer.answers()?.iter().map(|answer| answer.t).collect())
        })?;
    }
    Ok(bvh)
}

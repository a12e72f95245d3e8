//! The buffers of the light BVH, which a renderer has if its settings draw candidates from it.

use super::settings::{Candidates, Far, Integrator, LightBvhSettings, LightChoice, Settings};
use crate::Result;
use crate::gpu::{Buffer, Device, Resource};
use crate::tracing::buffers::usage;
use crate::tracing::light_bvh::{LightBvh, LightBvhContents, LightBvhOptions};
use crate::tracing::{Fetch, GpuScene, Variant};
use std::sync::{Arc, Mutex};

/// The light BVH on the device; empty where nothing draws from it.
pub struct LightBvhBuffers {
    /// Number of nodes.
    pub node_count: u32,
    nodes: Buffer,
    lights: Buffer,
    places: Buffer,
    /// What it is made from, and the time of the lights that the buffers hold.
    source: Option<(LightBvh, Mutex<f64>)>,
}

impl LightBvhBuffers {
    /// Builds what `settings` need for the scene.
    ///
    /// # Errors
    /// More memory than the device has.
    pub fn new(device: &Arc<Device>, scene: &GpuScene, settings: &Settings) -> Result<Self> {
        let lights = scene.first_lights();
        let bvh = settings
            .draws_from_light_bvh()
            .then(|| LightBvh::new(lights, &scene.surface_points, settings.light_bvh.options()));
        let contents = bvh.as_ref().map(|bvh| bvh.contents(lights));
        let LightBvhContents {
            nodes,
            lights,
            places,
        } = contents.unwrap_or_default();
        if let Some(bvh) = &bvh {
            log::info!(
                "light BVH: {} clusters of {} lights, scale {}",
                bvh.cluster_count(),
                lights.len().saturating_sub(1),
                bvh.scale
            );
        }
        let variant = scene.variant;
        let named = |name: &'static str| (name, usage(name, variant));
        let (node, light) = (named("light_nodes"), named("node_lights"));
        let place = named("light_places");
        Ok(Self {
            node_count: nodes.len() as u32,
            nodes: Buffer::from_slice(device, node.0, &nodes, node.1)?,
            lights: Buffer::from_slice(device, light.0, &lights, light.1)?,
            places: Buffer::from_slice(device, place.0, &places, place.1)?,
            source: bvh.map(|bvh| (bvh, Mutex::new(0.0))),
        })
    }

    /// Name and buffer.
    pub fn named(&self) -> [(&'static str, &Buffer); 3] {
        [
            ("light_nodes", &self.nodes),
            ("node_lights", &self.lights),
            ("light_places", &self.places),
        ]
    }

    /// What shaders of a variant bind.
    pub fn resources(
        &self,
        variant: Variant,
    ) -> impl Iterator<Item = (&'static str, Resource<'_>)> {
        self.named().into_iter().map(move |(name, buffer)| {
            let resource = match variant.fetch {
                Fetch::Texels => Resource::Texels(buffer),
                _ => Resource::Read(buffer),
            };
            (name, resource)
        })
    }

    /// Fits the boxes to the scene's lights as they are now.
    ///
    /// # Errors
    /// The device fails.
    pub fn follow(&self, scene: &GpuScene) -> Result<()> {
        let Some((bvh, time)) = self.source.as_ref().filter(|_| scene.moves()) else {
            return Ok(());
        };
        let (lights, now) = scene.lights()?;
        let Ok(mut time) = time.lock() else {
            return Ok(());
        };
        if *time != now {
            let contents = bvh.contents(&lights);
            self.nodes.write(&contents.nodes)?;
            self.lights.write(&contents.lights)?;
            self.places.write(&contents.places)?;
            *time = now;
        }
        Ok(())
    }
}

impl Settings {
    /// Whether candidates of some kind of light are drawn from the light BVH.
    pub fn draws_from_light_bvh(&self) -> bool {
        let kinds = [&self.direct.resampling, &self.indirect.resampling];
        self.integrator == Integrator::Restir
            && (kinds.iter()).any(|resampling| resampling.candidates == Candidates::LightBvh)
    }
}

impl LightBvhSettings {
    /// How the tree is built.
    fn options(&self) -> LightBvhOptions {
        LightBvhOptions {
            scale: self.scale.number(),
            cut: self.far == Far::Joined,
            clusters: self.cluster,
            by_power: self.choice == LightChoice::Contribution,
        }
    }
}

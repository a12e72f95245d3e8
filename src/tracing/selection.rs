//! The choice of tracer and geometry access for a scene on a device: by rule from the device and the size of the
//! scene, never from a timing, so that the same command on the same machine always does the same.

use super::buffers::is_fetched;
use super::sizes::SceneSizes;
use super::{Fetch, GeometryAccess, Tracer, Variant};
use crate::gpu::{DeviceInfo, DriverKind, Features};
use crate::{Error, Result};

/// The tracer as the user asks for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TracerChoice {
    /// By rule from the device.
    #[default]
    Auto,
    /// The driver's acceleration structures.
    RayQuery,
    /// The BVH traversed in compute.
    ComputeBvh,
}

/// A variant and the reasons for it.
#[derive(Clone, Debug)]
pub struct Selection {
    /// What the shaders are compiled for.
    pub variant: Variant,
    /// Why this tracer.
    pub tracer_reason: String,
    /// Why this geometry access.
    pub geometry_reason: String,
    /// Why this fetch.
    pub fetch_reason: String,
}

impl Selection {
    /// The features the device must be opened with.
    pub fn features(&self) -> Features {
        Features {
            ray_query: self.variant.tracer == Tracer::RayQuery,
            buffer_addresses: self.variant.geometry == GeometryAccess::BufferAddresses,
        }
    }
}

/// The rule. A CPU device traces in compute: its ray query is the slower one by far. Addresses are
/// used where the device has them, since they reach further than a binding, but for drivers that
/// were measured to be slow with them (processor time of path tracing `cornell-glossy` and
/// `night-city`) and scenes that these can bind.
///
/// # Errors
/// Ray query was asked for on a device that has none.
pub fn select(device: &DeviceInfo, wanted: TracerChoice, scene: &SceneSizes) -> Result<Selection> {
    let (tracer, tracer_reason) = tracer(device, wanted)?;
    let (fetch, fetch_reason) = fetch(device, scene);
    let (geometry, geometry_reason) = geometry(device, scene, fetch);
    Ok(Selection {
        variant: Variant {
            tracer,
            geometry,
            fetch,
        },
        tracer_reason: tracer_reason.into(),
        geometry_reason,
        fetch_reason,
    })
}

fn tracer(device: &DeviceInfo, wanted: TracerChoice) -> Result<(Tracer, &'static str)> {
    Ok(match wanted {
        TracerChoice::RayQuery if !device.ray_query => {
            return Err(Error::input(format!(
                "device '{}' has no ray query; use --tracer compute-bvh or auto",
                device.name
            )));
        }
        TracerChoice::RayQuery => (Tracer::RayQuery, "asked for"),
        TracerChoice::ComputeBvh => (Tracer::ComputeBvh, "asked for"),
        TracerChoice::Auto if !device.ray_query => {
            (Tracer::ComputeBvh, "the device has no ray query")
        }
        TracerChoice::Auto if device.is_cpu() => (
            Tracer::ComputeBvh,
            "ray query on a CPU device is slower than compute",
        ),
        TracerChoice::Auto => (Tracer::RayQuery, "the device has ray query"),
    })
}

fn fetch(device: &DeviceInfo, scene: &SceneSizes) -> (Fetch, String) {
    let reach = device.max_texel_bytes();
    let (name, bytes) = scene.largest(is_fetched);
    if reach < device.max_storage_buffer_range {
        (Fetch::Words, "texels reach less far than a binding".into())
    } else if device.buffer_addresses && bytes > reach {
        (
            Fetch::Words,
            format!("the {name} take {bytes} bytes, texels reach {reach}"),
        )
    } else {
        (Fetch::Texels, "texels reach as far as a binding".into())
    }
}

fn geometry(device: &DeviceInfo, scene: &SceneSizes, fetch: Fetch) -> (GeometryAccess, String) {
    use GeometryAccess::{BufferAddresses, StorageBuffers};
    // Through bindings, or by address.
    let (name, bytes) = scene.largest(|name| fetch == Fetch::Words || !is_fetched(name));
    let range = device.max_storage_buffer_range;
    let slow = match device.driver_kind {
        DriverKind::Llvmpipe { mesa: ..=22 } => {
            Some("by address this driver takes 1.3 times as long")
        }
        DriverKind::SwiftShader => Some("by address this driver takes 1.05 times as long"),
        _ => None,
    };
    match slow {
        _ if !device.buffer_addresses => (
            StorageBuffers,
            "the device has no buffer addresses".to_owned(),
        ),
        Some(_) if bytes > range => (
            BufferAddresses,
            format!("the {name} take {bytes} bytes, a binding holds {range}"),
        ),
        Some(reason) => (StorageBuffers, reason.to_owned()),
        None => (
            BufferAddresses,
            "the device has buffer addresses".to_owned(),
        ),
    }
}

//! The choice of the shader variant for a scene on a device. A variant states how shaders trace rays (tracer), access
//! buffers (by bindings or by address), read groups of four words (as texels or as words), and read textures. Rules choose
//! it from the device and the sizes of the scene, never from a timing, so that a command always makes the same choice on the
//! same machine.

use super::buffers::is_fetched;
use super::sizes::SceneSizes;
use crate::gpu::{DeviceInfo, DriverKind, Features};
use crate::shader_interface::{Fetch, GeometryAccess, Textures, Tracer, Variant};
use crate::{Error, Result};

/// The inputs that decide the shader variant besides the device and the scene: the requests of the user, and
/// whether a tool captures the commands. For each request that is `None`, [`select`] decides by its rules. A
/// shader variant states how shaders trace rays, and how they read buffers and textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// The requested tracer: ray queries, or the BVH that is traversed in compute. With `None`, [`select`]
    /// decides.
    pub tracer: Option<Tracer>,
    /// The requested access of shaders to the buffers of the scene: through bound storage buffers, whose size
    /// the device limits, or by device address. With `None`, [`select`] decides.
    pub geometry: Option<GeometryAccess>,
    /// The requested access of shaders to the texels of textures: from a buffer or from images. With `None`,
    /// [`select`] decides.
    pub textures: Option<Textures>,
    /// True if a capture tool records the commands, to replay them later. Buffer addresses are then avoided on devices that
    /// cannot give a replayed buffer the same address.
    pub captured: bool,
}

/// The selected shader variant, with the reason for each choice, as reports and `headwater info` show it.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The variant in which all shaders of the scene are compiled.
    pub variant: Variant,
    /// A phrase for reports that states why this tracer was chosen, such as `the device has ray query`.
    pub tracer_reason: String,
    /// A phrase for reports that states why shaders access the scene's buffers through bindings or by address.
    pub geometry_reason: String,
    /// A phrase for reports that states why shaders read data in groups of four words, such as nodes of
    /// trees, as texels or as single words.
    pub fetch_reason: String,
    /// A phrase for reports that states why shaders read textures from a buffer or from images.
    pub textures_reason: String,
}

impl Selection {
    /// The features with which the device must be opened, so that it can run shaders of the variant.
    pub fn features(&self) -> Features {
        Features {
            ray_query: self.variant.tracer == Tracer::RayQuery,
            // Acceleration structures are built from addresses.
            buffer_addresses: self.variant.geometry == GeometryAccess::BufferAddresses
                || self.variant.tracer == Tracer::RayQuery,
            image_arrays: self.variant.textures == Textures::Images,
            ..Features::default()
        }
    }
}

/// The reason that reports state for a choice that avoids buffer addresses because the commands are captured.
const NO_REPLAY: &str = "addresses of buffers cannot be replayed on this device";

/// Selects the shader variant for a scene on a device.
///
/// Without requests, these rules hold:
///
/// - Rays are traced by ray queries if the device has them. But a CPU device traces in compute, because its ray queries are
///   much slower.
/// - Data in groups of four words are read as texels if a texel buffer can hold at least as much as a binding. On a device
///   with buffer addresses, it must also be able to hold each such buffer of the scene. Otherwise the data are read as
///   words.
/// - Buffers are accessed by address if the device has addresses, because the size of a bound buffer is limited. On two
///   drivers addresses are slower ([`DriverKind`]), as measured by the processor time of path tracing `cornell-glossy` and
///   `night-city`. These drivers use bindings, if a binding can hold each buffer that is not read as texels.
/// - Textures are read from images if buffers are accessed by address and the device can sample all images of the scene;
///   otherwise from a buffer. A CPU device reads them from a buffer, which is faster there, unless the texels are too large
///   for one buffer.
///
/// The exception is a capture on a device that cannot give buffers the same addresses in a replay. Rays are then traced in
/// compute, and buffers are accessed by bindings.
///
/// # Errors
/// A request cannot be met: ray queries or buffer addresses on a device without them, storage buffers for a scene that is
/// too large for them, or images on a device that cannot sample those of the scene. Or a frame is captured whose scene is
/// too large to be replayed without addresses.
pub fn select(device: &DeviceInfo, request: Request, scene: &SceneSizes) -> Result<Selection> {
    // Addresses would be others when the capture is replayed.
    let without_addresses = request.captured && device.buffer_addresses && !device.address_replay;
    let (tracer, tracer_reason) = match request.tracer {
        None if without_addresses => (Tracer::ComputeBvh, NO_REPLAY),
        request => tracer(device, request)?,
    };
    let (fetch, fetch_reason) = fetch(device, scene);
    let (geometry, geometry_reason) = match request.geometry {
        None if without_addresses => {
            let request = Some(GeometryAccess::StorageBuffers);
            let access = geometry(device, request, scene, fetch).map_err(|_| {
                let (name, bytes) = scene.largest_buffer(|_| true);
                Error::input(format!(
                    "{NO_REPLAY}, and its bindings hold less than the {bytes} bytes of {name}; capture a smaller scene"
                ))
            })?;
            (access.0, NO_REPLAY.into())
        }
        request => geometry(device, request, scene, fetch)?,
    };
    let (textures, textures_reason) = textures(device, request.textures, scene, geometry)?;
    Ok(Selection {
        variant: Variant {
            tracer,
            geometry,
            fetch,
            textures,
        },
        tracer_reason: tracer_reason.into(),
        geometry_reason,
        fetch_reason,
        textures_reason,
    })
}

fn tracer(device: &DeviceInfo, request: Option<Tracer>) -> Result<(Tracer, &'static str)> {
    Ok(match request {
        Some(Tracer::RayQuery) if !device.ray_query => {
            return Err(Error::input(format!(
                "device '{}' has no ray query; use --tracer compute-bvh or auto",
                device.name
            )));
        }
        Some(Tracer::RayQuery) => (Tracer::RayQuery, "asked for"),
        Some(Tracer::ComputeBvh) => (Tracer::ComputeBvh, "asked for"),
        None if !device.ray_query => (Tracer::ComputeBvh, "the device has no ray query"),
        None if device.is_cpu() => (
            Tracer::ComputeBvh,
            "ray query on a CPU device is slower than compute",
        ),
        None => (Tracer::RayQuery, "the device has ray query"),
    })
}

fn fetch(device: &DeviceInfo, scene: &SceneSizes) -> (Fetch, String) {
    let reach = device.max_texel_bytes();
    let (name, bytes) = scene.largest_buffer(is_fetched);
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

fn geometry(
    device: &DeviceInfo,
    request: Option<GeometryAccess>,
    scene: &SceneSizes,
    fetch: Fetch,
) -> Result<(GeometryAccess, String)> {
    use GeometryAccess::{BufferAddresses, StorageBuffers};
    // Through bindings, or by address.
    let (name, bytes) = scene.largest_buffer(|name| fetch == Fetch::Words || !is_fetched(name));
    let range = device.max_storage_buffer_range;
    let slow = match device.driver_kind {
        DriverKind::Llvmpipe { mesa: ..=22 } => {
            Some("by address this driver takes 1.3 times as long")
        }
        DriverKind::SwiftShader => Some("by address this driver takes 1.05 times as long"),
        _ => None,
    };
    let refused = |why: String, instead: &str| {
        let device = &device.name;
        Err(Error::input(format!(
            "{why} on device '{device}'; use --geometry {instead} or auto"
        )))
    };
    Ok(match (request, slow) {
        (Some(GeometryAccess::BufferAddresses), _) if !device.buffer_addresses => {
            return refused("there are no buffer addresses".into(), "storage-buffers");
        }
        (Some(GeometryAccess::StorageBuffers), _) if device.buffer_addresses && bytes > range => {
            return refused(
                format!("the {name} take {bytes} bytes, but a binding holds {range}"),
                "buffer-addresses",
            );
        }
        (Some(GeometryAccess::BufferAddresses), _) => (BufferAddresses, "asked for".into()),
        (Some(GeometryAccess::StorageBuffers), _) => (StorageBuffers, "asked for".into()),
        _ if !device.buffer_addresses => (
            StorageBuffers,
            "the device has no buffer addresses".to_owned(),
        ),
        (_, Some(_)) if bytes > range => (
            BufferAddresses,
            format!("the {name} take {bytes} bytes, a binding holds {range}"),
        ),
        (_, Some(reason)) => (StorageBuffers, reason.to_owned()),
        (_, None) => (
            BufferAddresses,
            "the device has buffer addresses".to_owned(),
        ),
    })
}

fn textures(
    device: &DeviceInfo,
    request: Option<Textures>,
    scene: &SceneSizes,
    geometry: GeometryAccess,
) -> Result<(Textures, String)> {
    let obstacle = if !device.image_arrays {
        Some("the device has no descriptor indexing".to_owned())
    } else if geometry == GeometryAccess::StorageBuffers {
        Some(match device.buffer_addresses {
            true => "images need buffer addresses, which are not used".to_owned(),
            false => "the device has no buffer addresses".to_owned(),
        })
    } else {
        scene.images.excess(device)
    };
    Ok(match (request, obstacle) {
        _ if scene.images.count == 0 => (Textures::Buffer, "the scene has no images".into()),
        (Some(Textures::Images), Some(obstacle)) => {
            return Err(Error::input(format!(
                "textures cannot be images on device '{}': {obstacle}; use --textures buffer or auto",
                device.name
            )));
        }
        (Some(Textures::Images), None) => (Textures::Images, "asked for".into()),
        (Some(Textures::Buffer), _) => (Textures::Buffer, "asked for".into()),
        (None, Some(obstacle)) => (Textures::Buffer, obstacle),
        (None, None) if scene.bytes.texels > device.max_buffer_size => (
            Textures::Images,
            format!(
                "the texels take {} bytes, a buffer holds {}",
                scene.bytes.texels, device.max_buffer_size
            ),
        ),
        (None, None) if device.is_cpu() => (
            Textures::Buffer,
            "images on a CPU device are slower than a buffer".into(),
        ),
        (None, None) => (
            Textures::Images,
            "the device has descriptor indexing".into(),
        ),
    })
}

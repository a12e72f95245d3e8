//! The sizes in bytes of a scene's buffers and images, which are known before any tree is built, and the comparison of these
//! sizes with the limits of a device. So a scene that is too large is refused early, with a message that names the limit.

use super::buffers::{BufferBytes, is_fetched};
use super::images::ImageSizes;
use super::merge_static::ElementCounts;
use crate::base::memory;
use crate::gpu::DeviceInfo;
use crate::scene::Scene;
use crate::scene::lights::{AliasColumn, EmitterTriangle, LightTriangle};
use crate::shader_interface::{
    Fetch, GeometryAccess, GpuLight, GpuLightChoice, LIGHT_MASK, Textures, Variant,
};
use crate::{Error, Result};

/// The maximum number of stored triangles; a scene with more is refused. Shaders index the words of the buffer `positions`
/// in 32 bits, and a triangle takes nine words.
const MAX_TRIANGLES: u64 = u32::MAX as u64 / 9;

/// The maximum number of emissive triangles in the world; a scene with more is refused. A reservoir stores the index of its
/// light in 29 bits.
const MAX_LIGHTS: u64 = LIGHT_MASK as u64 + 1;

/// The host memory, in bytes, that an emissive triangle takes while a scene is uploaded. If all emissive triangles need more
/// than is free, the scene is refused. The memory consists of the triangle in object space and in world space, its data for
/// shaders (twice: for time 0 and for the current pose), its column of the alias table, and eight numbers of 64 bits, such
/// as powers.
const LIGHT_BYTES: usize = size_of::<EmitterTriangle>()
    + size_of::<LightTriangle>()
    + 2 * (size_of::<GpuLight>() + size_of::<GpuLightChoice>())
    + size_of::<AliasColumn>()
    + 8 * size_of::<f64>();

/// The sizes that a scene will have on a device. The shader variant is chosen by them, and [`SceneSizes::check`] compares
/// them with the device's limits before anything is uploaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneSizes {
    /// The number of stored triangles, which must be so small that shaders can address their positions with
    /// 32-bit indices. The triangles of a mesh with several instances are stored once.
    pub triangles: u64,
    /// The number of emissive triangles in the world, which must not exceed 2²⁹, the number that a reservoir can index. A
    /// triangle counts once for each instance of its mesh.
    pub triangle_lights: u64,
    /// An upper bound of the size in bytes of each buffer except that of the trees' nodes. The buffer of
    /// nodes counts as 0, because the number of nodes is not known before the trees are built. The shader
    /// variant is chosen by these sizes.
    pub bytes: BufferBytes,
    /// The number and the largest sizes of the scene's images. If they exceed a limit of the device, shaders
    /// read texels from a buffer instead of sampling images.
    pub images: ImageSizes,
}

impl SceneSizes {
    /// Computes the sizes that a scene will have on a device, without building trees or uploading anything.
    pub fn of(scene: &Scene) -> Self {
        let counts = ElementCounts::of(scene);
        Self {
            triangles: counts.triangles,
            triangle_lights: counts.triangle_lights,
            bytes: BufferBytes::of(&counts),
            images: ImageSizes::of(scene),
        }
    }

    /// The name and the size in bytes of the largest buffer. A buffer is left out if `counted`, called with its name, returns
    /// false; if all are left out, the result is an empty name and 0. To choose the shader variant, the size is compared
    /// with the limits for bindings and texel buffers.
    pub(super) fn largest_buffer(&self, counted: impl Fn(&str) -> bool) -> (&'static str, u64) {
        let buffers = self.bytes.named().into_iter();
        let buffers = buffers.filter(|(name, _)| counted(name));
        buffers.max_by_key(|(_, bytes)| *bytes).unwrap_or_default()
    }

    /// Checks that a device can store the scene and read it with shaders of `variant`, and that the host has free memory for
    /// the scene's emissive triangles.
    ///
    /// # Errors
    /// A count, a buffer, an image or the total size exceeds a limit. The message names the one that is too large, its size,
    /// and the limit.
    pub fn check(&self, device: &DeviceInfo, variant: Variant) -> Result<()> {
        if self.triangles > MAX_TRIANGLES {
            return Err(Error::input(format!(
                "the scene's {} triangles need {} bytes of positions, but shaders count at most {MAX_TRIANGLES} triangles; use a smaller scene",
                self.triangles, self.bytes.positions
            )));
        }
        if self.triangle_lights > MAX_LIGHTS {
            return Err(Error::input(format!(
                "the scene has {} emissive triangles, but reservoirs can name at most {MAX_LIGHTS}; use a smaller scene",
                self.triangle_lights
            )));
        }
        memory::check(self.triangle_lights * LIGHT_BYTES as u64).map_err(|cause| {
            Error::input(format!(
                "the scene's {} emissive triangles: {cause}; use a smaller scene",
                self.triangle_lights
            ))
        })?;
        let samples_images = variant.textures == Textures::Images;
        if let Some(excess) = self.images.excess(device).filter(|_| samples_images) {
            return Err(Error::input(format!(
                "the scene's textures cannot be images on device '{}': {excess}; use --textures auto",
                device.name
            )));
        }
        for (name, bytes) in self.bytes.named() {
            if name == "texels" && samples_images {
                continue;
            }
            check_buffer(device, variant, name, bytes)?;
        }
        let total: u64 = self.bytes.named().iter().map(|(_, bytes)| bytes).sum();
        if total > device.device_memory {
            return Err(Error::input(format!(
                "the scene needs more than {total} bytes, but device '{}' has {}; use a smaller scene or another device",
                device.name, device.device_memory
            )));
        }
        Ok(())
    }
}

/// Checks that a device can hold the scene's buffer `name` of `bytes` bytes, and that shaders of `variant` can read all of
/// it: as texels, through a binding, or by address.
///
/// # Errors
/// The buffer exceeds a limit of the device; the message names the buffer, its size and the limit.
pub(crate) fn check_buffer(
    device: &DeviceInfo,
    variant: Variant,
    name: &str,
    bytes: u64,
) -> Result<()> {
    let (reach, how) = match (variant.fetch, variant.geometry) {
        (Fetch::Texels, _) if is_fetched(name) => (device.max_texel_bytes(), "read as texels"),
        (_, GeometryAccess::StorageBuffers) => (device.max_storage_buffer_range, "bound at once"),
        (_, GeometryAccess::BufferAddresses) => (u64::MAX, ""),
    };
    let (limit, how) = if device.max_buffer_size < reach {
        (device.max_buffer_size, "in one buffer")
    } else {
        (reach, how)
    };
    if bytes > limit {
        return Err(Error::input(format!(
            "the scene's {name} need {bytes} bytes, but device '{}' takes at most {limit} {how}; use a smaller scene or another device",
            device.name
        )));
    }
    Ok(())
}

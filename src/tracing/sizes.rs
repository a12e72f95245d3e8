//! How many bytes a scene takes on a device, told before any tree is built.

use super::{Fetch, GeometryAccess, Variant};
use crate::gpu::DeviceInfo;
use crate::layouts::{GpuInstance, GpuLight, GpuMaterial};
use crate::scene::Scene;
use crate::{Error, Result};

/// Bytes of a triangle's corners, of its packed normals, and of its part's words.
const CORNERS: u64 = 36;
const NORMALS: u64 = 12;
const PARTS: u64 = 12;

/// Shaders count a triangle's words in 32 bits, nine for its corners.
const MOST_TRIANGLES: u64 = u32::MAX as u64 / 9;

/// Bytes of a scene's buffers. Only those of the trees' nodes are missing, which the trees decide;
/// they are fewer than those of the positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneSizes {
    /// Triangles that are stored: those of a mesh in several places once.
    pub triangles: u64,
    /// Corner positions.
    pub positions: u64,
    /// Corner normals of smooth meshes.
    pub normals: u64,
    /// Materials and lights of meshes that have several.
    pub triangle_parts: u64,
    /// Instances in the order of the tree over them.
    pub top_instances: u64,
    /// Instances.
    pub instances: u64,
    /// Materials.
    pub materials: u64,
    /// Emissive triangles.
    pub lights: u64,
}

impl SceneSizes {
    /// What a scene takes, its meshes gathered as [`gather`](super::gather::gather) does.
    pub fn of(scene: &Scene) -> Self {
        let mut uses = vec![0_u64; scene.meshes.len()];
        for instance in &scene.instances {
            uses[instance.mesh as usize] += 1;
        }
        let gathers = uses.iter().filter(|uses| **uses == 1).count() > 1;
        // A flat and a smooth gathered mesh.
        let mut instances = if gathers { 2 } else { 0 };
        let mut sizes = Self {
            materials: (scene.materials.len() * size_of::<GpuMaterial>()) as u64,
            lights: scene.emissive_triangle_count() * size_of::<GpuLight>() as u64,
            ..Self::default()
        };
        for (mesh, uses) in scene.meshes.iter().zip(uses) {
            if gathers && uses == 0 {
                continue;
            }
            let gathered = gathers && uses == 1;
            let count = mesh.triangles.len() as u64;
            sizes.triangles += count;
            if !mesh.normals.is_empty() {
                sizes.normals += count * NORMALS;
            }
            let emits = |material: u32| scene.materials[material as usize].is_emissive();
            if gathered || mesh.parts.len() > 1 || mesh.parts.iter().any(|p| emits(p.material)) {
                sizes.triangle_parts += count * PARTS;
            }
            instances += if gathered { 0 } else { uses };
        }
        sizes.positions = sizes.triangles * CORNERS;
        sizes.top_instances = instances * 4;
        sizes.instances = instances * size_of::<GpuInstance>() as u64;
        sizes
    }

    /// The largest of the buffers that a device reads through bindings, or by address.
    pub(super) fn largest(&self, fetch: Fetch) -> (&'static str, u64) {
        let buffers = self.buffers().into_iter();
        let read = buffers.filter(|(name, _)| !(fetch == Fetch::Texels && is_fetched(name)));
        read.max_by_key(|(_, bytes)| *bytes).unwrap_or_default()
    }

    /// Whether a device can hold the scene and read it as a variant does.
    ///
    /// # Errors
    /// It cannot: which buffer, its bytes, and the limit.
    pub fn check(&self, device: &DeviceInfo, variant: Variant) -> Result<()> {
        if self.triangles > MOST_TRIANGLES {
            return Err(Error::input(format!(
                "the scene's {} triangles need {} bytes of positions, but shaders count at most {MOST_TRIANGLES} triangles; use a smaller scene",
                self.triangles, self.positions
            )));
        }
        for (name, bytes) in self.buffers() {
            check_buffer(device, variant, name, bytes)?;
        }
        let total: u64 = self.buffers().iter().map(|(_, bytes)| bytes).sum();
        if total > device.device_memory {
            return Err(Error::input(format!(
                "the scene needs more than {total} bytes, but device '{}' has {}; use a smaller scene or another device",
                device.name, device.device_memory
            )));
        }
        Ok(())
    }

    fn buffers(&self) -> [(&'static str, u64); 7] {
        [
            ("positions", self.positions),
            ("normals", self.normals),
            ("triangle_parts", self.triangle_parts),
            ("top_instances", self.top_instances),
            ("instances", self.instances),
            ("materials", self.materials),
            ("lights", self.lights),
        ]
    }
}

/// Whether [`Fetch`] decides how a buffer is read.
fn is_fetched(name: &str) -> bool {
    matches!(name, "positions" | "nodes")
}

/// Whether a device can hold one of a scene's buffers and read it as a variant does.
///
/// # Errors
/// It cannot.
pub(super) fn check_buffer(
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

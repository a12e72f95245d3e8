//! The driver's acceleration structures over a scene.

use super::geometry::Geometry;
use crate::Result;
use crate::gpu::{AccelerationStructure, BlasGeometry, Buffer, Device, TlasInstance};
use crate::layouts::GpuInstance;
use std::sync::Arc;

/// One structure a mesh, and one over the instances.
pub struct RayQueryScene {
    /// The structure that rays are traced in.
    pub top: AccelerationStructure,
    /// What `top` refers to.
    meshes: Vec<Option<AccelerationStructure>>,
}

impl RayQueryScene {
    /// Builds all structures. `mesh_of` gives each instance's mesh.
    ///
    /// # Errors
    /// The device has no memory left.
    pub fn new(
        device: &Arc<Device>,
        geometry: &Geometry,
        positions: &Buffer,
        instances: &[GpuInstance],
        mesh_of: &[u32],
    ) -> Result<Self> {
        let meshes = geometry
            .meshes
            .iter()
            .enumerate()
            .map(|(number, place)| {
                if place.triangle_count == 0 {
                    return Ok(None);
                }
                let mesh = BlasGeometry {
                    positions,
                    first_triangle: place.first_triangle,
                    triangle_count: place.triangle_count,
                };
                AccelerationStructure::bottom(device, &format!("mesh {number}"), mesh).map(Some)
            })
            .collect::<Result<Vec<_>>>()?;
        let placed: Vec<TlasInstance<'_>> = instances
            .iter()
            .zip(mesh_of)
            .enumerate()
            .filter_map(|(index, (instance, mesh))| {
                Some(TlasInstance {
                    blas: meshes[*mesh as usize].as_ref()?,
                    object_to_world: instance.object_to_world,
                    index: index as u32,
                })
            })
            .collect();
        let top = AccelerationStructure::top(device, "instances", &placed)?;
        Ok(Self { top, meshes })
    }

    /// Bytes of all structures.
    pub fn size(&self) -> u64 {
        let meshes = self.meshes.iter().flatten();
        self.top.size() + meshes.map(AccelerationStructure::size).sum::<u64>()
    }
}

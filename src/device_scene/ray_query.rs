//! The driver's acceleration structures over a scene.

use super::geometry::MeshOffsets;
use crate::Result;
use crate::gpu::{AccelerationStructure, BlasGeometry, Buffer, Device, TlasInstance};
use crate::shader_interface::GpuInstance;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One structure per mesh, and one or two over the instances.
pub struct RayQueryScene {
    /// The top-level structures in which rays are traced; two if the scene moves, for this frame and the previous one.
    tops: Vec<AccelerationStructure>,
    /// The index of the structure of this frame.
    current: AtomicUsize,
    /// The bottom-level structures of the meshes.
    meshes: Vec<Option<AccelerationStructure>>,
    /// Each instance's mesh.
    mesh_of: Vec<u32>,
}

impl RayQueryScene {
    /// Builds all structures, `tops` of them over the `visible` ones among the `instances`;
    /// `mesh_of` gives each instance's mesh.
    ///
    /// # Errors
    /// The device has no memory left.
    pub fn new(
        device: &Arc<Device>,
        meshes: &[MeshOffsets],
        positions: &Buffer,
        (instances, visible): (&[GpuInstance], &[u32]),
        mesh_of: Vec<u32>,
        tops: usize,
    ) -> Result<Self> {
        let meshes = meshes
            .iter()
            .enumerate()
            .map(|(number, offsets)| {
                if offsets.triangle_count == 0 {
                    return Ok(None);
                }
                let mesh = BlasGeometry {
                    positions,
                    first_triangle: offsets.first_triangle,
                    triangle_count: offsets.triangle_count,
                    opaque: offsets.opaque,
                };
                AccelerationStructure::bottom(device, &format!("mesh {number}"), mesh).map(Some)
            })
            .collect::<Result<Vec<_>>>()?;
        let mut scene = Self {
            tops: Vec::new(),
            current: AtomicUsize::new(0),
            meshes,
            mesh_of,
        };
        for _ in 0..tops {
            let placed = scene.placed(instances, visible);
            let most = scene.mesh_of.len();
            let top = AccelerationStructure::top(device, "instances", &placed, most)?;
            scene.tops.push(top);
        }
        Ok(scene)
    }

    /// The structure over this frame's instances.
    pub fn top(&self) -> &AccelerationStructure {
        &self.tops[self.current.load(Ordering::Relaxed)]
    }

    /// The structure over the previous frame's instances, which is the current one if nothing moves.
    pub fn previous_top(&self) -> &AccelerationStructure {
        let previous = (self.current.load(Ordering::Relaxed) + 1) % self.tops.len();
        &self.tops[previous]
    }

    /// Makes the current structure the previous one.
    pub fn advance(&self) {
        let next = (self.current.load(Ordering::Relaxed) + 1) % self.tops.len();
        self.current.store(next, Ordering::Relaxed);
    }

    /// Rebuilds one of the structures over the instances.
    ///
    /// # Errors
    /// The device has no memory left.
    pub fn rebuild(
        &self,
        top: &AccelerationStructure,
        instances: &[GpuInstance],
        visible: &[u32],
    ) -> Result<()> {
        top.rebuild_top(&self.placed(instances, visible))
    }

    fn placed(&self, instances: &[GpuInstance], visible: &[u32]) -> Vec<TlasInstance<'_>> {
        visible
            .iter()
            .filter_map(|&index| {
                let mesh = self.mesh_of[index as usize];
                Some(TlasInstance {
                    blas: self.meshes[mesh as usize].as_ref()?,
                    object_to_world: instances[index as usize].object_to_world,
                    index,
                })
            })
            .collect()
    }

    /// The size of all structures in bytes.
    pub fn size(&self) -> u64 {
        let meshes = self.meshes.iter().flatten();
        let all = meshes.chain(&self.tops);
        all.map(AccelerationStructure::size).sum()
    }
}

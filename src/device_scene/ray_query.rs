//! The driver's acceleration structures over the meshes and instances of a scene, in which shaders trace ray queries.

use super::geometry::MeshOffsets;
use crate::Result;
use crate::gpu::{AccelerationStructure, BlasGeometry, Buffer, Device, TlasInstance};
use crate::shader_interface::GpuInstance;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The acceleration structures of a scene, in which shaders trace rays: one bottom-level structure per mesh, one top-level
/// structure over the instances and, if something moves, a second one over the instances as they were in the previous frame.
pub struct RayQueryScene {
    /// The top-level structures. If something moves, there are two, one for the current and one for the previous frame,
    /// which exchange these roles in each new frame. Otherwise there is one.
    tops: Vec<AccelerationStructure>,
    /// The index in `tops` of the structure of the current frame: 0 or 1. It changes in each new frame if
    /// there are two structures.
    current: AtomicUsize,
    /// The bottom-level structure of each mesh; `None` for a mesh without triangles.
    meshes: Vec<Option<AccelerationStructure>>,
    /// For each instance, the index of its mesh in `meshes`. A top-level structure that is rebuilt finds the
    /// meshes of its instances with it.
    mesh_of: Vec<u32>,
}

impl RayQueryScene {
    /// Builds a bottom-level structure for each mesh, and top-level structures over the instances. `tops` is
    /// the number of top-level structures: 2 if something moves, for the current and the previous frame,
    /// otherwise 1. `positions` is the buffer with the triangles of all meshes. `visible` has the indices of
    /// the instances that are included, and `mesh_of` has the index in `meshes` of each instance's mesh.
    ///
    /// # Errors
    /// The device lacks memory, was opened without ray query, or there are more than 2²⁴ instances.
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
            .map(|(index, offsets)| {
                if offsets.triangle_count == 0 {
                    return Ok(None);
                }
                let mesh = BlasGeometry {
                    positions,
                    first_triangle: offsets.first_triangle,
                    triangle_count: offsets.triangle_count,
                    opaque: offsets.opaque,
                };
                AccelerationStructure::bottom(device, &format!("mesh {index}"), mesh).map(Some)
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

    /// The top-level structure over the instances of the current frame, in which shaders trace rays.
    pub fn top(&self) -> &AccelerationStructure {
        &self.tops[self.current.load(Ordering::Relaxed)]
    }

    /// The top-level structure over the instances as they were in the previous frame. Shaders trace shadow rays in it, to
    /// find what was visible in that frame. If nothing moves, it is the structure of the current frame.
    pub fn previous_top(&self) -> &AccelerationStructure {
        let previous = (self.current.load(Ordering::Relaxed) + 1) % self.tops.len();
        &self.tops[previous]
    }

    /// Begins a new frame of a scene that moves: the current top-level structure becomes that of the previous frame. The
    /// other structure becomes current, and the caller must rebuild it with the new transforms. Without motion, there is
    /// only one structure, and the call has no effect.
    pub fn advance(&self) {
        let next = (self.current.load(Ordering::Relaxed) + 1) % self.tops.len();
        self.current.store(next, Ordering::Relaxed);
    }

    /// Rebuilds `top`, one of the two top-level structures, from the transforms in `instances`. Only the instances with an
    /// index in `visible` are included.
    ///
    /// # Errors
    /// The device lacks memory.
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

    /// The size in bytes of all bottom-level and top-level structures together, for reports of memory.
    pub fn size(&self) -> u64 {
        let meshes = self.meshes.iter().flatten();
        let all = meshes.chain(&self.tops);
        all.map(AccelerationStructure::size).sum()
    }
}

//! The driver's acceleration structures over the meshes and instances of a scene, in which shaders trace ray queries.

use super::geometry::MeshOffsets;
use crate::gpu::{AccelerationStructure, BlasGeometry, Buffer, Device, TlasInstance};
use crate::shader_interface::GpuInstance;
use crate::{Error, Result};
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

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
    /// The meshes as they are in the device's buffer of triangles, from which structures are built.
    offsets: Vec<MeshOffsets>,
    /// The structures of meshes that deform, for each of their shapes. The key is the index of the shape's first triangle in
    /// the buffer `positions`; an instance without an entry has the structure of its mesh.
    shapes: Mutex<Shapes>,
    device: Arc<Device>,
    /// For each instance, the index of its mesh in `meshes`. A top-level structure that is rebuilt finds the
    /// meshes of its instances with it.
    mesh_of: Vec<u32>,
}

type Shapes = HashMap<u32, Arc<AccelerationStructure>>;

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
        let offsets = meshes.to_vec();
        let meshes = meshes
            .iter()
            .enumerate()
            .map(|(index, offsets)| {
                if offsets.triangle_count == 0 {
                    return Ok(None);
                }
                let first = offsets.first_triangle;
                bottom(device, index, offsets, positions, first).map(Some)
            })
            .collect::<Result<Vec<_>>>()?;
        let mut scene = Self {
            tops: Vec::new(),
            current: AtomicUsize::new(0),
            meshes,
            mesh_of,
            offsets,
            shapes: Mutex::default(),
            device: device.clone(),
        };
        for _ in 0..tops {
            let shapes = Shapes::default();
            let placed = scene.placed(instances, visible, &shapes);
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
        let shapes = self.shapes()?;
        top.rebuild_top(&self.placed(instances, visible, &shapes))
    }

    /// Builds the structures of meshes that have got another shape. `shapes` has the index of each such mesh and the index in
    /// the buffer `positions` of the first triangle of its shape.
    ///
    /// # Errors
    /// The device lacks memory.
    pub fn rebuild_meshes(
        &self,
        positions: &Buffer,
        shapes: impl Iterator<Item = (u32, u32)>,
    ) -> Result<()> {
        for (mesh, first_triangle) in shapes {
            let index = mesh as usize;
            let built = bottom(
                &self.device,
                index,
                &self.offsets[index],
                positions,
                first_triangle,
            )?;
            self.shapes()?.insert(first_triangle, Arc::new(built));
        }
        Ok(())
    }

    fn shapes(&self) -> Result<MutexGuard<'_, Shapes>> {
        let failed = "building acceleration structures failed in another thread";
        self.shapes.lock().map_err(|_| Error::failed(failed))
    }

    fn placed<'a>(
        &'a self,
        instances: &[GpuInstance],
        visible: &[u32],
        shapes: &'a Shapes,
    ) -> Vec<TlasInstance<'a>> {
        visible
            .iter()
            .filter_map(|&index| {
                let mesh = self.mesh_of[index as usize];
                Some(TlasInstance {
                    blas: match shapes.get(&instances[index as usize].first_triangle) {
                        Some(shape) => shape,
                        None => self.meshes[mesh as usize].as_ref()?,
                    },
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
        let shapes = self.shapes.lock().map_or(0, |shapes| {
            shapes.values().map(|shape| shape.size()).sum::<u64>()
        });
        all.map(AccelerationStructure::size).sum::<u64>() + shapes
    }
}

/// Builds the structure of the mesh with the index `index`, from its triangles that begin at `first_triangle` in `positions`.
fn bottom(
    device: &Arc<Device>,
    index: usize,
    offsets: &MeshOffsets,
    positions: &Buffer,
    first_triangle: u32,
) -> Result<AccelerationStructure> {
    let mesh = BlasGeometry {
        positions,
        first_triangle,
        triangle_count: offsets.triangle_count,
        opaque: offsets.opaque,
    };
    AccelerationStructure::bottom(device, &format!("mesh {index}"), mesh)
}

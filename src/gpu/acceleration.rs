//! The driver's acceleration structures, in which shaders trace ray queries: a bottom-level structure for each mesh, and
//! top-level structures over the instances.

use super::buffer::{Buffer, Usage};
use super::commands::Commands;
use super::device::Device;
use crate::{Error, Result};
use ash::{khr, vk};
use glam::Vec3;
use std::sync::Arc;

/// A bottom-level or top-level acceleration structure, and the buffer that stores it. Shaders trace ray queries in a
/// top-level structure, which refers to bottom-level ones.
pub struct AccelerationStructure {
    pub(super) raw: vk::AccelerationStructureKHR,
    buffer: Buffer,
}

/// The triangles of one mesh, from which a bottom-level structure is built. A triangle is nine floats, the positions of its
/// three corners; there are no vertex indices.
#[derive(Clone, Copy)]
pub struct BlasGeometry<'a> {
    /// Buffer with the triangles of all meshes, 36 bytes each. Their positions are in object space:
    /// [`TlasInstance::object_to_world`] places them in the world.
    pub positions: &'a Buffer,
    /// Index of the mesh's first triangle in `positions`, counted in triangles.
    pub first_triangle: u32,
    /// Number of triangles of the mesh, which are consecutive in `positions`.
    pub triangle_count: u32,
    /// True if every intersection is a hit, so that the shader need not check the intersection. Otherwise the shader accepts
    /// or rejects each intersection, for example by its alpha.
    pub opaque: bool,
}

/// One instance in a top-level structure: a mesh with a transform, and an index by which shaders recognise it in a hit.
#[derive(Clone, Copy)]
pub struct TlasInstance<'a> {
    /// Bottom-level structure of the instance's mesh, in which rays that reach the instance are traced
    /// further.
    pub blas: &'a AccelerationStructure,
    /// The four columns of the 3×4 transform from object space to world space; the last column is the translation.
    pub object_to_world: [Vec3; 4],
    /// Value in [0, 2²⁴) that `rayQueryGetIntersectionInstanceCustomIndexEXT` returns for the instance, so that shaders find
    /// its data.
    pub index: u32,
}

impl AccelerationStructure {
    /// Builds the bottom-level structure of one mesh on the device, and waits for the build. Profilers, debuggers and
    /// messages show `name`.
    ///
    /// # Errors
    /// The device was opened without ray query.
    pub fn bottom(device: &Arc<Device>, name: &str, mesh: BlasGeometry<'_>) -> Result<Self> {
        let start = mesh.positions.address()? + u64::from(mesh.first_triangle) * 36;
        let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(vk::DeviceOrHostAddressConstKHR {
                device_address: start,
            })
            .vertex_stride(12)
            .max_vertex((mesh.triangle_count * 3).saturating_sub(1))
            .index_type(vk::IndexType::NONE_KHR);
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
            .flags(match mesh.opaque {
                true => vk::GeometryFlagsKHR::OPAQUE,
                // A triangle that is asked for twice would weaken a ray twice.
                false => vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION,
            });
        let build = Build {
            kind: vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
            geometry,
        };
        let structure = Self::make(device, name, build, mesh.triangle_count)?;
        structure.fill(build, mesh.triangle_count)?;
        Ok(structure)
    }

    /// Builds a top-level structure over `instances` on the device, and waits for the build. [`Self::rebuild_top`] can later
    /// replace the instances by up to `capacity` other ones. Profilers, debuggers and messages show `name`.
    ///
    /// # Errors
    /// There are more than 2²⁴ instances, or the device was opened without ray query.
    pub fn top(
        device: &Arc<Device>,
        name: &str,
        instances: &[TlasInstance<'_>],
        capacity: usize,
    ) -> Result<Self> {
        let buffer = instance_buffer(device, name, instances)?;
        let build = Build::over_instances(&buffer)?;
        let structure = Self::make(device, name, build, capacity.max(instances.len()) as u32)?;
        structure.fill(build, instances.len() as u32)?;
        Ok(structure)
    }

    /// Rebuilds a structure that [`Self::top`] has made, over the new `instances`, and waits for the build. The caller must
    /// check that their number does not exceed the structure's capacity.
    ///
    /// # Errors
    /// There are more than 2²⁴ instances.
    pub fn rebuild_top(&self, instances: &[TlasInstance<'_>]) -> Result<()> {
        let buffer = instance_buffer(&self.buffer.device, self.buffer.name(), instances)?;
        self.fill(Build::over_instances(&buffer)?, instances.len() as u32)
    }

    /// Size in bytes of the buffer that stores the structure, for reports of memory. It does not include scratch memory,
    /// which exists only during a build.
    pub fn size(&self) -> u64 {
        self.buffer.size()
    }

    /// Makes a structure with memory for up to `capacity` triangles or instances. `build` states whether it is a
    /// bottom-level or a top-level structure. The structure has no content until [`Self::fill`] builds it.
    fn make(device: &Arc<Device>, name: &str, build: Build<'_>, capacity: u32) -> Result<Self> {
        let functions = functions(device)?;
        let sizes = build.sizes(functions, capacity);
        let usage = Usage {
            acceleration_storage: true,
            ..Usage::default()
        };
        let buffer = Buffer::new(device, name, sizes.acceleration_structure_size, usage)?;
        if !device.runs() {
            let raw = vk::AccelerationStructureKHR::null();
            return Ok(Self { raw, buffer });
        }
        let create = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(buffer.raw)
            .size(sizes.acceleration_structure_size)
            .ty(build.kind);
        // SAFETY: the buffer has the required size and usage and lives as long as the structure.
        let raw = unsafe { functions.create_acceleration_structure(&create, None) }
            .map_err(|e| device.failure(&format!("make {name}"), e))?;
        device.name(raw, name);
        Ok(Self { raw, buffer })
    }

    /// Builds the content of the structure from `count` triangles or instances, which must not exceed its capacity, and
    /// waits for the build.
    fn fill(&self, build: Build<'_>, count: u32) -> Result<()> {
        let (device, name) = (&self.buffer.device, self.buffer.name());
        if !device.runs() {
            return Ok(());
        }
        let functions = functions(device)?;
        let sizes = build.sizes(functions, count);
        let alignment = device.scratch_alignment;
        let scratch = Buffer::new(
            device,
            &format!("{name} (scratch)"),
            sizes.build_scratch_size + alignment,
            Usage::default(),
        )?;
        let geometries = [build.geometry];
        let info = (build.info(&geometries))
            .dst_acceleration_structure(self.raw)
            .scratch_data(vk::DeviceOrHostAddressKHR {
                device_address: scratch.address()?.next_multiple_of(alignment),
            });
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)];
        let mut commands = Commands::new(device)?;
        commands.barrier();
        commands.begin(&format!("build {name}"), false);
        // SAFETY: inputs, scratch and target live until `finish` has waited.
        unsafe {
            functions.cmd_build_acceleration_structures(commands.raw(), &[info], &[&range]);
        }
        commands.end();
        commands.finish().map(drop)
    }

    fn address(&self, device: &Device) -> Result<u64> {
        if !device.runs() {
            return Ok(0);
        }
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default()
            .acceleration_structure(self.raw);
        // SAFETY: the structure is alive and belongs to this device.
        Ok(unsafe { functions(device)?.get_acceleration_structure_device_address(&info) })
    }
}

/// The input for the build of an acceleration structure: the level of the structure (bottom or top), and the address of its
/// triangles or instances on the device. From the same input, the driver also computes how much memory the structure and its
/// build need.
#[derive(Clone, Copy)]
struct Build<'a> {
    kind: vk::AccelerationStructureTypeKHR,
    geometry: vk::AccelerationStructureGeometryKHR<'a>,
}

impl Build<'_> {
    fn over_instances(buffer: &Buffer) -> Result<Self> {
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(
            vk::DeviceOrHostAddressConstKHR {
                device_address: buffer.address()?,
            },
        );
        Ok(Self {
            kind: vk::AccelerationStructureTypeKHR::TOP_LEVEL,
            geometry: vk::AccelerationStructureGeometryKHR::default()
                .geometry_type(vk::GeometryTypeKHR::INSTANCES)
                .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data }),
        })
    }

    fn info<'b>(
        &self,
        geometries: &'b [vk::AccelerationStructureGeometryKHR<'b>],
    ) -> vk::AccelerationStructureBuildGeometryInfoKHR<'b> {
        vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(self.kind)
            .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(geometries)
    }

    /// Sizes in bytes of a structure of `count` triangles or instances, and of the scratch memory that its build needs. The
    /// buffers for both are made with these sizes.
    fn sizes(
        &self,
        functions: &khr::acceleration_structure::Device,
        count: u32,
    ) -> vk::AccelerationStructureBuildSizesInfoKHR<'static> {
        let geometries = [self.geometry];
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: the geometry lives through the call.
        unsafe {
            functions.get_acceleration_structure_build_sizes(
                vk::AccelerationStructureBuildTypeKHR::DEVICE,
                &self.info(&geometries),
                &[count],
                &mut sizes,
            );
        }
        sizes
    }
}

/// Makes a buffer on the device with the instances, in the layout that a build of a top-level structure reads
/// (`VkAccelerationStructureInstanceKHR`). Only the build uses the buffer, so the caller frees it after the
/// build. The name of the buffer is made from `name`, the name of the structure.
fn instance_buffer(
    device: &Arc<Device>,
    name: &str,
    instances: &[TlasInstance<'_>],
) -> Result<Buffer> {
    if instances.len() > 1 << 24 {
        return Err(Error::failed(format!(
            "{} instances, but ray query counts only 16777216; use --tracer compute-bvh",
            instances.len()
        )));
    }
    // VkAccelerationStructureInstanceKHR: 12 floats, two packed words, an address.
    let mut words: Vec<u32> = Vec::with_capacity(instances.len() * 16);
    for instance in instances {
        for row in 0..3 {
            words.extend(instance.object_to_world.map(|column| column[row].to_bits()));
        }
        words.push(instance.index | 0xFF << 24);
        words.push(vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE.as_raw() << 24);
        let address = instance.blas.address(device)?;
        words.extend([address as u32, (address >> 32) as u32]);
    }
    let usage = Usage {
        acceleration_input: true,
        ..Usage::default()
    };
    Buffer::from_slice(device, &format!("{name} (instances)"), &words, usage)
}

fn functions(device: &Device) -> Result<&khr::acceleration_structure::Device> {
    device
        .acceleration
        .as_ref()
        .ok_or_else(|| Error::failed("the device was opened without ray query"))
}

impl Drop for AccelerationStructure {
    fn drop(&mut self) {
        self.buffer.device.wait_before_drop();
        if let Some(functions) = &self.buffer.device.acceleration {
            // SAFETY: all commands that used the structure have finished.
            unsafe { functions.destroy_acceleration_structure(self.raw, None) };
        }
    }
}

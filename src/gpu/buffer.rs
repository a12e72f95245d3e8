//! Buffers, each with a separate range of memory, and copies between buffers and the host.

use super::commands::Commands;
use super::device::Device;
use super::device_info::TEXEL_SIZE;
use crate::{Error, Result};
use ash::vk;
use glam::UVec2;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// The optional uses of a buffer, which must be requested when it is made. Without any, a buffer can be a storage buffer,
/// and the source or the destination of copies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// True if the buffer can be input for the build of an acceleration structure: positions of triangles, or
    /// instances.
    pub acceleration_input: bool,
    /// True if the buffer can store an acceleration structure, as the destination of its build.
    pub acceleration_storage: bool,
    /// True if the buffer can be bound as a uniform buffer, for small data that all invocations share, such
    /// as constants of a pass.
    pub uniform: bool,
    /// True if shaders can read the buffer as texels of four `uint`s. Its size is then limited to
    /// [`DeviceInfo::max_texel_bytes`](super::DeviceInfo::max_texel_bytes).
    pub texels: bool,
}

/// A range of device memory with a name, which shaders read and write. The memory is freed when the value is dropped. On a
/// device that only compiles ([`Features::compiles_only`](super::Features::compiles_only)), the buffer has a size but no
/// memory, and reads as zeros.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    /// The view through which shaders read the buffer as texels; null without [`Usage::texels`].
    pub(super) view: vk::BufferView,
    pub(super) device: Arc<Device>,
    allocation: Option<Allocation>,
    size: u64,
    is_texels: bool,
    name: String,
}

impl Buffer {
    /// Makes a buffer in device memory; profilers, debuggers and messages show `name`. `size` is in bytes. It is rounded up
    /// to a multiple of 16, and to at least 16, so that an empty array can be bound too. The contents are undefined, or
    /// zeros with [`Features::hashed_outputs`](super::Features::hashed_outputs).
    ///
    /// # Errors
    /// `size` exceeds a limit of the device or its free memory.
    pub fn new(device: &Arc<Device>, name: &str, size: u64, usage: Usage) -> Result<Self> {
        let buffer = Self::with_location(device, name, size, usage, MemoryLocation::GpuOnly)?;
        if device.features.hashed_outputs {
            let commands = Commands::new(device)?;
            commands.clear(buffer.raw);
            commands.finish()?;
        }
        Ok(buffer)
    }

    /// Makes a buffer in device memory that is as large as `data`, copies `data` into it, and waits for the copy.
    ///
    /// # Errors
    /// `data` is larger than a limit of the device or its free memory.
    pub fn from_slice<T: bytemuck::Pod>(
        device: &Arc<Device>,
        name: &str,
        data: &[T],
        usage: Usage,
    ) -> Result<Self> {
        let buffer = Self::new(device, name, size_of_val(data) as u64, usage)?;
        buffer.write(data)?;
        Ok(buffer)
    }

    pub(super) fn with_location(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        usage: Usage,
        location: MemoryLocation,
    ) -> Result<Self> {
        // Whole texels, so that the last words can be read as a texel.
        let size = size.max(TEXEL_SIZE).next_multiple_of(TEXEL_SIZE);
        if size > device.info.max_buffer_size {
            return Err(Error::failed(format!(
                "{name} needs {size} bytes, but device '{}' allows {} in one buffer",
                device.info.name, device.info.max_buffer_size
            )));
        }
        let mut flags = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        if device.features.buffer_addresses {
            flags |= vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        }
        if usage.acceleration_input {
            flags |= vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
        }
        if usage.acceleration_storage {
            flags |= vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        }
        if usage.uniform {
            flags |= vk::BufferUsageFlags::UNIFORM_BUFFER;
        }
        if usage.texels {
            flags |= vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER;
            let limit = device.info.max_texel_bytes();
            if size > limit {
                return Err(Error::failed(format!(
                    "{name} needs {size} bytes, but device '{}' reads at most {limit} as texels",
                    device.info.name
                )));
            }
        }
        let mut buffer = Self {
            raw: vk::Buffer::null(),
            view: vk::BufferView::null(),
            device: device.clone(),
            allocation: None,
            size,
            is_texels: usage.texels,
            name: name.to_owned(),
        };
        if !device.runs() {
            return Ok(buffer);
        }
        let info = vk::BufferCreateInfo::default().size(size).usage(flags);
        // SAFETY: `info` lives through the call.
        let raw = unsafe { device.raw.create_buffer(&info, None) }
            .map_err(|e| device.failure(&format!("make buffer {name} of {size} bytes"), e))?;
        buffer.raw = raw;
        device.name(raw, name);
        // SAFETY: plain query on the buffer just made.
        let mut requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        // Software drivers report a smaller alignment than acceleration structures and their
        // scratch memory need.
        requirements.alignment = requirements.alignment.max(256);
        let wanted = AllocationCreateDesc {
            name,
            requirements,
            location,
            linear: true,
            allocation_scheme: if size >= 1 << 24 {
                AllocationScheme::DedicatedBuffer(raw)
            } else {
                AllocationScheme::GpuAllocatorManaged
            },
        };
        let allocation = device.allocate(&wanted, size)?;
        device.records.note_allocated(name, size);
        // SAFETY: the memory was allocated for this buffer's requirements and is bound once.
        let bound = unsafe {
            device
                .raw
                .bind_buffer_memory(raw, allocation.memory(), allocation.offset())
        };
        buffer.allocation = Some(allocation);
        bound.map_err(|e| device.failure(&format!("bind memory of {name}"), e))?;
        if usage.texels {
            let info = vk::BufferViewCreateInfo::default()
                .buffer(raw)
                .format(vk::Format::R32G32B32A32_UINT)
                .range(vk::WHOLE_SIZE);
            // SAFETY: the buffer has the usage and is bound to memory; every device supports this
            // format for uniform texel buffers.
            buffer.view = unsafe { device.raw.create_buffer_view(&info, None) }
                .map_err(|e| device.failure(&format!("read {name} as texels"), e))?;
            device.name(buffer.view, name);
        }
        Ok(buffer)
    }

    /// Size of the buffer in bytes: the requested size, rounded up to a multiple of 16, and at least 16.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// True if shaders may read the buffer as texels ([`Usage::texels`]). If false, a pass that would read it as texels
    /// returns an error.
    pub fn is_texels(&self) -> bool {
        self.is_texels
    }

    /// Name of the buffer, which profilers, debuggers and messages show.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Address of the buffer in device memory, by which shaders and builds of acceleration structures access it without a
    /// binding. It is 0 on a device that only compiles.
    ///
    /// # Errors
    /// The device was opened without buffer addresses.
    pub fn address(&self) -> Result<u64> {
        if !self.device.features.buffer_addresses {
            return Err(Error::failed(format!(
                "the address of {} was asked for on a device opened without addresses",
                self.name
            )));
        }
        if !self.device.runs() {
            return Ok(0);
        }
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: the feature is on and the buffer was made with the address usage.
        Ok(unsafe { self.device.raw.get_buffer_device_address(&info) })
    }

    /// The address from [`Self::address`] as two words, the form in which shaders read it: x is the lower 32 bits, y the
    /// upper 32 bits.
    ///
    /// # Errors
    /// The device was opened without buffer addresses.
    pub fn address_words(&self) -> Result<UVec2> {
        let address = self.address()?;
        Ok(UVec2::new(address as u32, (address >> 32) as u32))
    }

    /// Copies `data` to the start of the buffer, and waits for the copy. On a device that only compiles, it does nothing.
    ///
    /// # Errors
    /// `data` is larger than the buffer.
    pub fn write<T: bytemuck::Pod>(&self, data: &[T]) -> Result<()> {
        self.write_at(0, data)
    }

    /// Copies `data` into the buffer so that it begins at the index `first`, counted in values of the type `T`, and waits for
    /// the copy. On a device that only compiles, it does nothing.
    ///
    /// # Errors
    /// `data` extends beyond the buffer.
    pub fn write_at<T: bytemuck::Pod>(&self, first: usize, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let start = (first * size_of::<T>()) as u64;
        self.check(start + bytes.len() as u64)?;
        if bytes.is_empty() || !self.device.runs() {
            return Ok(());
        }
        // Large uploads are split, so that staging memory stays small.
        let piece = bytes.len().min(64 << 20);
        let mut staging = Self::staging(&self.device, piece as u64)?;
        for (index, part) in bytes.chunks(piece).enumerate() {
            staging.mapped()?[..part.len()].copy_from_slice(part);
            copy(
                &self.device,
                (&staging, 0),
                (self, start + (index * piece) as u64),
                part.len() as u64,
            )?;
        }
        Ok(())
    }

    /// Copies the first `count` values from the start of the buffer to the host, and waits for the copy. On a device that
    /// only compiles, all values are zeros.
    ///
    /// # Errors
    /// The buffer has fewer than `count` values of the type `T`.
    pub fn read<T: bytemuck::Pod>(&self, count: usize) -> Result<Vec<T>> {
        let size = count * size_of::<T>();
        self.check(size as u64)?;
        let mut values = vec![T::zeroed(); count];
        let piece = size.min(64 << 20);
        if piece == 0 || !self.device.runs() {
            return Ok(values);
        }
        let mut staging = Self::with_location(
            &self.device,
            "staging (download)",
            piece as u64,
            Usage::default(),
            MemoryLocation::GpuToCpu,
        )?;
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        for (index, part) in bytes.chunks_mut(piece).enumerate() {
            copy(
                &self.device,
                (self, (index * piece) as u64),
                (&staging, 0),
                part.len() as u64,
            )?;
            let length = part.len();
            part.copy_from_slice(&staging.mapped()?[..length]);
        }
        Ok(values)
    }

    /// Makes a buffer of at least `size` bytes in memory that the host can write. Uploads are written into it, and copied
    /// from it to device memory.
    pub(super) fn staging(device: &Arc<Device>, size: u64) -> Result<Self> {
        Self::with_location(
            device,
            "staging (upload)",
            size,
            Usage::default(),
            MemoryLocation::CpuToGpu,
        )
    }

    fn check(&self, size: u64) -> Result<()> {
        if size > self.size {
            return Err(Error::failed(format!(
                "{size} bytes do not fit {} of {} bytes",
                self.name, self.size
            )));
        }
        Ok(())
    }

    /// The bytes of the buffer, for reading and writing on the host. The call fails if the host cannot access the memory of
    /// the buffer.
    pub(super) fn mapped(&mut self) -> Result<&mut [u8]> {
        self.allocation
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .ok_or_else(|| Error::failed(format!("{} is not visible to the host", self.name)))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        self.device.wait_before_drop();
        if self.allocation.is_some() {
            self.device.records.note_freed(&self.name, self.size);
        }
        self.device.free(self.allocation.take());
        // SAFETY: all commands that used the buffer have finished; a null view is ignored.
        unsafe {
            self.device.raw.destroy_buffer_view(self.view, None);
            self.device.raw.destroy_buffer(self.raw, None);
        }
    }
}

/// Copies `size` bytes from one buffer to another, and waits for the copy. Offsets are in bytes. The caller must have
/// checked that both ranges are inside their buffers.
fn copy(
    device: &Arc<Device>,
    (from, from_offset): (&Buffer, u64),
    (to, to_offset): (&Buffer, u64),
    size: u64,
) -> Result<()> {
    let commands = Commands::new(device)?;
    let region = [vk::BufferCopy {
        src_offset: from_offset,
        dst_offset: to_offset,
        size,
    }];
    commands.barrier();
    // SAFETY: both buffers allow transfers and are alive until `finish` has waited.
    unsafe {
        device
            .raw
            .cmd_copy_buffer(commands.raw(), from.raw, to.raw, &region);
    }
    commands.finish().map(drop)
}

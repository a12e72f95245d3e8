//! Images with four bytes per texel, which hold the textures of a scene on the device. Shaders fetch single texels from
//! them.

use super::buffer::Buffer;
use super::commands::Commands;
use super::device::Device;
use super::image_commands::{Rows, UPLOAD, WHOLE};
use crate::{Error, Result};
use ash::vk;
use ash::vk::ImageLayout;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Format of all images: four bytes per texel, which shaders read as values in [0, 1] without sRGB decoding. Every device
/// can sample it.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// The maximum number of bytes of an image that are uploaded at once, which limits the size of the staging buffer. A single
/// row is uploaded at once even if it is longer.
const PIECE: usize = 64 << 20;

/// Name under which [`Records::memory_use`](super::records::Records::memory_use) counts all images together, because a scene
/// may have thousands.
const MEMORY_NAME: &str = "images";

/// A 2D image, usually a texture of a scene, from which shaders fetch texels. Its layout is `GENERAL`. Dropping it frees its
/// memory. On a device that only compiles ([`Features::compiles_only`](super::Features::compiles_only)) it has no memory.
pub struct SampledImage {
    pub(super) view: vk::ImageView,
    raw: vk::Image,
    device: Arc<Device>,
    allocation: Option<Allocation>,
    size: u64,
}

impl SampledImage {
    /// Makes an image of `width` columns, uploads its texels, and waits for the upload. `texels` has red, green, blue and
    /// alpha of each texel, row by row from the top; their number decides the height. Tools and messages show `name`.
    ///
    /// # Errors
    /// `texels` is empty or has an incomplete row, `width` is 0, or the image exceeds the device's memory or its limit on
    /// width and height.
    pub fn new(device: &Arc<Device>, name: &str, width: u32, texels: &[[u8; 4]]) -> Result<Self> {
        let height = (texels.len() / width.max(1) as usize) as u32;
        if height == 0 || width as usize * height as usize != texels.len() {
            return Err(Error::failed(format!(
                "{name}: {} texels are no rows of {width}",
                texels.len()
            )));
        }
        let side = width.max(height);
        if side > device.info.max_image_side {
            return Err(Error::failed(format!(
                "{name} is {side} texels long, but device '{}' allows {}",
                device.info.name, device.info.max_image_side
            )));
        }
        let mut image = Self {
            view: vk::ImageView::null(),
            raw: vk::Image::null(),
            device: device.clone(),
            allocation: None,
            size: 0,
        };
        if device.runs() {
            image.make(name, [width, height])?;
            image.write(width, texels)?;
        }
        Ok(image)
    }

    /// Size in bytes of the memory that the image occupies on the device; 0 on a device that only compiles.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Makes the Vulkan image of `width` × `height` texels, its memory and the view through which shaders sample it, and
    /// stores them in `self`. The texels are not written yet. `name` appears in tools and error messages.
    fn make(&mut self, name: &str, [width, height]: [u32; 2]) -> Result<()> {
        let device = &self.device;
        let fail = |e| device.failure(&format!("make image {name} of {width} × {height}"), e);
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(FORMAT)
            .extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST);
        // SAFETY: `info` lives through the call, and its sides are within the device's limit.
        self.raw = unsafe { device.raw.create_image(&info, None) }.map_err(fail)?;
        device.name(self.raw, name);
        // SAFETY: plain query on the image just made.
        let requirements = unsafe { device.raw.get_image_memory_requirements(self.raw) };
        self.size = requirements.size;
        let wanted = AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = device.allocate(&wanted, self.size)?;
        // SAFETY: the memory was allocated for this image's requirements and is bound once.
        let bound = unsafe {
            let (memory, offset) = (allocation.memory(), allocation.offset());
            device.raw.bind_image_memory(self.raw, memory, offset)
        };
        self.allocation = Some(allocation);
        self.device.records.note_allocated(MEMORY_NAME, self.size);
        bound.map_err(fail)?;
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(FORMAT)
            .subresource_range(WHOLE);
        // SAFETY: the image is bound to memory and of the view's type and format.
        self.view = unsafe { device.raw.create_image_view(&info, None) }.map_err(fail)?;
        device.name(self.view, name);
        Ok(())
    }

    /// Uploads the texels in pieces of whole rows (see [`PIECE`]), and then changes the image to the layout `GENERAL`.
    fn write(&self, width: u32, texels: &[[u8; 4]]) -> Result<()> {
        let device = &self.device;
        let rows = (PIECE / (4 * width as usize)).max(1);
        let piece = (rows * width as usize).min(texels.len());
        let mut staging = Buffer::staging(device, 4 * piece as u64)?;
        for (index, part) in texels.chunks(piece).enumerate() {
            let bytes = part.as_flattened();
            staging.mapped()?[..bytes.len()].copy_from_slice(bytes);
            let commands = Commands::new(device)?;
            commands.barrier();
            if index == 0 {
                commands.change_layout(self.raw, [ImageLayout::UNDEFINED, UPLOAD]);
            }
            let part_rows = Rows {
                width,
                first: (index * rows) as u32,
                count: (part.len() / width as usize) as u32,
            };
            commands.copy_rows(&staging, self.raw, &part_rows);
            if (index + 1) * piece >= texels.len() {
                commands.change_layout(self.raw, [UPLOAD, ImageLayout::GENERAL]);
            }
            commands.finish()?;
        }
        Ok(())
    }
}

impl Drop for SampledImage {
    fn drop(&mut self) {
        self.device.wait_before_drop();
        if self.allocation.is_some() {
            self.device.records.note_freed(MEMORY_NAME, self.size);
        }
        // SAFETY: all commands that used the image have finished; null handles are ignored.
        unsafe {
            self.device.raw.destroy_image_view(self.view, None);
            self.device.raw.destroy_image(self.raw, None);
        }
        self.device.free(self.allocation.take());
    }
}

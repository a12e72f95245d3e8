//! Presentation of frames to a swapchain that no window shows, so that capture tools such as GFXReconstruct see where a
//! frame ends.

use super::buffer::Buffer;
use super::commands::Commands;
use super::device::Device;
use super::image_commands::{Rows, UPLOAD};
use crate::{Error, Result};
use ash::vk;
use ash::vk::ImageLayout;
use std::sync::Arc;

/// The formats that presented pictures can have, the preferred one first. The flag is true if the first byte of a pixel in
/// memory is blue, and false if it is red. If the surface offers none of these formats, [`Presentation::new`] returns an
/// error.
const FORMATS: [(vk::Format, bool); 2] = [
    (vk::Format::R8G8B8A8_UNORM, false),
    (vk::Format::B8G8R8A8_UNORM, true),
];

/// A swapchain on a headless surface, which has no window. Capture tools such as GFXReconstruct see each presented picture
/// as the end of a frame, so that they can record chosen frames of a render.
pub struct Presentation {
    device: Arc<Device>,
    surface: vk::SurfaceKHR,
    swapchain: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    /// The fence that the driver signals when the swapchain image of the next picture may be written. [`Self::present`]
    /// waits for it before it copies the picture.
    acquired: vk::Fence,
    size: (u32, u32),
    begins_with_blue: bool,
}

impl Presentation {
    /// Makes the swapchain for pictures of `size`, which is (width, height) in pixels.
    ///
    /// # Errors
    /// The driver has no headless surface or no swapchain, the device was opened without
    /// [`Features::presentation`](super::Features::presentation), its queue cannot present, or the surface does not support
    /// the size, an 8-bit format, or copies into its images.
    pub fn new(device: &Arc<Device>, size: (u32, u32)) -> Result<Self> {
        let fail = |e| device.failure("present to a headless surface", e);
        let lacks = |what: &str| {
            Error::failed(format!(
                "device '{}' cannot present to a headless surface: {what}",
                device.info.name
            ))
        };
        let (Some(presenting), Some(surfaces)) =
            (&device.presentation, &device.instance().surfaces)
        else {
            let instance = device.instance();
            return Err(lacks(if instance.surfaces.is_none() {
                "its driver has no VK_EXT_headless_surface"
            } else if !device.info.presentation {
                "it has no VK_KHR_swapchain"
            } else {
                "it was opened without presentation"
            }));
        };
        let mut made = Self {
            device: device.clone(),
            surface: vk::SurfaceKHR::null(),
            swapchain: vk::SwapchainKHR::null(),
            images: Vec::new(),
            acquired: vk::Fence::null(),
            size,
            begins_with_blue: false,
        };
        let (physical, family) = (device.info.raw, device.info.queue_family);
        // SAFETY: create-infos live through their calls; what was made before a failure is destroyed by Drop.
        unsafe {
            let info = vk::HeadlessSurfaceCreateInfoEXT::default();
            let headless = &surfaces.headless;
            made.surface = headless
                .create_headless_surface(&info, None)
                .map_err(fail)?;
            let queries = &surfaces.surface;
            let supported =
                queries.get_physical_device_surface_support(physical, family, made.surface);
            if !supported.map_err(fail)? {
                return Err(lacks("its compute queue does not present"));
            }
            let limits = queries.get_physical_device_surface_capabilities(physical, made.surface);
            let limits = limits.map_err(fail)?;
            let largest = limits.max_image_extent;
            if size.0 > largest.width || size.1 > largest.height {
                return Err(lacks(&format!(
                    "a picture of {} × {} is larger than {} × {}",
                    size.0, size.1, largest.width, largest.height
                )));
            }
            // A presented picture is only copied to.
            let (usage, alpha) = (
                vk::ImageUsageFlags::TRANSFER_DST,
                vk::CompositeAlphaFlagsKHR::OPAQUE,
            );
            if !limits.supported_usage_flags.contains(usage)
                || !limits.supported_composite_alpha.contains(alpha)
            {
                return Err(lacks("its pictures cannot be copied to"));
            }
            let formats = queries.get_physical_device_surface_formats(physical, made.surface);
            let formats = formats.map_err(fail)?;
            let found = FORMATS.into_iter().find_map(|(format, begins_with_blue)| {
                let mut offered = formats.iter();
                let offered = offered.find(|offered| offered.format == format)?;
                Some((*offered, begins_with_blue))
            });
            let (format, begins_with_blue) =
                found.ok_or_else(|| lacks("it has no 8-bit format"))?;
            made.begins_with_blue = begins_with_blue;
            let info = vk::SwapchainCreateInfoKHR::default()
                .surface(made.surface)
                .min_image_count(limits.min_image_count)
                .image_format(format.format)
                .image_color_space(format.color_space)
                .image_extent(vk::Extent2D {
                    width: size.0,
                    height: size.1,
                })
                .image_array_layers(1)
                .image_usage(usage)
                .pre_transform(limits.current_transform)
                .composite_alpha(alpha)
                .present_mode(vk::PresentModeKHR::FIFO);
            made.swapchain = presenting.create_swapchain(&info, None).map_err(fail)?;
            made.images = presenting
                .get_swapchain_images(made.swapchain)
                .map_err(fail)?;
            let info = vk::FenceCreateInfo::default();
            made.acquired = device.raw.create_fence(&info, None).map_err(fail)?;
        }
        device.name(made.swapchain, "headless swapchain");
        for image in &made.images {
            device.name(*image, "presented picture");
        }
        Ok(made)
    }

    /// True if the least significant byte of a presented 32-bit pixel is blue; if false, it is red. The pixels for
    /// [`Self::present`] must be packed in this order, or red and blue are exchanged.
    pub fn begins_with_blue(&self) -> bool {
        self.begins_with_blue
    }

    /// Presents a picture, which ends the frame with the index `frame`. If the device has `VK_EXT_frame_boundary`, capture
    /// tools learn the index from this extension. `pixels` has one 32-bit word per pixel, row by row from the top;
    /// [`Self::begins_with_blue`] tells the order of the channels in a word. The call waits until the pixels are copied, not
    /// until they are presented.
    ///
    /// # Errors
    /// `pixels` has fewer pixels than a picture, or the device or the swapchain fails.
    pub fn present(&self, frame: u32, pixels: &Buffer) -> Result<()> {
        let Some(presenting) = &self.device.presentation else {
            return Err(Error::failed("the device was opened without presentation"));
        };
        let (width, height) = self.size;
        if pixels.size() < 4 * u64::from(width) * u64::from(height) {
            return Err(Error::failed(format!(
                "{} holds fewer than {width} × {height} pixels",
                pixels.name()
            )));
        }
        let raw = &self.device.raw;
        let fail = |e| self.device.failure("present a frame", e);
        // SAFETY: the fence is unsignalled: it was just made, or reset after the last wait.
        let index = unsafe {
            let (index, _) = presenting
                .acquire_next_image(
                    self.swapchain,
                    u64::MAX,
                    vk::Semaphore::null(),
                    self.acquired,
                )
                .map_err(fail)?;
            let fences = [self.acquired];
            raw.wait_for_fences(&fences, true, u64::MAX).map_err(fail)?;
            raw.reset_fences(&fences).map_err(fail)?;
            index
        };
        let image = self.images[index as usize];
        let mut commands = Commands::new(&self.device)?;
        commands.begin("present", false);
        commands.barrier();
        commands.change_layout(image, [ImageLayout::UNDEFINED, UPLOAD]);
        let rows = Rows {
            width,
            first: 0,
            count: height,
        };
        commands.copy_rows(pixels, image, &rows);
        commands.change_layout(image, [UPLOAD, ImageLayout::PRESENT_SRC_KHR]);
        commands.end();
        commands.ends_frame(frame, image);
        commands.finish()?;
        let (swapchains, indices) = ([self.swapchain], [index]);
        let info = vk::PresentInfoKHR::default()
            .swapchains(&swapchains)
            .image_indices(&indices);
        let _lock = self.device.queue_lock.lock();
        // SAFETY: the commands that wrote the image have finished, so there is no semaphore to wait for.
        unsafe { presenting.queue_present(self.device.queue, &info) }
            .map(drop)
            .map_err(fail)
    }
}

impl Drop for Presentation {
    fn drop(&mut self) {
        let _lock = self.device.queue_lock.lock();
        // SAFETY: nothing runs or is presented after the wait; null handles are ignored.
        unsafe {
            let _ = self.device.raw.device_wait_idle();
            self.device.raw.destroy_fence(self.acquired, None);
            if let Some(presenting) = &self.device.presentation {
                presenting.destroy_swapchain(self.swapchain, None);
            }
            if let Some(surfaces) = &self.device.instance().surfaces {
                surfaces.surface.destroy_surface(self.surface, None);
            }
        }
    }
}

//! The texture images of a scene, for shader variants that sample images instead of reading texels from a buffer.

use crate::Result;
use crate::gpu::{Device, DeviceInfo, SampledImage};
use crate::scene::Scene;
use std::sync::Arc;

/// The number of a pass's bindings that is reserved for resources other than images, because the device limits the sum of
/// both. A larger value allows fewer images.
const OTHER_BINDINGS: u64 = 64;

/// The count and the largest sizes of a scene's images, which are compared with the device's limits before the upload.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageSizes {
    /// The number of images in the scene.
    pub count: u64,
    /// The longest width or height of any image, in texels; 0 without images.
    pub max_side: u32,
    /// The size of the largest image in bytes; 0 without images.
    pub max_bytes: u64,
}

impl ImageSizes {
    /// Measures the images of a scene.
    pub fn of(scene: &Scene) -> Self {
        let images = || scene.images.iter();
        let max_side = images().map(|image| image.width.max(image.height)).max();
        let max_bytes = images()
            .map(|image| size_of_val(&*image.texels) as u64)
            .max();
        Self {
            count: scene.images.len() as u64,
            max_side: max_side.unwrap_or(0),
            max_bytes: max_bytes.unwrap_or(0),
        }
    }

    /// Describes the limit of the device that the images exceed; `None` if the device can bind and hold all of them.
    pub(super) fn excess(&self, device: &DeviceInfo) -> Option<String> {
        let most = u64::from(device.max_sampled_images).saturating_sub(OTHER_BINDINGS);
        if self.count > most {
            Some(format!(
                "a pass binds at most {most} of {} images",
                self.count
            ))
        } else if self.max_side > device.max_image_side {
            Some(format!(
                "an image is {} texels long, the device allows {}",
                self.max_side, device.max_image_side
            ))
        } else if self.max_bytes > device.max_buffer_size {
            Some(format!(
                "an image takes {} bytes, the device allows {}",
                self.max_bytes, device.max_buffer_size
            ))
        } else {
            None
        }
    }
}

/// Uploads the images of a scene, and returns them in the order of the scene. A scene without images gets one image of a
/// single texel, because shaders that sample images need at least one binding.
///
/// # Errors
/// An image exceeds a limit of the device or its free memory.
pub fn upload(device: &Arc<Device>, scene: &Scene) -> Result<Vec<SampledImage>> {
    if scene.images.is_empty() {
        return Ok(vec![SampledImage::new(device, "image", 1, &[[0; 4]])?]);
    }
    let images = scene.images.iter().map(|image| {
        let name = format!("image {}", image.name);
        SampledImage::new(device, &name, image.width, &image.texels)
    });
    images.collect()
}

//! The images of textures, where shaders sample images.

use crate::Result;
use crate::gpu::{Device, DeviceInfo, SampledImage};
use crate::scene::Scene;
use std::sync::Arc;

/// The maximum number of a pass's bindings besides images: both together count for some limits of the device.
const OTHER_BINDINGS: u64 = 64;

/// The sizes of a scene's images, known before the images are uploaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageSizes {
    /// The number of images.
    pub count: u64,
    /// The longest side, in texels.
    pub max_side: u32,
    /// The size of the largest image, in bytes.
    pub max_bytes: u64,
}

impl ImageSizes {
    /// The sizes of a scene's images.
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

    /// A description of the device's limit that the images exceed, if they exceed one.
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

/// Uploads a scene's images. A scene without images has one image of a single texel, so that an image can be bound.
///
/// # Errors
/// More memory than the device has.
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

//! The texture images of a scene, for shader variants that sample images instead of reading texels from a buffer: their
//! upload, and the comparison of their sizes with the limits of the device.

use crate::Result;
use crate::gpu::{Device, DeviceInfo, SampledImage};
use crate::scene::Scene;
use std::sync::Arc;

/// The number of bindings of a pass that are kept free for resources other than images. The device limits the number of
/// images and other resources together, so a larger value lowers the number of images that a scene may have.
const OTHER_BINDINGS: u64 = 64;

/// The count and the largest sizes of a scene's images. They are compared with the limits of the device, to decide whether
/// shaders can sample images or must read texels from a buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageSizes {
    /// The number of images in the scene. A pass that samples images binds all of them.
    pub count: u64,
    /// The longest width or height of any image, in texels; 0 without images. A texel with 16 bits per channel counts as two
    /// along the width.
    pub max_side: u32,
    /// The size in bytes of the texels of the largest image; 0 without images.
    pub max_bytes: u64,
}

impl ImageSizes {
    /// Counts the images of a scene, and finds their longest side in texels and their largest size in bytes,
    /// without uploading them.
    pub fn of(scene: &Scene) -> Self {
        let images = || scene.images.iter();
        let max_side = images()
            .map(|image| image.row_length().max(image.height))
            .max();
        let max_bytes = images()
            .map(|image| size_of_val(&*image.texels) as u64)
            .max();
        Self {
            count: scene.images.len() as u64,
            max_side: max_side.unwrap_or(0),
            max_bytes: max_bytes.unwrap_or(0),
        }
    }

    /// Describes the first limit of the device that the images exceed, as a phrase for reports and errors. The limits apply
    /// to the number of images, the longest side of an image, and the bytes of one image. `None` if the images exceed no
    /// limit, so that shaders can sample them.
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
        SampledImage::new(device, &name, image.row_length(), &image.texels)
    });
    images.collect()
}

//! Commands on images: changes of the layout, and copies of whole rows from a buffer. With them, textures are uploaded, and
//! pictures are presented to capture tools. The images have one level of detail and one layer.

use super::buffer::Buffer;
use super::commands::Commands;
use ash::vk;

/// Layout of an image while rows are copied into it. The layout `GENERAL` would also work, but the validation
/// layers warn of copies into images with that layout.
pub(super) const UPLOAD: vk::ImageLayout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;

/// The subresource range of a whole colour image with one level of detail and one layer. All images of Headwater are of this
/// form.
pub(super) const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// A range of whole rows of an image, which one command copies. A large image is uploaded in several such ranges, so that
/// staging memory stays small.
pub(super) struct Rows {
    /// Width of the image, and so of each row, in pixels.
    pub(super) width: u32,
    /// Index of the first row of the range, counted from the top of the image.
    pub(super) first: u32,
    /// Number of rows in the range.
    pub(super) count: u32,
}

impl Commands {
    /// Records a change of the whole image from the layout `from` to the layout `to`. The change is also a barrier: all
    /// memory accesses of earlier commands finish before those of later commands begin.
    pub(super) fn change_layout(&self, image: vk::Image, [from, to]: [vk::ImageLayout; 2]) {
        let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(all)
            .dst_access_mask(all)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image)
            .subresource_range(WHOLE)];
        let stages = vk::PipelineStageFlags::ALL_COMMANDS;
        // SAFETY: plain command on a buffer that is being recorded; the image is in the layout `from` then.
        unsafe {
            self.device.raw.cmd_pipeline_barrier(
                self.raw(),
                stages,
                stages,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &barrier,
            );
        }
    }

    /// Records a copy of `rows`, four bytes per pixel, from the start of a buffer into an image in the layout [`UPLOAD`].
    /// The caller must have checked that the buffer and the image are large enough for the rows.
    pub(super) fn copy_rows(&self, from: &Buffer, to: vk::Image, rows: &Rows) {
        let region = [vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: WHOLE.aspect_mask,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_offset(vk::Offset3D {
                x: 0,
                y: rows.first as i32,
                z: 0,
            })
            .image_extent(vk::Extent3D {
                width: rows.width,
                height: rows.count,
                depth: 1,
            })];
        // SAFETY: both allow transfers, and are alive until the commands have run.
        unsafe {
            let raw = &self.device.raw;
            raw.cmd_copy_buffer_to_image(self.raw(), from.raw, to, UPLOAD, &region);
        }
    }
}

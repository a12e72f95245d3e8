//! Functions that cut a picture into strips of whole rows, each with a separate buffer. Strips are needed because a
//! device can bind only a limited number of bytes at once (128 MiB in lavapipe). Also, the driver of a GPU that drives a
//! display may abort a submission that takes too long.

use crate::gpu::{Buffer, Device, Usage};
use crate::shader_interface::{Strip, TILE};
use crate::{Error, Result};
use std::sync::Arc;

/// The maximum number of pixels in a strip. A strip has at least `TILE` rows, so a strip of a very wide picture can have
/// more pixels. Each strip is one submission; a software driver on two CPU cores takes about one second to path trace a
/// strip. Higher: fewer submissions, but each takes longer, and the driver of a GPU that also drives a display may abort a
/// long one.
const MAX_PIXELS: u64 = 1 << 20;

/// The maximum number of workgroups along one axis of a dispatch that every Vulkan device supports. A workgroup covers a
/// tile of `TILE` × `TILE` pixels, so this number limits the sides of a picture or strip.
const MAX_TILES: u32 = 65_535;

/// The maximum width and height, in pixels, of a picture or strip that one dispatch covers. Wider pictures are refused;
/// higher ones are cut into strips, or are refused by an integrator that needs the whole picture in one dispatch.
const MAX_SIDE: u32 = MAX_TILES * TILE;

/// Checks that one side of a picture, `pixels` pixels long, has at most 65,535 tiles, because not every Vulkan device can
/// dispatch more workgroups along an axis. `how` names the side in the message: `wide` or `high`.
///
/// # Errors
/// The side is longer than `MAX_SIDE` pixels.
pub(super) fn check_side(how: &str, pixels: u32) -> Result<()> {
    if pixels > MAX_SIDE {
        return Err(Error::input(format!(
            "a picture {pixels} pixels {how}; at most {MAX_SIDE} are possible"
        )));
    }
    Ok(())
}

/// Cuts a picture of `width` × `height` pixels into strips (groups of whole rows), from top to bottom. The height of a
/// strip is a multiple of `TILE` rows, except for the last one, and at most `MAX_SIDE`. Each strip has at most
/// `most_bytes` bytes, with `bytes_a_pixel` bytes per pixel. It has at most `MAX_PIXELS` pixels, unless `TILE` rows
/// already have more.
///
/// # Errors
/// One row of tiles has more than `most_bytes` bytes, or more than 65,535 tiles, which not every device can dispatch.
fn cut_to(width: u32, height: u32, bytes_a_pixel: u64, most_bytes: u64) -> Result<Vec<Strip>> {
    check_side("wide", width)?;
    let row = u64::from(width) * bytes_a_pixel;
    let fitting = most_bytes / row / u64::from(TILE);
    if fitting == 0 {
        return Err(Error::input(format!(
            "{TILE} rows of {width} pixels take {} bytes, but the device binds at most {most_bytes}; choose a smaller --width",
            row * u64::from(TILE)
        )));
    }
    let wanted = (MAX_PIXELS / u64::from(width * TILE)).clamp(1, MAX_TILES.into());
    let rows = fitting.min(wanted).min(u64::from(height.div_ceil(TILE))) as u32 * TILE;
    Ok((0..height)
        .step_by(rows as usize)
        .map(|first_row| Strip {
            first_row,
            rows: rows.min(height - first_row),
        })
        .collect())
}

/// Cuts a picture into strips (groups of whole rows), from top to bottom, and makes a buffer for each strip, with space for
/// one `T` per pixel. Passes then run once per strip. `name` is the name of all these buffers.
///
/// # Errors
/// [`cut`] returns an error, or the device has too little free memory.
pub(super) fn strips_of<T>(
    device: &Arc<Device>,
    name: &str,
    width: u32,
    height: u32,
) -> Result<Vec<(Strip, Buffer)>> {
    cut::<T>(device, name, width, height)?
        .into_iter()
        .map(|strip| {
            let size = (strip.pixels(width) * size_of::<T>()) as u64;
            Ok((strip, Buffer::new(device, name, size, Usage::default())?))
        })
        .collect()
}

/// Cuts a picture into strips (groups of whole rows), from top to bottom, so that the device can bind a buffer with one `T`
/// for each pixel of a strip. The caller makes the buffers; error messages call them `name`.
///
/// # Errors
/// The buffers of all strips together exceed the memory of the device, or the picture is wider than the device can bind or
/// dispatch.
pub(super) fn cut<T>(device: &Device, name: &str, width: u32, height: u32) -> Result<Vec<Strip>> {
    let bytes = size_of::<T>() as u64;
    let info = &device.info;
    let total = u64::from(width) * u64::from(height) * bytes;
    if total > info.device_memory {
        return Err(Error::input(format!(
            "a picture of {width} × {height} needs {total} bytes for its {name}, but device '{}' has {}",
            info.name, info.device_memory
        )));
    }
    let most = info.max_storage_buffer_range.min(info.max_buffer_size);
    cut_to(width, height, bytes, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_cover_the_picture_and_fit() {
        let sizes = [
            (1, 1),
            (640, 360),
            (2560, 1440),
            (8192, 8192),
            (349_525, 9),
            (1, 600_000),
        ];
        for (width, height) in sizes {
            let strips = cut_to(width, height, 48, 1 << 27).unwrap();
            let mut next = 0;
            for strip in &strips {
                assert_eq!(strip.first_row, next);
                assert_eq!(next % TILE, 0);
                assert!(strip.pixels(width) as u64 * 48 <= 1 << 27);
                assert!(strip.rows <= MAX_SIDE);
                next += strip.rows;
            }
            assert_eq!(next, height);
        }
    }

    #[test]
    fn rows_that_cannot_be_bound_are_refused_with_their_bytes() {
        let error = |width| cut_to(width, 8, 48, 1 << 27).unwrap_err().to_string();
        assert!(error(400_000).contains("153600000"));
        assert!(error(MAX_SIDE + 1).contains("524280"));
    }
}

//! Decodes the images of textures (PNG, JPEG, WebP, KTX2) to RGBA with 8 bits per channel, or with 16 if a PNG file has them. It
//! limits the sizes that files may state in their headers, so that a small file cannot fill the memory.

use super::ktx2;
use super::progress::Progress;
use crate::base::memory;
use crate::base::panics::caught;
use crate::scene::notices::quoted;
use crate::scene::texture::Image;
use crate::{Error, Result};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Cursor;

/// The largest width and the largest height of an image, in texels. A larger image is an error, because a small file can
/// state any size in its header, and decoding it would fill the memory.
pub const MAX_SIZE: u32 = 16384;

/// The maximum number of texels of all images of a scene together, where a texel with 16 bits per channel counts as two; more
/// are an error. The limit exists because shaders find a texel by an index of 32 bits among the texels of all images.
pub const MAX_TEXELS: u64 = 1 << 32;

/// The size of one texel after decoding, in bytes: one byte for each of red, green, blue and alpha. A texel with 16 bits per
/// channel counts as two. From it loaders compute how much memory images will take.
pub(super) const BYTES: u64 = size_of::<[u8; 4]>() as u64;

/// The maximum number of texels of the images that are decoded at the same time, in parallel: as many as one image of the
/// largest size has. The limit saves memory, because an image takes up to four times its final size while it is decoded.
const TEXELS_AT_ONCE: u64 = MAX_SIZE as u64 * MAX_SIZE as u64;

/// The maximum number of bytes that an image decoder may allocate for data other than texels, such as the colour profile of
/// a PNG file. Without the limit a small file could fill the memory, because compressed data can become a thousand times
/// larger when they are decoded.
const MAX_METADATA: u64 = 16 << 20;

/// The content of a PNG, JPEG, WebP or KTX2 file that is not decoded yet, with two names of the image for messages. Loaders
/// collect one for each image of a scene, so that [`decode`] can decode several in parallel.
pub(super) struct Encoded<'a> {
    /// The element of the scene's file that contains or names the image, such as `image 3`, for messages.
    pub what: String,
    /// The path of the image's file as the scene states it or, for an image without a file, the name of the image in the
    /// scene's file. It may be empty. Messages show it, and it becomes the name of the decoded image.
    pub name: String,
    /// The whole content of a PNG, JPEG, WebP or KTX2 file. The format is recognised from these bytes, not from the name.
    pub bytes: Cow<'a, [u8]>,
}

/// The sum of the numbers of texels of a scene's images, to which each image is added before it is decoded. If it exceeds
/// [`MAX_TEXELS`], loading ends with an error before more memory is taken.
#[derive(Default)]
pub(super) struct TexelCount(u64);

impl TexelCount {
    /// Adds `texels`, the number of texels of one more image, to the sum. If the sum then exceeds the limit, `name` is
    /// called, which returns the name of this image for the error.
    ///
    /// # Errors
    /// With this image, the images of the scene have more than [`MAX_TEXELS`] texels.
    pub fn add(&mut self, texels: u64, name: impl FnOnce() -> String) -> Result<()> {
        self.0 = self.0.saturating_add(texels);
        if self.0 <= MAX_TEXELS {
            return Ok(());
        }
        Err(Error::input(format!(
            "{}: with its {} bytes the scene's images have {} bytes when decoded, more than {}; scale them",
            name(),
            BYTES * texels,
            BYTES.saturating_mul(self.0),
            BYTES * MAX_TEXELS
        )))
    }
}

/// The images of a scene after decoding.
pub(super) struct Decoded {
    /// The decoded images, in the order of their files.
    pub images: Vec<Image>,
    /// For each encoded image, its index in [`Self::images`]; `None` if it was left out.
    pub index_of: Vec<Option<usize>>,
}

/// Decodes images, several at a time in parallel. `count` is the number of texels of the scene's images so far; the texels of
/// these images are added to it. `leave_out` decides about each image that cannot be decoded: it is called with the index of
/// the image in `encoded` and with the fault. If it returns `Ok`, the image is left out.
///
/// # Errors
/// `leave_out` returns an error, for an image that is not a PNG, JPEG, WebP or KTX2 file, is damaged, or is larger than
/// [`MAX_SIZE`]; the scene's images have more than [`MAX_TEXELS`] texels or need more memory than there is; or the callback
/// of `progress` returns an error.
pub(super) fn decode(
    encoded: &[Encoded<'_>],
    count: &mut TexelCount,
    progress: &mut Progress<'_>,
    leave_out: &mut dyn FnMut(usize, Error) -> Result<()>,
) -> Result<Decoded> {
    // All sizes first: what is too much must not fill the memory. An image that is left out has size 0.
    let mut sizes: Vec<u64> = Vec::with_capacity(encoded.len());
    for (index, image) in encoded.iter().enumerate() {
        let texels = image.guarded(Encoded::texels).or_else(|fault| {
            leave_out(index, fault)?;
            Ok(0)
        })?;
        count.add(texels, || image.label())?;
        sizes.push(texels);
    }
    let texels: u64 = sizes.iter().sum();
    memory::check(BYTES * (texels + 3 * texels.min(TEXELS_AT_ONCE)))
        .map_err(|cause| Error::input(format!("the scene's images: {cause}; scale them")))?;
    let (mut images, mut index_of) = (Vec::new(), Vec::with_capacity(encoded.len()));
    while index_of.len() < encoded.len() {
        progress.pause()?;
        let (_, sizes) = sizes.split_at(index_of.len());
        let batch = &encoded[index_of.len()..][..batch_length(sizes)];
        let decoded: Vec<Option<Result<Image>>> = (batch.par_iter().zip(sizes))
            .map(|(image, size)| (*size > 0).then(|| image.guarded(Encoded::decode)))
            .collect();
        for image in decoded {
            let image = image.transpose().or_else(|fault| {
                leave_out(index_of.len(), fault)?;
                Ok(None)
            })?;
            index_of.push(image.map(|image| {
                images.push(image);
                images.len() - 1
            }));
        }
    }
    progress.pause()?;
    Ok(Decoded { images, index_of })
}

/// The number of images in the next batch, whose images are decoded in parallel. `sizes` is the number of texels of each
/// image that is not decoded yet, in their order. A batch has at least one image and at most four per thread, so that threads
/// seldom wait for the slowest image, and at most [`TEXELS_AT_ONCE`] texels.
fn batch_length(sizes: &[u64]) -> usize {
    let mut texels = 0;
    let fitting = sizes.iter().take_while(|size| {
        texels += **size;
        texels <= TEXELS_AT_ONCE
    });
    fitting
        .take(4 * rayon::current_num_threads())
        .count()
        .max(1)
}

impl Encoded<'_> {
    /// The name of the image in messages: the element of the scene's file that contains or names it, such as `image 3`,
    /// followed by the image's own name in parentheses, if it has one.
    fn label(&self) -> String {
        match self.name.as_str() {
            "" => self.what.clone(),
            name => format!("{} ({})", self.what, quoted(name)),
        }
    }

    fn wrong(&self, fault: impl std::fmt::Display) -> Error {
        Error::input(format!("{}: {fault}", self.label()))
    }

    fn damaged(&self, cause: impl std::fmt::Display) -> Error {
        let cause = cause.to_string().replace('\n', " ");
        self.wrong(format!("cannot be decoded: {cause}; export it again"))
    }

    /// Runs `work`, which decodes this image or its header. If `work` panics, which decoders may do on damaged data, this
    /// function returns an error that the image is damaged.
    fn guarded<T>(&self, work: impl FnOnce(&Self) -> Result<T>) -> Result<T> {
        caught(|| work(self)).unwrap_or_else(|| Err(self.damaged("it is damaged")))
    }

    /// The number of texels of the image, computed from the width and the height in the header of its file. It is doubled for
    /// an image with 16 bits per channel, as in [`Image::texels`]. Fails if the header is damaged, if the format is not PNG,
    /// JPEG, WebP or KTX2, or if the width or the height is 0 or above [`MAX_SIZE`].
    fn texels(&self) -> Result<u64> {
        let (width, height, entries) = if ktx2::is_ktx2(&self.bytes) {
            let (width, height) = self.ktx2_size()?;
            (width, height, 1)
        } else {
            let (decoder, _) = self.decoder()?;
            let (width, height) = decoder.dimensions();
            let entries = if is_deep(decoder.color_type()) { 2 } else { 1 };
            (width, height, entries)
        };
        Ok(entries * u64::from(width) * u64::from(height))
    }

    /// The width and the height of a KTX2 file, in texels. Fails if the file is not one that can be decoded, or if the width
    /// or the height is 0 or above [`MAX_SIZE`].
    fn ktx2_size(&self) -> Result<(u32, u32)> {
        let size = ktx2::size(&self.bytes).map_err(|cause| self.damaged(cause))?;
        self.check_size(size)?;
        Ok(size)
    }

    fn check_size(&self, (width, height): (u32, u32)) -> Result<()> {
        if width > MAX_SIZE || height > MAX_SIZE || width == 0 || height == 0 {
            return Err(self.wrong(format!(
                "has {width} × {height} texels, it must be 1 to {MAX_SIZE} each way; scale it"
            )));
        }
        Ok(())
    }

    /// A decoder that has read the header of the file but no texels yet, and the format of the file. Fails if the format is
    /// not PNG, JPEG or WebP, if the header is damaged, or if the width or the height is 0 or above [`MAX_SIZE`].
    fn decoder(&self) -> Result<(impl ImageDecoder, ImageFormat)> {
        let mut reader = ImageReader::new(Cursor::new(&*self.bytes))
            .with_guessed_format()
            .map_err(|cause| self.damaged(cause))?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(MAX_METADATA);
        reader.limits(limits);
        // The library reads other formats too, for environments.
        let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) =
            reader.format()
        else {
            return Err(self.wrong("is not PNG, JPEG, WebP or KTX2; convert it to one of them"));
        };
        let decoder = reader.into_decoder().map_err(|cause| self.damaged(cause))?;
        self.check_size(decoder.dimensions())?;
        Ok((decoder, format))
    }

    fn decode(&self) -> Result<Image> {
        if ktx2::is_ktx2(&self.bytes) {
            let (width, height) = self.ktx2_size()?;
            let decoded = ktx2::decode(&self.bytes).map_err(|cause| self.damaged(cause))?;
            let texels: &[[u8; 4]] = bytemuck::cast_slice(&decoded);
            return Ok(Image {
                name: self.name.clone(),
                width,
                height,
                texels: texels.into(),
            });
        }
        let (decoder, format) = self.decoder()?;
        // Some decoders accept a truncated file without an error, and invent the missing texels.
        let is_whole = match format {
            ImageFormat::Jpeg => is_whole_jpeg(&self.bytes),
            ImageFormat::WebP => is_whole_webp(&self.bytes),
            _ => true,
        };
        if !is_whole {
            return Err(self.damaged("it is cut off"));
        }
        let decoded = DynamicImage::from_decoder(decoder).map_err(|cause| self.damaged(cause))?;
        let (width, height) = (decoded.width(), decoded.height());
        let texels = if is_deep(decoded.color()) {
            let decoded = decoded.into_rgba16();
            decoded
                .pixels()
                .flat_map(|texel| Image::entries(texel.0))
                .collect()
        } else if let DynamicImage::ImageRgb8(rgb) = &decoded {
            // The most common form, for which the library would make two copies.
            let (texels, _) = rgb.as_raw().as_chunks();
            texels.iter().map(|[r, g, b]| [*r, *g, *b, 255]).collect()
        } else {
            bytemuck::cast_slice(decoded.into_rgba8().as_raw()).into()
        };
        Ok(Image {
            name: self.name.clone(),
            width,
            height,
            texels,
        })
    }
}

/// True if an image of this type has more than 8 bits per channel; it then keeps 16 bits.
fn is_deep(color: ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}

/// True if the content `bytes` of a JPEG file is not cut off, because it contains the end marker of the image. A photograph
/// may contain a small preview image in a segment of its file; end markers inside segments do not count.
fn is_whole_jpeg(bytes: &[u8]) -> bool {
    const END: u8 = 0xD9;
    // These markers have no segment; 0 stands for a byte of data, and FF before a marker for nothing.
    let is_alone = |code: u8| matches!(code, 0 | 0x01 | 0xD0..=0xD8 | 0xFF);
    let mut rest = bytes;
    loop {
        let is_marker = |pair: &[u8]| pair[0] == 0xFF && !is_alone(pair[1]);
        let Some(at) = rest.windows(2).position(is_marker) else {
            return false;
        };
        if rest[at + 1] == END {
            return true;
        }
        // The length of the segment counts its own two bytes.
        rest = &rest[at + 2..];
        let length = rest.first_chunk().map(|length| u16::from_be_bytes(*length));
        match length.and_then(|length| rest.get(usize::from(length)..)) {
            Some(after) => rest = after,
            None => return false,
        }
    }
}

/// True if the content `bytes` of a WebP file is not cut off, because it has at least the length that its header states. The
/// stated length does not include the first eight bytes of the file. One byte less is accepted, because some programs leave
/// out the padding byte at the end.
fn is_whole_webp(bytes: &[u8]) -> bool {
    let length = bytes.get(4..).and_then(|bytes| bytes.first_chunk());
    length
        .is_some_and(|length| bytes.len() as u64 + 1 >= 8 + u64::from(u32::from_le_bytes(*length)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jpeg_is_whole_if_its_own_end_is_there() {
        let start = [0xFF, 0xD8];
        let preview = [0xFF, 0xE1, 0, 6, 0xFF, 0xD8, 0xFF, 0xD9];
        let scan = [0xFF, 0xDA, 0, 2, 1, 0xFF, 0, 2, 0xFF, 0xD3, 3];
        let end = [0xFF, 0xFF, 0xD9];
        assert!(is_whole_jpeg(&[&start[..], &scan, &end].concat()));
        assert!(is_whole_jpeg(
            &[&start[..], &preview, &scan, &scan, &end, b"more"].concat()
        ));
        for cut in [
            &[&start[..], &preview, &scan].concat()[..],
            &[&start[..], &scan, &[0xFF]].concat(),
            &preview[..7],
            &[0xFF, 0xD8, 0xFF, 0xE1],
            b"",
        ] {
            assert!(!is_whole_jpeg(cut), "{cut:?}");
        }
    }

    #[test]
    fn a_webp_is_whole_if_it_is_as_long_as_it_says() {
        let whole = b"RIFF\x06\0\0\0WEBPab";
        assert!(is_whole_webp(whole) && is_whole_webp(&[&whole[..], b"more"].concat()));
        assert!(!is_whole_webp(&whole[..12]) && !is_whole_webp(b"RIFF"));
    }

    #[test]
    fn large_images_are_decoded_one_by_one() {
        let largest = TEXELS_AT_ONCE;
        assert_eq!(batch_length(&[largest, 1, 1]), 1);
        assert_eq!(batch_length(&[1, largest, 1]), 1);
        assert_eq!(batch_length(&[1]), 1);
        let threads = rayon::current_num_threads();
        assert_eq!(batch_length(&vec![1; 4 * threads + 1]), 4 * threads);
    }

    #[test]
    fn texels_are_counted_up_to_the_limit() {
        let mut count = TexelCount::default();
        count.add(MAX_TEXELS - 1, || "a".into()).unwrap();
        count.add(1, || "b".into()).unwrap();
        let text = count.add(1, || "c".into()).unwrap_err().to_string();
        assert!(
            text.starts_with("c: with its 4 bytes") && text.contains("17179869188 bytes"),
            "{text}"
        );
    }
}

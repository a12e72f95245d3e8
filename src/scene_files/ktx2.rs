//! Decodes KTX2 images that Basis Universal has compressed (ETC1S and UASTC), as `KHR_texture_basisu` defines them. Only the
//! finest level is read.

use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};

/// The first bytes of every KTX2 file.
const IDENTIFIER: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// The number of bytes of a block of 4 × 4 texels in UASTC.
const UASTC_BLOCK_BYTES: u64 = 16;

/// The value of a KTX2 header for levels that are compressed with Zstandard.
const ZSTANDARD: u32 = 2;

/// True if the content `bytes` of a file begins as a KTX2 file does.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(IDENTIFIER)
}

/// The width and the height of the finest level of a KTX2 file, in texels, from its header.
///
/// # Errors
/// The header is cut off, or the file is not one image that Basis Universal has compressed; the text states which.
pub(super) fn size(bytes: &[u8]) -> Result<(u32, u32), &'static str> {
    let (format, depth, layers, faces) = (
        word(bytes, 12)?,
        word(bytes, 28)?,
        word(bytes, 32)?,
        word(bytes, 36)?,
    );
    if format != 0 {
        return Err("its texels are not compressed by Basis Universal");
    }
    if depth != 0 || layers > 1 || faces != 1 {
        return Err("it is not a single two-dimensional image");
    }
    Ok((word(bytes, 20)?, word(bytes, 24)?))
}

/// The texels of the finest level, row by row from the top, with the bytes red, green, blue and alpha. The caller has
/// checked the memory for the texels of [`size`].
///
/// # Errors
/// The file is damaged, or its texels are in another format of Basis Universal, which glTF does not permit and whose decoders
/// allocate what the file states; the text states which.
pub(super) fn decode(bytes: &[u8]) -> Result<Vec<u8>, &'static str> {
    let (width, height) = size(bytes)?;
    // The decoder allocates as many bytes as the file states for its level.
    if word(bytes, 44)? == ZSTANDARD {
        let stated = u64::from(word(bytes, 96)?) | u64::from(word(bytes, 100)?) << 32;
        let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
        if stated != blocks * UASTC_BLOCK_BYTES {
            return Err("its level 0 does not have the size of its texels");
        }
    }
    const DAMAGED: &str = "the data are damaged";
    let image = Transcoder::new(bytes).map_err(|_| DAMAGED)?;
    match image.source_format() {
        SourceFormat::Etc1s | SourceFormat::UastcLdr => image
            .transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
            .map_err(|_| DAMAGED),
        _ => Err("its texels are neither ETC1S nor UASTC"),
    }
}

/// The unsigned number in the four bytes from byte `at`. Fails if the file ends before the fourth byte.
fn word(bytes: &[u8], at: usize) -> Result<u32, &'static str> {
    let word = bytes.get(at..).and_then(|bytes| bytes.first_chunk());
    word.map(|word| u32::from_le_bytes(*word))
        .ok_or("it is cut off")
}

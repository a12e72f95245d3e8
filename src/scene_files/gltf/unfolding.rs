//! A limit on the memory that the elements of a glTF file take when they are unfolded, which means copied out of its
//! buffers. Many elements may use the same bytes, so a small file could otherwise require any amount of memory or time.

use crate::base::memory;
use crate::{Error, Result};
use std::cell::Cell;

/// The number of bytes that the elements of a glTF file may take, when copied out of its buffers, for each byte of the file.
/// The limit is this number times the size of the file, plus [`FREE_BYTES`].
const RATIO: u64 = 64;

/// The number of bytes that the elements of a glTF file may always take when copied out of its buffers, however small the
/// file is.
const FREE_BYTES: u64 = 1 << 30;

/// The number of bytes that the elements of a glTF file (vertices, indices, keys) may still take when they are copied out of
/// the file's buffers. It decreases with each read, and bounds the memory that a small file can require.
pub struct Unfolding(Cell<u64>);

impl Unfolding {
    /// The limit for a file whose buffers and JSON have `file_bytes` bytes together.
    pub fn of(file_bytes: u64) -> Self {
        Self(Cell::new(
            FREE_BYTES.saturating_add(file_bytes.saturating_mul(RATIO)),
        ))
    }

    /// Subtracts `bytes`, the memory that elements will take, from the limit. `what` names the elements in messages.
    ///
    /// # Errors
    /// The limit has fewer bytes left, or there is not enough memory for them.
    pub fn take(&self, what: &str, bytes: u128) -> Result<()> {
        let bytes = u64::try_from(bytes).ok();
        match bytes.and_then(|bytes| self.0.get().checked_sub(bytes)) {
            Some(left) => {
                self.0.set(left);
                memory::check(bytes.unwrap_or_default())
                    .map_err(|cause| Error::input(format!("{what}: {cause}; split the file")))
            }
            None => Err(Error::input(format!(
                "{what}: with it the file unfolds to more than {RATIO} times its size; split the file"
            ))),
        }
    }
}

//! A limit on the memory that the elements of a glTF file (vertices, indices, keys) take when they are unfolded, which means
//! copied out of the file's buffers. Many elements may use the same bytes of a buffer, so a small file could otherwise
//! require any amount of memory or time.

use crate::base::memory;
use crate::{Error, Result};
use std::cell::Cell;

/// The number of bytes that the elements of a glTF file may take for each byte of its JSON and its buffers, when they are
/// copied out of the buffers. The whole limit is this number times the size of JSON and buffers, plus [`FREE_BYTES`]. A file
/// whose elements would take more is an error.
const RATIO: u64 = 64;

/// The constant part of the limit, in bytes (1 GiB). The elements of a glTF file may take this much memory in any case, so
/// that a small file is not refused only because many of its elements use the same bytes.
const FREE_BYTES: u64 = 1 << 30;

/// The number of bytes that the elements of a glTF file (vertices, indices, keys) may still take when they are copied out of
/// the file's buffers. Each read of elements subtracts its bytes; if too few are left, loading ends with an error. Thus a
/// small file cannot require any amount of memory.
pub struct Unfolding(Cell<u64>);

impl Unfolding {
    /// The limit of memory for a glTF file, before any element is read. It grows with `file_bytes`, the size in bytes of the
    /// file's JSON and of its buffers.
    pub fn of(file_bytes: u64) -> Self {
        Self(Cell::new(
            FREE_BYTES.saturating_add(file_bytes.saturating_mul(RATIO)),
        ))
    }

    /// Subtracts `bytes`, the memory that elements will take, from what is left of the limit. Readers call this before they
    /// allocate the memory. `what` names the elements in messages.
    ///
    /// # Errors
    /// Less than `bytes` is left of the limit, or the machine has less free memory.
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

//! A limit on the memory of a file's elements when they are unfolded: many may use the same bytes, and a small file could
//! otherwise require any amount of memory or time.

use crate::base::memory;
use crate::{Error, Result};
use std::cell::Cell;

/// The number of bytes to which elements may unfold per byte of the file, in addition to [`FREE_BYTES`].
const RATIO: u64 = 64;

/// The number of bytes to which any file may unfold.
const FREE_BYTES: u64 = 1 << 30;

/// The number of bytes to which a file may still unfold.
pub struct Unfolding(Cell<u64>);

impl Unfolding {
    /// The allowance of a file whose buffers and JSON have `file_bytes` bytes.
    pub fn of(file_bytes: u64) -> Self {
        Self(Cell::new(
            FREE_BYTES.saturating_add(file_bytes.saturating_mul(RATIO)),
        ))
    }

    /// Takes the bytes of an element; `what` names it in the message.
    ///
    /// # Errors
    /// There are fewer bytes left, or there is not enough memory for them.
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

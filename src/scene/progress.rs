//! Progress of loading a scene, reported to a callback.

use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A step of loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Reading the file and those that it refers to; counted in bytes.
    Reading,
    /// Decoding; counted in meshes.
    Decoding,
}

/// A callback that receives the step, how much of it is done, and the total; its error stops the
/// loading.
pub type Watch<'a> = dyn FnMut(Step, u64, u64) -> Result<()> + 'a;

/// Sums the bytes read of all files.
pub(super) struct Progress<'a> {
    watch: &'a mut Watch<'a>,
    read: u64,
    to_read: u64,
}

impl<'a> Progress<'a> {
    pub(super) fn new(watch: &'a mut Watch<'a>) -> Self {
        Self {
            watch,
            read: 0,
            to_read: 0,
        }
    }

    /// Adds `bytes` to the total to read.
    pub(super) fn expect(&mut self, bytes: u64) {
        self.to_read = self.to_read.saturating_add(bytes);
    }

    /// Asks the watcher, between things that take long, whether to go on.
    pub(super) fn pause(&mut self) -> Result<()> {
        (self.watch)(Step::Reading, self.read, self.to_read)
    }

    /// Reports that `done` of `total` meshes are decoded.
    pub(super) fn decoded(&mut self, done: usize, total: usize) -> Result<()> {
        (self.watch)(Step::Decoding, done as u64, total as u64)
    }
}

/// A file that reports the progress of its reading.
pub(super) struct Watched<'p, 'a> {
    file: File,
    progress: &'p mut Progress<'a>,
}

impl<'p, 'a> Watched<'p, 'a> {
    pub(super) fn new(file: File, progress: &'p mut Progress<'a>) -> Self {
        Self { file, progress }
    }
}

impl Read for Watched<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.progress.read += count as u64;
        // Carried through std::io as it is; see Error::from_io.
        self.progress.pause().map_err(std::io::Error::other)?;
        Ok(count)
    }
}

/// At most `at_most` bytes of a file; `unreadable` makes the error for a cause.
///
/// # Errors
/// The file cannot be read, or the watcher's error.
pub(super) fn read_file(
    path: &Path,
    at_most: u64,
    progress: &mut Progress<'_>,
    unreadable: impl Fn(&dyn std::fmt::Display) -> Error,
) -> Result<Vec<u8>> {
    let file = File::open(path).map_err(|cause| unreadable(&cause))?;
    let found = file.metadata().map_err(|cause| unreadable(&cause))?;
    if !found.is_file() {
        return Err(unreadable(&"it is not a file"));
    }
    let length = at_most.min(found.len());
    let mut bytes = room_for(length).map_err(|cause| unreadable(&cause))?;
    Watched::new(file, progress)
        .take(length)
        .read_to_end(&mut bytes)
        .map_err(|cause| Error::from_io(cause, |cause| unreadable(&cause)))?;
    Ok(bytes)
}

/// An empty vector with a capacity of `bytes`.
///
/// # Errors
/// Not enough memory: a sparse file can claim to be larger than any disk.
pub(super) fn room_for(bytes: u64) -> Result<Vec<u8>> {
    let mut room = Vec::new();
    usize::try_from(bytes)
        .ok()
        .and_then(|bytes| room.try_reserve_exact(bytes).ok())
        .ok_or_else(|| {
            Error::input(format!(
                "{bytes} bytes are more than there is memory for; give a smaller scene"
            ))
        })?;
    Ok(room)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_little_and_none_for_all() {
        assert!(room_for(1000).unwrap().capacity() >= 1000);
        let error = room_for(u64::MAX).unwrap_err();
        assert!(error.to_string().contains("18446744073709551615 bytes"));
        assert_eq!(error.exit_status(), 2);
    }
}

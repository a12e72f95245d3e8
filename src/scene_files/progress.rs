//! Progress of loading a scene, reported to a callback.

use super::scene_folder::{SceneFile, unreadable};
use crate::base::input_files;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;

/// A step of loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Reading the file and the files that it names, counted in bytes.
    Reading,
    /// Decoding; counted in meshes.
    Decoding,
}

/// A callback that receives the step, its progress and its total; an error from it stops the loading.
pub type Watch<'a> = dyn FnMut(Step, u64, u64) -> Result<()> + 'a;

/// The sum of the bytes read from all files.
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

    /// Adds `bytes` to the total number of bytes to read.
    pub(super) fn expect(&mut self, bytes: u64) {
        self.to_read = self.to_read.saturating_add(bytes);
    }

    /// Calls the watcher between long steps; its error ends the loading.
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

/// At most `at_most` bytes of a file that a scene names; `what` is the element that names it, for messages.
///
/// # Errors
/// The file cannot be read, there is no memory for it, or the watcher's error.
pub(super) fn read_file(
    what: &str,
    file: SceneFile,
    at_most: u64,
    progress: &mut Progress<'_>,
) -> Result<Vec<u8>> {
    let name = &file.name;
    let length = at_most.min(file.length);
    progress.expect(length);
    input_files::read_length(Watched::new(file.file, progress), length)
        .map_err(|cause| Error::from_io(cause, |cause| unreadable(what, name, &cause)))
}

//! Progress of loading a scene, reported to a callback.

use super::scene_folder::{SceneFile, unreadable};
use crate::base::input_files;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;

/// The step of loading a scene that a report of progress is about. It determines the unit of the report's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Reading the scene's file and the files that it names. Progress and total are in bytes.
    Reading,
    /// Decoding the meshes of a glTF file. Progress and total are numbers of meshes.
    Decoding,
}

/// A callback that receives the current step of loading, its progress and its total, in the unit of the step. The total may
/// grow as files name further files. An error that the callback returns ends the loading.
pub type Watch<'a> = dyn FnMut(Step, u64, u64) -> Result<()> + 'a;

/// The callback that receives the progress of loading a scene, and the numbers of bytes for it: those read so far, and the
/// total of all files of the scene that are known so far.
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

    /// Adds `bytes` to the total number of bytes to read, because one more file will be read.
    pub(super) fn expect(&mut self, bytes: u64) {
        self.to_read = self.to_read.saturating_add(bytes);
    }

    /// Reports the bytes read so far to the callback. Loaders call this function between long pieces of work, so that the
    /// user can end the loading: then the callback returns an error, and so does this function.
    pub(super) fn pause(&mut self) -> Result<()> {
        (self.watch)(Step::Reading, self.read, self.to_read)
    }

    /// Reports to the callback that `done` of `total` meshes are decoded. Returns the callback's error.
    pub(super) fn decoded(&mut self, done: usize, total: usize) -> Result<()> {
        (self.watch)(Step::Decoding, done as u64, total as u64)
    }
}

/// An open file that adds all bytes read from it to the progress of loading, and reports them.
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

/// Reads the first `at_most` bytes of a file that a scene names, or the whole file if it is shorter. `what` is the element
/// of the scene that names the file, for messages.
///
/// # Errors
/// The file cannot be read, there is not enough memory for it, or the callback of `progress` returns an error.
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

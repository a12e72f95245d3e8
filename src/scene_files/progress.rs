//! The progress of loading a scene. Loaders report it to a callback of the user, which can show it and can end the loading.

use super::scene_folder::{SceneFile, unreadable};
use crate::base::input_files;
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;

/// The step of loading a scene to which a progress report belongs. It determines the unit of the numbers in the report,
/// bytes or meshes, which a callback needs to show them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The loader reads the scene's file and the files that it names. Progress and total are numbers of bytes.
    Reading,
    /// The loader converts the meshes of a glTF file. Progress and total are numbers of meshes.
    Decoding,
}

/// A callback that receives the current step of loading, the progress of this step and its total, both in the unit of the
/// step. The total may grow while files are read that name further files. If the callback returns an error, the loading ends
/// with this error.
pub type Watch<'a> = dyn FnMut(Step, u64, u64) -> Result<()> + 'a;

/// The callback that receives the progress of loading a scene, and the two numbers of bytes that are reported to it: the
/// bytes read so far, and the total size of all files of the scene that are known so far. All readers of files share it, so
/// that the numbers count the bytes of all of them.
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

    /// Adds `bytes`, the size of one more file that will be read, to the total number of bytes that is
    /// reported to the callback.
    pub(super) fn add_to_read(&mut self, bytes: u64) {
        self.to_read = self.to_read.saturating_add(bytes);
    }

    /// Reports to the callback how many bytes were read so far. Loaders call this function between long pieces of work, so
    /// that the user can end the loading: in this case the callback returns an error, and this function returns the same
    /// error.
    pub(super) fn pause(&mut self) -> Result<()> {
        (self.watch)(Step::Reading, self.read, self.to_read)
    }

    /// Reports to the callback that `done` of `total` meshes of a glTF file are converted. If the callback returns an error,
    /// this function returns the same error.
    pub(super) fn decoded(&mut self, done: usize, total: usize) -> Result<()> {
        (self.watch)(Step::Decoding, done as u64, total as u64)
    }
}

/// A reader of an open file that reports the progress of loading: each read adds its number of bytes to
/// `progress` and calls the user's callback. An error of the callback ends the read.
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

/// Reads the first `at_most` bytes of a file that a scene names, or the whole file if it is shorter, and reports the
/// progress. `what` is the element of the scene that names the file, for messages.
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
    progress.add_to_read(length);
    input_files::read_length(Watched::new(file.file, progress), length)
        .map_err(|cause| Error::from_io(cause, |cause| unreadable(what, name, &cause)))
}

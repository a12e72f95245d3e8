//! Image files of textures, and the treatment of missing ones.

use super::progress::{Progress, read_file};
use super::scene_folder::{SceneFile, SceneFolder, unreadable};
use crate::scene::notices::{Tally, quoted};
use crate::{Error, Result};

/// The largest image file, in bytes: more than the largest image takes without compression.
const MAX_BYTES: u64 = 4 << 30;

/// The bytes of an image file.
///
/// # Errors
/// The file is too large or cannot be read, or the watcher's error.
pub(super) fn read(what: &str, file: SceneFile, progress: &mut Progress<'_>) -> Result<Vec<u8>> {
    let length = file.length;
    if length > MAX_BYTES {
        let text = format!("it has {length} bytes, an image file at most {MAX_BYTES}");
        return Err(unreadable(what, &file.name, &text));
    }
    read_file(what, file, MAX_BYTES, progress)
}

/// Notes that an image file is missing, if `folder` permits it.
///
/// # Errors
/// `folder` does not permit it.
pub(super) fn missing(
    what: &str,
    name: &str,
    folder: &SceneFolder<'_>,
    tally: &mut Tally,
) -> Result<()> {
    let file = quoted(name);
    if folder.options.allow_missing {
        tally.add(
            "image files are missing, the plain factors are used",
            || format!("{file} ({what})"),
        );
        return Ok(());
    }
    Err(Error::input(format!(
        "{what}: there is no file {file} beside the scene; put it there, or render without it by --allow-missing"
    )))
}

//! Reads the image files of textures, and treats missing ones as errors or as notices.

use super::progress::{Progress, read_file};
use super::scene_folder::{SceneFile, SceneFolder, unreadable};
use crate::scene::notices::{Tally, quoted};
use crate::{Error, Result};

/// The maximum size of an image file, in bytes. A larger file is an error: even an uncompressed image with the largest
/// permitted width and height is smaller.
const MAX_BYTES: u64 = 4 << 30;

/// Reads a whole image file without decoding it. `what` is the element of the scene that names the file, for messages.
///
/// # Errors
/// The file has more than [`MAX_BYTES`] bytes or cannot be read, there is not enough memory for it, or the callback of
/// `progress` returns an error.
pub(super) fn read(what: &str, file: SceneFile, progress: &mut Progress<'_>) -> Result<Vec<u8>> {
    let length = file.length;
    if length > MAX_BYTES {
        let text = format!("it has {length} bytes, an image file at most {MAX_BYTES}");
        return Err(unreadable(what, &file.name, &text));
    }
    read_file(what, file, MAX_BYTES, progress)
}

/// Treats a missing image file `name`. If the user permits missing files (`allow_missing`), a notice is added to `tally`,
/// and the caller continues without the texture. `what` is the element of the scene that names the file, for messages.
///
/// # Errors
/// The user does not permit missing files.
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

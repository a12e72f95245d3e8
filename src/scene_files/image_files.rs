//! Reads the image files of textures. A file that is missing or cannot be read is an error; if the user permits missing files,
//! it is only a notice, and the material is rendered without the texture.

use super::progress::{Progress, read_file};
use super::scene_folder::{SceneFile, SceneFolder, unreadable};
use crate::scene::notices::{Tally, quoted};
use crate::{Error, Result};
use std::path::Path;

/// The maximum size of an image file, in bytes. A larger file is an error and is not read, so that it cannot fill the
/// memory. Even an uncompressed image with the largest permitted width and height is smaller.
const MAX_BYTES: u64 = 4 << 30;

/// Reads the whole content of an image file, still encoded, such as PNG. `what` is the element of the scene that
/// names the file, for messages.
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

/// Handles a missing image file; `name` is its path in the scene. If the user permits missing files
/// (`allow_missing`), a notice is added to `tally`, and the caller continues without the texture. `what` is
/// the element of the scene that names the file, for messages.
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
    let hint = folder.hint(Path::new(name));
    Err(Error::input(format!(
        "{what}: there is no file {file} beside the scene{hint}; put it there, or render without it by --allow-missing"
    )))
}

/// Handles an image that cannot be read or decoded because of `fault`. If the scene may do without it (`is_dispensable`), a
/// notice is added to `tally`, and the caller continues without the image.
///
/// # Errors
/// The scene may not do without the image, or `fault` is not a fault of the input.
pub(super) fn leave_out(fault: Error, is_dispensable: bool, tally: &mut Tally) -> Result<()> {
    match fault {
        Error::Input(fault) if is_dispensable => {
            tally.add("images that cannot be read are left out", || fault);
            Ok(())
        }
        other => Err(other),
    }
}

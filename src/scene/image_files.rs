//! Image files of textures: where they may lie, and what follows where one is missing.

use super::load::Options;
use super::notices::{Tally, quoted};
use super::progress::{self, Progress};
use crate::{Error, Result};
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

/// The path, from the scene's folder, of the first of these files that exists; none if none does. Names are paths from
/// that folder too. Of one file the path is always the same.
///
/// # Errors
/// They are outside of the folder, or it cannot be told whether they exist.
pub(super) fn find(what: &str, names: &[PathBuf], folder: &Path) -> Result<Option<PathBuf>> {
    // A scene from elsewhere must not show what else is on this machine.
    let outside = |name: &Path| {
        Err(unreadable(
            what,
            name,
            &"it is outside of the scene's folder; copy it there and name it by its path from there",
        ))
    };
    let inside: Vec<PathBuf> = names.iter().filter_map(|name| normalized(name)).collect();
    if inside.is_empty() {
        return outside(names.last().map_or(Path::new(""), PathBuf::as_path));
    }
    for path in inside {
        let real = match folder.join(&path).canonicalize() {
            Ok(real) => real,
            Err(cause) if cause.kind() == ErrorKind::NotFound => continue,
            Err(cause) => return Err(unreadable(what, &path, &cause)),
        };
        // A link may lead out of the folder. The path of the current folder is empty.
        let folder = match folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => folder,
        };
        let folder = (folder.canonicalize()).map_err(|cause| unreadable(what, folder, &cause))?;
        if !real.starts_with(folder) {
            return outside(&path);
        }
        return Ok(Some(path));
    }
    Ok(None)
}

/// The bytes of a file that [`find`] has found.
///
/// # Errors
/// It cannot be read, or the watcher's error.
pub(super) fn read(
    what: &str,
    path: &Path,
    folder: &Path,
    progress: &mut Progress<'_>,
) -> Result<Vec<u8>> {
    let wrong = |cause: &dyn std::fmt::Display| unreadable(what, path, cause);
    let place = folder.join(path);
    let found = place.metadata().map_err(|cause| wrong(&cause))?;
    // To open a pipe would wait for somebody who writes.
    if !found.is_file() {
        return Err(wrong(&"it is not a file"));
    }
    progress.expect(found.len());
    progress::read_file(&place, u64::MAX, progress, wrong)
}

/// What follows where an image file is missing: a notice if `options` permit it.
///
/// # Errors
/// They do not.
pub(super) fn missing(what: &str, name: &str, options: Options, tally: &mut Tally) -> Result<()> {
    let file = quoted(name);
    if options.allow_missing {
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

fn unreadable(what: &str, path: &Path, cause: &dyn std::fmt::Display) -> Error {
    let name = quoted(&path.to_string_lossy());
    Error::input(format!("{what}: cannot read {name}: {cause}"))
}

/// The path without `.` and `..`; none if it leads out of the folder that it starts from.
fn normalized(path: &Path) -> Option<PathBuf> {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => plain.push(name),
            Component::CurDir => {}
            Component::ParentDir => plain.pop().then_some(())?,
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_may_go_up_within_the_folder_only() {
        let inside = |path: &str| normalized(Path::new(path));
        for (path, plain) in [
            ("a/b.png", "a/b.png"),
            ("./a//b.png", "a/b.png"),
            ("a/../b.png", "b.png"),
            ("a/c/../../b.png", "b.png"),
        ] {
            assert_eq!(inside(path).as_deref(), Some(Path::new(plain)), "{path}");
        }
        for path in ["../b.png", "a/../../b.png", "/b.png", "..", "a/../.."] {
            assert_eq!(inside(path), None, "{path}");
        }
    }
}

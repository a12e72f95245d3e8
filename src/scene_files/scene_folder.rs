//! Opens files that a scene names. Only files in the scene's folder are opened, unless the user permits others: a scene from
//! elsewhere must not show other files of this machine.
//!
//! A link that leads out of the folder is treated like `..`. The path to a file is walked from the folder without following
//! links, so that a link that is inserted between the check and the opening is refused too. Hard links and mounts inside of
//! the folder are part of it.

use super::Options;
use crate::base::input_files;
use crate::scene::notices::quoted;
use crate::{Error, Result};
use rustix::fs::{Mode, OFlags, open, openat};
use std::fs::File;
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Component, Path, PathBuf};

/// The flags with which the folders on the way to a file are opened. With `PATH`, which only Linux has, the user needs the
/// right to pass through a folder, but not the right to read it.
#[cfg(target_os = "linux")]
const THROUGH: OFlags = OFlags::PATH.union(OFlags::DIRECTORY);
#[cfg(not(target_os = "linux"))]
const THROUGH: OFlags = OFlags::DIRECTORY;

/// The folder of a scene's file, with the user's permissions. It opens the files that the scene names.
#[derive(Clone, Copy)]
pub(super) struct SceneFolder<'a> {
    path: &'a Path,
    pub options: Options,
}

/// A plain file that a scene names, opened for reading.
pub(super) struct SceneFile {
    pub file: File,
    /// The size of the file when it was opened, in bytes.
    pub length: u64,
    /// The device number and the inode number of the file. They identify it under any of its names, so that no file is read
    /// twice.
    pub id: (u64, u64),
    /// The path under which the file was found, relative to the scene's folder. If the scene gave several paths for the
    /// file, it is the first one that exists.
    pub name: PathBuf,
}

/// The result of the search for a file under one or more names.
enum Lookup {
    Found(SceneFile),
    Missing,
    /// No file was found in the folder, and the name given here leads out of the folder. The user has not permitted this.
    Outside(PathBuf),
}

impl<'a> SceneFolder<'a> {
    /// The folder at `path`, which contains the scene's file; an empty path is the current folder. If the scene's file is a
    /// link, `path` is the folder that contains the link.
    pub const fn new(path: &'a Path, options: Options) -> Self {
        Self { path, options }
    }

    /// Opens the first existing file among `names`, which are paths relative to the folder; `None` if none exists. `what` is
    /// the element that names the file, for messages.
    ///
    /// # Errors
    /// If the user does not permit files outside of the folder: all names lead out of it, or one does by a link while no
    /// other name is found. In any case: the file cannot be opened or is not a plain file.
    pub fn open(&self, what: &str, names: &[PathBuf]) -> Result<Option<SceneFile>> {
        self.look_up(what, names)?.or_refused(what)
    }

    /// [`Self::open`] for a file without which the scene can be loaded, such as an image. If the user permits missing files,
    /// a file outside of the folder counts as missing (`None`) instead of being an error.
    ///
    /// # Errors
    /// The errors of [`Self::open`].
    pub fn open_dispensable(&self, what: &str, names: &[PathBuf]) -> Result<Option<SceneFile>> {
        match self.look_up(what, names)? {
            Lookup::Outside(_) if self.options.allow_missing => Ok(None),
            found => found.or_refused(what),
        }
    }

    fn look_up(&self, what: &str, names: &[PathBuf]) -> Result<Lookup> {
        let permitted: Vec<PathBuf> = match self.options.allow_outside {
            true => names.to_vec(),
            false => names.iter().filter_map(|name| normalized(name)).collect(),
        };
        if permitted.is_empty() {
            return Ok(Lookup::Outside(names.last().cloned().unwrap_or_default()));
        }
        let mut outside = None;
        for name in permitted {
            let opened = match self.options.allow_outside {
                true => input_files::open(&self.path.join(&name)).map(Some),
                false => self.open_inside(&name),
            };
            let file = match opened {
                Ok(Some(file)) => file,
                Ok(None) => {
                    outside.get_or_insert(name);
                    continue;
                }
                Err(cause) if is_absence(cause.kind()) => continue,
                Err(cause) => return Err(unreadable(what, &name, &cause)),
            };
            let found = file.metadata();
            let found = found.map_err(|cause| unreadable(what, &name, &cause))?;
            return Ok(Lookup::Found(SceneFile {
                file,
                length: found.len(),
                id: (found.dev(), found.ino()),
                name,
            }));
        }
        Ok(outside.map_or(Lookup::Missing, Lookup::Outside))
    }

    /// Opens a plain file by its path relative to the folder, without following a link that is inserted meanwhile. `None` if
    /// a link on the way leads out of the folder.
    fn open_inside(&self, name: &Path) -> io::Result<Option<File>> {
        let folder = match self.path.as_os_str().is_empty() {
            true => Path::new("."),
            false => self.path,
        };
        let folder = folder.canonicalize()?;
        let real = folder.join(name).canonicalize()?;
        let Ok(inner) = real.strip_prefix(&folder) else {
            return Ok(None);
        };
        input_files::check_plain(&real.metadata()?)?;
        let mut at = open(&folder, THROUGH | OFlags::CLOEXEC, Mode::empty())?;
        let mut parts = inner.components().peekable();
        while let Some(part) = parts.next() {
            let how = match parts.peek() {
                Some(_) => THROUGH,
                None => OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY,
            };
            let flags = how | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            at = openat(&at, part.as_os_str(), flags, Mode::empty())?;
        }
        let file = File::from(at);
        input_files::check_plain(&file.metadata()?)?;
        Ok(Some(file))
    }
}

impl Lookup {
    fn or_refused(self, what: &str) -> Result<Option<SceneFile>> {
        match self {
            Self::Found(file) => Ok(Some(file)),
            Self::Missing => Ok(None),
            Self::Outside(name) => Err(unreadable(
                what,
                &name,
                &"it is outside of the scene's folder; copy it there and name it by its path from there, or permit it by --allow-outside",
            )),
        }
    }
}

/// True if this error of opening a file means that the file does not exist. A name that is too long counts too, since no
/// file can have it.
fn is_absence(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidFilename
    )
}

/// The error that the file `name` cannot be read because of `cause`. `what` is the element of the scene that names it.
pub(super) fn unreadable(what: &str, name: &Path, cause: &dyn std::fmt::Display) -> Error {
    let name = quoted(&name.to_string_lossy());
    Error::input(format!("{what}: cannot read {name}: {cause}"))
}

/// The same relative path without `.` and `..`; `None` if it is absolute or leads out of the folder from which it starts.
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

    #[test]
    fn a_file_has_one_identity_under_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("inner")).unwrap();
        std::fs::write(at("inner/a"), "").unwrap();
        std::os::unix::fs::symlink("inner", at("folder")).unwrap();
        std::fs::hard_link(at("inner/a"), at("b")).unwrap();
        let scene = SceneFolder::new(folder.path(), Options::default());
        let id = |name: &str| scene.open("", &[name.into()]).unwrap().map(|file| file.id);
        for name in ["./inner/a", "folder/a", "inner/../b"] {
            assert_eq!(id(name), id("inner/a"), "{name}");
        }
        for missing in ["c", "b/c", "no/c"] {
            assert_eq!(id(missing), None, "{missing}");
        }
    }
}

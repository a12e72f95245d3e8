//! Files that a scene names: only files in the scene's folder are opened, unless the user permits others. A scene from
//! elsewhere must not show other files of this machine.
//!
//! A link that leads out of the folder is treated like `..`. The path to a file is walked from the folder without following
//! links, so that a link that is inserted between the check and the opening is refused too. Hard links and mounts inside of the
//! folder are part of it.

use super::Options;
use crate::base::input_files;
use crate::scene::notices::quoted;
use crate::{Error, Result};
use rustix::fs::{Mode, OFlags, open, openat};
use std::fs::File;
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Component, Path, PathBuf};

/// The flags with which folders on the way to a file are opened. A folder that may be passed through need not be readable,
/// except where the system has no such flag.
#[cfg(target_os = "linux")]
const THROUGH: OFlags = OFlags::PATH.union(OFlags::DIRECTORY);
#[cfg(not(target_os = "linux"))]
const THROUGH: OFlags = OFlags::DIRECTORY;

/// The folder of a scene, and the permissions of the user.
#[derive(Clone, Copy)]
pub(super) struct SceneFolder<'a> {
    path: &'a Path,
    pub options: Options,
}

/// A plain file that a scene names, opened.
pub(super) struct SceneFile {
    pub file: File,
    /// The size of the file when it was opened, in bytes.
    pub length: u64,
    /// The device and the inode, which identify the file under any of its names.
    pub id: (u64, u64),
    /// The first of the names under which it was found.
    pub name: PathBuf,
}

/// The result of looking for a file.
enum Lookup {
    Found(SceneFile),
    Missing,
    /// No file in the folder has any of the names, and this name leads out of it.
    Outside(PathBuf),
}

impl<'a> SceneFolder<'a> {
    /// The folder that contains the scene's file; an empty path is the current folder. If the file is a link, the folder of the
    /// link counts.
    pub const fn new(path: &'a Path, options: Options) -> Self {
        Self { path, options }
    }

    /// Opens the first of these files that exists; `None` if none exists. Names are paths from the folder; `what` is the
    /// element that names them, for messages.
    ///
    /// # Errors
    /// The names lead out of the folder, or the file cannot be opened or is not a plain one.
    pub fn open(&self, what: &str, names: &[PathBuf]) -> Result<Option<SceneFile>> {
        self.look_up(what, names)?.or_refused(what)
    }

    /// [`Self::open`] for files that a scene can do without: if missing files are permitted, files outside of the folder count
    /// as missing.
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

    /// Opens a plain file; none if a link on the way to it leads out of the folder.
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

/// True if an error means that the file does not exist: a name that is too long cannot exist.
fn is_absence(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidFilename
    )
}

/// The error for a file that cannot be read.
pub(super) fn unreadable(what: &str, name: &Path, cause: &dyn std::fmt::Display) -> Error {
    let name = quoted(&name.to_string_lossy());
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

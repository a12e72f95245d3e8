//! Opens the files that a scene names, such as images. Only files in the scene's folder are opened, unless the user permits
//! others, because a scene from another person must not make other files of this machine visible.
//!
//! A symbolic link whose target is outside of the folder is refused, like a path that leaves the folder by `..`. All links
//! are resolved and checked first. Then the resolved path is opened folder by folder without following links, so that a link
//! that another program inserts after the check is refused too. Hard links and mounts inside of the folder are part of it.
//!
//! A path that does not exist is searched without regard to letter case, because Windows and macOS find such files.

use super::Options;
use crate::base::input_files;
use crate::scene::notices::{Tally, quoted};
use crate::{Error, Result};
use rustix::fs::{Mode, OFlags, open, openat};
use std::ffi::OsStr;
use std::fs::{File, ReadDir};
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Component, Path, PathBuf};

/// The flags for opening each folder on the path to a file. On Linux, the flag `PATH` is used: with it, the
/// user needs the right to pass through a folder, but not the right to list its files. Other systems lack
/// this flag, and both rights are needed there.
#[cfg(target_os = "linux")]
const THROUGH: OFlags = OFlags::PATH.union(OFlags::DIRECTORY);
#[cfg(not(target_os = "linux"))]
const THROUGH: OFlags = OFlags::DIRECTORY;

/// The folder that contains a scene's file, with the user's permissions for loading the scene. Loaders open
/// the files that the scene names through it.
#[derive(Clone, Copy)]
pub(super) struct SceneFolder<'a> {
    path: &'a Path,
    pub options: &'a Options,
}

/// A plain file that a scene names, opened for reading; a loader reads its content. A folder, a pipe, a socket or a device
/// is an error.
pub(super) struct SceneFile {
    pub file: File,
    /// The size of the file in bytes, at the time when it was opened. Loaders check it and read at most this
    /// many bytes.
    pub length: u64,
    /// The device number and the inode number of the file. They identify it under any of its names, so that no file is read
    /// twice.
    pub id: (u64, u64),
    /// The path under which the file was found, relative to the scene's folder. If the scene states several possible paths
    /// for the file, it is the first one that exists.
    pub name: PathBuf,
}

/// The result of the search for a file under one or more possible paths. The caller decides with it whether to read the
/// file, to continue without it, or to return an error.
enum Lookup {
    Found(SceneFile),
    Missing,
    /// No file was found, and one of the possible paths of the file leads out of the folder, which the user has not
    /// permitted. The value is this path, for the error.
    Outside(PathBuf),
}

impl<'a> SceneFolder<'a> {
    /// The folder at `path`, which contains the scene's file; an empty path is the current folder. If the scene's file is a
    /// link, `path` must be the folder that contains the link, not that of its target.
    pub const fn new(path: &'a Path, options: &'a Options) -> Self {
        Self { path, options }
    }

    /// Opens the first existing file among `names`, which are possible paths of one file, relative to the folder. `None` if
    /// none of them exists. If only one file has one of these paths in another letter case, it is opened, with a notice in
    /// `tally`. `what` is the element of the scene that names the file, for messages.
    ///
    /// # Errors
    /// The file cannot be opened or is not a plain file. Or the user does not permit files outside of the folder, and either
    /// all paths lead out of the folder, or one leads out of it by a link while none of the others exists.
    pub fn open(
        &self,
        what: &str,
        names: &[PathBuf],
        tally: &mut Tally,
    ) -> Result<Option<SceneFile>> {
        self.look_up(what, names, tally)?.or_refused(what)
    }

    /// Opens a file that the scene can do without, such as an image. This differs from [`Self::open`] in one case: if the
    /// user permits missing files, a file outside of the folder is not an error, but is treated as missing (`None`).
    ///
    /// # Errors
    /// The other errors of [`Self::open`].
    pub fn open_dispensable(
        &self,
        what: &str,
        names: &[PathBuf],
        tally: &mut Tally,
    ) -> Result<Option<SceneFile>> {
        match self.look_up(what, names, tally)? {
            Lookup::Outside(_) if self.options.allow_missing => Ok(None),
            found => found.or_refused(what),
        }
    }

    fn look_up(&self, what: &str, names: &[PathBuf], tally: &mut Tally) -> Result<Lookup> {
        let permitted: Vec<PathBuf> = match self.options.allow_outside {
            true => names.to_vec(),
            false => names.iter().filter_map(|name| normalized(name)).collect(),
        };
        if permitted.is_empty() {
            return Ok(Lookup::Outside(names.last().cloned().unwrap_or_default()));
        }
        let mut outside = None;
        for name in &permitted {
            match self.look_up_one(what, name)? {
                Lookup::Missing => {}
                Lookup::Outside(name) => outside = outside.or(Some(name)),
                found => return Ok(found),
            }
        }
        for name in &permitted {
            let [other_case] = &self.in_other_case(name)[..] else {
                continue;
            };
            let found = self.look_up_one(what, other_case)?;
            if let Lookup::Found(_) = found {
                let what = "files are taken whose names differ in letter case";
                tally.add(what, || {
                    let [name, found] = [name, other_case].map(|path| quoted_path(path));
                    format!("{found} for {name}")
                });
                return Ok(found);
            }
        }
        Ok(outside.map_or(Lookup::Missing, Lookup::Outside))
    }

    /// Looks up the file with the path `name` and no other one. Fails if it exists but cannot be opened.
    fn look_up_one(&self, what: &str, name: &Path) -> Result<Lookup> {
        let opened = match self.options.allow_outside {
            true => input_files::open(&self.path.join(name)).map(Some),
            false => self.open_inside(name),
        };
        let file = match opened {
            Ok(Some(file)) => file,
            Ok(None) => return Ok(Lookup::Outside(name.into())),
            Err(cause) if is_absence(cause.kind()) => return Ok(Lookup::Missing),
            Err(cause) => return Err(unreadable(what, name, &cause)),
        };
        let found = file.metadata();
        let found = found.map_err(|cause| unreadable(what, name, &cause))?;
        Ok(Lookup::Found(SceneFile {
            file,
            length: found.len(),
            id: (found.dev(), found.ino()),
            name: name.into(),
        }))
    }

    /// The existing paths that differ from `name` in letter case only. If a folder on the path exists as it is written, no
    /// other one is searched. Empty if a folder cannot be listed or is outside of the scene's folder without the user's
    /// permission.
    fn in_other_case(&self, name: &Path) -> Vec<PathBuf> {
        let mut found = vec![PathBuf::new()];
        for part in name.components() {
            let Component::Normal(part) = part else {
                found.iter_mut().for_each(|path| path.push(part));
                continue;
            };
            found = (found.into_iter())
                .flat_map(|folder| self.entries_like(&folder, part))
                .collect();
        }
        found
    }

    /// The paths, relative to the scene's folder, of the files and folders in `folder` with the name `part`: the one with
    /// exactly this name if it exists, otherwise all whose names differ in letter case only.
    fn entries_like(&self, folder: &Path, part: &OsStr) -> Vec<PathBuf> {
        if self.path.join(folder).join(part).symlink_metadata().is_ok() {
            return vec![folder.join(part)];
        }
        let Some(list) = self.list(folder) else {
            return Vec::new();
        };
        let wanted = part.to_string_lossy().to_lowercase();
        let names = list.filter_map(|entry| Some(entry.ok()?.file_name()));
        let mut found: Vec<PathBuf> = names
            .filter(|name| name.to_string_lossy().to_lowercase() == wanted)
            .map(|name| folder.join(name))
            .collect();
        found.sort();
        found
    }

    /// Lists a folder; `None` if it cannot be listed, or if it is outside of the scene's folder without the user's
    /// permission.
    fn list(&self, folder: &Path) -> Option<ReadDir> {
        let root = match self.path.as_os_str().is_empty() {
            true => Path::new("."),
            false => self.path,
        };
        let real = root.join(folder).canonicalize().ok()?;
        let is_permitted =
            self.options.allow_outside || real.starts_with(root.canonicalize().ok()?);
        is_permitted.then(|| real.read_dir().ok())?
    }

    /// A hint for the error that the file `name` is missing: the files whose names differ from it in letter case only.
    /// Empty without such files.
    pub fn hint(&self, name: &Path) -> String {
        let similar = normalized(name).map(|name| self.in_other_case(&name));
        let similar = similar.unwrap_or_default();
        let names: Vec<String> = (similar.iter().take(3))
            .map(|path| quoted_path(path))
            .collect();
        match &names[..] {
            [] => String::new(),
            [name] => format!(" (there is {name})"),
            several => format!(" (there are {})", several.join(" and ")),
        }
    }

    /// Opens a plain file in the folder by its path relative to the folder. `None` if a symbolic link on this path leads out
    /// of the folder. Fails if the file cannot be opened or is not plain, or if another program inserts a link into the path
    /// after it was checked.
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

/// True if this kind of error, which an attempt to open a file returned, means that the file does not exist; the search then
/// tries the next possible path of the file. A path that is too long for the system counts too, since no file can have it.
fn is_absence(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidFilename
    )
}

/// The error that the file at `name`, its path relative to the scene's folder, cannot be read because of `cause`. `what` is
/// the element of the scene that names the file.
pub(super) fn unreadable(what: &str, name: &Path, cause: &dyn std::fmt::Display) -> Error {
    let name = quoted_path(name);
    Error::input(format!("{what}: cannot read {name}: {cause}"))
}

fn quoted_path(path: &Path) -> String {
    quoted(&path.to_string_lossy())
}

/// Resolves `.` and `..` in a relative path by its text alone. `None` if the path is absolute or leads out of the folder to
/// which it is relative; such a path is not opened without the user's permission.
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
        let options = Options::default();
        let scene = SceneFolder::new(folder.path(), &options);
        let mut tally = Tally::default();
        let mut id = |name: &str| {
            let file = scene.open("", &[name.into()], &mut tally).unwrap();
            file.map(|file| file.id)
        };
        for name in ["./inner/a", "folder/a", "inner/../b"] {
            let (found, expected) = (id(name), id("inner/a"));
            assert_eq!(found, expected, "{name}");
        }
        for missing in ["c", "b/c", "no/c"] {
            assert_eq!(id(missing), None, "{missing}");
        }
    }
}

//! Writing of output files. A new file is written beside its target and then replaces it, so that the target is never
//! incomplete. On Linux the new file has no name until it is complete, if the file system supports this; then even SIGKILL
//! leaves nothing of it.

use crate::{Error, Result};
use rustix::fs::{OFlags, fcntl_setfl};
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// The buffered writer that [`write_atomically`] passes to its closure, which writes the content of the file to it.
pub type Output = BufWriter<File>;

/// Writes the file at `path`; the closure `write` writes its content. On failure, an existing file stays unchanged, and
/// no incomplete file is left. If `path` is a symbolic link, it remains a link, and the file that it leads to is
/// replaced. A device or a pipe is written directly.
///
/// # Errors
/// The file cannot be created or written, or `write` returns an error.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut Output) -> std::io::Result<()>,
) -> Result<()> {
    let failed = |e: std::io::Error| Error::writing(path, e);
    // A rename would replace the device with a file.
    if is_device(path) {
        let file = open_device(path).map_err(failed)?;
        let mut output = BufWriter::new(file);
        return write(&mut output)
            .and_then(|()| output.flush())
            .map_err(failed);
    }
    let target = target(path);
    let New { file, name } = New::beside(path, &target)?;
    let mut output = BufWriter::new(file);
    write(&mut output)
        .and_then(|()| output.flush())
        .map_err(failed)?;
    // Some errors, such as a full disk, appear only here.
    output.get_mut().sync_all().map_err(failed)?;
    match name {
        Some(name) => name.persist(&target).map_err(|e| failed(e.error)),
        None => unnamed::give_name(output.get_ref(), &target).map_err(failed),
    }
}

/// Checks, before long work, that a file can be written at `path`. It leaves an existing file unchanged.
///
/// # Errors
/// The folder does not exist, no file can be created in it, or `path` is a folder, a socket, a pipe without a reader, a
/// device that cannot be opened, or a name that no file can have.
pub fn check_writable(path: &Path) -> Result<()> {
    if path.is_dir() || path.as_os_str().as_bytes().ends_with(b"/") {
        return Err(Error::writing(path, "it is a folder; name a file"));
    }
    match path.symlink_metadata() {
        Ok(about) if about.file_type().is_socket() => {
            return Err(Error::writing(path, "it is a socket; name a file"));
        }
        // A name that is too long would else be noticed only when the work is done.
        Err(e) if !matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Err(Error::writing(path, e));
        }
        _ => {}
    }
    if is_device(path) {
        let opened = open_device(path).map_err(|e| Error::writing(path, e))?;
        // It stays open: the reader of a pipe takes the close for the end of what is written.
        std::mem::forget(opened);
        return Ok(());
    }
    New::beside(path, &target(path)).map(drop)
}

/// Opens a device or a pipe for writing. If no process reads the pipe, this returns an error at once, whereas the system
/// would by default wait for a reader. Later writes wait as usual.
fn open_device(path: &Path) -> std::io::Result<File> {
    let mut options = File::options();
    options.write(true).custom_flags(libc::O_NONBLOCK);
    let file = options.open(path).map_err(|e| match e.raw_os_error() {
        Some(libc::ENXIO) => std::io::Error::new(
            ErrorKind::NotConnected,
            "it is a pipe that nobody reads; start its reader first",
        ),
        _ => e,
    })?;
    // Once it is open, writing waits as usual.
    fcntl_setfl(&file, OFlags::empty())?;
    Ok(file)
}

/// True if two paths lead to the same file, even if they are spelled differently or contain links. The file need not
/// exist yet. Commands refuse such paths if one of them is an output, because it would overwrite the other. For a
/// device, such as /dev/null, the result is always false, because several outputs may be written to one device.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    if is_device(a) {
        return false;
    }
    match (std::fs::metadata(a), std::fs::metadata(b)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => resolved(a) == resolved(b),
    }
}

/// `path` in a form in which two spellings of one path are equal: its folder is an absolute path without
/// links, `.` and `..`. A folder that does not exist is not changed.
fn resolved(path: &Path) -> PathBuf {
    let folder = folder(path);
    let folder = folder.canonicalize().unwrap_or(folder);
    path.file_name()
        .map_or_else(|| folder.clone(), |name| folder.join(name))
}

/// A new output file that does not have its final name yet. It gets that name, and so replaces an older file, when its
/// content is complete.
struct New {
    file: File,
    /// The unique temporary path of the file, which is deleted when this value is dropped. `None` if the file has no name at
    /// all, which only some file systems support.
    name: Option<TempPath>,
}

impl New {
    /// Creates the new file in the folder of `target`, the file that it will replace. Error messages name `path`, as the
    /// user gave it; it is `target` or a link to it.
    fn beside(path: &Path, target: &Path) -> Result<Self> {
        let folder = folder(target);
        if !folder.is_dir() {
            return Err(Error::writing(
                path,
                "its folder does not exist; make it first",
            ));
        }
        if let Some(file) = unnamed::create(&folder) {
            return Ok(Self { file, name: None });
        }
        let named = tempfile::Builder::new()
            .prefix(PREFIX)
            // The umask decides the mode; tempfile's default would let only the owner read the file.
            .make_in(&folder, |name| File::create_new(name))
            // The error's own text names the temporary file, which means nothing to the user.
            .map_err(|e| Error::writing(path, format!("its folder takes no file: {}", e.kind())))?;
        let (file, name) = named.into_parts();
        Ok(Self {
            file,
            name: Some(name),
        })
    }
}

/// Prefix of the names of temporary files, by which a user recognises a file that a killed process has left.
/// A temporary file is in the folder of the file that it will replace.
const PREFIX: &str = ".headwater-";

#[cfg(target_os = "linux")]
mod unnamed {
    use super::{ErrorKind, File, OsStrExt, PREFIX, Path, folder};
    use crate::base::short_hash::short;
    use rustix::fs::{AtFlags, CWD, linkat};
    use rustix::io::Errno;
    use std::io::Result;
    use std::os::fd::AsRawFd;
    use std::os::unix::fs::OpenOptionsExt;

    /// Folder in which Linux shows the open files of this process, with one link per file. Through its link,
    /// a file without a name is given one.
    const OPEN_FILES: &str = "/proc/self/fd";

    /// Creates a file without a name in `folder`; `None` if the file system does not support this or the folder cannot be
    /// written.
    pub fn create(folder: &Path) -> Option<File> {
        let mut options = File::options();
        options.write(true).custom_flags(libc::O_TMPFILE);
        let file = options.open(folder).ok()?;
        Path::new(OPEN_FILES).is_dir().then_some(file)
    }

    /// Gives a file without a name the name `target`, and so replaces an older file of that name.
    ///
    /// # Errors
    /// No file can be linked, renamed or removed in the folder.
    pub fn give_name(file: &File, target: &Path) -> Result<()> {
        let open = format!("{OPEN_FILES}/{}", file.as_raw_fd());
        // True if no file of that name existed before.
        let link = |name: &Path| -> Result<bool> {
            match linkat(CWD, &open, CWD, name, AtFlags::SYMLINK_FOLLOW) {
                Ok(()) => Ok(true),
                Err(Errno::EXIST) => Ok(false),
                Err(error) => Err(error.into()),
            }
        };
        // A link replaces no file, but a rename does. The name that it takes is the same in every process: what a
        // killed one has left under it is removed by the next, and each file under it is complete.
        let name = target.file_name().unwrap_or_default();
        let beside = format!("{PREFIX}{}", short(&blake3::hash(name.as_bytes())));
        let beside = folder(target).join(beside);
        let if_there = |done: Result<()>| match done {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
            done => done.map(|()| true),
        };
        while !link(target)? {
            if !link(&beside)? {
                if_there(std::fs::remove_file(&beside))?;
                continue;
            }
            // Another process that writes the same target may have removed it.
            let renamed = if_there(std::fs::rename(&beside, target));
            if renamed.inspect_err(|_| drop(std::fs::remove_file(&beside)))? {
                break;
            }
        }
        Ok(())
    }
}

#[cfg(not(target_os = "linux"))]
mod unnamed {
    use super::{File, Path};

    pub const fn create(_: &Path) -> Option<File> {
        None
    }

    pub fn give_name(_: &File, _: &Path) -> std::io::Result<()> {
        Ok(())
    }
}

/// True if `path` exists and is neither a file nor a folder, such as /dev/full or a pipe. It is then written directly,
/// because a new file beside it would replace the device.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// The file that the symbolic link `path` leads to; `path` itself if it is no link or leads to nothing. New content
/// replaces this file, so that the link remains.
fn target(path: &Path) -> Cow<'_, Path> {
    if path.is_symlink() {
        path.canonicalize().map_or(path.into(), Cow::Owned)
    } else {
        path.into()
    }
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, |f| f.write_all(b"old")).unwrap();
        let failing = write_atomically(&path, |f| {
            f.write_all(b"new")?;
            Err(std::io::Error::other("planted"))
        });
        assert_eq!(failing.unwrap_err().exit_status(), 1);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn the_same_file_is_known_by_any_path() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("inner")).unwrap();
        std::fs::write(at("old"), "").unwrap();
        std::fs::hard_link(at("old"), at("hard")).unwrap();
        symlink(at("old"), at("soft")).unwrap();
        symlink(at("inner"), at("folder")).unwrap();
        for (a, b) in [
            ("new", "new"),
            ("new", "./inner/../new"),
            ("inner/new", "folder/new"),
            ("old", "soft"),
            ("old", "hard"),
            ("no/folder", "no/folder"),
        ] {
            assert!(is_same_file(&at(a), &at(b)), "{a} {b}");
        }
        for (a, b) in [("new", "other"), ("old", "new"), ("inner/new", "new")] {
            assert!(!is_same_file(&at(a), &at(b)), "{a} {b}");
        }
        let null = Path::new("/dev/null");
        assert!(!is_same_file(null, null));
    }

    #[test]
    fn a_missing_folder_is_failed_work() {
        let path = Path::new("no/such/folder/a.txt");
        assert_eq!(check_writable(path).unwrap_err().exit_status(), 1);
        assert!(write_atomically(path, |_| Ok(())).is_err());
    }

    #[test]
    fn a_folder_that_takes_no_files_is_failed_work() {
        // A place where even root cannot create files.
        let path = Path::new("/proc/a.txt");
        for error in [check_writable(path), write_atomically(path, |_| Ok(()))] {
            let error = error.unwrap_err();
            assert_eq!(error.exit_status(), 1);
            assert!(!error.to_string().contains(".headwater-"), "{error}");
        }
        assert_eq!(check_writable(Path::new("/")).unwrap_err().exit_status(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_gets_the_mode_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (usual, ours) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&usual, "").unwrap();
        write_atomically(&ours, |_| Ok(())).unwrap();
        let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&usual), mode(&ours));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_a_device() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        check_writable(&link).unwrap();
        write_atomically(&link, |f| f.write_all(b"new")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        let null = Path::new("/dev/null");
        check_writable(null).unwrap();
        write_atomically(null, |f| f.write_all(b"new")).unwrap();
        assert!(!null.is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_written_if_somebody_reads_it() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        for error in [check_writable(&pipe), write_atomically(&pipe, |_| Ok(()))] {
            let error = error.unwrap_err();
            assert!(error.to_string().contains("nobody reads"), "{error}");
        }
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        // More than a pipe holds.
        let bytes = vec![7; 1 << 20];
        while write_atomically(&pipe, |f| f.write_all(&bytes)).is_err() {
            std::thread::yield_now();
        }
        assert_eq!(reader.join().unwrap(), bytes);
    }
}

//! Output files: written to a temporary file that then replaces the target, so that a target is
//! never incomplete.

use crate::{Error, Result};
use std::borrow::Cow;
use std::io::{BufWriter, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// The writer that [`write_atomically`] passes to its closure.
pub type Output = BufWriter<std::fs::File>;

/// Writes `path` through `write`. On failure an existing file stays unchanged and no new file is
/// left. A symbolic link stays a link.
///
/// # Errors
/// The file cannot be created or written, or `write`'s own error.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut Output) -> std::io::Result<()>,
) -> Result<()> {
    let failed = |e: std::io::Error| Error::writing(path, e);
    // A rename would replace the device with a file.
    if is_device(path) {
        let file = std::fs::File::options()
            .write(true)
            .open(path)
            .map_err(failed)?;
        let mut output = BufWriter::new(file);
        return write(&mut output)
            .and_then(|()| output.flush())
            .map_err(failed);
    }
    let target = target(path);
    let temporary = temporary(path, &target)?;
    let (file, name) = temporary.into_parts();
    let mut output = BufWriter::new(file);
    write(&mut output)
        .and_then(|()| output.flush())
        .map_err(failed)?;
    // Some errors, such as a full disk, appear only here.
    output.get_mut().sync_all().map_err(failed)?;
    drop(output);
    name.persist(&target).map_err(|e| failed(e.error))
}

/// Checks, before long work, that `path` can be written.
///
/// # Errors
/// The folder does not exist, no file can be created in it, or `path` is a folder.
pub fn check_writable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::writing(path, "it is a folder; name a file"));
    }
    if is_device(path) {
        return Ok(());
    }
    temporary(path, &target(path)).map(drop)
}

/// Whether two paths lead to the same file, which need not exist yet: by another spelling or a link. Devices,
/// such as /dev/null, are no files: all may be written to one.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    if is_device(a) {
        return false;
    }
    match (std::fs::metadata(a), std::fs::metadata(b)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => resolved(a) == resolved(b),
    }
}

/// The path without links or detours as far as its folder exists.
fn resolved(path: &Path) -> PathBuf {
    let folder = folder(path);
    let folder = folder.canonicalize().unwrap_or(folder);
    path.file_name()
        .map_or_else(|| folder.clone(), |name| folder.join(name))
}

/// A temporary file beside `target`, deleted on drop unless it is renamed. Errors name `path`.
fn temporary(path: &Path, target: &Path) -> Result<tempfile::NamedTempFile> {
    let folder = folder(target);
    if !folder.is_dir() {
        return Err(Error::writing(
            path,
            "its folder does not exist; make it first",
        ));
    }
    tempfile::Builder::new()
        .prefix(".headwater-")
        // The umask decides the mode; tempfile's default would let only the owner read the file.
        .make_in(&folder, |name| std::fs::File::create_new(name))
        // The error's own text names the temporary file, which means nothing to the user.
        .map_err(|e| Error::writing(path, format!("its folder takes no file: {}", e.kind())))
}

/// Whether `path` exists and is neither a file nor a folder, such as /dev/full or a pipe.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// The file that `path` links to, or `path` itself if it is no link.
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
}

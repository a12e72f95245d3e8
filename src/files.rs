//! Output files: written beside their target and renamed, so that no one ever sees half a file.

use crate::{Error, Result};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// What [`write_atomically`] hands to its caller.
pub type Output = BufWriter<std::fs::File>;

/// Writes `path` through `write`. On any failure the old file, if there was one, stays as it was
/// and nothing new is left behind.
///
/// # Errors
/// The folder or the disk does not take the file, or `write`'s own error.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut Output) -> std::io::Result<()>,
) -> Result<()> {
    let failed = |e: std::io::Error| Error::writing(path, e);
    // A device such as /dev/full is written as it is: a rename would replace it.
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        let file = std::fs::File::options()
            .write(true)
            .open(path)
            .map_err(failed)?;
        let mut output = BufWriter::new(file);
        return write(&mut output)
            .and_then(|()| output.flush())
            .map_err(failed);
    }
    let temporary = tempfile::Builder::new()
        .prefix(".headwater-")
        .make_in(folder(path), |name| {
            // Not tempfile's own mode, which nobody else could read: the umask decides.
            std::fs::File::create_new(name)
        })
        .map_err(failed)?;
    let (file, name) = temporary.into_parts();
    let mut output = BufWriter::new(file);
    write(&mut output)
        .and_then(|()| output.flush())
        .map_err(failed)?;
    // A full disk may only be noticed now.
    output.get_mut().sync_all().map_err(failed)?;
    drop(output);
    name.persist(path).map_err(|e| failed(e.error))
}

/// Checks before long work that `path` could be written.
///
/// # Errors
/// The folder does not exist or takes no files, or the path is a folder.
pub fn check_writable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::writing(path, "it is a folder; name a file"));
    }
    tempfile::Builder::new()
        .prefix(".headwater-")
        .tempfile_in(folder(path))
        .map(drop)
        .map_err(|e| Error::writing(path, e))
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
    fn a_missing_folder_is_failed_work() {
        let path = Path::new("no/such/folder/a.txt");
        assert_eq!(check_writable(path).unwrap_err().exit_status(), 1);
        assert!(write_atomically(path, |_| Ok(())).is_err());
    }
}

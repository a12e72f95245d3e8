//! Reads input files. Only plain files are opened, because a pipe has no size and may never end, and because merely
//! opening a device can have an effect.

use crate::base::memory::room_for;
use crate::{Error, Result};
use std::fs::{File, FileType, Metadata};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

/// The maximum size in bytes of a file of settings or of a study plan; larger files are refused. The limit is low because
/// the TOML parser takes about a hundred times the size of the file in memory.
pub const MAX_TOML_BYTES: u64 = 16 << 20;

/// The maximum size in bytes of a JSON file that is read: a list of golden frames, a profile, or statistics of
/// pipelines. Larger files are refused before they are read, so that a wrong file does not fill the memory.
pub const MAX_JSON_BYTES: u64 = 256 << 20;

/// Opens a plain file for reading. The function never waits, even if a pipe replaces the file after this function has
/// checked that it is a plain file.
///
/// # Errors
/// The file cannot be opened, or it is a folder, a pipe, a socket or a device.
pub fn open(path: &Path) -> io::Result<File> {
    check_plain(&path.metadata()?)?;
    // Something else may have taken the file's place by now: then this does not wait, and the second check refuses it.
    let file = File::options()
        .read(true)
        .custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY)
        .open(path)?;
    check_plain(&file.metadata()?)?;
    Ok(file)
}

/// Checks that `file`, the metadata of a file, belongs to a plain file. Other kinds are not read, because reading them
/// may never end.
///
/// # Errors
/// The file is a folder, a pipe, a socket or a device.
pub fn check_plain(file: &Metadata) -> io::Result<()> {
    if file.is_file() {
        return Ok(());
    }
    let kind = kind_of(file.file_type());
    let text = format!("it is {kind}, and only plain files are read");
    Err(io::Error::new(ErrorKind::InvalidInput, text))
}

/// Checks, before long work, that a plain file is at `path`, so that a missing input is found at once. It does not open
/// the file.
///
/// # Errors
/// There is no plain file at `path`.
pub fn check(path: &Path) -> Result<()> {
    let found = path.metadata().and_then(|file| check_plain(&file));
    found.map_err(|cause| Error::reading(path, cause))
}

/// Reads all bytes of the plain file at `path`.
///
/// # Errors
/// The file cannot be read, is not a plain file, or there is not enough memory for it.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, u64::MAX)
}

/// Reads the text of the plain file at `path`. A file of more than `most` bytes is refused before it is read.
///
/// # Errors
/// The file cannot be read, is not a plain file, has more than `most` bytes, or is not UTF-8; or there is not enough memory
/// for it.
pub fn read_text(path: &Path, most: u64) -> Result<String> {
    let bytes = read_at_most(path, most)?;
    let not_text = |_| Error::reading(path, "it is not UTF-8; save it as UTF-8");
    String::from_utf8(bytes).map_err(not_text)
}

fn read_at_most(path: &Path, most: u64) -> Result<Vec<u8>> {
    let wrong = |cause: &dyn std::fmt::Display| Error::reading(path, cause);
    let file = open(path).map_err(|cause| wrong(&cause))?;
    let length = file.metadata().map_err(|cause| wrong(&cause))?.len();
    if length > most {
        let text =
            format!("it has {length} bytes, and at most {most} are read; give a smaller file");
        return Err(wrong(&text));
    }
    read_length(file, length).map_err(|cause| wrong(&cause))
}

/// Reads the first `length` bytes of a file. If the file has fewer, because it was shortened meanwhile, reads all of
/// them.
///
/// # Errors
/// The file cannot be read, or there is not enough memory for `length` bytes.
pub fn read_length(file: impl Read, length: u64) -> io::Result<Vec<u8>> {
    let no_room = |cause| {
        let text = format!("{cause}; give a smaller file");
        io::Error::new(ErrorKind::OutOfMemory, text)
    };
    let mut bytes = room_for(length).map_err(no_room)?;
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn kind_of(kind: FileType) -> &'static str {
    if kind.is_dir() {
        "a folder"
    } else if kind.is_fifo() {
        "a pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CString;
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::net::UnixListener;

    #[test]
    fn only_plain_files_are_read_and_nothing_is_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("plain"), "text").unwrap();
        std::os::unix::fs::symlink(at("plain"), at("link")).unwrap();
        for name in ["plain", "link"] {
            assert_eq!(read_text(&at(name), 4).unwrap(), "text");
            check(&at(name)).unwrap();
        }
        let pipe = CString::new(at("pipe").as_os_str().as_bytes()).unwrap();
        // SAFETY: the name ends with a zero byte.
        assert_eq!(unsafe { libc::mkfifo(pipe.as_ptr(), 0o600) }, 0);
        let _socket = UnixListener::bind(at("socket")).unwrap();
        for (path, kind) in [
            (at("pipe"), "a pipe"),
            (at("socket"), "a socket"),
            (at(""), "a folder"),
            ("/dev/null".into(), "a device"),
        ] {
            for error in [check(&path), read(&path).map(drop)] {
                let error = error.unwrap_err();
                assert_eq!(error.exit_status(), 2);
                assert!(error.to_string().contains(kind), "{error}");
            }
        }
    }

    #[test]
    fn what_is_too_large_or_no_text_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, b"\xff\xfe").unwrap();
        let message = |most| read_text(&path, most).unwrap_err().to_string();
        assert!(message(2).contains("not UTF-8"));
        assert!(message(1).contains("2 bytes, and at most 1"));
        std::fs::File::options()
            .write(true)
            .open(&path)
            .unwrap()
            .set_len(8 << 40)
            .unwrap();
        let text = read(&path).unwrap_err().to_string();
        assert!(text.contains("8796093022208 bytes"), "{text}");
    }
}

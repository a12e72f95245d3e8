//! The error type of this crate. Each variant of it ends the process with another exit status, so that a script can
//! tell wrong input from failed work.

use crate::base::printable::printable;
use std::path::Path;

/// An error that ends the program; it is shown to the user on stderr. Its text is one line: what failed, where, and, if
/// possible, what the user can do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command-line arguments or an input file are wrong; the process then ends with exit status 2. The text is the
    /// whole message.
    #[error("{0}")]
    Input(String),
    /// The device, the disk or another part of the system failed, or a check failed, such as that of an error against a
    /// limit of `compare`; the process then ends with exit status 1. The text is the whole message.
    #[error("{0}")]
    Failed(String),
    /// A signal, SIGINT or SIGTERM, stopped the work; the process then ends with exit status 128 + the signal's number.
    #[error("stopped by signal {signal}; {kept}")]
    Interrupted {
        /// The number of the signal, such as 2 for SIGINT.
        signal: i32,
        /// A clause that states which results were saved, such as "nothing was written". It ends the message.
        kept: String,
    },
}

/// The result of a function that can fail: its value, or the [`Error`] of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An [`Error::Input`] with this message. Line breaks and control characters in it are escaped, because the message may
    /// quote arguments or files.
    pub fn input(message: impl AsRef<str>) -> Self {
        Self::Input(printable(message.as_ref()))
    }

    /// An [`Error::Failed`] with this message, which is used unchanged. It must be one line, because the program prints
    /// each error as one line.
    pub fn failed(message: impl Into<String>) -> Self {
        Self::Failed(message.into())
    }

    /// An [`Error::Input`] whose message states that the file at `path` cannot be read, and why (`cause`).
    pub fn reading(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::input(format!("cannot read {}: {cause}", path.display()))
    }

    /// An [`Error::Failed`] whose message states that the file at `path` cannot be written, and why (`cause`).
    pub fn writing(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::Failed(format!("cannot write {}: {cause}", path.display()))
    }

    /// Converts an I/O error: returns the error of this crate that `cause` wraps, or `make(cause)` if it wraps none. It
    /// wraps one if a reader or writer of this crate returned its error through [`std::io::Error::other`]; so the error
    /// keeps its message and its exit status.
    pub fn from_io(cause: std::io::Error, make: impl FnOnce(std::io::Error) -> Self) -> Self {
        cause.downcast::<Self>().unwrap_or_else(make)
    }

    /// Exit status of the process for this error: 1 for failed work, 2 for wrong input, 128 + signal number after a signal.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted { signal, .. } => 128 + *signal as u8,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_error_quotes_leaves_it_one_line() {
        let path = Path::new("a\nb");
        for error in [Error::input("x\ny"), Error::reading(path, "x\u{2028}y")] {
            assert_eq!(error.to_string().lines().count(), 1);
            assert!(!error.to_string().contains('\u{2028}'));
        }
    }
}

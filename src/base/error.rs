//! The error type of this crate. Each kind of error has its own exit status of the process.

use crate::base::printable::printable;
use std::path::Path;

/// An error that is shown to the user. Its text is one line: the failure, its location, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The arguments or the input are wrong (exit status 2).
    #[error("{0}")]
    Input(String),
    /// The work failed, or a check failed (exit status 1).
    #[error("{0}")]
    Failed(String),
    /// A signal stopped the work (exit status 128 + signal).
    #[error("stopped by signal {signal}; {kept}")]
    Interrupted {
        /// The number of the signal, such as 2 for SIGINT.
        signal: i32,
        /// A clause about the results that were kept, which ends the message.
        kept: String,
    },
}

/// A result whose error is the [`Error`] of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An [`Error::Input`] with this message. Line breaks and control characters in it are escaped, since it may quote
    /// arguments or files.
    pub fn input(message: impl AsRef<str>) -> Self {
        Self::Input(printable(message.as_ref()))
    }

    /// An [`Error::Failed`] with this message, which is used unchanged and must be one line.
    pub fn failed(message: impl Into<String>) -> Self {
        Self::Failed(message.into())
    }

    /// An [`Error::Input`] about a file at `path` that cannot be read, with the cause.
    pub fn reading(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::input(format!("cannot read {}: {cause}", path.display()))
    }

    /// An [`Error::Failed`] about a file at `path` that cannot be written, with the cause.
    pub fn writing(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::Failed(format!("cannot write {}: {cause}", path.display()))
    }

    /// Converts an I/O error: returns the error of this crate that `cause` wraps, or `make(cause)` if it wraps none. A
    /// reader or writer can return errors of this crate through [`std::io::Error::other`].
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

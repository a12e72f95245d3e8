//! What can go wrong, sorted by the exit status it ends in.

use std::path::Path;

/// An error a user can meet. Its text is one line: what, where, what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The arguments or the input are wrong (exit status 2).
    #[error("{0}")]
    Input(String),
    /// The work failed, or a check did not hold (exit status 1).
    #[error("{0}")]
    Failed(String),
    /// A signal ended the work (exit status 128 + signal).
    #[error("stopped by signal {signal}; {kept}")]
    Interrupted {
        /// The signal's number.
        signal: i32,
        /// What was kept of the work.
        kept: String,
    },
}

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Wrong arguments or input.
    pub fn input(message: impl Into<String>) -> Self {
        Self::Input(message.into())
    }

    /// Work that failed.
    pub fn failed(message: impl Into<String>) -> Self {
        Self::Failed(message.into())
    }

    /// A file that cannot be read is wrong input.
    pub fn reading(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::Input(format!("cannot read {}: {cause}", path.display()))
    }

    /// A file that cannot be written is failed work.
    pub fn writing(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::Failed(format!("cannot write {}: {cause}", path.display()))
    }

    /// The error of this crate that ended reading or writing from within, or else what `make` makes
    /// of the system's.
    pub fn from_io(cause: std::io::Error, make: impl FnOnce(std::io::Error) -> Self) -> Self {
        cause.downcast::<Self>().unwrap_or_else(make)
    }

    /// The process's exit status for this error.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted { signal, .. } => 128 + *signal as u8,
        }
    }
}

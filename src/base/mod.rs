//! Parts that every other module may use: errors, files, memory, text, random numbers.

pub(crate) mod environment_variable;
pub mod error;
pub mod files;
pub(crate) mod input_files;
pub(crate) mod json;
pub(crate) mod memory;
pub(crate) mod milliseconds;
pub(crate) mod nearest;
pub mod out_of_memory;
pub(crate) mod panics;
pub(crate) mod printable;
pub mod progress;
pub(crate) mod random;
pub(crate) mod shell_word;
pub(crate) mod short_hash;
pub(crate) mod timed;
pub mod toml_text;

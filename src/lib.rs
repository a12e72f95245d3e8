//! Headwater: a headless Vulkan renderer that path traces real scenes with reservoir resampling
//! and measures how much accuracy each faster setting costs.
//!
//! The way of the data: [`scene`] → [`gpu`] → [`device_scene`] → [`render`] → `image` → `metrics`.
#![warn(missing_docs)]

pub mod commands;
pub mod device_scene;
mod environment_variable;
pub mod error;
pub mod files;
pub mod gpu;
pub mod image;
mod input_files;
mod json;
mod memory;
pub mod metrics;
mod nearest;
pub mod out_of_memory;
mod panics;
mod printable;
pub mod procedural;
pub mod profile;
pub mod progress;
mod random;
pub mod regress;
pub mod render;
pub mod scene;
pub mod scene_files;
mod short_hash;
pub mod study;
pub mod toml_text;

pub use error::{Error, Result};
pub use headwater_shader_interface as shader_interface;

//! Headwater: a headless Vulkan renderer that path traces real scenes with reservoir resampling
//! and measures how much accuracy each faster setting costs.
//!
//! The way of the data: [`scene`] → [`gpu`] → [`device_scene`] → [`render`] → `image` → `metrics`.
#![warn(missing_docs)]

pub mod base;
pub mod commands;
pub mod device_scene;
pub mod gpu;
pub mod image;
pub mod metrics;
pub mod procedural;
pub mod profile;
pub mod regress;
pub mod render;
pub mod scene;
pub mod scene_files;
pub mod study;

pub use base::error::{Error, Result};
pub use headwater_shader_interface as shader_interface;

//! What images and numbers say about each other. Knows no scene and no Vulkan.

pub mod error;
pub mod flip;
pub mod statistics;

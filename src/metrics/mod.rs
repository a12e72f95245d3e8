//! Errors of pictures, and statistics. Independent of scenes and Vulkan.

pub mod error;
pub mod flip;
pub mod statistics;

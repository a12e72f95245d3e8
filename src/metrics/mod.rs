//! Errors of pictures, and statistics. This module needs neither scenes nor Vulkan.

pub mod error;
pub mod flip;
pub mod statistics;

//! Errors of pictures against references, and the statistics with which studies and tests decide whether a difference is
//! more than noise. This module needs neither scenes nor Vulkan.

pub mod error;
pub mod flip;
pub mod relative;
pub mod sharing;
pub mod spectrum;
pub mod statistics;

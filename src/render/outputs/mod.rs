//! Outputs besides the picture: AOVs of surfaces, sums over samples, the picture for displays.

pub mod display;
pub mod primary_surfaces;
mod sums;

pub use sums::Sums;

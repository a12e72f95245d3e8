//! Outputs besides the picture: AOVs of surfaces, sums over samples, the picture for displays.

pub mod accumulator;
pub mod display;
pub mod primary_surfaces;
pub mod radiance;
mod sums;

pub use accumulator::Accumulator;
pub use radiance::Radiance;
pub use sums::Sums;

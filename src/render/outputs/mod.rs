//! Outputs of a renderer: sums over samples, radiance on the device, the picture for displays, and AOVs (additional
//! channels) of surfaces.

pub mod accumulator;
pub mod display;
pub mod primary_surfaces;
pub mod radiance;
mod sums;

pub use accumulator::Accumulator;
pub use radiance::Radiance;
pub use sums::Sums;

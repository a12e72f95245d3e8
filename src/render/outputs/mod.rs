//! Outputs of a renderer: the sums of radiance over samples, from which the mean picture follows; the location of radiance
//! on the device; the picture for displays; and AOVs (additional channels of a picture) of surfaces.

pub mod accumulator;
pub mod display;
pub mod primary_surfaces;
pub mod radiance;
mod sums;

pub use accumulator::Accumulator;
pub use radiance::Radiance;
pub use sums::Sums;

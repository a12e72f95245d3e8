//! The outputs of a technique besides its picture: AOVs, and sums over samples.

pub mod display;
pub mod primary_surfaces;
pub mod reservoir_aovs;
mod sums;

pub use sums::Sums;

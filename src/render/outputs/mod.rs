//! The outputs of a technique besides its picture: AOVs, sums over samples, and lists of traced rays.

pub mod primary_surfaces;
pub mod ray_list;
pub mod reservoir_aovs;
mod sums;

pub use sums::Sums;

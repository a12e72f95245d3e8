//! What is read of a technique besides its picture.

pub mod primary_surfaces;
pub mod ray_list;
pub mod reservoir_aovs;
mod sums;

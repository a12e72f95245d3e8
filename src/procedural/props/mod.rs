//! Models that the procedural scenes place, such as furniture, houses, a car and a statue.

mod arches;
pub mod car;
pub mod city_house;
pub mod colonnade;
pub mod festival;
pub mod furniture;
pub mod houses;
pub mod statue;
pub mod workshop;

pub use arches::Arch;

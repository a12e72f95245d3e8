//! The techniques that make pictures: path tracing, and reservoir resampling with its two kinds of light.

mod constants;
mod direct;
mod hash_grid;
mod indirect;
mod light_lists;
pub mod path_tracing;
mod pilots;
pub mod prefix_sum;
pub mod restir;
mod reuse;
mod sizes;
mod world_reservoirs;
pub mod world_table;

pub use direct::DirectLight;
pub use indirect::IndirectLight;
pub use path_tracing::PathTracer;
pub use restir::Restir;
pub use reuse::Reuse;

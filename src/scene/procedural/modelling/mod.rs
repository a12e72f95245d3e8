//! What scenes and props are modelled with: shapes, materials, and a builder that puts them together.

mod builder;
pub mod dual_contouring;
pub mod implicit;
mod materials;
mod rounded;
mod shape;
mod simplify;
pub mod tumble;
mod turned;

pub use builder::{Builder, Heap, SINK};
pub use materials::{dielectric, lamp, metal};
pub use rounded::{lathe, soft_box};
pub use shape::Shape;
pub use turned::Profile;

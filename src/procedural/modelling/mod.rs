//! Modelling tools that the scenes and props use: shapes, materials, and builders of scenes.

mod builder;
pub mod dual_contouring;
pub mod implicit;
mod materials;
mod rounded;
mod shape;
mod simplify;
pub mod stage;
mod tessellate;
pub mod tumble;
mod turned;

pub use builder::{Builder, Model, SINK};
pub use materials::{brushed, coated, dielectric, emitter, metal};
pub use rounded::{lathe, soft_box};
pub use shape::Shape;
pub use tessellate::tessellate_lights;
pub use turned::Profile;

//! The integrators, which make pictures: path tracing, and reservoir resampling of direct and indirect light.

pub mod path_tracing;
pub mod restir;

pub use path_tracing::PathTracer;
pub use restir::Restir;

//! Sources of light candidates that have data of their own. Each has a folder with its settings, passes and buffers;
//! `glsl/lights/samplers/sources.glsl` draws from all of them.

pub mod hash_grid;
pub mod light_bvh;

//! The scene on the device: its buffers, its lights, its bounding volume hierarchies (trees), and the two
//! ways to trace rays in it. A ray is traced either by a ray query on the driver's acceleration structures,
//! or by a walk through an eight-wide BVH in a compute shader. Both ways see the same triangles, instances
//! and transforms.

pub mod buffers;
pub mod compute_bvh;
mod deforming;
pub mod environment;
mod epochs;
pub mod geometry;
pub mod images;
pub mod light_bvh;
pub mod lights;
pub mod materials;
pub mod merge_static;
mod pose;
mod rare_lights;
pub mod ray_query;
mod refit;
pub mod scene;
pub mod selection;
pub mod shaders;
pub mod sizes;
mod specialisation;
pub mod surface_points;
pub mod units;

pub use materials::gpu_material;
pub use scene::GpuScene;
pub use sizes::SceneSizes;
pub use units::Units;

//! Lists of rays and their answers.

use glam::Vec3;

crate::gpu_struct! {
    /// A ray of the ray-buffer pass.
    pub struct RayQuery {
        /// Origin: relative to the scene's origin and in scene units in lists of rays, in the device's unit in buffers.
        pub origin: Vec3,
        /// Hits at this parameter and beyond are ignored.
        pub t_max: f32,
        /// Direction; the parameter counts in its length.
        pub direction: Vec3,
        /// 1: any hit will do; 0: the closest.
        pub any: u32,
    }
}

crate::gpu_struct! {
    /// The answer to a [`RayQuery`].
    pub struct RayHit {
        /// Ray parameter; −1 = miss. With `any` only hit or miss has meaning.
        pub t: f32,
        /// Index of the instance; NONE = miss.
        pub instance: u32,
        /// Triangle of the instance's mesh, in leaf order.
        pub primitive: u32,
        /// Barycentric weight of the second corner.
        pub u: f32,
        /// Barycentric weight of the third corner.
        pub v: f32,
        /// With `any`, the share of light that passes between the ray's ends; otherwise 0 or, of a miss, without meaning.
        pub transmittance: f32,
    }
}

crate::gpu_struct! {
    /// The rays that the ray-buffer pass traces.
    pub struct RayBatch {
        /// Number of rays.
        pub count: u32,
        /// Threads that the device gives fixed runs of workgroups, or 1.
        pub interleave: u32,
    }
}

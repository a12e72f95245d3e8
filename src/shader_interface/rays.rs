//! Lists of rays and their hits.

use glam::Vec3;

crate::gpu_struct! {
    /// A ray of the ray-buffer pass.
    pub struct RayQuery {
        /// Origin: relative to the scene's origin and in scene units in lists of rays, in the device's unit in buffers.
        pub origin: Vec3,
        /// The parameter from which on hits are ignored.
        pub t_max: f32,
        /// Direction; the parameter counts in its length.
        pub direction: Vec3,
        /// 1: any hit is sufficient; 0: the closest hit.
        pub any: u32,
    }
}

crate::gpu_struct! {
    /// The hit of a [`RayQuery`].
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
        /// With `any`, the fraction of light that passes between the ray's ends; otherwise 0 or, for a miss, without meaning.
        pub transmittance: f32,
    }
}

crate::gpu_struct! {
    /// The rays that the ray-buffer pass traces.
    pub struct RayBatch {
        /// Number of rays.
        pub count: u32,
        /// The number of threads to which the device gives fixed ranges of workgroups, or 1.
        pub interleave: u32,
    }
}

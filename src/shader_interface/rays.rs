//! Lists of rays that the pass `trace_rays` traces, and their hits: for tests, benchmarks and the boxes of the light BVH.

use glam::Vec3;

crate::gpu_struct! {
    /// One ray for the ray-buffer pass (`trace_rays`).
    pub struct RayQuery {
        /// Origin of the ray, relative to the scene's origin: in scene units in a list of rays, in device units in a buffer.
        pub origin: Vec3,
        /// The upper limit of the ray parameter, in lengths of `direction`: only hits with 0 < t < `t_max` count.
        pub t_max: f32,
        /// Direction of the ray, of any length except 0; a hit lies at `origin` + t · `direction`.
        pub direction: Vec3,
        /// 1: the first hit that is found ends the search, which is sufficient for visibility; 0: the closest hit is found.
        pub any: u32,
    }
}

crate::gpu_struct! {
    /// The result of one [`RayQuery`], at the same index in its list.
    pub struct RayHit {
        /// Ray parameter of the hit, in lengths of the ray's direction; −1 = no hit. With `RayQuery::any`, only hit or no
        /// hit has meaning.
        pub t: f32,
        /// Index of the traced instance that was hit; NONE = no hit.
        pub instance: u32,
        /// Index of the hit triangle among the triangles of the instance's mesh, in the order in which the device stores
        /// them.
        pub primitive: u32,
        /// Barycentric weight, in [0, 1], of the triangle's second corner at the hit.
        pub u: f32,
        /// Barycentric weight, in [0, 1], of the triangle's third corner at the hit.
        pub v: f32,
        /// With `RayQuery::any` = 1, the fraction in [0, 1] of light that passes between the ends of the ray. With
        /// `RayQuery::any` = 0, it is 0 for a hit, and without meaning for a miss.
        pub transmittance: f32,
    }
}

crate::gpu_struct! {
    /// Push constants of the ray-buffer pass (`trace_rays`): the rays of one dispatch.
    pub struct RayBatch {
        /// Number of rays in the list; invocations beyond it do nothing.
        pub count: u32,
        /// Number of CPU threads among which the device splits a dispatch into contiguous ranges, or 1 on a GPU. The pass
        /// interleaves the list by it, so that no thread gets only easy rays.
        pub interleave: u32,
    }
}

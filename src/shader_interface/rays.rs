//! The rays of a list that the pass `trace_rays` traces, and what these rays hit. Tests and benchmarks of tracers use this
//! pass. The light BVH uses it to measure how far the light of emitters reaches.

use glam::Vec3;

crate::gpu_struct! {
    /// One ray that the pass `trace_rays` traces: for a test or a benchmark of a tracer, or to measure how far the light of
    /// an emitter reaches. Points on the ray are `origin` + t · `direction`, where t is the ray parameter.
    pub struct RayQuery {
        /// Origin of the ray in world space, relative to the scene's origin. It is in scene units in a list of rays that the
        /// caller makes, and in the device's unit of length in the buffer that the shader reads.
        pub origin: Vec3,
        /// The upper limit of the ray parameter t, measured in lengths of `direction`. A hit counts only if 0 < t < `t_max`.
        pub t_max: f32,
        /// Direction of the ray in world space. Its length may have any value except 0; t is measured in this length.
        pub direction: Vec3,
        /// 1: the search ends at the first hit that it finds, which is sufficient for visibility; 0: it finds the closest
        /// hit.
        pub any: u32,
    }
}

crate::gpu_struct! {
    /// The result of one [`RayQuery`]: what the ray hit, and where. It has the same index in the list of results as the ray
    /// in the list of rays.
    pub struct RayHit {
        /// Ray parameter t of the hit, measured in lengths of the ray's direction; −1 = no hit. If `RayQuery::any` is 1,
        /// only its sign has a meaning: hit or no hit.
        pub t: f32,
        /// Index, in the buffer `instances`, of the instance that the ray hit; NONE = no hit. If several instances of the
        /// scene were merged into one, this buffer has one entry for all of them.
        pub instance: u32,
        /// Index of the hit triangle among the triangles of the instance's mesh, in the order in which the device stores
        /// them. Without meaning for a miss.
        pub primitive: u32,
        /// Barycentric weight, in [0, 1], of the second corner of the triangle at the hit point. Without meaning for a miss.
        pub u: f32,
        /// Barycentric weight, in [0, 1], of the third corner of the triangle at the hit point. Without meaning for a miss.
        pub v: f32,
        /// If `RayQuery::any` is 1, the fraction, in [0, 1], of light that passes from one end of the ray to the other
        /// through partly transparent surfaces. If `RayQuery::any` is 0, it is 0 for a hit and has no meaning for a miss.
        pub transmittance: f32,
    }
}

crate::gpu_struct! {
    /// Push constants of the pass `trace_rays` for one dispatch, which traces the rays of a list.
    pub struct RayBatch {
        /// Number of rays in the list. The shader traces one ray per invocation; superfluous invocations of the last
        /// workgroups do nothing.
        pub count: u32,
        /// Number of CPU threads among which a CPU device splits a dispatch; 1 on a GPU. Each thread gets a contiguous range
        /// of workgroups. The pass `trace_rays` distributes the workgroups of each range over the whole list of rays, so
        /// that no thread gets only rays that are fast to trace.
        pub interleave: u32,
    }
}

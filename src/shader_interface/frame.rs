//! What the passes of a frame are told: the view, settings of reuse, and which part of it they work on.

use crate::TILE;
use glam::{UVec2, Vec2, Vec3};

crate::gpu_struct! {
    /// A pinhole camera relative to the scene's origin.
    pub struct GpuCamera {
        /// Position.
        pub position: Vec3,
        /// Half the image plane's width at distance 1, to the right.
        pub right: Vec3,
        /// Half the image plane's height at distance 1, upwards.
        pub up: Vec3,
        /// Unit viewing direction.
        pub forward: Vec3,
    }
}

crate::gpu_struct! {
    /// The view that is rendered, and limits of paths.
    pub struct ViewConstants {
        /// The camera.
        pub camera: GpuCamera,
        /// Image width in pixels.
        pub width: u32,
        /// Image height in pixels.
        pub height: u32,
        /// Threads of a device that gives each a contiguous range of workgroups, or 1.
        pub interleave: u32,
        /// The run's seed.
        pub seed: u32,
        /// Maximum scattering events of a path.
        pub bounces: u32,
        /// Scattering events before Russian roulette begins.
        pub roulette_start: u32,
        /// Minimum probability of continuing a path.
        pub roulette_floor: f32,
    }
}

crate::gpu_struct! {
    /// Constants of path tracing and of the AOVs.
    pub struct FrameConstants {
        /// The view.
        pub view: ViewConstants,
        /// Index of the first sample.
        pub first_sample: u32,
        /// Samples a pixel in this dispatch.
        pub samples: u32,
        /// Box filter over the pixel (1) or pixel centres (0).
        pub jitter: u32,
        /// The [`Heuristic`](crate::Heuristic).
        pub heuristic: u32,
        /// 1 if light that was scattered once is left out, otherwise 0.
        pub without_direct_light: u32,
    }
}

crate::gpu_struct! {
    /// The resampling of direct or of indirect light.
    pub struct ReuseConstants {
        /// 1 if light candidates are drawn uniformly among all lights, 0 if by power.
        pub uniform_candidates: u32,
        /// Light samples of a pixel, or of a vertex of a path.
        pub light_samples: u32,
        /// Probability of a candidate among rare lights; used only where they are apart.
        pub rare_lights: f32,
        /// The number of light samples drawn from the light BVH, where it finds lights; they come first.
        pub near_samples: u32,
        /// Their share of all; of a single sample the probability.
        pub near_share: f32,
        /// Maximum confidence of history.
        pub temporal_confidence_cap: f32,
        /// Maximum confidence of a neighbour.
        pub spatial_confidence_cap: f32,
        /// Maximum number of neighbours of a pixel whose surface has a history.
        pub neighbours: u32,
        /// Maximum confidence of the merge of a pixel whose surface has no history.
        pub confidence_without_history: f32,
        /// Maximum number of pixels that a search tries for each neighbour.
        pub tries: u32,
        /// Radius of the disc of neighbours, in pixels.
        pub radius: f32,
        /// Minimum cosine between the normals of similar surfaces.
        pub min_normal_cosine: f32,
        /// Maximum relative difference of similar surfaces' depths.
        pub depth_tolerance: f32,
        /// 1 if similar surfaces must have the same material, otherwise 0.
        pub same_material: u32,
    }
}

crate::gpu_struct! {
    /// The hash grid.
    pub struct GridConstants {
        /// Side of a cell; in pixels, where cells fit the picture.
        pub cell: f32,
        /// Bins of normals along each side of the octahedral map.
        pub bins: u32,
        /// Slots of reservoirs, a power of two.
        pub slots: u32,
        /// Number of surfaces that claim them.
        pub sources: u32,
        /// Slots of a cell's bin.
        pub reservoirs: u32,
        /// Light candidates of each reservoir.
        pub candidates: u32,
        /// Reservoirs that a pixel merges.
        pub merged: u32,
        /// Confidence of each of these.
        pub confidence: f32,
        /// The frame from which on none are merged.
        pub until_frame: u32,
    }
}

crate::gpu_struct! {
    /// Addresses of the world reservoirs of a frame, for shaders that take addresses; zeros for others.
    pub struct WorldAddresses {
        /// Address of the array of `GpuGridPoint`: lower word, upper word.
        pub points: UVec2,
        /// Address of the array of `GpuWorldSample`.
        pub samples: UVec2,
    }
}

crate::gpu_struct! {
    /// World reservoirs.
    pub struct WorldConstants {
        /// Where the reservoirs of the previous frame are.
        pub previous: WorldAddresses,
        /// The addresses of this frame's buffers.
        pub current: WorldAddresses,
        /// Side of a cell, in pixels.
        pub cell: f32,
        /// Bins of normals along each side of the octahedral map.
        pub bins: u32,
        /// The width of the range in which a vertex looks for its cell, in cells.
        pub jitter: f32,
        /// Reservoirs that a vertex merges.
        pub merged: u32,
        /// Maximum confidence of each of these.
        pub confidence_cap: f32,
        /// 1 if vertices keep what they merged, 0 if they keep what their own light samples selected.
        pub keeps_merged: u32,
        /// Vertices of a path that have reservoirs.
        pub depth: u32,
        /// Reservoirs of a frame.
        pub vertices: u32,
        /// Buckets of the table, a power of two.
        pub buckets: u32,
        /// Slots of a bucket.
        pub bucket_slots: u32,
    }
}

crate::gpu_struct! {
    /// A level of a prefix sum: which values, and where the sums of their blocks are.
    pub struct PrefixLevel {
        /// Index of the first value.
        pub first: u32,
        /// Number of values.
        pub count: u32,
        /// Index of the first sum.
        pub sums: u32,
    }
}

crate::gpu_struct! {
    /// Constants of the passes of resampling.
    pub struct RestirConstants {
        /// The view.
        pub view: ViewConstants,
        /// The previous frame's camera.
        pub previous_camera: GpuCamera,
        /// 1 if primary rays are jittered, 0 if they pass through the centres of the pixels.
        pub jitters: u32,
        /// The position of this frame's primary rays in the first pixel, 0…1, downwards.
        pub jitter: Vec2,
        /// That of the previous frame.
        pub previous_jitter: Vec2,
        /// Slots for pixels in a buffer: with tiles, more than there are pixels.
        pub slots: u32,
        /// Index of the frame.
        pub frame: u32,
        /// Maximum ratio of the solid angles per area at a second vertex between two views that share it; below 1: any.
        pub jacobian_limit: f32,
        /// Minimum distance to a second vertex that is shared, relative to the viewer's distance from the camera.
        pub min_distance: f32,
        /// BSDF candidates of a pixel.
        pub bsdf_samples: u32,
        /// Maximum number of additional BSDF candidates, in pixels that need them.
        pub more_bsdf_samples: u32,
        /// Mean luminance of the lights, weighted by their power.
        pub mean_light_luminance: f32,
        /// Number of nodes of the light BVH.
        pub light_node_count: u32,
        /// 1 if far lights are joined, 0 if they are skipped.
        pub light_bvh_joins: u32,
        /// 1 if lights are drawn from it uniformly, 0 if by their expected contribution.
        pub light_bvh_uniform: u32,
        /// Pixels a side of the tiles that have light lists.
        pub light_tile: u32,
        /// Entries of a light list.
        pub light_list: u32,
        /// The hash grid.
        pub grid: GridConstants,
        /// World reservoirs.
        pub world: WorldConstants,
        /// The resampling of the light of the pass.
        pub reuse: ReuseConstants,
    }
}

crate::gpu_struct! {
    /// One of the spatial passes of a frame.
    pub struct SpatialStep {
        /// The index of the spatial pass, from 0.
        pub index: u32,
        /// 1 if it also adds what it merges to the picture, otherwise 0.
        pub shades: u32,
    }
}

crate::gpu_struct! {
    /// The rows of the picture that a dispatch works on; its buffers hold only these rows.
    pub struct Strip {
        /// First row.
        pub first_row: u32,
        /// Number of rows.
        pub rows: u32,
    }
}

impl Strip {
    /// Pixels of the strip in a picture of this width.
    pub fn pixels(&self, width: u32) -> usize {
        width as usize * self.rows as usize
    }

    /// Workgroups of one tile each that cover the strip.
    pub fn groups(&self, width: u32) -> [u32; 3] {
        [width.div_ceil(TILE), self.rows.div_ceil(TILE), 1]
    }
}

//! The constants of the passes of a frame: the view, settings of reuse, and the part of the frame that a pass works on.

use crate::TILE;
use glam::{UVec2, Vec2, Vec3};

crate::gpu_struct! {
    /// A pinhole camera relative to the scene's origin.
    pub struct GpuCamera {
        /// The position.
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
        /// The number of threads of a device that gives each thread a contiguous range of workgroups, or 1.
        pub interleave: u32,
        /// The seed of the run.
        pub seed: u32,
        /// The maximum number of scattering events of a path.
        pub bounces: u32,
        /// The number of scattering events before Russian roulette begins.
        pub roulette_start: u32,
        /// The minimum probability that a path continues.
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
        /// The number of samples per pixel in this dispatch.
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
        /// The number of light samples of a pixel, or of a vertex of a path.
        pub light_samples: u32,
        /// The probability of a candidate among rare lights; used only if they have separate candidates.
        pub rare_lights: f32,
        /// The number of light samples drawn from the light BVH, if it finds lights; they come first.
        pub near_samples: u32,
        /// The fraction of these among all light samples; for a single sample, the probability.
        pub near_share: f32,
        /// Maximum confidence of history.
        pub temporal_confidence_cap: f32,
        /// Maximum confidence of a neighbour.
        pub spatial_confidence_cap: f32,
        /// The maximum number of neighbours of a pixel whose surface has a history.
        pub neighbours: u32,
        /// The maximum confidence of the merge of a pixel whose surface has no history.
        pub confidence_without_history: f32,
        /// The maximum number of pixels that a search tries for each neighbour.
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
        /// The size of a cell; in pixels if cells fit the picture.
        pub cell: f32,
        /// Bins of normals along each side of the octahedral map.
        pub bins: u32,
        /// The number of slots of reservoirs, a power of two.
        pub slots: u32,
        /// The number of surfaces that claim slots.
        pub sources: u32,
        /// The maximum number of slots per cell and bin.
        pub reservoirs: u32,
        /// The number of light candidates of each reservoir.
        pub candidates: u32,
        /// The number of reservoirs that a pixel merges.
        pub merged: u32,
        /// The confidence of each merged reservoir.
        pub confidence: f32,
        /// The index of the frame from which on no reservoirs are merged.
        pub until_frame: u32,
    }
}

crate::gpu_struct! {
    /// The addresses of the world reservoirs of a frame, for shaders that use addresses; zeros for others.
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
        /// The addresses of the previous frame's buffers.
        pub previous: WorldAddresses,
        /// The addresses of this frame's buffers.
        pub current: WorldAddresses,
        /// The size of a cell, in pixels.
        pub cell: f32,
        /// Bins of normals along each side of the octahedral map.
        pub bins: u32,
        /// The width of the range in which a vertex looks for its cell, in cells.
        pub jitter: f32,
        /// The number of reservoirs that a vertex merges.
        pub merged: u32,
        /// The maximum confidence of each merged reservoir.
        pub confidence_cap: f32,
        /// 1 if vertices keep the merged sample, 0 if they keep the sample that their light candidates selected.
        pub keeps_merged: u32,
        /// The number of vertices per path that have reservoirs.
        pub depth: u32,
        /// The number of reservoirs of a frame.
        pub vertices: u32,
        /// The number of buckets of the table, a power of two.
        pub buckets: u32,
        /// The number of slots per bucket.
        pub bucket_slots: u32,
    }
}

crate::gpu_struct! {
    /// A level of a prefix sum: the range of its values, and the location of the sums of their blocks.
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
        /// The position of this frame's primary rays in the first pixel, each coordinate in [0, 1], downwards.
        pub jitter: Vec2,
        /// The position of the previous frame's primary rays in the first pixel.
        pub previous_jitter: Vec2,
        /// Slots for pixels in a buffer: with tiles, more than there are pixels.
        pub slots: u32,
        /// Index of the frame.
        pub frame: u32,
        /// The maximum ratio between two viewers of the solid angle per area at a reused second vertex; below 1: no limit.
        pub jacobian_limit: f32,
        /// The minimum distance to a reused second vertex, relative to the viewer's distance from the camera.
        pub min_distance: f32,
        /// The number of BSDF candidates per pixel.
        pub bsdf_samples: u32,
        /// The maximum number of additional BSDF candidates, in pixels that need them.
        pub more_bsdf_samples: u32,
        /// Mean luminance of the lights, weighted by their power.
        pub mean_light_luminance: f32,
        /// Number of nodes of the light BVH.
        pub light_node_count: u32,
        /// 1 if far lights are joined, 0 if they are skipped.
        pub light_bvh_joins: u32,
        /// 1 if lights are drawn from the light BVH uniformly, 0 if by their expected contribution.
        pub light_bvh_uniform: u32,
        /// The side of the tiles that have light lists, in pixels.
        pub light_tile: u32,
        /// The number of entries of a light list.
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
        /// 1 if it also adds the merged light to the picture, otherwise 0.
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
    /// The number of pixels of the strip in a picture with this width.
    pub fn pixels(&self, width: u32) -> usize {
        width as usize * self.rows as usize
    }

    /// Workgroups of one tile each that cover the strip.
    pub fn groups(&self, width: u32) -> [u32; 3] {
        [width.div_ceil(TILE), self.rows.div_ceil(TILE), 1]
    }
}

//! The constants that a frame gives to its passes: the view, the settings of reuse, and the part of the picture that a
//! dispatch works on.

use crate::TILE;
use glam::{UVec2, Vec2, Vec3};

crate::gpu_struct! {
    /// A pinhole camera, from which shaders make primary rays and to which they project points.
    pub struct GpuCamera {
        /// Position relative to the scene's origin, in device units.
        pub position: Vec3,
        /// Vector to the right whose length is half the width of the image plane at distance 1.
        pub right: Vec3,
        /// Upward vector whose length is half the height of the image plane at distance 1.
        pub up: Vec3,
        /// Unit viewing direction, from the camera to the centre of the picture.
        pub forward: Vec3,
    }
}

crate::gpu_struct! {
    /// The camera, the picture size, the seed, and the limits of paths: the constants that all integrators read.
    pub struct ViewConstants {
        /// Camera of this frame.
        pub camera: GpuCamera,
        /// Width of the picture in pixels.
        pub width: u32,
        /// Height of the picture in pixels.
        pub height: u32,
        /// Number of CPU threads among which the device splits a dispatch into contiguous ranges, or 1 on a GPU. Shaders
        /// interleave workgroups by it, so that no thread gets only the easy part of the picture.
        pub interleave: u32,
        /// Seed of the run, from which all random numbers follow.
        pub seed: u32,
        /// Maximum number of scattering events of a path: 0 shows emitters only, 1 is direct light.
        pub bounces: u32,
        /// Number of scattering events from which on Russian roulette is used: after this event and each later one, the path
        /// may end at random.
        pub roulette_start: u32,
        /// Minimum probability, in (0, 1], with which a path continues after Russian roulette; it limits the weight of
        /// survivors.
        pub roulette_floor: f32,
    }
}

crate::gpu_struct! {
    /// Constants of the passes of path tracing, and of the pass that makes the AOVs of primary surfaces.
    pub struct FrameConstants {
        /// Camera, picture size, seed and limits of paths.
        pub view: ViewConstants,
        /// Index of the first sample per pixel in this dispatch, which selects the random numbers.
        pub first_sample: u32,
        /// Number of samples per pixel in this dispatch.
        pub samples: u32,
        /// 1: primary rays pass through random points of the pixel (box filter); 0: through its centre.
        pub jitter: u32,
        /// The MIS heuristic, as a value of [`Heuristic`](crate::Heuristic).
        pub heuristic: u32,
        /// 1 if light that was scattered exactly once is left out of the picture, otherwise 0.
        pub without_direct_light: u32,
    }
}

crate::gpu_struct! {
    /// The settings by which a pass draws light candidates and reuses reservoirs, for direct or for indirect light.
    pub struct ReuseConstants {
        /// 1 if candidates among all lights are drawn with the same probability for each light, 0 if in proportion to power.
        pub uniform_candidates: u32,
        /// Number of light samples per pixel and frame for direct light, per path vertex for indirect light.
        pub light_samples: u32,
        /// Probability, in [0, 1], of a separate candidate among rare lights, those far dimmer than the others; used only
        /// with the specialisation constant `RARE_LIGHTS`.
        pub rare_lights: f32,
        /// Number of the light samples that are drawn from the light BVH at points where it finds lights. These samples come
        /// before the others.
        pub near_samples: u32,
        /// Fraction, in [0, 1], of the light samples that are drawn from the light BVH: `near_samples` / `light_samples`.
        /// For a single light sample, it is the probability that this sample is drawn from the light BVH.
        pub near_fraction: f32,
        /// Maximum confidence of the previous frame's reservoir in a merge, in units of an initial reservoir. A higher cap
        /// means less noise, but older errors.
        pub temporal_confidence_cap: f32,
        /// Maximum confidence of a neighbour's reservoir in a merge, in units of an initial reservoir.
        pub spatial_confidence_cap: f32,
        /// Maximum number of neighbours that a spatial pass merges in a pixel with a history, that is, whose reservoir
        /// contains one of the previous frame. For other pixels, the specialisation constant `NEIGHBOURS` is the maximum.
        pub neighbours: u32,
        /// Maximum confidence of the merged reservoir of a pixel without a history, in units of an initial reservoir. These
        /// pixels share noise with their neighbours, and the limit keeps it from staying for many frames.
        pub confidence_without_history: f32,
        /// Maximum number of random pixels that the search for neighbours tries, per neighbour.
        pub tries: u32,
        /// Radius in pixels of the disc around the pixel in which neighbours are searched.
        pub radius: f32,
        /// Minimum cosine between the normals of two surfaces that may share samples.
        pub min_normal_cosine: f32,
        /// Maximum difference between the camera distances of two surfaces that may share samples, as a fraction of the
        /// pixel's distance.
        pub depth_tolerance: f32,
        /// 1 if two surfaces may share samples only if they have the same material, otherwise 0.
        pub same_material: u32,
    }
}

crate::gpu_struct! {
    /// Constants of the hash grid, a light sampler that keeps reservoirs of direct light in cells of space.
    pub struct GridConstants {
        /// Side of a cell: in pixels where pixels fill the grid, otherwise in the device's unit of length. Larger cells have
        /// more reservoirs in common, which fit each pixel less well.
        pub cell: f32,
        /// Number of bins of normals along each side of the octahedral map; a cell has `bins`² bins. 1: normals do not
        /// matter.
        pub bins: u32,
        /// Number of slots for reservoirs in the whole grid, a power of two, because the shaders mask hashes with it.
        pub slots: u32,
        /// Number of surfaces that claim slots: one per block of pixels, or the length of the list of points.
        pub sources: u32,
        /// Maximum number of reservoirs per bin of a cell.
        pub reservoirs: u32,
        /// Number of light candidates from which each reservoir of the grid selects its sample.
        pub candidates: u32,
        /// Maximum number of reservoirs of the grid that a pixel merges with its light samples.
        pub merged: u32,
        /// Confidence of each merged reservoir; 1 is the confidence of all candidates of the pixel together.
        pub confidence: f32,
        /// Index of the first frame in which pixels no longer merge reservoirs of the grid, because their history is better
        /// by then; `u32::MAX`: they always merge them.
        pub until_frame: u32,
    }
}

crate::gpu_struct! {
    /// Device addresses of the two buffers of one frame's world reservoirs; zeros in shader variants that do not use
    /// addresses.
    pub struct WorldAddresses {
        /// Address of the array of `GpuGridPoint`, one per path vertex: lower word, upper word.
        pub points: UVec2,
        /// Address of the array of `GpuWorldSample`, one per path vertex: lower word, upper word.
        pub samples: UVec2,
    }
}

crate::gpu_struct! {
    /// Constants of world reservoirs: reservoirs of direct light at path vertices in cells of space, which vertices of the
    /// next frame merge.
    pub struct WorldConstants {
        /// Addresses of the reservoirs that vertices of the previous frame stored; vertices of this frame merge them.
        pub previous: WorldAddresses,
        /// Addresses of the reservoirs that vertices of this frame store for the next frame.
        pub current: WorldAddresses,
        /// Side of a cell of space, in pixels of the picture; a cell far from the camera is larger in the scene.
        pub cell: f32,
        /// Number of bins of normals along each side of the octahedral map; a cell has `bins`² bins. 1: normals do not
        /// matter.
        pub bins: u32,
        /// Width, in cells, of the range around a vertex from which it selects a cell at random, so that borders of cells do
        /// not show.
        pub jitter: f32,
        /// Maximum number of reservoirs of the previous frame that a vertex merges.
        pub merged: u32,
        /// Maximum confidence of each merged reservoir; 1 is the confidence of all light samples of a vertex together.
        pub confidence_cap: f32,
        /// 1 if a vertex stores the sample that its merge selected, 0 if it stores the sample that its own light candidates
        /// selected. With 1, vertices still store the latter if a channel of their diffuse albedo is at most 0.01 or if
        /// their shading normal differs from the geometric normal.
        pub keeps_merged: u32,
        /// Number of vertices per path that have world reservoirs, from the second vertex on.
        pub depth: u32,
        /// Number of world reservoirs in the buffers of a frame: `depth` for each pixel slot.
        pub vertices: u32,
        /// Number of buckets of the table that finds cells by key: a power of two, because the shaders mask keys with it.
        pub buckets: u32,
        /// Number of slots for cells per bucket of that table.
        pub bucket_slots: u32,
    }
}

crate::gpu_struct! {
    /// One level of a prefix sum: its values in the buffer, and the position of the sums of its blocks of `PREFIX_BLOCK`
    /// values. These sums are the values of the next level.
    pub struct PrefixLevel {
        /// Index of the level's first value in the buffer.
        pub first: u32,
        /// Number of values of the level.
        pub count: u32,
        /// Index in the buffer of the sum of the level's first block; the sums of the next blocks follow.
        pub sums: u32,
    }
}

crate::gpu_struct! {
    /// Constants of the passes of resampling, rewritten for every frame, and for direct and indirect light separately.
    pub struct RestirConstants {
        /// Camera, picture size, seed and limits of paths.
        pub view: ViewConstants,
        /// Camera of the previous frame, for reprojection and for cells of world reservoirs.
        pub previous_camera: GpuCamera,
        /// 1 if primary rays pass through varying points of their pixels, 0 if they pass through the centres.
        pub jitters: u32,
        /// Point of the pixel (0, 0) through which its primary ray passes in this frame: coordinates in [0, 1), to the right
        /// and down. Other pixels add an offset that depends on their coordinates, modulo 1.
        pub jitter: Vec2,
        /// Point of the pixel (0, 0) through which its primary ray passed in the previous frame, as for `jitter`.
        pub previous_jitter: Vec2,
        /// Number of slots for pixels in a buffer with one entry per pixel. If the order of pixels uses tiles, it is more
        /// than the number of pixels.
        pub slots: u32,
        /// Index of the frame, from 0, which selects the random numbers.
        pub frame: u32,
        /// Maximum ratio between the solid angles that a unit of area at a path's second vertex has from two surface points.
        /// Points with a larger ratio do not share the path. Below 1: no limit.
        pub jacobian_limit: f32,
        /// Minimum distance from a surface point to a reused second vertex, as a fraction of the point's distance from the
        /// camera. Paths with a closer second vertex are not shared.
        pub min_distance: f32,
        /// Number of BSDF candidates of direct light per pixel and frame.
        pub bsdf_samples: u32,
        /// Maximum number of additional BSDF candidates. Pixels get them if their lobes are narrow, or if pilots (stored
        /// first BSDF rays) near them found bright light.
        pub more_bsdf_samples: u32,
        /// Mean luminance of emissive triangles and environment, weighted by power, in the device's unit of radiance; 0 if
        /// there are neither. The brightness that a pilot (a stored first BSDF ray) found is measured in this unit.
        pub mean_light_luminance: f32,
        /// Number of nodes of the light BVH; the entries of the light BVH begin after them in the same buffer.
        pub light_node_count: u32,
        /// 1 if the light BVH joins lights that are far from a point into groups, so that a draw can select them; 0 if it
        /// finds a light only at points inside the box of influence of the light's leaf.
        pub light_bvh_joins: u32,
        /// 1 if the lights that the light BVH finds are drawn with the same probability each, 0 if in proportion to their
        /// expected contribution.
        pub light_bvh_uniform: u32,
        /// Side, in pixels, of the square tiles of the picture, each of which has one light list.
        pub light_tile: u32,
        /// Number of entries of a light list, each with a light and its probability.
        pub light_list: u32,
        /// Constants of the hash grid (reservoirs of direct light in cells of space); all zero if there is no hash grid.
        pub grid: GridConstants,
        /// Constants of world reservoirs (reservoirs of path vertices in cells of space); all zero if there are none.
        pub world: WorldConstants,
        /// Settings of candidates and reuse, for the kind of light (direct or indirect) that the pass works on.
        pub reuse: ReuseConstants,
    }
}

crate::gpu_struct! {
    /// Push constants of one of the spatial passes of a frame.
    pub struct SpatialStep {
        /// Index of the spatial pass in the frame, from 0; it selects the random numbers.
        pub index: u32,
        /// 1 if the pass also adds the light of the merge to the picture, as the last spatial pass may do; otherwise 0.
        pub shades: u32,
    }
}

crate::gpu_struct! {
    /// The rows of the picture that a dispatch works on. The buffers of the pass hold the pixels of these rows only.
    pub struct Strip {
        /// Index of the first row, from the top of the picture.
        pub first_row: u32,
        /// Number of rows.
        pub rows: u32,
    }
}

impl Strip {
    /// The number of pixels of the strip in a picture of `width` pixels per row.
    pub fn pixels(&self, width: u32) -> usize {
        width as usize * self.rows as usize
    }

    /// The numbers of workgroups along x, y and z that cover the strip, one tile of [`TILE`] × [`TILE`] pixels per
    /// workgroup.
    pub fn groups(&self, width: u32) -> [u32; 3] {
        [width.div_ceil(TILE), self.rows.div_ceil(TILE), 1]
    }
}

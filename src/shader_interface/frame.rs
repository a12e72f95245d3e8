//! The constants that the program writes for the passes of a frame: the camera, the settings of resampling, and the part of
//! the picture that a dispatch works on.

use crate::TILE;
use glam::{UVec2, Vec2, Vec3};

crate::gpu_struct! {
    /// A camera, whose [`CameraModel`](crate::CameraModel) is a specialisation constant. Shaders compute primary rays from
    /// it, and project points to the picture with it, for example to find where a surface was in the previous frame.
    pub struct GpuCamera {
        /// Position of the camera relative to the scene's origin, in the device's unit of length. Primary
        /// rays begin there, those of an orthographic camera in the plane of `right` and `up` around it, and those of a
        /// thin lens on the disc around it.
        pub position: Vec3,
        /// The direction in world space that points to the right in the picture. Its length is half the width of the image
        /// plane: of an orthographic camera in the device's unit of length, of others at distance 1 from the camera.
        pub right: Vec3,
        /// The direction in world space that points upwards in the picture. Its length is half the height of the image
        /// plane, in the same unit as that of `right`.
        pub up: Vec3,
        /// Unit viewing direction in world space, from the camera to the centre of the picture. The direction
        /// of a primary ray is the sum of this vector and multiples, in [−1, 1], of `right` and `up`; with an orthographic
        /// camera, it is this vector.
        pub forward: Vec3,
        /// Radius of the thin lens, in the device's unit of length; 0 without a lens.
        pub lens_radius: f32,
        /// Radius of the thin lens divided by its focus distance: the tangent of the angle by which a ray through the rim of
        /// the lens is tilted against the parallel ray through its centre. 0 without a lens, or if it is focused on infinity.
        pub lens_slope: f32,
    }
}

crate::gpu_struct! {
    /// The camera, the size of the picture, the seed, and the limits of paths: the constants that the passes of every
    /// integrator (path tracing and ReSTIR) read.
    pub struct ViewConstants {
        /// Camera of the current frame, from which shaders compute the primary rays.
        pub camera: GpuCamera,
        /// Width of the picture in pixels. Shaders convert between the coordinates of a pixel and its index
        /// with it.
        pub width: u32,
        /// Height of the picture in pixels. Shaders compute primary rays with it, and test whether a pixel is
        /// inside the picture.
        pub height: u32,
        /// Number of CPU threads among which a CPU device splits a dispatch; 1 on a GPU. Each thread gets a contiguous range
        /// of workgroups. Shaders distribute the workgroups of each range over the whole picture, so that no thread gets
        /// only easy parts such as the sky.
        pub interleave: u32,
        /// Seed of the run. Together with frame, pixel and random stream it determines all random numbers, so that a run can
        /// be repeated.
        pub seed: u32,
        /// Maximum number of scattering events of a path. 0: only emitters that the camera sees directly are visible; 1:
        /// direct light is added; more: indirect light is added.
        pub bounces: u32,
        /// Number of the first scattering event, counted from 1, after which Russian roulette may end the path at random. It
        /// may also end the path after each later event.
        pub roulette_start: u32,
        /// Minimum probability, in (0, 1], with which Russian roulette continues a path. The light of a continued path is
        /// divided by the probability, so this minimum limits its weight.
        pub roulette_floor: f32,
    }
}

crate::gpu_struct! {
    /// Constants of the passes of path tracing, and of the pass that computes the AOVs of the surfaces that the camera sees.
    pub struct FrameConstants {
        /// Camera, picture size, seed and limits of paths, which the passes of every integrator need.
        pub view: ViewConstants,
        /// Index of the first sample of each pixel that this dispatch adds, counted from the start of the run. It selects
        /// the random numbers of the sample.
        pub first_sample: u32,
        /// Number of samples that this dispatch adds to each pixel.
        pub samples: u32,
        /// 1: the primary ray of each sample passes through a random point of its pixel (box filter); 0: through the pixel's
        /// centre.
        pub jitter: u32,
        /// The MIS heuristic that weighs light samples against BSDF rays: the index of a variant of
        /// [`Heuristic`](crate::Heuristic).
        pub heuristic: u32,
        /// 1: direct light, which was scattered exactly once, is left out of the picture, because the settings switch direct
        /// light off; 0: the picture contains all light.
        pub without_direct_light: u32,
    }
}

crate::gpu_struct! {
    /// The settings by which a pass draws light candidates and reuses reservoirs. A pass of direct light and a pass of
    /// indirect light get different values.
    pub struct ReuseConstants {
        /// 1: a candidate that is drawn among all lights selects each light with the same probability; 0: in proportion to
        /// the light's power.
        pub uniform_candidates: u32,
        /// Number of light samples, which are candidates for resampling: per pixel and frame for direct
        /// light, per path vertex for indirect light. More samples mean less noise and more time.
        pub light_samples: u32,
        /// A probability, in [0, 1], for rare lights, which are far dimmer than the others. For direct light, each pixel
        /// draws a separate candidate among rare lights, and a shadow ray tests it with at least this probability. For
        /// indirect light, a path vertex draws one rare light with this probability, and otherwise draws its usual light
        /// samples. Unused if the specialisation constant `RARE_LIGHTS` is false.
        pub rare_lights: f32,
        /// Number of light samples that may be drawn from the light BVH; 0 without a light BVH. They are the samples with
        /// the lowest indices; the other samples are drawn among all lights. At a point where no light can be drawn from the
        /// light BVH, all samples are drawn among all lights.
        pub near_samples: u32,
        /// Fraction, in [0, 1], of the light samples that are drawn from the light BVH; shaders compute the densities of
        /// light samples with it. With two or more light samples it is `near_samples` / `light_samples`. With a single one,
        /// `near_samples` is 1, and shaders draw this sample from the light BVH with the probability `near_fraction`.
        pub near_fraction: f32,
        /// Maximum confidence with which the previous frame's reservoir enters a merge; 1 is the confidence of an initial
        /// reservoir. A larger value means less noise, but the noise of one frame stays visible in more of the following
        /// frames.
        pub temporal_confidence_cap: f32,
        /// Maximum confidence with which a neighbour's reservoir enters a merge; 1 is the confidence of an initial
        /// reservoir. A larger value gives neighbours more weight against the pixel's own reservoir.
        pub spatial_confidence_cap: f32,
        /// Maximum number of neighbours that a spatial pass merges in a pixel with a history. A pixel has a history if its
        /// reservoir already contains the reservoir of the previous frame. For pixels without a history, the specialisation
        /// constant `NEIGHBOURS` is the maximum.
        pub neighbours: u32,
        /// Maximum confidence, after a spatial merge, of the reservoir of a pixel without a history (see `neighbours`); 1 is
        /// the confidence of an initial reservoir. Such pixels often merge the same samples as pixels close to them, so
        /// their noise is similar. With less confidence, later frames replace this noise sooner. `f32::MAX`: no limit.
        pub confidence_without_history: f32,
        /// Maximum number of random pixels that the search for neighbours tries for each wanted neighbour. If it is above 1,
        /// the search tries another pixel after one whose surface is too different.
        pub tries: u32,
        /// Radius, in pixels, of the disc around a pixel in which its neighbours are searched. In a larger disc, more
        /// neighbours have surfaces that are too different to share samples.
        pub radius: f32,
        /// Minimum cosine between the normals of two surfaces that may reuse each other's samples. With a smaller cosine
        /// there is no reuse, because a good sample of one surface is rarely good for the other.
        pub min_normal_cosine: f32,
        /// Maximum difference between the distances of two surfaces from the camera, as a fraction of the distance of the
        /// pixel's own surface; for an orthographic camera, the difference of depths as a fraction of the picture's height.
        /// Surfaces with a larger difference do not reuse each other's samples.
        pub depth_tolerance: f32,
        /// 1: two surfaces may reuse each other's samples only if they have the same material; 0: their materials do not
        /// matter.
        pub same_material: u32,
    }
}

crate::gpu_struct! {
    /// Constants of the hash grid. It is a light sampler that stores reservoirs of direct light in cells of space; pixels
    /// merge the reservoirs of their cell with their own light samples.
    pub struct GridConstants {
        /// Side of a cell of the hash grid. With [`HashGrid::Pixels`](crate::HashGrid::Pixels) it is the number of pixels
        /// that a cell spans in the picture; with [`HashGrid::Points`](crate::HashGrid::Points) it is a length in the
        /// device's unit. In larger cells more pixels merge the same reservoirs, whose lights are less suitable for each of
        /// them, so the noise is higher.
        pub cell: f32,
        /// Number of bins into which each side of the octahedral map of normals is divided, so that a cell has `bins`² bins.
        /// Pixels merge only reservoirs of their own bin. 1: normals do not matter.
        pub bins: u32,
        /// Number of slots for reservoirs in the whole grid. It is a power of two, because the shaders mask hashes to find a
        /// slot.
        pub slots: u32,
        /// Number of surfaces that try to fill a slot of the hash grid with a reservoir. With
        /// [`HashGrid::Pixels`](crate::HashGrid::Pixels) there is one surface per block of 4 × 4 pixels; with
        /// [`HashGrid::Points`](crate::HashGrid::Points) there are two per sampled point of a surface, one for each side. If
        /// several surfaces try to fill the same slot, one of them fills it.
        pub sources: u32,
        /// Maximum number of reservoirs of the hash grid in each bin of a cell; a bin is a range of normals. Pixels select
        /// at random among them.
        pub reservoirs: u32,
        /// Number of light candidates from which the sample of each reservoir of the grid is selected. More candidates mean
        /// less noise.
        pub candidates: u32,
        /// Maximum number of reservoirs of the hash grid that a pixel merges with its own light samples in a frame.
        pub merged: u32,
        /// Confidence with which each reservoir of the grid enters a merge; 1 is the confidence of all candidates of the
        /// pixel together.
        pub confidence: f32,
        /// Index of the first frame in which pixels no longer merge reservoirs of the grid, because the reservoirs of the
        /// previous frame are better by then. `u32::MAX`: pixels merge them in every frame.
        pub until_frame: u32,
    }
}

crate::gpu_struct! {
    /// Device addresses of the two buffers that store the world reservoirs (light samples of path vertices) of one frame.
    /// Path vertices of the next frame read these buffers. The addresses are zero if the shaders access the buffers by
    /// bindings instead.
    pub struct WorldAddresses {
        /// Address of the array of `GpuGridPoint` (surface points), with one entry per path vertex; x is the lower and y the
        /// upper word.
        pub points: UVec2,
        /// Address of the array of `GpuWorldSample` (light samples), with one entry per path vertex; x is the lower and y
        /// the upper word.
        pub samples: UVec2,
    }
}

crate::gpu_struct! {
    /// Constants of world reservoirs. A world reservoir is a reservoir of direct light that a path vertex stores in its cell
    /// of space; path vertices of the next frame in this cell merge it with their own light sample.
    pub struct WorldConstants {
        /// Addresses of the reservoirs that path vertices of the previous frame stored. Vertices of the current frame merge
        /// them.
        pub previous: WorldAddresses,
        /// Addresses to which path vertices of the current frame write their reservoirs, for the next frame.
        pub current: WorldAddresses,
        /// Side of a cell of the world reservoirs, as the number of pixels that it spans in the picture. Cells that are
        /// farther from the camera are therefore larger in the scene.
        pub cell: f32,
        /// Number of bins into which each side of the octahedral map of normals is divided, so that a cell has `bins`² bins.
        /// Vertices merge only reservoirs of their own bin. 1: normals do not matter.
        pub bins: u32,
        /// Width of the random offset that is added to the position of a vertex before its cell is looked up, where 1 is the
        /// side of a cell. Neighbouring vertices then use different cells, so that the borders of cells do not show in the
        /// noise.
        pub jitter: f32,
        /// Maximum number of world reservoirs of the previous frame that a path vertex merges with its own light sample.
        pub merged: u32,
        /// Maximum confidence with which each world reservoir of the previous frame enters a merge; 1 is the confidence of
        /// all light samples of a vertex together.
        pub confidence_cap: f32,
        /// 1: a path vertex with a matte surface stores for the next frame the sample that its merge selected; 0: each
        /// vertex stores the sample that it selected among its own light samples. A surface counts as matte if each channel
        /// of its diffuse albedo is above 0.01 and its shading normal is equal to its geometric normal. With 1, all other
        /// vertices store the same as with 0.
        pub keeps_merged: u32,
        /// Number of vertices per path that store and merge world reservoirs. They begin with the path's second vertex; its
        /// first vertex is the surface that the camera sees. Later vertices use only their own light samples.
        pub depth: u32,
        /// Number of path vertices that may store a world reservoir in a frame: `depth` × `RestirConstants::slots`. The
        /// buffers of a frame have one entry for each of them.
        pub vertices: u32,
        /// Number of buckets of the hash table that maps the key of a cell to the cell's list of vertices. It is a power of
        /// two, because the shaders mask keys to find a bucket.
        pub buckets: u32,
        /// Number of slots in each bucket of the hash table; each slot can store one cell. If more cells than this belong to
        /// a bucket, the next frame cannot reuse the reservoirs of the cells without a slot.
        pub bucket_slots: u32,
    }
}

crate::gpu_struct! {
    /// Push constants for one level of a prefix sum over a buffer of integers. The prefix sum finds where the list of each
    /// cell of world reservoirs begins. A level is an array of values, which is divided into blocks of `PREFIX_BLOCK`
    /// values; the sums of these blocks are the values of the next level.
    pub struct PrefixLevel {
        /// Index of the level's first value in the buffer of integers over which the prefix sum runs.
        pub first: u32,
        /// Number of values of this level of the prefix sum. The shader skips values after them.
        pub count: u32,
        /// Index at which the pass stores the sum of the level's first block (`PREFIX_BLOCK` values), in the same buffer as
        /// the values. The sums of the next blocks follow.
        pub sums: u32,
    }
}

crate::gpu_struct! {
    /// Constants of the passes of resampling (ReSTIR). The program writes them for every frame, separately for direct and
    /// for indirect light.
    pub struct RestirConstants {
        /// Camera of the current frame, picture size, seed and limits of paths, which the passes of every
        /// integrator need.
        pub view: ViewConstants,
        /// Camera of the previous frame. Shaders use it to find where a surface was in the previous picture, and to find the
        /// cells of that frame's world reservoirs.
        pub previous_camera: GpuCamera,
        /// 1: in every frame, each primary ray passes through another point of its pixel, which `jitter` determines; 0:
        /// primary rays pass through the centres of their pixels.
        pub jitters: u32,
        /// Position inside the pixel (0, 0) through which its primary ray passes in this frame: the distances from the left
        /// and the upper edge of the pixel, in pixels, each in [0, 1). Each other pixel adds its own constant offset to this
        /// position, modulo 1. Without meaning if `jitters` is 0.
        pub jitter: Vec2,
        /// The value of `jitter` in the previous frame. Shaders compute the primary rays of that frame again with it.
        pub previous_jitter: Vec2,
        /// Point of the thin lens through which primary rays pass in this frame, in [0, 1)². Each pixel adds a random offset
        /// of its own, modulo 1, and maps the sum to the disc. Without meaning for other camera models.
        pub lens_point: Vec2,
        /// The value of `lens_point` in the previous frame. Shaders compute the primary rays of that frame again with it.
        pub previous_lens_point: Vec2,
        /// Number of entries in a buffer with one entry per pixel. If the order of pixels uses tiles, it is larger than the
        /// number of pixels, because incomplete tiles at the edge count as whole.
        pub slots: u32,
        /// Index of the frame, counted from 0; it selects the random numbers of the frame.
        pub frame: u32,
        /// Maximum ratio of two solid angles with which two surface points still share a path. They are the solid angles of
        /// one unit of area at the path's second vertex, as seen from each of the two points; the larger one is divided by
        /// the smaller one. With a larger ratio the path could get a very large weight and become an outlier, so it is not
        /// shared. Below 1: no limit.
        pub jacobian_limit: f32,
        /// Minimum distance between the second vertex of a path and each of the two surface points that share the path, as a
        /// fraction of this point's distance from the camera (of the picture's height for an orthographic camera). Paths with a closer second vertex are not shared, because they
        /// cause outliers in corners. 0: no limit.
        pub min_distance: f32,
        /// Number of BSDF rays that each pixel traces per frame as candidates of direct light. Their hits
        /// find lights that light samples rarely reach, for example in glossy reflections.
        pub bsdf_samples: u32,
        /// Maximum number of BSDF rays that a pixel traces per frame in addition to `bsdf_samples`. A pixel gets more of
        /// them if the lobes of its BSDF are narrow, or if the pilots (first BSDF rays) of pixels near it found bright
        /// light.
        pub more_bsdf_samples: u32,
        /// Mean luminance of the scene's emissive triangles and environment, each weighted by its power, in the device's
        /// unit of radiance; 0 if none has power. Shaders divide by it the luminance of the light that a pilot (the first
        /// BSDF ray of a pixel) found. Pixels near a pilot with a high quotient trace additional BSDF rays.
        pub mean_light_luminance: f32,
        /// Number of nodes of the light BVH, a tree from which light samples are drawn. A walk through the tree ends after
        /// the last node. The entries of the light BVH (`GpuLightEntry`) come after the nodes in the same buffer.
        pub light_node_count: u32,
        /// 1: each light of the light BVH can be drawn at every point; lights that are far from the point are drawn in two
        /// steps, first a group and then one of its lights. 0: a light can be drawn only at points inside the box of
        /// influence of the leaf that contains the light; outside of this box the light contributes little.
        pub light_bvh_joins: u32,
        /// 1: all lights that can be drawn from the light BVH at a point have the same probability. 0: the probability of a
        /// light is larger if it is expected to contribute more at the point.
        pub light_bvh_uniform: u32,
        /// Side, in pixels, of the square tiles into which the picture is divided. One pixel of each tile draws a light list
        /// for the tile; pixels in or near the tile draw their light samples from this list.
        pub light_tile: u32,
        /// Number of entries of each light list. An entry is a light and the probability with which it was drawn.
        pub light_list: u32,
        /// Constants of the hash grid, which stores reservoirs of direct light in cells of space; all zero if there is no
        /// hash grid.
        pub grid: GridConstants,
        /// Constants of world reservoirs, which path vertices store in cells of space; all zero if there are no world
        /// reservoirs.
        pub world: WorldConstants,
        /// The settings by which this pass draws candidates and reuses reservoirs. They differ between direct and indirect
        /// light.
        pub reuse: ReuseConstants,
    }
}

crate::gpu_struct! {
    /// Push constants of one spatial pass, which merges each pixel's reservoir with those of neighbours. A frame may have
    /// several such passes, one after the other.
    pub struct SpatialStep {
        /// Index of the spatial pass in the frame, counted from 0; it selects the random numbers of the pass.
        pub index: u32,
        /// 1: the pass also adds the light of the merge to the picture, which the last spatial pass of a frame can do; 0: a
        /// later pass adds the light.
        pub shades: u32,
    }
}

crate::gpu_struct! {
    /// The rows of the picture that a dispatch works on. A large picture is divided into such strips, one dispatch after the
    /// other. The buffers of the pass contain the pixels of one strip only, so that they stay within the limits of the
    /// device.
    pub struct Strip {
        /// Index of the first row of the picture that the dispatch works on, counted from the top of the
        /// picture. The buffers of the pass begin with this row.
        pub first_row: u32,
        /// Number of rows of the picture that the dispatch works on. Invocations below these rows do nothing.
        pub rows: u32,
    }
}

impl Strip {
    /// The number of pixels in the rows of the strip, if the picture is `width` pixels wide. The buffers of the pass have
    /// one entry for each of these pixels.
    pub fn pixels(&self, width: u32) -> usize {
        width as usize * self.rows as usize
    }

    /// The numbers of workgroups along x, y and z for a dispatch that covers the strip, if the picture is `width` pixels
    /// wide. Each workgroup covers [`TILE`] × [`TILE`] pixels.
    pub fn groups(&self, width: u32) -> [u32; 3] {
        [width.div_ceil(TILE), self.rows.div_ceil(TILE), 1]
    }
}

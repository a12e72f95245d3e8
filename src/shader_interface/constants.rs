//! The constants of Rust and the shaders.

crate::gpu_constants! {
    /// The index that means "none": no normals, no light, no hit.
    pub const NONE: u32 = 0xFFFF_FFFF;
    /// The width and the height of a workgroup, in pixels.
    pub const TILE: u32 = 8;
    /// The number of rays that a workgroup of the ray-buffer pass traces.
    pub const RAYS_PER_GROUP: u32 = 64;
    /// Perceptual roughness below which a specular lobe is a perfect mirror, because f32 half vectors do not resolve
    /// its GGX peak.
    pub const MIRROR_ROUGHNESS: f32 = 0.01;
    /// Alpha mode of an opaque material.
    pub const ALPHA_OPAQUE: u32 = 0;
    /// Alpha mode of a material whose surface is opaque where its alpha is at least 1, and absent elsewhere.
    pub const ALPHA_MASK: u32 = 1;
    /// Alpha mode of a material whose alpha is the fraction of light that it covers.
    pub const ALPHA_BLEND: u32 = 2;
    /// Flag of a material: the camera sees its base colour as radiance, all other rays see black.
    pub const MATERIAL_UNLIT: u32 = 1;
    /// Flag of a material at a point of a surface: textures or vertex colours decide the base colour.
    pub const MATERIAL_VARIES: u32 = 2;
    /// Wrap mode: the image of a texture repeats.
    pub const WRAP_REPEAT: u32 = 0;
    /// Wrap mode: the image of a texture repeats, mirrored every other time.
    pub const WRAP_MIRROR: u32 = 1;
    /// Wrap mode: the texels at the edges of the image continue.
    pub const WRAP_CLAMP: u32 = 2;
    /// Minimum cosine between a shading normal and the direction to the eye.
    pub const MIN_FACING: f32 = 0.01;
    /// The number of cells along a side of the directional albedo table (cosine × roughness).
    pub const ALBEDO_CELLS: u32 = 64;
    /// Words of a compact reservoir of direct light.
    pub const DIRECT_COMPACT_WORDS: u32 = 4;
    /// Words of a full reservoir of direct light.
    pub const DIRECT_FULL_WORDS: u32 = 11;
    /// Words of a compact reservoir of indirect light.
    pub const INDIRECT_COMPACT_WORDS: u32 = 8;
    /// Words of a full reservoir of indirect light.
    pub const INDIRECT_FULL_WORDS: u32 = 15;
    /// Words for debug AOVs: two of the origin of a reservoir's sample, one of the pixel's neighbours.
    pub const DEBUG_WORDS: u32 = 3;
    /// Words of the sample data of a pixel.
    pub const SAMPLE_DATA_WORDS: u32 = 8;
    /// Words of the sums of a pixel.
    pub const PIXEL_SUMS_WORDS: u32 = 12;
    /// Words of a pilot, the hit of a pixel's first BSDF ray.
    pub const PILOT_WORDS: u32 = 5;
    /// Words of the context of a light list.
    pub const LIST_CONTEXT_WORDS: u32 = 14;
    /// The size of a node of the light BVH, in entries. The entries come after the nodes.
    pub const NODE_ENTRIES: u32 = 5;
    /// Kind of a light sample: none.
    pub const LIGHT_NONE: u32 = 0;
    /// Kind of a light sample: on an emissive triangle, in area measure.
    pub const LIGHT_TRIANGLE: u32 = 1;
    /// Kind of a light sample: on an emissive triangle that emits to both sides, in area measure.
    pub const LIGHT_TWO_SIDED: u32 = 2;
    /// Kind of a light sample: on the environment, in solid angle.
    pub const LIGHT_ENVIRONMENT: u32 = 3;
    /// Kind of a light sample: a point light, in discrete measure; the kinds after it are also in discrete measure.
    pub const LIGHT_POINT: u32 = 4;
    /// Kind of a light sample: a spot.
    pub const LIGHT_SPOT: u32 = 5;
    /// Kind of a light sample: a directional light.
    pub const LIGHT_DIRECTIONAL: u32 = 6;
    /// The position of the kind of a light sample in a word, above the index.
    pub const LIGHT_KIND_SHIFT: u32 = 29;
    /// The bits of the index of a light.
    pub const LIGHT_MASK: u32 = 0x1FFF_FFFF;
    /// Position of the kind of a path in a word.
    pub const PATH_KIND_SHIFT: u32 = 30;
    /// Bits of the index of the instance of a path's second vertex, below the path's kind.
    pub const INSTANCE_MASK: u32 = 0x3FFF_FFFF;
    /// Random stream of the initial candidates.
    pub const STREAM_INITIAL: u32 = 1;
    /// Random stream of temporal reuse.
    pub const STREAM_TEMPORAL: u32 = 2;
    /// Random stream of the pilots.
    pub const STREAM_PILOTS: u32 = 3;
    /// Random stream of the decisions of primary rays at surfaces that cover a part.
    pub const STREAM_ALPHA: u32 = 4;
    /// Random stream of the light lists.
    pub const STREAM_LISTS: u32 = 5;
    /// Random stream of the choice of a light list.
    pub const STREAM_TILES: u32 = 6;
    /// Random stream of the surfaces that fill the hash grid; the next one is that of the choice among its reservoirs.
    pub const STREAM_GRID: u32 = 7;
    /// Random stream of the candidates among rare lights.
    pub const STREAM_RARE: u32 = 9;
    /// Random stream of the first spatial pass; that of pass n is n higher.
    pub const STREAM_SPATIAL: u32 = 16;
    /// The offset of all these streams in passes of indirect light, except in the pilots, which direct and indirect light have
    /// in common.
    pub const STREAM_INDIRECT: u32 = 64;
    /// Random stream of the list of a cell of world reservoirs; those of the n-th vertex of a path are 2n and 2n + 1 higher.
    pub const STREAM_WORLD: u32 = 128;
    /// The width and the height of a block of pixels; one pixel of a block claims a slot of the hash grid.
    pub const GRID_BLOCK: u32 = 4;
    /// The maximum number of reservoirs of the hash grid that a pixel merges.
    pub const MAX_GRID_MERGED: u32 = 16;
    /// Bits of the index of a vertex, plus 1, in a list of world reservoirs.
    pub const WORLD_VERTEX_BITS: u32 = 27;
    /// The maximum number of world reservoirs that a vertex merges.
    pub const MAX_WORLD_MERGED: u32 = 16;
    /// The number of values in a block of prefix sums.
    pub const PREFIX_BLOCK: u32 = 1024;
    /// The number of invocations in a workgroup of a prefix sum.
    pub const PREFIX_GROUP: u32 = 128;
    /// The maximum radiance of a sample, in the unit of the device, in which the brightest light is below 2: the squares of
    /// millions of samples still add up in f32. It is far above the brightest light, since improbable samples have large
    /// weights.
    pub const MAX_RADIANCE: f32 = 1e15;
    /// Display brightness up to which the tone curve is the identity.
    pub const TONE_KNEE: f32 = 0.8;
    /// Strength of the desaturation of colours beyond the display's range.
    pub const TONE_DESATURATION: f32 = 0.15;
    /// The counter of values rejected because they were NaN, negative or beyond MAX_RADIANCE.
    pub const COUNTER_REJECTED: u32 = 0;
    /// The counter of invocations whose loops the driver ended early.
    pub const COUNTER_CUT_SHORT: u32 = 1;
    /// The counter of rays traced.
    pub const COUNTER_RAYS: u32 = 2;
    /// The counter of lanes that trace a ray, followed by the counter of all lanes of their subgroups.
    pub const COUNTER_TRACE_LANES: u32 = 3;
    /// The counter of lanes that evaluate a target of a merge, followed by the counter of all lanes of their subgroups.
    pub const COUNTER_MERGE_LANES: u32 = 5;
    /// The counter of neighbours, or histories, that were merged.
    pub const COUNTER_NEIGHBOURS: u32 = 7;
    /// The counter of path vertices that found no slot among world reservoirs.
    pub const COUNTER_DROPPED: u32 = 8;
    /// The counter of words read from the data of pixels, vertices, tiles and cells.
    pub const COUNTER_READ: u32 = 9;
    /// The counter of words written to the data of pixels, vertices, tiles and cells.
    pub const COUNTER_WRITTEN: u32 = 10;
    /// The counter of rays that hit a surface.
    pub const COUNTER_HITS: u32 = 11;
    /// The counter of path vertices with a world reservoir.
    pub const COUNTER_VERTICES: u32 = 12;
    /// The counter of cells of the table of world reservoirs that hold a vertex.
    pub const COUNTER_CELLS: u32 = 13;
    /// The counter of slots of that table.
    pub const COUNTER_SLOTS: u32 = 14;
    /// The number of counters of a pass.
    pub const COUNTERS: u32 = 15;
}

//! Constants that Rust and the shaders share: sizes of workgroups and records, flags, random streams and indices of
//! counters.

crate::gpu_constants! {
    /// The index that means "none", in every field that holds an index: no hit, no light, no texture, no normals.
    pub const NONE: u32 = 0xFFFF_FFFF;
    /// The width and the height in pixels of the square that one workgroup works on.
    pub const TILE: u32 = 8;
    /// The number of rays that one workgroup of the ray-buffer pass (`trace_rays`) traces, one per invocation.
    pub const RAYS_PER_GROUP: u32 = 64;
    /// The perceptual roughness below which a specular lobe is treated as a perfect mirror, because half vectors in f32 do
    /// not resolve the GGX peak of such a lobe.
    pub const MIRROR_ROUGHNESS: f32 = 0.01;
    /// Alpha mode of an opaque material: rays ignore its alpha.
    pub const ALPHA_OPAQUE: u32 = 0;
    /// Alpha mode of a material whose surface is opaque where its alpha reaches a threshold, and absent elsewhere.
    pub const ALPHA_MASK: u32 = 1;
    /// Alpha mode of a material whose alpha is the fraction of light, in [0, 1], that the surface stops or reflects; the
    /// rest passes.
    pub const ALPHA_BLEND: u32 = 2;
    /// Bit in `GpuMaterial::flags`: the camera sees the base colour as radiance, and all other rays see a black surface.
    pub const MATERIAL_UNLIT: u32 = 1;
    /// Bit in `GpuMaterial::flags` that shaders set at a point whose base colour comes from a texture or from vertex
    /// colours, so that the sample data of the pixel must store this colour.
    pub const MATERIAL_VARIES: u32 = 2;
    /// Wrap mode: texture coordinates beyond [0, 1] repeat the image.
    pub const WRAP_REPEAT: u32 = 0;
    /// Wrap mode: texture coordinates beyond [0, 1] repeat the image, mirrored every other time.
    pub const WRAP_MIRROR: u32 = 1;
    /// Wrap mode: texture coordinates beyond [0, 1] read the texels at the edge of the image.
    pub const WRAP_CLAMP: u32 = 2;
    /// The minimum cosine between a shading normal and the direction to the viewer; normals below it are bent towards the
    /// viewer, so that no visible surface is seen from its back.
    pub const MIN_FACING: f32 = 0.01;
    /// The number of cells along each side (cosine and roughness) of the directional albedo table, which compensates the
    /// energy that single scattering loses. The table has one node more per side; more cells make it more precise.
    pub const ALBEDO_CELLS: u32 = 64;
    /// The number of 32-bit words of a reservoir of direct light in the compact format.
    pub const DIRECT_COMPACT_WORDS: u32 = 4;
    /// The number of 32-bit words of a reservoir of direct light in the full format.
    pub const DIRECT_FULL_WORDS: u32 = 11;
    /// The number of 32-bit words of a reservoir of indirect light in the compact format.
    pub const INDIRECT_COMPACT_WORDS: u32 = 8;
    /// The number of 32-bit words of a reservoir of indirect light in the full format.
    pub const INDIRECT_FULL_WORDS: u32 = 15;
    /// The number of 32-bit words that debug AOVs add to a reservoir: the pixel that drew the sample, the solid angle of the
    /// sample seen from there, and the number of neighbours that the pixel merged.
    pub const DEBUG_WORDS: u32 = 3;
    /// The number of 32-bit words of [`SampleData`](crate::SampleData), the packed primary surface of a pixel.
    pub const SAMPLE_DATA_WORDS: u32 = 8;
    /// The number of 32-bit words of [`PixelSums`](crate::PixelSums), the sums of radiance of a pixel.
    pub const PIXEL_SUMS_WORDS: u32 = 12;
    /// The number of 32-bit words of a pilot, which is the stored hit of a pixel's first BSDF ray.
    pub const PILOT_WORDS: u32 = 5;
    /// The number of 32-bit words at the beginning of a light list (lights that one pixel draws for the pixels near it).
    /// They describe the surface point which drew the list; the entries of the list follow.
    pub const LIST_CONTEXT_WORDS: u32 = 14;
    /// The size of a node of the light BVH (`GpuLightNode`) in units of an entry (`GpuLightEntry`). One buffer has first all
    /// nodes and then all entries, so the first entry has the index `NODE_ENTRIES` × number of nodes.
    pub const NODE_ENTRIES: u32 = 5;
    /// Kind of a light sample: no light was sampled.
    pub const LIGHT_NONE: u32 = 0;
    /// Kind of a light sample: a point on an emissive triangle. Its density is per area.
    pub const LIGHT_TRIANGLE: u32 = 1;
    /// Kind of a light sample: a point on an emissive triangle that emits to both sides. Its density is per area.
    pub const LIGHT_TWO_SIDED: u32 = 2;
    /// Kind of a light sample: a direction to the environment. Its density is per solid angle.
    pub const LIGHT_ENVIRONMENT: u32 = 3;
    /// Kind of a light sample: a point light. Its density is a discrete probability; this holds for every kind from this
    /// number on.
    pub const LIGHT_POINT: u32 = 4;
    /// Kind of a light sample: a spot light. Its density is a discrete probability.
    pub const LIGHT_SPOT: u32 = 5;
    /// Kind of a light sample: a directional light. Its density is a discrete probability.
    pub const LIGHT_DIRECTIONAL: u32 = 6;
    /// The index of the lowest bit of a light's kind (`LIGHT_…`) in the word that packs kind and index of a light.
    pub const LIGHT_KIND_SHIFT: u32 = 29;
    /// The mask of the bits of a light's index in the word that packs kind and index. It limits the number of lights, or of
    /// environment texels, to 2²⁹.
    pub const LIGHT_MASK: u32 = 0x1FFF_FFFF;
    /// The index of the lowest bit of a path's kind (how the path continues from its second vertex) in the word of a
    /// reservoir that packs it with the index of an instance.
    pub const PATH_KIND_SHIFT: u32 = 30;
    /// The mask of the bits of an instance's index in the word of a reservoir that packs it with a path's kind. The index is
    /// that of the instance at the path's second vertex.
    pub const INSTANCE_MASK: u32 = 0x3FFF_FFFF;
    /// Random stream of the initial candidates. Streams are independent, so a pass that draws more numbers does not change
    /// the numbers of another pass.
    pub const STREAM_INITIAL: u32 = 1;
    /// Random stream of the merge of a pixel's reservoir with the one of the previous frame.
    pub const STREAM_TEMPORAL: u32 = 2;
    /// Random stream of the pilots, the first BSDF ray of each pixel.
    pub const STREAM_PILOTS: u32 = 3;
    /// Random stream with which primary rays decide whether they pass a surface with alpha mode blend.
    pub const STREAM_ALPHA: u32 = 4;
    /// Random stream with which a tile draws the entries of its light list, the lights that pixels near it share.
    pub const STREAM_LISTS: u32 = 5;
    /// Random stream with which a pixel selects the tile near it whose light list it reads.
    pub const STREAM_TILES: u32 = 6;
    /// Random stream of the hash grid (reservoirs of direct light in cells of space): it decides which slot a surface
    /// claims, and with which sample the surface fills it. The next stream, `STREAM_GRID + 1`, selects the reservoirs of the
    /// grid that a pixel merges.
    pub const STREAM_GRID: u32 = 7;
    /// Random stream of the separate candidate that a pixel draws among rare lights, which are far dimmer than the others.
    pub const STREAM_RARE: u32 = 9;
    /// Random stream of the first spatial pass; spatial pass n, counted from 0, has the stream `STREAM_SPATIAL + n`.
    pub const STREAM_SPATIAL: u32 = 16;
    /// The offset that passes of indirect light add to the streams of initial candidates, temporal reuse and spatial reuse,
    /// so that their numbers differ from those of direct light.
    pub const STREAM_INDIRECT: u32 = 64;
    /// Random stream that orders the lists of world reservoirs, which are reservoirs of path vertices in cells of space. A
    /// path vertex that merges world reservoirs has the stream `STREAM_WORLD` + 2n or + 2n + 1, where n is the number of
    /// scattering events before it.
    pub const STREAM_WORLD: u32 = 128;
    /// The width and the height of a block of pixels. In each frame, one random pixel of the block claims a slot of the hash
    /// grid (reservoirs of direct light in cells of space). A larger block makes the grid cheaper and gives it fewer
    /// reservoirs.
    pub const GRID_BLOCK: u32 = 4;
    /// The maximum number of hash-grid reservoirs that a pixel merges; it is the length of an array in the shader.
    pub const MAX_GRID_MERGED: u32 = 16;
    /// The number of low bits in an entry of a world-reservoir list that hold a path vertex, as its index plus 1. The higher
    /// bits are random and decide which of two vertices keeps a slot of the list. The number of path vertices per frame is
    /// thus below 2²⁷.
    pub const WORLD_VERTEX_BITS: u32 = 27;
    /// The maximum number of world reservoirs that a path vertex merges; it is the length of an array in the shader.
    pub const MAX_WORLD_MERGED: u32 = 16;
    /// The number of consecutive values that one workgroup of a prefix sum adds up.
    pub const PREFIX_BLOCK: u32 = 1024;
    /// The number of invocations in a workgroup of a prefix sum; each handles `PREFIX_BLOCK / PREFIX_GROUP` values.
    pub const PREFIX_GROUP: u32 = 128;
    /// The maximum radiance that one sample may add to a pixel, in the device's unit, in which the brightest light is below
    /// 2. Larger values are rejected and counted. The limit is far above the brightest light, because samples with a low
    /// density have large weights. The sum of millions of squared samples below the limit is still finite in f32.
    pub const MAX_RADIANCE: f32 = 1e15;
    /// The display brightness, in [0, 1], up to which the tone curve is the identity; the curve compresses brighter values.
    pub const TONE_KNEE: f32 = 0.8;
    /// The strength with which the tone curve turns colours brighter than the display's range towards white; 0 never does.
    pub const TONE_DESATURATION: f32 = 0.15;
    /// Index of the counter of rejected values: radiance that is NaN, negative or above `MAX_RADIANCE`, and weights of
    /// reservoirs that are NaN, negative or infinite.
    pub const COUNTER_REJECTED: u32 = 0;
    /// Index of the counter of invocations whose loops the driver ended early. Any count ends the command with an error,
    /// because light is missing.
    pub const COUNTER_CUT_SHORT: u32 = 1;
    /// Index of the counter of traced rays.
    pub const COUNTER_RAYS: u32 = 2;
    /// Index of the counter of lanes (invocations of a subgroup) that trace a ray. The next counter counts all lanes of the
    /// subgroups of these lanes, so that the ratio of the two is the fraction of lanes in use.
    pub const COUNTER_TRACE_LANES: u32 = 3;
    /// Index of the counter of lanes (invocations of a subgroup) that evaluate a target function in a merge. The next
    /// counter counts all lanes of the subgroups of these lanes, so that the ratio of the two is the fraction of lanes in
    /// use.
    pub const COUNTER_MERGE_LANES: u32 = 5;
    /// Index of the counter of merged reservoirs that are not a pixel's or vertex's own: those of neighbours, of the
    /// previous frame, and world reservoirs.
    pub const COUNTER_NEIGHBOURS: u32 = 7;
    /// Index of the counter of path vertices that found no slot in the table or the lists of world reservoirs, and so are
    /// not reused.
    pub const COUNTER_DROPPED: u32 = 8;
    /// Index of the counter of 32-bit words read from pixel data, reservoirs, pilots, light lists and world reservoirs;
    /// reads of scene buffers and tables are not counted.
    pub const COUNTER_READ: u32 = 9;
    /// Index of the counter of 32-bit words written to pixel data, reservoirs, pilots, light lists and world reservoirs.
    pub const COUNTER_WRITTEN: u32 = 10;
    /// Index of the counter of rays that hit a surface.
    pub const COUNTER_HITS: u32 = 11;
    /// Index of the counter of path vertices that made a world reservoir, a light sample which vertices in the same cell of
    /// space merge in the next frame.
    pub const COUNTER_VERTICES: u32 = 12;
    /// Index of the counter of cells in the table of world reservoirs that hold at least one path vertex.
    pub const COUNTER_CELLS: u32 = 13;
    /// Index of the counter of slots for cells in the table of world reservoirs, occupied or not; added once per frame.
    pub const COUNTER_SLOTS: u32 = 14;
    /// The number of counters of a pass. The counters of all passes are in one buffer, one pass after the other.
    pub const COUNTERS: u32 = 15;
}

//! Constants that Rust and the shaders share: sizes of workgroups and of stored values, kinds and flags, numbers of random
//! streams, and indices of counters.

crate::gpu_constants! {
    /// The value that means "none" in every field that contains an index, for example no hit, no light, no
    /// texture or no normals. Shaders test for this value before they use the index.
    pub const NONE: u32 = 0xFFFF_FFFF;
    /// The width and the height, in pixels, of the square of the picture that one workgroup works on, one pixel per
    /// invocation. Workgroups that work on a list of elements, such as path vertices, also have `TILE` × `TILE` invocations.
    pub const TILE: u32 = 8;
    /// The number of rays that one workgroup of the pass `trace_rays` traces, one ray per invocation. This pass traces the
    /// rays of a buffer, for tests and benchmarks, and to measure how far the light of emitters reaches.
    pub const RAYS_PER_GROUP: u32 = 64;
    /// The perceptual roughness below which a specular lobe is treated as a perfect mirror. The GGX peak of such a lobe is
    /// so narrow that half vectors in f32 do not resolve it.
    pub const MIRROR_ROUGHNESS: f32 = 0.01;
    /// Alpha mode of an opaque material: its alpha has no effect, and every ray that hits it ends.
    pub const ALPHA_OPAQUE: u32 = 0;
    /// Alpha mode of a material with holes: its surface is opaque where its alpha is at least the threshold
    /// `GpuMaterial::alpha`, and absent elsewhere.
    pub const ALPHA_MASK: u32 = 1;
    /// Alpha mode of a partly transparent material. Its alpha, in [0, 1], is the fraction of light that the surface stops or
    /// reflects; the remaining light passes through.
    pub const ALPHA_BLEND: u32 = 2;
    /// Bit in `GpuMaterial::flags` of a material that neither reflects nor receives light. The camera sees its base colour
    /// as radiance; all other rays see a black surface.
    pub const MATERIAL_UNLIT: u32 = 1;
    /// Bit in `GpuMaterial::flags` that a shader sets in its copy of the material if a texture or vertex colours change the
    /// base colour at a point. The shader must then store this colour in the pixel's `SampleData`, because it differs from
    /// the colour in the buffer of materials.
    pub const MATERIAL_VARIES: u32 = 2;
    /// Bit in `GpuMaterial::flags` of a material whose back the camera does not see: its rays go on behind the surface.
    pub const MATERIAL_CULLED: u32 = 4;
    /// Bit in `GpuMaterial::flags` of a material with a texture whose alpha multiplies the strength of the dielectric's
    /// specular reflection.
    pub const MATERIAL_SPECULAR_TEXTURE: u32 = 8;
    /// Bit in `GpuMaterial::flags` of a material with a texture whose colour tints the dielectric's specular reflection at
    /// normal incidence.
    pub const MATERIAL_SPECULAR_COLOR_TEXTURE: u32 = 16;
    /// The number of the lowest bit of the index in `GpuMaterial::flags` of the material's first specular texture. The 27
    /// bits from there suffice for each index of the buffer `textures`, which has at most 2³² bytes. The second specular
    /// texture follows the first in that buffer.
    pub const MATERIAL_SPECULAR_SHIFT: u32 = 5;
    /// Bit in `GpuTexture::flags` of a texture whose lookups return the texel that contains the point. Without it, they
    /// interpolate between the four texels around the point.
    pub const TEXTURE_NEAREST: u32 = 1;
    /// Bit in `GpuTexture::flags` of a texture whose image has 16 bits per channel, and so two words per texel.
    pub const TEXTURE_DEEP: u32 = 2;
    /// Wrap mode of a texture: outside of [0, 1], texture coordinates read the image as if it were repeated.
    pub const WRAP_REPEAT: u32 = 0;
    /// Wrap mode of a texture: outside of [0, 1], texture coordinates read the image as if it were repeated
    /// and every second repetition were mirrored.
    pub const WRAP_MIRROR: u32 = 1;
    /// Wrap mode of a texture: outside of [0, 1], texture coordinates read the nearest texels at the edge of
    /// the image.
    pub const WRAP_CLAMP: u32 = 2;
    /// The minimum cosine between a shading normal and the direction to the viewer. A shading normal with a smaller cosine
    /// is bent towards the viewer, because a visible surface would be black if its shading normal pointed away from the
    /// viewer.
    pub const MIN_FACING: f32 = 0.01;
    /// The number of steps into which the table of the directional albedo divides each of its two axes: the roughness and
    /// the cosine of the view direction. The table therefore has (`ALBEDO_CELLS` + 1)² entries. The directional albedo is
    /// the fraction of light that the specular lobe reflects; with it, shaders add the energy that single scattering loses.
    /// More steps make the table more precise.
    pub const ALBEDO_CELLS: u32 = 64;
    /// The number of 32-bit words of a reservoir of direct light in the compact format, which stores the weight and the
    /// confidence, the light, and the point on it. The sizes of the buffers of reservoirs follow from it.
    pub const DIRECT_COMPACT_WORDS: u32 = 4;
    /// The number of 32-bit words of a reservoir of direct light in the full format, which also stores position, normal and
    /// emission at the point on the light. The sizes of the buffers of reservoirs follow from it.
    pub const DIRECT_FULL_WORDS: u32 = 11;
    /// The number of 32-bit words of a reservoir of indirect light in the compact format, which stores the weight and the
    /// confidence, the second vertex of the path, and how the path continues. The sizes of the buffers of reservoirs follow
    /// from it.
    pub const INDIRECT_COMPACT_WORDS: u32 = 8;
    /// The number of 32-bit words of a reservoir of indirect light in the full format, which also stores position, normals
    /// and material index at the path's second vertex. The sizes of the buffers of reservoirs follow from it.
    pub const INDIRECT_FULL_WORDS: u32 = 15;
    /// The number of 32-bit words that a reservoir stores in addition if the renderer is made to show its data in debug
    /// AOVs: the pixel that drew the sample, the solid angle of one unit of area at the sample as seen from the surface of
    /// that pixel, and the number of neighbours that were merged.
    pub const DEBUG_WORDS: u32 = 3;
    /// The number of 32-bit words of [`SampleData`](crate::SampleData), the packed surface that the camera sees in a pixel.
    /// Shaders use it only to count the memory that they read and write.
    pub const SAMPLE_DATA_WORDS: u32 = 8;
    /// The number of 32-bit words of [`PixelSums`](crate::PixelSums), the sums of radiance over the samples of a pixel.
    /// Shaders use it only to count the memory that they read and write.
    pub const PIXEL_SUMS_WORDS: u32 = 12;
    /// The number of 32-bit words of a pilot: the stored hit of a pixel's first BSDF ray. It is a candidate of direct light
    /// and the first segment of a path of indirect light, so that one ray serves both.
    pub const PILOT_WORDS: u32 = 5;
    /// The number of 32-bit words at the beginning of a light list (lights that one pixel of a tile draws for the pixels
    /// near it). They store the surface point of that pixel: position, normal, direction to the viewer, and a summary of the
    /// BSDF. Pixels need them to compute the density with which the list draws a light. The entries of the list come after
    /// them.
    pub const LIST_CONTEXT_WORDS: u32 = 14;
    /// The size of a node of the light BVH (`GpuLightNode`), a tree from which lights are drawn, measured in entries
    /// (`GpuLightEntry`). One buffer contains first all nodes and then all entries. Seen as an array of entries, its first
    /// entry therefore has the index `NODE_ENTRIES` × number of nodes.
    pub const NODE_ENTRIES: u32 = 5;
    /// Kind of a light sample: no light was sampled, for example because a ray hit no light.
    pub const LIGHT_NONE: u32 = 0;
    /// Kind of a light sample: a point on a triangle that emits to one side. Its density is per area.
    pub const LIGHT_TRIANGLE: u32 = 1;
    /// Kind of a light sample: a point on a triangle that emits to both sides. Its density is per area.
    pub const LIGHT_TWO_SIDED: u32 = 2;
    /// Kind of a light sample: a direction to the environment. Its density is per solid angle.
    pub const LIGHT_ENVIRONMENT: u32 = 3;
    /// Kind of a light sample: a point light. Its density is a discrete probability. All kinds with this number or a larger
    /// one are punctual lights, which have discrete probabilities.
    pub const LIGHT_POINT: u32 = 4;
    /// Kind of a light sample: a spot light. Its density is a discrete probability.
    pub const LIGHT_SPOT: u32 = 5;
    /// Kind of a light sample: a directional light. Its density is a discrete probability.
    pub const LIGHT_DIRECTIONAL: u32 = 6;
    /// The index of the lowest bit of a light's kind (`LIGHT_…`) in a 32-bit word that stores the kind and the index of a
    /// light together. The index is in the bits below it.
    pub const LIGHT_KIND_SHIFT: u32 = 29;
    /// The mask of the bits of a light's index in a 32-bit word that stores the kind and the index of a light together. The
    /// number of its bits limits the number of lights, and of texels of the environment, to 2²⁹; a scene with more emissive
    /// triangles is an error.
    pub const LIGHT_MASK: u32 = 0x1FFF_FFFF;
    /// The index of the lowest bit of a path's kind in a word of a reservoir of indirect light. The kind
    /// states how the path continues from its second vertex, for example directly to a light. The bits below
    /// it are the index of the instance at the second vertex.
    pub const PATH_KIND_SHIFT: u32 = 30;
    /// The mask of the low bits of a word of a reservoir of indirect light; they are the index of the instance that contains
    /// the path's second vertex. The same word stores the kind of the path in the bits above, from `PATH_KIND_SHIFT` on.
    pub const INSTANCE_MASK: u32 = 0x3FFF_FFFF;
    /// Number of the random stream of initial candidates. A random stream is a sequence of random numbers for one purpose.
    /// Streams are independent, so a pass that draws more numbers does not change the numbers of another pass.
    pub const STREAM_INITIAL: u32 = 1;
    /// Number of the random stream of temporal reuse, which merges a pixel's reservoir with that of the
    /// previous frame. Its random numbers decide which sample the merged reservoir keeps.
    pub const STREAM_TEMPORAL: u32 = 2;
    /// Number of the random stream of the pilots. A pilot is the first BSDF ray of a pixel, which direct and
    /// indirect light share; the random numbers select its direction.
    pub const STREAM_PILOTS: u32 = 3;
    /// Number of the random stream with which primary rays decide whether they pass through a partly transparent surface
    /// (alpha mode blend).
    pub const STREAM_ALPHA: u32 = 4;
    /// Number of the random stream with which one pixel of each tile of the picture draws the entries of the tile's light
    /// list. Pixels near the tile draw their light samples from this list.
    pub const STREAM_LISTS: u32 = 5;
    /// Number of the random stream with which a pixel selects a tile near it. The pixel then draws its light samples from
    /// the light list of this tile.
    pub const STREAM_TILES: u32 = 6;
    /// Number of the random stream with which surfaces fill the hash grid (reservoirs of direct light in cells of space). It
    /// decides which slot of the grid a surface tries to fill, and which sample it stores there. The next stream,
    /// `STREAM_GRID + 1`, selects the reservoirs of the grid that a pixel merges.
    pub const STREAM_GRID: u32 = 7;
    /// Number of the random stream of the separate candidate that a pixel draws among rare lights. Rare lights are far
    /// dimmer than the others, so a pixel would almost never select them among all lights.
    pub const STREAM_RARE: u32 = 9;
    /// Number that selects the offset which each pixel adds to the lens point of a frame.
    pub const STREAM_LENS: u32 = 10;
    /// Number of the random stream of the first spatial pass, which merges each pixel's reservoir with those
    /// of random neighbours. Spatial pass n of a frame, counted from 0, has the stream `STREAM_SPATIAL + n`.
    pub const STREAM_SPATIAL: u32 = 16;
    /// The offset between the streams of direct and of indirect light. Passes of indirect light add it to the numbers of the
    /// streams of initial candidates, temporal reuse and spatial reuse, so that their random numbers differ from those of
    /// direct light.
    pub const STREAM_INDIRECT: u32 = 64;
    /// Number of a random stream of path vertices. Each vertex uses it to select a random position in the
    /// list of its cell of space; vertices of the next frame find the world reservoir of the vertex there.
    /// Merges of world reservoirs use larger numbers: `STREAM_WORLD` + (`MAX_DELTA_LOBES` + 1) · n at a vertex
    /// after n scattering events (n ≥ 1), and up to `MAX_DELTA_LOBES` more if the path begins at a delta lobe.
    pub const STREAM_WORLD: u32 = 128;
    /// The width and the height, in pixels, of a block of the picture. In each frame, the surface at one random pixel of
    /// each block fills a slot of the hash grid with a reservoir of direct light, unless another surface takes this slot. A
    /// larger block makes the grid cheaper, but then the grid contains fewer reservoirs.
    pub const GRID_BLOCK: u32 = 4;
    /// The maximum number of reservoirs of the hash grid that a pixel merges. The shader stores their indices in an array of
    /// this length, so the setting `hash_grid.merged` must not be larger.
    pub const MAX_GRID_MERGED: u32 = 16;
    /// The number of low bits of a list entry that store the index of a path vertex plus 1. Each cell of
    /// space has a list of such entries; vertices of the next frame use it to find the world reservoirs of
    /// the cell. The high bits of an entry are random: if two vertices write to the same position of a list,
    /// the larger entry remains, so the choice between them is random. A frame with 2²⁷ path vertices or more
    /// would need more bits, so its settings are an error.
    pub const WORLD_VERTEX_BITS: u32 = 27;
    /// The maximum number of world reservoirs (light samples that path vertices of the previous frame stored) that a path
    /// vertex merges. The shader stores their indices in an array of this length, so the setting `world_reservoirs.merged`
    /// must not be larger.
    pub const MAX_WORLD_MERGED: u32 = 16;
    /// The number of consecutive values that one workgroup of a prefix sum adds up. Prefix sums compute where the list of
    /// each cell of world reservoirs begins.
    pub const PREFIX_BLOCK: u32 = 1024;
    /// The number of invocations in a workgroup of a prefix sum. Each invocation adds up `PREFIX_BLOCK / PREFIX_GROUP`
    /// values.
    pub const PREFIX_GROUP: u32 = 128;
    /// The maximum radiance that one sample may add to a pixel, in the device's unit, in which the brightest light has a
    /// radiance from 1 to 2. Larger values are replaced by 0 and counted as faults. The limit is far above the brightest
    /// light, because samples with a low density have large weights. It is low enough that the sum of the squares of
    /// millions of samples is finite in f32.
    pub const MAX_RADIANCE: f32 = 1e15;
    /// The value of a colour's largest RGB component up to which the tone curve does not change the colour; 1
    /// is the maximum of the display. The curve compresses larger values, so that they stay at most 1.
    pub const TONE_KNEE: f32 = 0.8;
    /// The strength, at least 0, with which the tone curve mixes colours above `TONE_KNEE` with white. A
    /// larger value makes bright colours white sooner; with 0, they keep their saturation.
    pub const TONE_DESATURATION: f32 = 0.15;
    /// Index of the counter of values that shaders replaced by 0 because of a fault: radiance that is NaN, negative or above
    /// `MAX_RADIANCE`, and weights of reservoirs that are NaN, negative or infinite. If it is above 0, commands that render
    /// a picture print a notice, because light is missing.
    pub const COUNTER_REJECTED: u32 = 0;
    /// Index of the counter of shader invocations that did not finish a loop, because some drivers end long loops too early.
    /// If it is above 0, the command ends with an error, because light is missing in the picture.
    pub const COUNTER_CUT_SHORT: u32 = 1;
    /// Index of the counter of all rays that the pass traced. Profiles show their number as a measure of the
    /// work of the pass.
    pub const COUNTER_RAYS: u32 = 2;
    /// Index of the counter of lanes (invocations of a subgroup) that trace a ray. The counter with the next index counts
    /// all lanes of the same subgroups, also idle ones. Profiles show the ratio of the two: the fraction of lanes in use.
    pub const COUNTER_TRACE_LANES: u32 = 3;
    /// Index of the counter of lanes (invocations of a subgroup) that evaluate a target function in a merge. The counter
    /// with the next index counts all lanes of the same subgroups, also idle ones. Profiles show the ratio of the two: the
    /// fraction of lanes in use.
    pub const COUNTER_MERGE_LANES: u32 = 5;
    /// Index of the counter of reservoirs that pixels and path vertices merged with their own: reservoirs of neighbours, of
    /// the previous frame, and world reservoirs. Profiles show it as a measure of reuse. Reservoirs of the hash grid are not
    /// counted.
    pub const COUNTER_NEIGHBOURS: u32 = 7;
    /// Index of the counter of path vertices whose world reservoir cannot be reused in the next frame, because the table has
    /// no slot for their cell, or because another vertex takes their random position in the list of the cell. Profiles show
    /// it, because dropped reservoirs mean more noise, but no bias.
    pub const COUNTER_DROPPED: u32 = 8;
    /// Index of the counter of the 32-bit words that the pass reads from large buffers; profiles show them in
    /// bytes. The counter includes the buffers with one entry per pixel (primary surfaces, colour, sums of
    /// radiance, pilots and reservoirs), light lists, reservoirs of the hash grid and world reservoirs. It
    /// does not include reads of the scene and of tables.
    pub const COUNTER_READ: u32 = 9;
    /// Index of the counter of the 32-bit words that the pass writes to the buffers that [`COUNTER_READ`] names. Profiles
    /// show it in bytes.
    pub const COUNTER_WRITTEN: u32 = 10;
    /// Index of the counter of rays that hit a surface, among all rays that the pass traced. Profiles show
    /// the fraction of rays that hit a surface.
    pub const COUNTER_HITS: u32 = 11;
    /// Index of the counter of path vertices that stored a world reservoir in this frame. A world reservoir is a light
    /// sample of a path vertex, which vertices in the same cell of space merge in the next frame.
    pub const COUNTER_VERTICES: u32 = 12;
    /// Index of the counter of cells of space in the table of world reservoirs that contain at least one path vertex in this
    /// frame. Profiles show it, since more vertices per cell mean more samples to reuse.
    pub const COUNTER_CELLS: u32 = 13;
    /// Index of the counter of slots in the table of world reservoirs; each slot can store one cell of space. The number of
    /// all slots, occupied or not, is added once per frame. Profiles divide the counted cells (`COUNTER_CELLS`) by it to
    /// show how full the table is.
    pub const COUNTER_SLOTS: u32 = 14;
    /// The number of counters of one pass. One buffer contains the counters of all passes, one pass after the other.
    pub const COUNTERS: u32 = 15;
}

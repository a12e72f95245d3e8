//! The structures and constants that Rust and the shaders share, besides enumerations
//! ([`crate::choices`]), specialisation constants ([`crate::render::specialisation`]) and the buffers of a
//! scene ([`crate::tracing::buffers`]).
//!
//! Positions, lengths and radiance in them are in the units of the device ([`crate::tracing::units`]).
//!
//! The build script compiles this file too, for the GLSL text.

use crate::choices;
use crate::gpu::layout::{GpuStruct, StructLayout};
use crate::render::specialisation::Specialisation;
use crate::tracing::buffers::{self, SceneTable};
use glam::{UVec2, UVec3, Vec2, Vec3};

crate::gpu_constants! {
    /// "None": no normals, no light, no hit.
    pub const NONE: u32 = 0xFFFF_FFFF;
    /// Width and height of a workgroup, in pixels.
    pub const TILE: u32 = 8;
    /// Rays a workgroup of the ray-buffer pass traces.
    pub const RAYS_PER_GROUP: u32 = 64;
    /// Perceptual roughness below which a specular lobe is a perfect mirror, because f32 half vectors do not resolve
    /// its GGX peak.
    pub const MIRROR_ROUGHNESS: f32 = 0.01;
    /// A material's surface covers all.
    pub const ALPHA_OPAQUE: u32 = 0;
    /// It covers all where its alpha is at least 1, and elsewhere nothing.
    pub const ALPHA_MASK: u32 = 1;
    /// It covers the share that alpha says.
    pub const ALPHA_BLEND: u32 = 2;
    /// Flag of a material: the camera sees its base colour as radiance, all else sees black.
    pub const MATERIAL_UNLIT: u32 = 1;
    /// Flag of a material at a point of a surface: textures or vertex colours decide the base colour.
    pub const MATERIAL_VARIES: u32 = 2;
    /// The image of a texture repeats.
    pub const WRAP_REPEAT: u32 = 0;
    /// It repeats mirrored.
    pub const WRAP_MIRROR: u32 = 1;
    /// Its edges continue.
    pub const WRAP_CLAMP: u32 = 2;
    /// Minimum cosine between a shading normal and the direction to the eye.
    pub const MIN_FACING: f32 = 0.01;
    /// Cells a side of the directional albedo table (cosine × roughness).
    pub const ALBEDO_CELLS: u32 = 64;
    /// Words of a compact reservoir of direct light.
    pub const DIRECT_COMPACT_WORDS: u32 = 4;
    /// Words of a full reservoir of direct light.
    pub const DIRECT_FULL_WORDS: u32 = 11;
    /// Words of a compact reservoir of indirect light.
    pub const INDIRECT_COMPACT_WORDS: u32 = 8;
    /// Words of a full reservoir of indirect light.
    pub const INDIRECT_FULL_WORDS: u32 = 15;
    /// Words of the origin of a reservoir's sample.
    pub const ORIGIN_WORDS: u32 = 2;
    /// Words of a pilot, the hit of a pixel's first BSDF ray.
    pub const PILOT_WORDS: u32 = 5;
    /// Kind of a point of a light: none.
    pub const LIGHT_NONE: u32 = 0;
    /// On an emissive triangle, in area measure.
    pub const LIGHT_TRIANGLE: u32 = 1;
    /// The same, and it emits to both sides.
    pub const LIGHT_TWO_SIDED: u32 = 2;
    /// Of the environment, in solid angle.
    pub const LIGHT_ENVIRONMENT: u32 = 3;
    /// A point light, in discrete measure; so are those that follow.
    pub const LIGHT_POINT: u32 = 4;
    /// A spot.
    pub const LIGHT_SPOT: u32 = 5;
    /// A light that comes from one direction.
    pub const LIGHT_DIRECTIONAL: u32 = 6;
    /// Position of that kind in a word, above the index.
    pub const LIGHT_KIND_SHIFT: u32 = 29;
    /// Bits of the index.
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
    /// Random stream of the coins of primary rays.
    pub const STREAM_COINS: u32 = 4;
    /// Random stream of the first spatial pass; that of pass n is n higher.
    pub const STREAM_SPATIAL: u32 = 16;
    /// Added to these by passes of indirect light, except by the pilots, which both kinds share.
    pub const STREAM_INDIRECT: u32 = 64;
    /// Maximum radiance of a sample, in the unit of the device, in which the brightest light is below 2: the squares of
    /// millions of them still add up in f32. It is far above that, since improbable samples have large weights.
    pub const MAX_RADIANCE: f32 = 1e15;
    /// Values rejected because they were NaN, negative or beyond MAX_RADIANCE.
    pub const COUNTER_REJECTED: u32 = 0;
    /// Invocations whose loops the driver ended early.
    pub const COUNTER_CUT_SHORT: u32 = 1;
    /// Rays traced.
    pub const COUNTER_RAYS: u32 = 2;
    /// Lanes that trace a ray, and, next to it, those of their subgroups.
    pub const COUNTER_TRACE_LANES: u32 = 3;
    /// Lanes that evaluate a target of a merge, and, next to it, those of their subgroups.
    pub const COUNTER_MERGE_LANES: u32 = 5;
    /// Neighbours, or histories, that were merged.
    pub const COUNTER_NEIGHBOURS: u32 = 7;
    /// Counters of a pass.
    pub const COUNTERS: u32 = 8;
}

crate::gpu_struct! {
    /// A mesh placed in the world, relative to the scene's origin.
    pub struct GpuInstance {
        /// Columns of the 3×4 object-to-world transform.
        pub object_to_world: [Vec3; 4],
        /// Columns of the 3×4 world-to-object transform.
        pub world_to_object: [Vec3; 4],
        /// First triangle of its mesh in the position array.
        pub first_triangle: u32,
        /// First triangle of its mesh in the normal array, or NONE for flat shading.
        pub first_normal: u32,
        /// First triangle of its mesh in the part array, or NONE if the mesh has one material.
        pub first_part: u32,
        /// Root of its mesh in the node array.
        pub root_node: u32,
        /// Material of a mesh of one part.
        pub material: u32,
        /// The light of its first emissive triangle, or NONE.
        pub first_light: u32,
        /// Index of this instance in the scene, as the AOV shows it.
        pub id: u32,
        /// First triangle of its mesh in the array of texture coordinates, for each of two sets; or NONE.
        pub first_uvs: UVec2,
        /// First triangle of its mesh in the array of vertex colours, or NONE.
        pub first_color: u32,
        /// First triangle of its mesh in the array of tangents, or NONE.
        pub first_tangent: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A surface's material.
    pub struct GpuMaterial {
        /// Linear base colour; with MATERIAL_UNLIT radiance.
        pub base_color: Vec3,
        /// 0 dielectric … 1 metal.
        pub metallic: f32,
        /// Reflectance of the dielectric at normal incidence.
        pub dielectric_f0: Vec3,
        /// Reflectance of the dielectric at grazing incidence.
        pub dielectric_f90: f32,
        /// Perceptual roughness.
        pub roughness: f32,
        /// Texture that multiplies the base colour, or NONE.
        pub base_color_texture: u32,
        /// Texture that multiplies roughness and metalness, or NONE.
        pub metallic_roughness_texture: u32,
        /// MATERIAL_…
        pub flags: u32,
        /// Texture that turns the shading normal, or NONE.
        pub normal_texture: u32,
        /// Multiplies its red and green.
        pub normal_scale: f32,
        /// ALPHA_…
        pub alpha_mode: u32,
        /// Coverage, which texture and vertex colours multiply; with ALPHA_MASK divided by the cutoff.
        pub alpha: f32,
    }
}

crate::gpu_struct! {
    /// An image as a material uses it.
    pub struct GpuTexture {
        /// First column of the 2×2 part of the transform from texture coordinates to those of the image.
        pub column_u: Vec2,
        /// Second column.
        pub column_v: Vec2,
        /// The translation.
        pub offset: Vec2,
        /// Where the image is: the index of its first texel in the array of texels or, where images are sampled, its own
        /// index.
        pub place: u32,
        /// Width in texels.
        pub width: u32,
        /// Height in texels.
        pub height: u32,
        /// The set of texture coordinates, 0 or 1.
        pub set: u32,
        /// WRAP_… along u, and along v times 4.
        pub wrap: u32,
        /// Whether a lookup takes the nearest texel (1) or interpolates between four (0).
        pub nearest: u32,
    }
}

crate::gpu_struct! {
    /// An emissive triangle in world space.
    pub struct GpuLight {
        /// First corner.
        pub corner: Vec3,
        /// From the first corner to the second.
        pub edge1: Vec3,
        /// From the first corner to the third.
        pub edge2: Vec3,
        /// Unit normal of the emitting side.
        pub normal: Vec3,
        /// Emitted radiance.
        pub emission: Vec3,
        /// Area, in the unit of length on the device.
        pub area: f32,
        /// Whether it emits on both sides (0 or 1).
        pub double_sided: u32,
        /// The traced instance that it belongs to.
        pub instance: u32,
        /// Its index in the mesh of that instance, if it may have holes; else NONE.
        pub primitive: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// A punctual light.
    pub struct GpuPunctualLight {
        /// Position; without meaning for a directional light.
        pub position: Vec3,
        /// LIGHT_POINT, LIGHT_SPOT or LIGHT_DIRECTIONAL.
        pub kind: u32,
        /// Unit, in which a spot is aimed or directional light travels.
        pub direction: Vec3,
        /// The distance up to which it reaches; 0: any.
        pub range: f32,
        /// Intensity; of a directional light the irradiance of a surface that faces it.
        pub intensity: Vec3,
        /// Of a spot: the square root of its share is this times the cosine to its axis,
        pub angle_scale: f32,
        /// plus this, within 0 and 1.
        pub angle_offset: f32,
        /// Fills the last four words.
        pub padding: UVec3,
    }
}

crate::gpu_struct! {
    /// One column of the alias table that selects lights of all kinds by power.
    pub struct GpuLightChoice {
        /// Probability of the column's own light.
        pub probability: f32,
        /// Take that light if 32 random bits are below this.
        pub keep_below: u32,
        /// Else take this one.
        pub alias: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// How a texture is laid onto a light.
    pub struct GpuLightTexture {
        /// Texture coordinates of the first corner.
        pub uv: Vec2,
        /// From the first corner to the second.
        pub edge1: Vec2,
        /// From the first corner to the third.
        pub edge2: Vec2,
        /// The texture that multiplies its emission, or NONE.
        pub texture: u32,
        /// Fills the last four words.
        pub padding: u32,
    }
}

crate::gpu_struct! {
    /// Where the points of an instance were in the previous frame.
    pub struct GpuPreviousTransform {
        /// Columns of the 3×4 transform from current to previous world positions.
        pub current_to_previous: [Vec3; 4],
    }
}

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
    /// What is rendered, and how far.
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
        /// The [`Heuristic`](crate::choices::Heuristic).
        pub heuristic: u32,
    }
}

crate::gpu_struct! {
    /// How one kind of light is resampled.
    pub struct ReuseConstants {
        /// Whether lights are selected uniformly (1) or by power (0).
        pub uniform_candidates: u32,
        /// Light samples of a pixel, or of a vertex of a path.
        pub light_samples: u32,
        /// Maximum confidence of history.
        pub temporal_confidence_cap: f32,
        /// Maximum confidence of a neighbour.
        pub spatial_confidence_cap: f32,
        /// Spatial passes of a frame.
        pub spatial_passes: u32,
        /// Maximum number of pixels that a search for neighbours tries.
        pub tries: u32,
        /// Radius of the disc of neighbours, in pixels.
        pub radius: f32,
        /// Minimum cosine between the normals of similar surfaces.
        pub min_normal_cosine: f32,
        /// Maximum relative difference of similar surfaces' depths.
        pub depth_tolerance: f32,
        /// Whether similar surfaces must have the same material.
        pub same_material: u32,
    }
}

crate::gpu_struct! {
    /// Constants of the passes of resampling.
    pub struct RestirConstants {
        /// The view.
        pub view: ViewConstants,
        /// The previous frame's camera.
        pub previous_camera: GpuCamera,
        /// Whether primary rays are jittered (1) or pass through the pixels' centres (0).
        pub jitters: u32,
        /// The position of this frame's primary rays in the first pixel, 0…1, downwards.
        pub jitter: Vec2,
        /// That of the previous frame.
        pub previous_jitter: Vec2,
        /// Places for pixels in a buffer: with tiles, more than there are pixels.
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
        /// How the kind of light of the pass is resampled.
        pub reuse: ReuseConstants,
    }
}

crate::gpu_struct! {
    /// Which of a frame's spatial passes this is.
    pub struct SpatialStep {
        /// Its index, from 0.
        pub index: u32,
        /// Whether it also adds what it merges to the picture (0 or 1).
        pub shades: u32,
    }
}

crate::gpu_struct! {
    /// The contents of a pixel's reservoir, for debug AOVs.
    pub struct ReservoirAov {
        /// Unbiased contribution weight; 0 = empty. In squared scene units for indirect light and for points of triangles,
        /// in steradians for the environment, without a unit for punctual lights.
        pub weight: f32,
        /// Confidence, in units of one initial reservoir.
        pub confidence: f32,
        /// Frames since the sample was drawn.
        pub age: u32,
        /// The sample's light; NONE = empty, or a path of indirect light that does not reach one from its
        /// second vertex.
        pub light: u32,
        /// Neighbours that the frame's spatial passes found.
        pub neighbours: u32,
        /// The pixel that drew the sample, in that frame; −1 = empty, or origins were not kept.
        pub source: Vec2,
        /// The ratio of the sample's solid angle seen from here to that seen from its origin: the product of the
        /// Jacobians, by solid angle, of all its shifts; 0 = empty, or origins were not kept.
        pub jacobian: f32,
    }
}

crate::gpu_struct! {
    /// A pixel's primary surface, packed for later passes and the next frame.
    pub struct SampleData {
        /// Distance along the primary ray to just before the surface.
        pub depth: f32,
        /// Geometric and shading normal (22 + 22 bits each, octahedral) and the exponent of the ray offset (8).
        pub packed_normals: UVec3,
        /// Index of the material.
        pub material: u32,
        /// Index of the instance in the scene; NONE = no surface.
        pub instance: u32,
        /// Base colour, metalness and roughness where textures or vertex colours decide them.
        pub packed_material: UVec2,
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

crate::gpu_struct! {
    /// Sums over a pixel's samples, each as an unevaluated pair high + low.
    pub struct PixelSums {
        /// Σ radiance, leading part.
        pub sum: Vec3,
        /// Σ radiance, rounding error of the leading part.
        pub sum_low: Vec3,
        /// Σ radiance², leading part.
        pub square: Vec3,
        /// Σ radiance², rounding error of the leading part.
        pub square_low: Vec3,
    }
}

crate::gpu_struct! {
    /// The surface through a pixel's centre.
    pub struct PrimarySurface {
        /// Diffuse and specular albedo, by which a denoiser divides.
        pub albedo: Vec3,
        /// Unit shading normal, world space, towards the camera.
        pub normal: Vec3,
        /// Distance along the ray; 0 = miss.
        pub depth: f32,
        /// Index of the instance in the scene; NONE = miss.
        pub instance: u32,
        /// Previous minus current position in the image, in pixels, downwards. A miss is at infinite distance. 0 if the
        /// surface was behind the camera.
        pub motion: Vec2,
    }
}

crate::gpu_struct! {
    /// A ray of the ray-buffer pass.
    pub struct RayQuery {
        /// Origin: relative to the scene's origin and in scene units in lists of rays, in the device's unit in buffers.
        pub origin: Vec3,
        /// Hits at this parameter and beyond are ignored.
        pub t_max: f32,
        /// Direction; the parameter counts in its length.
        pub direction: Vec3,
        /// 1: any hit will do; 0: the closest.
        pub any: u32,
    }
}

crate::gpu_struct! {
    /// The answer to a [`RayQuery`].
    pub struct RayAnswer {
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
        /// With `any`, the share of light that passes between the ray's ends; otherwise 0 or, of a miss, without meaning.
        pub transmittance: f32,
    }
}

crate::gpu_struct! {
    /// How many rays the ray-buffer pass traces.
    pub struct RayBatch {
        /// Number of rays.
        pub count: u32,
        /// Threads that the device gives fixed runs of workgroups, or 1.
        pub interleave: u32,
    }
}

/// Every shared structure; each comes after those that it contains.
pub const STRUCTS: &[StructLayout] = &[
    SceneTable::LAYOUT,
    GpuInstance::LAYOUT,
    GpuMaterial::LAYOUT,
    GpuTexture::LAYOUT,
    GpuLight::LAYOUT,
    GpuPunctualLight::LAYOUT,
    GpuLightChoice::LAYOUT,
    GpuLightTexture::LAYOUT,
    GpuPreviousTransform::LAYOUT,
    GpuCamera::LAYOUT,
    ViewConstants::LAYOUT,
    FrameConstants::LAYOUT,
    ReuseConstants::LAYOUT,
    RestirConstants::LAYOUT,
    SpatialStep::LAYOUT,
    ReservoirAov::LAYOUT,
    SampleData::LAYOUT,
    Strip::LAYOUT,
    PixelSums::LAYOUT,
    PrimarySurface::LAYOUT,
    RayQuery::LAYOUT,
    RayAnswer::LAYOUT,
    RayBatch::LAYOUT,
];

/// The text of `layouts.glsl`: constants, enumerations, specialisation constants and structures.
pub fn glsl() -> String {
    let mut text = constants_glsl() + &choices::glsl() + &Specialisation::glsl();
    for layout in STRUCTS {
        text += &layout.glsl();
    }
    text
}

/// The files that are generated for the shaders, by name.
pub fn generated() -> [(&'static str, String); 2] {
    [
        ("layouts.glsl", glsl()),
        ("scene_buffers.glsl", buffers::glsl()),
    ]
}

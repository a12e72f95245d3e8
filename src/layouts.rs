//! What Rust and the shaders share: structures and constants.
//!
//! This file is also compiled into the build script.

use crate::gpu::layout::{GpuStruct, StructLayout};
use glam::{UVec2, Vec3};

crate::gpu_constants! {
    /// Marks "none": no normals, no light, no hit.
    pub const NONE: u32 = 0xFFFF_FFFF;
    /// Width and height of a workgroup, in pixels.
    pub const TILE: u32 = 8;
    /// Rays a workgroup of the ray-buffer pass traces.
    pub const RAYS_PER_GROUP: u32 = 64;
    /// Words of a compressed eight-wide node.
    pub const NODE_WORDS: u32 = 20;
    /// Perceptual roughness below which a specular lobe is a perfect mirror: its GGX peak would
    /// exceed what f32 half-vectors resolve.
    pub const MIRROR_ROUGHNESS: f32 = 0.01;
    /// Least cosine between a shading normal and the direction to the eye.
    pub const LEAST_FACING: f32 = 0.01;
    /// Cells a side of the directional albedo table (cosine × roughness).
    pub const ALBEDO_CELLS: u32 = 64;
    /// Next-event estimation weighs by the balance heuristic.
    pub const HEURISTIC_BALANCE: u32 = 0;
    /// Next-event estimation weighs by the power heuristic (β = 2).
    pub const HEURISTIC_POWER: u32 = 1;
    /// Largest radiance of a sample: the squares of millions of them still add up in f32. It leaves
    /// room above the brightest lamp for what improbable samples weigh.
    pub const MOST_RADIANCE: f32 = 1e15;
    /// Values that a pass of path tracing refused because they were NaN, negative or beyond MOST_RADIANCE.
    pub const COUNTER_REJECTED: u32 = 0;
    /// Invocations whose loops the driver ended before their last sample.
    pub const COUNTER_CUT_SHORT: u32 = 1;
    /// Number of counters.
    pub const COUNTERS: u32 = 2;
}

crate::gpu_struct! {
    /// Where the scene lies, for shaders that read it by address.
    pub struct SceneAddresses {
        /// Corner normals, three packed octahedral words a triangle.
        pub normals: UVec2,
        /// Three words a triangle of a mesh of several parts: material, emissive rank, and what its
        /// part adds to the instance's number.
        pub triangle_parts: UVec2,
        /// Instances in the order of the top level's leaves.
        pub top_instances: UVec2,
        /// Instances.
        pub instances: UVec2,
        /// Nodes, five times four words each.
        pub nodes: UVec2,
        /// Corner positions, three a triangle.
        pub positions: UVec2,
        /// Materials.
        pub materials: UVec2,
        /// Lights.
        pub lights: UVec2,
    }
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
        /// The scene's own number of this instance, as the AOV shows it.
        pub id: u32,
    }
}

crate::gpu_struct! {
    /// A surface, ready for evaluation.
    pub struct GpuMaterial {
        /// Linear base colour.
        pub base_color: Vec3,
        /// 0 dielectric … 1 metal.
        pub metallic: f32,
        /// Reflectance of the dielectric at normal incidence.
        pub dielectric_f0: Vec3,
        /// Reflectance of the dielectric at grazing incidence.
        pub dielectric_f90: f32,
        /// Perceptual roughness.
        pub roughness: f32,
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
        /// Area in squared scene units.
        pub area: f32,
        /// Probability with which the light is picked.
        pub probability: f32,
        /// Whether it emits on both sides (0 or 1).
        pub double_sided: u32,
        /// Alias table: keep this light if 32 random bits are below this.
        pub keep_below: u32,
        /// Alias table: else take this light.
        pub alias: u32,
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
    /// What one dispatch of the passes over pixels needs to know.
    pub struct FrameConstants {
        /// The camera.
        pub camera: GpuCamera,
        /// Image width in pixels.
        pub width: u32,
        /// Image height in pixels.
        pub height: u32,
        /// Threads that the device gives fixed runs of workgroups, or 1.
        pub interleave: u32,
        /// The run's seed.
        pub seed: u32,
        /// Number of the first sample.
        pub first_sample: u32,
        /// Samples a pixel in this dispatch.
        pub samples: u32,
        /// Scattering events at most.
        pub bounces: u32,
        /// Box filter over the pixel (1) or pixel centres (0).
        pub jitter: u32,
        /// HEURISTIC_…
        pub heuristic: u32,
        /// Number of lights.
        pub lights: u32,
        /// Scattering events before Russian roulette begins.
        pub roulette_start: u32,
        /// Least probability of going on.
        pub roulette_floor: f32,
    }
}

crate::gpu_struct! {
    /// The rows of the picture that a dispatch works on; its buffers hold these rows alone.
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
        /// Σ radiance, what rounding left.
        pub sum_low: Vec3,
        /// Σ radiance², leading part.
        pub square: Vec3,
        /// Σ radiance², what rounding left.
        pub square_low: Vec3,
    }
}

crate::gpu_struct! {
    /// What the camera sees through a pixel's centre.
    pub struct PrimarySurface {
        /// Reflectance that a denoiser divides by: diffuse and specular albedo.
        pub albedo: Vec3,
        /// Unit shading normal, world space, towards the camera.
        pub normal: Vec3,
        /// Distance along the ray; 0 = miss.
        pub depth: f32,
        /// The scene's number of the instance; NONE = miss.
        pub instance: u32,
    }
}

crate::gpu_struct! {
    /// A ray of the ray-buffer pass.
    pub struct RayQuery {
        /// Origin relative to the scene's origin.
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

/// Every shared structure, in an order in which each stands after those it contains.
pub const STRUCTS: &[StructLayout] = &[
    SceneAddresses::LAYOUT,
    GpuInstance::LAYOUT,
    GpuMaterial::LAYOUT,
    GpuLight::LAYOUT,
    GpuCamera::LAYOUT,
    FrameConstants::LAYOUT,
    Strip::LAYOUT,
    PixelSums::LAYOUT,
    PrimarySurface::LAYOUT,
    RayQuery::LAYOUT,
    RayAnswer::LAYOUT,
    RayBatch::LAYOUT,
];

/// The text of `layouts.glsl`: every constant and structure of this file.
pub fn glsl() -> String {
    let mut text = constants_glsl();
    for layout in STRUCTS {
        text += &layout.glsl();
    }
    text
}

//! The data that Rust and the shaders share, each declared once, in Rust: structures, constants, enumerations,
//! specialisation constants, the buffers of a scene and the variants of the shaders. Their GLSL text is generated here. The
//! build script uses this package to compile the shaders of the folder `glsl`, and the program uses it to fill the buffers
//! that the shaders read.
//!
//! Positions, lengths and radiance in the structures are in the units of the device (`device_scene/units.rs`). The device's
//! units of length and radiance are powers of two of the scene's units. In these units the brightest light has a radiance of
//! 1 to 2, and usual instances have a size of about 1.
#![warn(missing_docs)]

mod choices;
pub mod compiler;
mod constants;
pub mod declare;
mod frame;
mod pixels;
mod rays;
mod scene;
mod scene_buffers;
mod specialisation;
mod variants;

pub use choices::{
    CameraModel, Format, HashGrid, Heuristic, Mis, PixelOrder, Visibility, WorldReservoirs,
};
pub use constants::*;
pub use frame::{
    FrameConstants, GpuCamera, GridConstants, PrefixLevel, RestirConstants, ReuseConstants,
    SpatialStep, Strip, ViewConstants, WorldAddresses, WorldConstants,
};
pub use pixels::{
    GpuWorldSample, PixelRange, PixelSums, PrimarySurface, ReservoirAov, SampleData, ToneMap,
};
pub use rays::{RayBatch, RayHit, RayQuery};
pub use scene::{
    GpuGridPoint, GpuGridSlot, GpuInstance, GpuLight, GpuLightChoice, GpuLightEntry, GpuLightNode,
    GpuLightTexture, GpuMaterial, GpuMaterialLayers, GpuPreviousTransform, GpuPunctualLight,
    GpuTexture,
};
pub use scene_buffers::{Access, BUFFERS, Elements, LIGHT_BVH, SceneTable};
pub use specialisation::Specialisation;
pub use variants::{Fetch, GeometryAccess, Textures, Tracer, Variant};

use declare::{GpuStruct, StructLayout};

/// The layouts of all structures that Rust and the shaders share, in the order of the generated GLSL text:
/// each structure comes after all structures that it contains. The GLSL text is generated from these layouts,
/// and tests compare them with the compiled shaders.
pub const STRUCTS: &[StructLayout] = &[
    SceneTable::LAYOUT,
    GpuInstance::LAYOUT,
    GpuMaterial::LAYOUT,
    GpuMaterialLayers::LAYOUT,
    GpuTexture::LAYOUT,
    GpuLight::LAYOUT,
    GpuPunctualLight::LAYOUT,
    GpuLightChoice::LAYOUT,
    GpuLightTexture::LAYOUT,
    GpuLightNode::LAYOUT,
    GpuLightEntry::LAYOUT,
    GpuGridSlot::LAYOUT,
    GpuGridPoint::LAYOUT,
    GpuPreviousTransform::LAYOUT,
    GpuCamera::LAYOUT,
    ViewConstants::LAYOUT,
    FrameConstants::LAYOUT,
    ReuseConstants::LAYOUT,
    GridConstants::LAYOUT,
    WorldAddresses::LAYOUT,
    WorldConstants::LAYOUT,
    PrefixLevel::LAYOUT,
    GpuWorldSample::LAYOUT,
    RestirConstants::LAYOUT,
    SpatialStep::LAYOUT,
    ReservoirAov::LAYOUT,
    SampleData::LAYOUT,
    Strip::LAYOUT,
    PixelSums::LAYOUT,
    PrimarySurface::LAYOUT,
    PixelRange::LAYOUT,
    ToneMap::LAYOUT,
    RayQuery::LAYOUT,
    RayHit::LAYOUT,
    RayBatch::LAYOUT,
];

/// The GLSL files that are generated for the shaders, as pairs of file name and text. `declarations.glsl` contains
/// constants, enumerations, specialisation constants and structures. `scene_buffers.glsl` declares the buffers of the scene
/// and functions that read them; `light_bvh_buffer.glsl` does the same for the buffer of the light BVH.
pub fn generated() -> [(&'static str, String); 3] {
    let structs: String = STRUCTS.iter().map(StructLayout::glsl).collect();
    let declarations = constants_glsl() + &choices::glsl() + &Specialisation::glsl() + &structs;
    [
        ("declarations.glsl", declarations),
        ("scene_buffers.glsl", scene_buffers::glsl()),
        ("light_bvh_buffer.glsl", scene_buffers::light_bvh_glsl()),
    ]
}

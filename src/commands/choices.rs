//! Options for loading a scene, and options that choose how rays are traced and how shaders access the scene.
//! If the user leaves a choice open, the program makes it by the features of the device and the size of the
//! scene.

use crate::device_scene::selection::Request;
use crate::image::ToneCurve;
use crate::scene_files::Options;
use crate::shader_interface::{GeometryAccess, Textures, Tracer};

/// Options that decide whether a scene may lack image files and may name files outside of its folder, and which variant of its
/// materials is shown. By default missing files and files outside are errors, and surfaces have their default materials.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct LoadArgs {
    /// Load the scene even if image files of textures are missing or damaged; its materials then do without these textures.
    /// Animations whose buffers are missing are left out too. Textures and MTL files outside of the scene's folder count as
    /// missing
    #[arg(long)]
    pub allow_missing: bool,
    /// Also open buffers, textures and MTL files outside of the scene's folder if the scene names them
    #[arg(long)]
    pub allow_outside: bool,
    /// Give surfaces their materials in this variant of the scene; 'headwater scene inspect' lists its variants
    #[arg(long, value_name = "NAME")]
    pub material_variant: Option<String>,
}

impl LoadArgs {
    /// Converts these arguments to the options of the scene loader.
    pub fn options(&self) -> Options {
        Options {
            allow_missing: self.allow_missing,
            allow_outside: self.allow_outside,
            material_variant: self.material_variant.clone(),
        }
    }
}

/// The method that traces rays, as `--tracer` names it. All shaders are compiled for this method.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum TracerArg {
    /// The program chooses the tracer by the features of the device
    #[default]
    Auto,
    /// Vulkan ray queries trace rays, in acceleration structures that the driver builds
    RayQuery,
    /// Compute shaders trace rays through a bounding volume hierarchy (BVH) that the program builds; this works on every
    /// device
    ComputeBvh,
}

impl TracerArg {
    /// The tracer that `--tracer` names; `None` for `auto`, with which the program chooses the tracer by the features of
    /// the device.
    pub const fn tracer(self) -> Option<Tracer> {
        match self {
            Self::Auto => None,
            Self::RayQuery => Some(Tracer::RayQuery),
            Self::ComputeBvh => Some(Tracer::ComputeBvh),
        }
    }
}

/// The values of `--jitter`: the points of each pixel through which the camera's rays pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum JitterArg {
    /// Random points of the pixel, so that the mean of several samples or frames has smooth edges (a box filter)
    #[default]
    On,
    /// The centre of the pixel: edges stay hard, and a view at rest needs fewer rays
    Off,
}

/// The values of `--tonemap`: the curves of PNG files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum TonemapArg {
    /// The Khronos PBR neutral tone mapper without its toe: colours up to 0.8 stay, and brighter ones approach white
    #[default]
    Neutral,
    /// No curve: values above 1 are clamped
    None,
}

impl TonemapArg {
    /// The curve with this name.
    pub const fn curve(self) -> ToneCurve {
        match self {
            Self::Neutral => ToneCurve::Neutral,
            Self::None => ToneCurve::None,
        }
    }
}

/// The values of `--geometry`: shaders read the buffers of the scene, and those of world reservoirs (light samples that are
/// stored for cells of space), through bindings or through addresses. The choice changes the speed, and not the picture.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum GeometryArg {
    /// The program chooses one of the other values by the features of the device and the size of the scene
    #[default]
    Auto,
    /// Shaders access the scene's buffers through storage buffer bindings, whose contents capture tools show and replay
    StorageBuffers,
    /// Shaders access the scene's buffers by buffer device address, so that no size limit of a binding applies
    BufferAddresses,
}

/// The way in which shaders read the texels of textures, as `--textures` names it. It decides how the textures are uploaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum TexturesArg {
    /// The program chooses one of the other values by the features of the device and the textures of the scene
    #[default]
    Auto,
    /// Shaders read textures from sampled images, which they select by descriptor indexing
    Images,
    /// Shaders read the texels of all textures from one storage buffer
    Buffer,
}

/// Options that choose the variant of the shaders: the tracer, and the access to buffers and textures. All shaders of a
/// run are compiled in one variant. Without these options, the program chooses by the features of the device and the
/// size of the scene.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct VariantArgs {
    /// The method that traces rays
    #[arg(long, value_enum, default_value_t)]
    pub tracer: TracerArg,
    /// The access of shaders to the buffers of the scene, and to those of world reservoirs (light samples
    /// stored for cells of space)
    #[arg(long, value_enum, default_value_t)]
    pub geometry: GeometryArg,
    /// The way in which shaders read the texels of textures
    #[arg(long, value_enum, default_value_t)]
    pub textures: TexturesArg,
}

impl VariantArgs {
    /// Converts these arguments to a request for a variant of the shaders. A choice that is `None` in the request is left to
    /// the program. The field `captured` is always false here; a session for a capture tool sets it to true.
    pub const fn request(&self) -> Request {
        Request {
            tracer: self.tracer.tracer(),
            geometry: match self.geometry {
                GeometryArg::Auto => None,
                GeometryArg::StorageBuffers => Some(GeometryAccess::StorageBuffers),
                GeometryArg::BufferAddresses => Some(GeometryAccess::BufferAddresses),
            },
            textures: match self.textures {
                TexturesArg::Auto => None,
                TexturesArg::Images => Some(Textures::Images),
                TexturesArg::Buffer => Some(Textures::Buffer),
            },
            captured: false,
        }
    }
}

//! Options for loading a scene, and options that choose how rays are traced and how shaders access the scene. Where the user
//! chooses nothing, the program chooses by its rules.

use crate::device_scene::selection::Request;
use crate::scene_files::Options;
use crate::shader_interface::{GeometryAccess, Textures, Tracer};

/// Permissions for loading a scene: without missing image files, and with files outside of its folder. By default both are
/// refused.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct LoadArgs {
    /// Render even if image files of textures are missing, without these textures
    #[arg(long)]
    pub allow_missing: bool,
    /// Also open files outside of the scene's folder if the scene names them: buffers, textures and MTL files
    #[arg(long)]
    pub allow_outside: bool,
}

impl LoadArgs {
    /// The options of the scene loader with the values of these arguments.
    pub const fn options(self) -> Options {
        Options {
            allow_missing: self.allow_missing,
            allow_outside: self.allow_outside,
        }
    }
}

/// The method that traces rays, as `--tracer` names it.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum TracerArg {
    /// The program chooses by the features of the device
    #[default]
    Auto,
    /// Ray query through the driver's acceleration structures
    RayQuery,
    /// A BVH that compute shaders traverse; every device has it
    ComputeBvh,
}

impl TracerArg {
    /// The tracer that the option names; `None` if the program chooses by its rules.
    pub const fn tracer(self) -> Option<Tracer> {
        match self {
            Self::Auto => None,
            Self::RayQuery => Some(Tracer::RayQuery),
            Self::ComputeBvh => Some(Tracer::ComputeBvh),
        }
    }
}

/// The access of shaders to the buffers of the scene and of world reservoirs (light samples that are kept for cells of
/// space), as `--geometry` names it.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum GeometryArg {
    /// The program chooses by the features of the device and the size of the scene
    #[default]
    Auto,
    /// Shaders access the scene's buffers through storage buffer bindings, which capture tools show and replay
    StorageBuffers,
    /// Shaders access the scene's buffers by buffer device address, without the size limit of a binding
    BufferAddresses,
}

/// The access of shaders to the texels of textures, as `--textures` names it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum TexturesArg {
    /// The program chooses by the features of the device
    #[default]
    Auto,
    /// Sampled images, one per texture, by descriptor indexing
    Images,
    /// One storage buffer with the texels of all textures
    Buffer,
}

/// Options that choose the variant of the shaders; by default, the program chooses by its rules.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct VariantArgs {
    /// The method that traces rays
    #[arg(long, value_enum, default_value_t)]
    pub tracer: TracerArg,
    /// How shaders access the buffers of the scene and of world reservoirs
    #[arg(long, value_enum, default_value_t)]
    pub geometry: GeometryArg,
    /// How shaders read the texels of textures
    #[arg(long, value_enum, default_value_t)]
    pub textures: TexturesArg,
}

impl VariantArgs {
    /// These arguments as a request for a variant of the shaders; `None` in the request leaves a choice to the program's
    /// rules. `captured` is false: a session for a capture tool sets it itself.
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

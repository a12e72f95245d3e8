//! Choices on the command line that rules make by default.

use crate::device_scene::selection::Request;
use crate::scene_files::Options;
use crate::shader_interface::{GeometryAccess, Textures, Tracer};

/// Permissions of loading a scene.
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
    /// The library's type with these values.
    pub const fn options(self) -> Options {
        Options {
            allow_missing: self.allow_missing,
            allow_outside: self.allow_outside,
        }
    }
}

/// The tracer of rays.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum TracerArg {
    /// By rule from the device
    #[default]
    Auto,
    /// The driver's acceleration structures
    RayQuery,
    /// The BVH traversed in compute
    ComputeBvh,
}

impl TracerArg {
    /// The tracer; `None` if the rules choose.
    pub const fn tracer(self) -> Option<Tracer> {
        match self {
            Self::Auto => None,
            Self::RayQuery => Some(Tracer::RayQuery),
            Self::ComputeBvh => Some(Tracer::ComputeBvh),
        }
    }
}

/// Access of shaders to the buffers of the scene and to world reservoirs
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum GeometryArg {
    /// By rule from the device and the size of the scene
    #[default]
    Auto,
    /// Access as named storage buffers, which capture tools show and replay
    StorageBuffers,
    /// Access by buffer device address
    BufferAddresses,
}

/// Access to the texels of textures
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum TexturesArg {
    /// By rule from the device
    #[default]
    Auto,
    /// From images, by descriptor indexing
    Images,
    /// From a buffer
    Buffer,
}

/// Choices of shader variants; by default, rules make them.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct VariantArgs {
    /// Tracer of rays
    #[arg(long, value_enum, default_value_t)]
    pub tracer: TracerArg,
    /// Access of shaders to the buffers of the scene and to world reservoirs
    #[arg(long, value_enum, default_value_t)]
    pub geometry: GeometryArg,
    /// Access to the texels of textures
    #[arg(long, value_enum, default_value_t)]
    pub textures: TexturesArg,
}

impl VariantArgs {
    /// The library's type with these values.
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

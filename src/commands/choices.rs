//! Choices on the command line that the rules make unless the user does.

use crate::device_scene::selection::Request;
use crate::scene_files::Options;
use crate::shader_interface::{GeometryAccess, Textures, Tracer};

/// Permissions of loading a scene.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct LoadArgs {
    /// Render even if image files of textures are missing: without these textures
    #[arg(long)]
    pub allow_missing: bool,
    /// Open files outside of the scene's folder too, where the scene names such: buffers, textures and MTL files
    #[arg(long)]
    pub allow_outside: bool,
}

impl LoadArgs {
    /// The same values as a type of the library.
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
    /// The tracer; none where the rules choose.
    pub const fn tracer(self) -> Option<Tracer> {
        match self {
            Self::Auto => None,
            Self::RayQuery => Some(Tracer::RayQuery),
            Self::ComputeBvh => Some(Tracer::ComputeBvh),
        }
    }
}

/// How shaders reach the buffers of the scene, and world reservoirs
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub enum GeometryArg {
    /// By rule from the device and the size of the scene
    #[default]
    Auto,
    /// As named storage buffers, which capture tools show and replay
    StorageBuffers,
    /// By buffer device address
    BufferAddresses,
}

/// How textures are read
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
    /// How rays are traced
    #[arg(long, value_enum, default_value_t)]
    pub tracer: TracerArg,
    /// How shaders reach the buffers of the scene, and world reservoirs
    #[arg(long, value_enum, default_value_t)]
    pub geometry: GeometryArg,
    /// How textures are read
    #[arg(long, value_enum, default_value_t)]
    pub textures: TexturesArg,
}

impl VariantArgs {
    /// The same values as a type of the library.
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

//! The legal variants of shaders. The build script compiles every pass, which are the files `NAME.comp` in `glsl`, in each of
//! them and embeds the SPIR-V.

/// The tracer of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tracer {
    /// `rayQueryEXT` on the driver's acceleration structures.
    RayQuery,
    /// An eight-wide compressed BVH traversed in compute.
    ComputeBvh,
}

/// The access of shaders to a scene's buffers, except those that [`Fetch`] decides on, and to world reservoirs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum GeometryAccess {
    /// Named storage buffers: supported everywhere, and shown in captures.
    StorageBuffers,
    /// Buffer device addresses: no limit of a descriptor's range.
    BufferAddresses,
}

/// The access of shaders to nodes of trees, positions, instances, materials, lights and sample data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Fetch {
    /// Texels of four words, which llvmpipe reads in one access.
    Texels,
    /// By the access of [`GeometryAccess`].
    Words,
}

/// The access of shaders to the texels of textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Textures {
    /// From one buffer with the texels of all images, by the access of [`GeometryAccess`]: runs everywhere.
    Buffer,
    /// From an array of images, by descriptor indexing.
    Images,
}

impl Tracer {
    /// The name on the command line and in variant keys.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RayQuery => "ray-query",
            Self::ComputeBvh => "compute-bvh",
        }
    }
}

impl GeometryAccess {
    /// The name in reports and in variant keys.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StorageBuffers => "storage-buffers",
            Self::BufferAddresses => "buffer-addresses",
        }
    }
}

impl Fetch {
    /// The name in reports and in variant keys.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Texels => "texels",
            Self::Words => "words",
        }
    }
}

impl Textures {
    /// The name on the command line and in variant keys.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Buffer => "buffer",
            Self::Images => "images",
        }
    }
}

/// One variant of the passes that trace rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variant {
    /// The tracer.
    pub tracer: Tracer,
    /// The access to buffers.
    pub geometry: GeometryAccess,
    /// The access to nodes, positions and records.
    pub fetch: Fetch,
    /// The access to texels of textures.
    pub textures: Textures,
}

impl Variant {
    /// All legal variants.
    pub fn all() -> impl Iterator<Item = Variant> {
        let tracers = [Tracer::RayQuery, Tracer::ComputeBvh];
        tracers.into_iter().flat_map(Self::of)
    }

    /// All legal variants with a tracer. Images are only for devices with buffer addresses: devices with descriptor indexing
    /// have them, and each variant takes time to compile and space in the program.
    pub fn of(tracer: Tracer) -> impl Iterator<Item = Variant> {
        use GeometryAccess::{BufferAddresses, StorageBuffers};
        [
            (StorageBuffers, Textures::Buffer),
            (BufferAddresses, Textures::Buffer),
            (BufferAddresses, Textures::Images),
        ]
        .into_iter()
        .flat_map(move |(geometry, textures)| {
            [Fetch::Texels, Fetch::Words].map(|fetch| Variant {
                tracer,
                geometry,
                fetch,
                textures,
            })
        })
    }

    /// Macros for the preprocessor.
    pub fn defines(self) -> Vec<(&'static str, &'static str)> {
        let flag = |on: bool| if on { "1" } else { "0" };
        vec![
            ("TRACE_RAY_QUERY", flag(self.tracer == Tracer::RayQuery)),
            (
                "GEOMETRY_ADDRESSES",
                flag(self.geometry == GeometryAccess::BufferAddresses),
            ),
            ("FETCH_TEXELS", flag(self.fetch == Fetch::Texels)),
            ("TEXTURE_IMAGES", flag(self.textures == Textures::Images)),
        ]
    }

    /// The embedded shader's key: pass, tracer, geometry access, fetch, textures.
    pub fn key(self, pass: &str) -> String {
        format!(
            "{pass}.{}.{}.{}.{}",
            self.tracer.name(),
            self.geometry.name(),
            self.fetch.name(),
            self.textures.name()
        )
    }
}

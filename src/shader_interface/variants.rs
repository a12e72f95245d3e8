//! The legal variants of shaders. The build script compiles every pass (each file `NAME.comp` in `glsl`) in each variant and
//! embeds the SPIR-V in the program; the program selects one variant per scene and device.

/// The method by which shaders trace rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tracer {
    /// `rayQueryEXT` on the driver's acceleration structures: fast on GPUs with ray tracing hardware.
    RayQuery,
    /// An eight-wide compressed BVH that the compute shader traverses: it runs on every device.
    ComputeBvh,
}

/// The access of shaders to the buffers of a scene and of world reservoirs (reservoirs of path vertices, found by position).
/// With [`Fetch::Texels`], buffers of the scene that are read four words at a time are texels instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum GeometryAccess {
    /// Named storage buffers: supported everywhere, and shown in captures, but limited by the range of a descriptor.
    StorageBuffers,
    /// Buffer device addresses: no limit of a descriptor's range, but not supported on every device.
    BufferAddresses,
}

/// The access of shaders to the data that they read four words at a time: nodes of trees, positions, instances, materials,
/// lights and sample data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Fetch {
    /// As texels of four words (`utextureBuffer`), which llvmpipe reads in one access.
    Texels,
    /// As words, through storage buffers or addresses, whichever [`GeometryAccess`] selects.
    Words,
}

/// The access of shaders to the texels of textures. Both give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Textures {
    /// From one buffer with the texels of all images, read as [`GeometryAccess`] selects: runs on every device.
    Buffer,
    /// From an array of images by descriptor indexing: no limit by the size of one buffer.
    Images,
}

impl Tracer {
    /// The name on the command line and in keys of variants: `ray-query` or `compute-bvh`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RayQuery => "ray-query",
            Self::ComputeBvh => "compute-bvh",
        }
    }
}

impl GeometryAccess {
    /// The name in reports and in keys of variants: `storage-buffers` or `buffer-addresses`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StorageBuffers => "storage-buffers",
            Self::BufferAddresses => "buffer-addresses",
        }
    }
}

impl Fetch {
    /// The name in reports and in keys of variants: `texels` or `words`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Texels => "texels",
            Self::Words => "words",
        }
    }
}

impl Textures {
    /// The name on the command line and in keys of variants: `buffer` or `images`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Buffer => "buffer",
            Self::Images => "images",
        }
    }
}

/// One combination of choices for which all passes are compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variant {
    /// The method by which rays are traced.
    pub tracer: Tracer,
    /// The access to the buffers of the scene and of world reservoirs.
    pub geometry: GeometryAccess,
    /// The access to data that is read four words at a time, such as nodes and positions.
    pub fetch: Fetch,
    /// The access to the texels of textures.
    pub textures: Textures,
}

impl Variant {
    /// All legal variants, in the order in which the build script compiles them.
    pub fn all() -> impl Iterator<Item = Variant> {
        let tracers = [Tracer::RayQuery, Tracer::ComputeBvh];
        tracers.into_iter().flat_map(Self::of)
    }

    /// All legal variants with one tracer. Images are combined only with buffer addresses: devices with descriptor indexing
    /// have addresses too, and each variant takes time to compile and space in the program.
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

    /// The macros of the preprocessor that select this variant in the shaders: pairs of name and value, "0" or "1".
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

    /// The key under which the shader of a pass is embedded: pass, tracer, geometry access, fetch and textures, separated by
    /// dots.
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

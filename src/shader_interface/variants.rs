//! The variants of shaders: combinations of a tracer and ways to access memory. The build script compiles every pass (each
//! file `NAME.comp` in `glsl`) in each variant and embeds the SPIR-V in the program. For each scene and device, the program
//! selects one variant, which all passes use.

/// The method by which shaders trace rays. Unless the user requests one, the program selects it by the device: usually ray
/// queries if the device has them and is not a CPU, otherwise compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tracer {
    /// Shaders trace rays by ray queries (`rayQueryEXT`) in acceleration structures that the driver builds. This is fast on
    /// GPUs with ray tracing hardware, but not every device supports it.
    RayQuery,
    /// Compute shaders traverse compressed BVHs with eight children per node, which the program builds. This works on every
    /// device.
    ComputeBvh,
}

/// The way in which shaders access the buffers of a scene and of world reservoirs (reservoirs of path vertices, found by
/// position). It does not apply to those buffers of the scene that shaders read as texels ([`Fetch::Texels`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum GeometryAccess {
    /// Shaders access storage buffers that are bound by descriptors. Every device supports this, and debuggers show the
    /// names of the buffers. The device limits the size of a buffer that a descriptor can bind.
    StorageBuffers,
    /// Shaders access buffers by their addresses in device memory. The limit for the size of a bound buffer then does not
    /// apply, but not every device supports addresses.
    BufferAddresses,
}

/// The way in which shaders read data in groups of four 32-bit words: nodes of trees, positions, instances, materials,
/// lights and the primary surfaces of pixels. The program selects it by the limits of the device and the size of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Fetch {
    /// Shaders read a group of four words as one texel of a texel buffer (`utextureBuffer`). On the driver llvmpipe this is
    /// faster, because it fetches such a texel in one access.
    Texels,
    /// Shaders read a group of four words from a storage buffer, through a descriptor or by its address, as
    /// [`GeometryAccess`] selects.
    Words,
}

/// The way in which shaders read the texels of textures. The program selects it by the device and the scene, unless the user
/// requests one. Both ways give the same bits of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Textures {
    /// Shaders read the texels of all images from one buffer, through a descriptor or by its address, as [`GeometryAccess`]
    /// selects. This works on every device.
    Buffer,
    /// Shaders read texels from an array of Vulkan images, one for each image of the scene (descriptor indexing). Unlike
    /// with [`Self::Buffer`], the texels of all images need not fit into one buffer, but not every device supports such an
    /// array.
    Images,
}

impl Tracer {
    /// The name of the tracer on the command line, in reports and in keys of variants ([`Variant::key`]):
    /// `ray-query` or `compute-bvh`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RayQuery => "ray-query",
            Self::ComputeBvh => "compute-bvh",
        }
    }
}

impl GeometryAccess {
    /// The name of the way of access on the command line, in reports and in keys of variants
    /// ([`Variant::key`]): `storage-buffers` or `buffer-addresses`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StorageBuffers => "storage-buffers",
            Self::BufferAddresses => "buffer-addresses",
        }
    }
}

impl Fetch {
    /// The name of the way of access in reports and in keys of variants ([`Variant::key`]): `texels` or
    /// `words`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Texels => "texels",
            Self::Words => "words",
        }
    }
}

impl Textures {
    /// The name of the way of access on the command line, in reports and in keys of variants
    /// ([`Variant::key`]): `buffer` or `images`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Buffer => "buffer",
            Self::Images => "images",
        }
    }
}

/// One combination of a tracer and ways to access memory. The build script compiles every pass in each
/// variant; all passes that render a scene use the same variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variant {
    /// The method by which shaders trace rays: ray queries of the driver, or the traversal of BVHs by compute
    /// shaders.
    pub tracer: Tracer,
    /// The access to the buffers of the scene and of world reservoirs, which are reservoirs of path vertices: by descriptors
    /// or by address.
    pub geometry: GeometryAccess,
    /// The access to data that shaders read four words at a time, such as nodes and positions: as texels or as words of a
    /// buffer.
    pub fetch: Fetch,
    /// The access to the texels of textures: in one buffer, or in one Vulkan image per image of the scene.
    pub textures: Textures,
}

impl Variant {
    /// All variants that are compiled, in the order in which the build script compiles them: first those with
    /// [`Tracer::RayQuery`], then those with [`Tracer::ComputeBvh`].
    pub fn all() -> impl Iterator<Item = Variant> {
        let tracers = [Tracer::RayQuery, Tracer::ComputeBvh];
        tracers.into_iter().flat_map(Self::of)
    }

    /// All variants with the tracer `tracer` that are compiled. [`Textures::Images`] is combined only with buffer addresses:
    /// devices with descriptor indexing have addresses too, and each further variant takes time to compile and space in the
    /// program.
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

    /// The preprocessor macros with which a shader is compiled for this variant, so that the GLSL code selects its tracer
    /// and its access to memory: pairs of the name of a macro and its value, "0" or "1".
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

    /// The key by which the program finds the SPIR-V of the pass with the name `pass` in this variant, among those that the
    /// build script embedded: the names of pass, tracer, geometry access, fetch and textures, separated by dots.
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

//! The table of shaders: every pass and every legal variant of it.
//!
//! Their SPIR-V is made by the build script from this table and embedded. This file is also
//! compiled into the build script, so it knows nothing of the rest.

/// How rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Tracer {
    /// `rayQueryEXT` on the driver's acceleration structures.
    RayQuery,
    /// An eight-wide compressed BVH traversed in compute.
    ComputeBvh,
}

/// How shaders read normals, parts and instances. Positions and nodes are texel buffers either way:
/// software drivers fetch those fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum GeometryAccess {
    /// Named storage buffers: runs everywhere, and is what a capture shows.
    StorageBuffers,
    /// Buffer device addresses: no limit of a descriptor's range.
    BufferAddresses,
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

/// One variant of the passes that trace rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variant {
    /// Which body the trace seam has.
    pub tracer: Tracer,
    /// Which body the geometry accessor has.
    pub geometry: GeometryAccess,
}

impl Variant {
    /// Every legal variant.
    pub const ALL: [Variant; 4] = {
        const fn of(tracer: Tracer, geometry: GeometryAccess) -> Variant {
            Variant { tracer, geometry }
        }
        [
            of(Tracer::RayQuery, GeometryAccess::StorageBuffers),
            of(Tracer::RayQuery, GeometryAccess::BufferAddresses),
            of(Tracer::ComputeBvh, GeometryAccess::StorageBuffers),
            of(Tracer::ComputeBvh, GeometryAccess::BufferAddresses),
        ]
    };

    /// What the preprocessor is told.
    pub fn defines(self) -> Vec<(&'static str, &'static str)> {
        let flag = |on: bool| if on { "1" } else { "0" };
        vec![
            ("TRACE_RAY_QUERY", flag(self.tracer == Tracer::RayQuery)),
            (
                "GEOMETRY_ADDRESSES",
                flag(self.geometry == GeometryAccess::BufferAddresses),
            ),
        ]
    }

    /// The embedded shader's key: pass, tracer, geometry access.
    pub fn key(self, pass: &str) -> String {
        format!("{pass}.{}.{}", self.tracer.name(), self.geometry.name())
    }
}

/// The passes that read geometry and trace rays: `glsl/passes/NAME.comp`, one for each [`Variant`].
pub const TRACING_PASSES: &[&str] = &["path_trace", "primary", "trace_rays"];

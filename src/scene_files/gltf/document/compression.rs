//! Types for the extensions that compress meshes and buffer views.

use serde::Deserialize;
use std::collections::BTreeMap;

/// The extension `KHR_draco_mesh_compression` of a primitive.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DracoCompression {
    /// The index of the buffer view with the compressed mesh.
    pub buffer_view: u64,
    /// The attributes of the primitive that are compressed, such as `POSITION`, each with the number that identifies it in
    /// the compressed mesh. Other attributes of the primitive are in their accessors as usual.
    pub attributes: BTreeMap<String, u64>,
}

/// The extensions of a buffer view that compress it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub ext: Option<MeshoptCompression>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub khr: Option<MeshoptCompression>,
}

/// The compressed form of a buffer view: `count` elements of `byte_stride` bytes, which are compressed to `byte_length` bytes
/// from byte `byte_offset` of the buffer with the index `buffer`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct MeshoptCompression {
    pub buffer: u64,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: u64,
    pub count: u64,
    /// The codec: `ATTRIBUTES`, `TRIANGLES` or `INDICES`.
    pub mode: String,
    /// The conversion of the decoded elements: `OCTAHEDRAL`, `QUATERNION`, `EXPONENTIAL` or `COLOR`. They stay as they are
    /// if it is missing or `NONE`.
    pub filter: Option<String>,
}

/// The extensions of a buffer that mark it as a fallback.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Fallback,
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Fallback,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Fallback {
    fallback: bool,
}

impl BufferExtensions {
    /// True if the buffer is for programs that cannot decode compressed buffer views. Its bytes need not exist.
    pub const fn is_fallback(&self) -> bool {
        self.ext.fallback || self.khr.fallback
    }
}

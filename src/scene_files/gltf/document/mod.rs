//! Types for the part of a glTF file's JSON that Headwater reads; other members are ignored. Indices are stored as the file
//! states them, in 64 bits, so the code that uses an index checks it first.
//!
//! The types of the `gltf` crate are not used, for these reasons:
//!
//! - transforms of nodes and the values of cameras are in f32, which has steps of half a unit at 5·10⁶ units from the
//!   origin;
//! - indices and component types are cut to 32 bits without an error, so that a damaged index can refer to another element;
//! - normal textures have no transform;
//! - values that the crate does not support are dropped, so that no message can quote them: types of accessors and cameras,
//!   interpolations, alpha modes, and the path `pointer` of an animation, which Headwater supports;
//! - files would be refused for faults in parts that Headwater ignores.

mod compression;
mod extensions;

pub use compression::*;
pub use extensions::*;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;

/// The root object of the JSON of a glTF file, with the lists of its elements. Elements refer to each other by their indices
/// in these lists.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Document {
    pub asset: Asset,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub extensions: DocumentExtensions,
    pub scene: Option<u64>,
    pub scenes: Vec<Roots>,
    pub nodes: Vec<Node>,
    pub skins: Vec<Skin>,
    pub cameras: Vec<Camera>,
    pub meshes: Vec<Mesh>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub samplers: Vec<TextureSampler>,
    pub images: Vec<Image>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub animations: Vec<Animation>,
}

/// The name of a value in the `extras` of a material, which exported scenes have: true if the camera sees the back of a
/// surface although only its front emits light. glTF has one property, `doubleSided`, for both.
pub const SEEN_FROM_BEHIND: &str = "seenFromBehind";

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Material {
    pub name: String,
    pub pbr_metallic_roughness: MetallicRoughness,
    pub normal_texture: Option<TextureInfo>,
    pub occlusion_texture: Option<IgnoredAny>,
    pub emissive_texture: Option<TextureInfo>,
    pub emissive_factor: [f32; 3],
    pub alpha_mode: Option<String>,
    pub alpha_cutoff: Option<f32>,
    pub double_sided: bool,
    pub extensions: MaterialExtensions,
    pub extras: serde_json::Value,
}

impl Material {
    /// True if the camera looks through the back of the material's surfaces: it is not double-sided, and does not state
    /// otherwise in its extra [`SEEN_FROM_BEHIND`].
    pub fn is_culled(&self) -> bool {
        let seen = self.extras.get(SEEN_FROM_BEHIND) == Some(&serde_json::Value::Bool(true));
        !self.double_sided && !seen
    }

    /// True if the material is unlit (`KHR_materials_unlit`). Then only its base colour and alpha are used. Its other
    /// properties are meant for programs that do not support the extension.
    pub const fn is_unlit(&self) -> bool {
        self.extensions.unlit.is_some()
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct MetallicRoughness {
    pub base_color_factor: [f32; 4],
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
    pub metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

/// A reference from a material to a texture, with the set and the transform of texture coordinates. The texture is read only
/// if it has an effect on the scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    pub index: u64,
    #[serde(default)]
    pub tex_coord: u64,
    /// The factor on x and y of the vectors in a normal texture; `None` counts as 1. References to other textures do not
    /// have it.
    pub scale: Option<f32>,
    #[serde(default)]
    pub extensions: TextureInfoExtensions,
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<TextureTransform>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct TextureTransform {
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
    pub tex_coord: Option<u64>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            tex_coord: None,
        }
    }
}

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub emissive_strength: EmissiveStrength,
    #[serde(rename = "KHR_materials_ior")]
    pub ior: Ior,
    #[serde(rename = "KHR_materials_specular")]
    pub specular: Specular,
    #[serde(rename = "KHR_materials_unlit")]
    pub unlit: Option<IgnoredAny>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct EmissiveStrength {
    pub emissive_strength: f32,
}

impl Default for EmissiveStrength {
    fn default() -> Self {
        Self {
            emissive_strength: 1.0,
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default)]
pub struct Ior {
    pub ior: f32,
}

impl Default for Ior {
    fn default() -> Self {
        Self { ior: 1.5 }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Specular {
    pub specular_factor: f32,
    pub specular_texture: Option<TextureInfo>,
    pub specular_color_factor: [f32; 3],
    pub specular_color_texture: Option<TextureInfo>,
}

impl Default for Specular {
    fn default() -> Self {
        Self {
            specular_factor: 1.0,
            specular_texture: None,
            specular_color_factor: [1.0; 3],
            specular_color_texture: None,
        }
    }
}

/// A texture of a glTF file: an image and a sampler (filters and wrap modes), by their indices in the document. Without a
/// sampler, the image repeats, and texels are interpolated. `source` is `None` if the texture has no image, or only one that
/// an extension names, such as a WebP image.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Texture {
    pub sampler: Option<u64>,
    pub source: Option<u64>,
    pub extensions: TextureExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub webp: Option<TextureSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub basisu: Option<TextureSource>,
}

#[derive(Debug, Deserialize)]
pub struct TextureSource {
    pub source: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct TextureSampler {
    pub mag_filter: Option<i64>,
    pub wrap_s: Option<i64>,
    pub wrap_t: Option<i64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Image {
    pub name: String,
    pub uri: Option<String>,
    pub buffer_view: Option<u64>,
}

/// The glTF version of a file (empty if the file states none), and the minimum version that a program must support to read
/// it (`None` if the file states no minimum). A file is refused if its minimum version is not 2.0. If it states no minimum,
/// it is refused unless its version begins with `2.`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

/// A `scene` of a glTF file: the indices of the nodes that are the roots of its trees. Only the nodes of the default scene
/// are read, or of the first scene if the file names no default scene.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Roots {
    pub nodes: Vec<u64>,
    pub extensions: SceneExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Node {
    pub name: String,
    pub children: Vec<u64>,
    pub mesh: Option<u64>,
    pub camera: Option<u64>,
    pub skin: Option<u64>,
    /// The weights of the morph targets of the node's mesh; empty if those of the mesh count.
    pub weights: Vec<f64>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub extensions: NodeExtensions,
}

/// A skin: the nodes that are its joints, and the accessor of one matrix for each of them, by which its meshes are bound.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Skin {
    pub name: String,
    pub joints: Vec<u64>,
    pub inverse_bind_matrices: Option<u64>,
}

#[derive(Debug, Deserialize)]
pub struct Camera {
    #[serde(default)]
    pub name: String,
    #[serde(rename = "type")]
    pub kind: String,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    pub yfov: f64,
    pub aspect_ratio: Option<f64>,
}

/// The values of an orthographic camera. As for a perspective camera, the planes `znear` and `zfar` are not read.
#[derive(Debug, Deserialize)]
pub struct Orthographic {
    /// Half of the width of the picture, in scene units.
    pub xmag: f64,
    /// Half of the height of the picture, in scene units.
    pub ymag: f64,
}

#[derive(Debug, Deserialize)]
pub struct Mesh {
    #[serde(default)]
    pub name: String,
    pub primitives: Vec<Primitive>,
    /// The weights of the morph targets where neither a node nor an animation states others; empty if all are 0.
    #[serde(default)]
    pub weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive {
    pub attributes: BTreeMap<String, u64>,
    pub indices: Option<u64>,
    pub material: Option<u64>,
    pub mode: Option<u64>,
    #[serde(default)]
    pub targets: Vec<BTreeMap<String, u64>>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Animation {
    pub channels: Vec<Channel>,
    pub samplers: Vec<Sampler>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Channel {
    pub sampler: Option<u64>,
    pub target: Target,
}

/// The property that a channel of an animation changes. It is the property `path` of the node `node`, such as `rotation`;
/// or, if `path` is `pointer`, the property that `KHR_animation_pointer` names in `extensions`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Target {
    pub node: Option<u64>,
    pub path: String,
    pub extensions: TargetExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct TargetExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pub pointer: Option<Pointer>,
}

#[derive(Debug, Deserialize)]
pub struct Pointer {
    pub pointer: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Sampler {
    pub input: Option<u64>,
    pub output: Option<u64>,
    pub interpolation: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<u64>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u64,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: u64,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: u64,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: u64,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
    #[serde(default)]
    pub extensions: BufferExtensions,
}

impl Buffer {
    /// The URI of the buffer if it names a file, which is then read; `None` for a data URI and for the binary chunk, whose
    /// bytes are in the glTF file itself.
    pub fn file(&self) -> Option<&str> {
        (self.uri.as_deref()).filter(|uri| !uri.starts_with("data:"))
    }
}

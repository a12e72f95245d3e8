//! Types for the extensions of nodes, primitives and the whole document that Headwater reads. Those of materials and textures
//! stand with their elements.

use super::DracoCompression;
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Visibility,
    #[serde(rename = "MSFT_lod")]
    pub levels: Levels,
}

#[derive(Debug, Deserialize)]
pub struct NodeLight {
    pub light: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Lights,
    #[serde(rename = "KHR_materials_variants")]
    pub variants: Variants,
    #[serde(rename = "EXT_lights_image_based")]
    pub image_based: ImageBasedLights,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<DracoCompression>,
    #[serde(rename = "KHR_materials_variants")]
    pub variants: Mappings,
}

/// A punctual light, as `KHR_lights_punctual` defines it; nodes place it in the scene. The numbers are in the units of that
/// extension: candela, or lux for directional lights; metres; radians.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub struct Light {
    pub name: String,
    #[serde(rename = "type")]
    pub kind: String,
    pub color: [f32; 3],
    pub intensity: f32,
    pub range: Option<f64>,
    pub spot: Spot,
    pub extras: serde_json::Value,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: String::new(),
            color: [1.0; 3],
            intensity: 1.0,
            range: None,
            spot: Spot::default(),
            extras: serde_json::Value::Null,
        }
    }
}

/// The extensions of a `scene` of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct SceneExtensions {
    #[serde(rename = "EXT_lights_image_based")]
    pub image_based: Option<NodeLight>,
}

/// The extension `EXT_lights_image_based` of the document. A scene names one of its lights.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct ImageBasedLights {
    pub lights: Vec<ImageBasedLight>,
}

/// An image-based light: a cube map of radiance, with a rotation and a factor. Its other members follow from the cube map and
/// are not read.
#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct ImageBasedLight {
    pub name: String,
    pub rotation: [f64; 4],
    pub intensity: f32,
    /// The levels of the cube map, of which the first is the sharpest. Each has the images of its faces, by their indices in
    /// the document.
    pub specular_images: Vec<Vec<u64>>,
}

impl Default for ImageBasedLight {
    fn default() -> Self {
        Self {
            name: String::new(),
            rotation: [0.0, 0.0, 0.0, 1.0],
            intensity: 1.0,
            specular_images: Vec::new(),
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Spot {
    pub inner_cone_angle: f64,
    pub outer_cone_angle: f64,
}

impl Default for Spot {
    fn default() -> Self {
        Self {
            inner_cone_angle: 0.0,
            outer_cone_angle: std::f64::consts::FRAC_PI_4,
        }
    }
}

/// The extension `EXT_mesh_gpu_instancing` of a node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Instancing {
    /// The accessors of `TRANSLATION`, `ROTATION` and `SCALE`, each with one element per instance. Other attributes are for
    /// programs that know them, and are ignored.
    pub attributes: BTreeMap<String, u64>,
}

/// The extension `KHR_materials_variants` of the document: the variants among which a user can choose.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Variants {
    pub variants: Vec<Variant>,
}

/// A material variant, such as a colour in which a product is sold.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Variant {
    pub name: String,
}

/// The extension `KHR_materials_variants` of a primitive: its materials in the variants.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Mappings {
    pub mappings: Vec<Mapping>,
}

/// The material that a primitive has in some variants. Both are indices into the lists of the document.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Mapping {
    pub material: Option<u64>,
    pub variants: Vec<u64>,
}

/// The extension `KHR_node_visibility` of a node.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub struct Visibility {
    /// False if meshes and lights of the node and of its descendants are not shown. Cameras are not affected.
    pub visible: bool,
}

impl Default for Visibility {
    fn default() -> Self {
        Self { visible: true }
    }
}

/// The extension `MSFT_lod` of a node, which is itself the finest level of detail.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Levels {
    /// The indices of the nodes that a program may show in place of this node, where it is small in the picture.
    pub ids: Vec<u64>,
}

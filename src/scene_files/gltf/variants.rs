//! Chooses among the material variants of a glTF file (`KHR_materials_variants`).

use super::document::Document;
use serde::Deserialize;

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

/// The names of the material variants of the document, in the order of the file.
pub fn names(document: &Document) -> Vec<String> {
    let variants = document.extensions.variants.variants.iter();
    variants.map(|variant| variant.name.clone()).collect()
}

/// Replaces the material of each primitive by its material in the first variant with the name `name`. Primitives without a
/// material for this variant keep theirs. Nothing changes if the document has no variant of this name.
pub fn choose(document: &mut Document, name: &str) {
    let variants = &document.extensions.variants.variants;
    let Some(chosen) = variants.iter().position(|variant| variant.name == name) else {
        return;
    };
    for primitive in document
        .meshes
        .iter_mut()
        .flat_map(|mesh| &mut mesh.primitives)
    {
        let mappings = &primitive.extensions.variants.mappings;
        let is_chosen = |mapping: &&Mapping| mapping.variants.contains(&(chosen as u64));
        if let Some(mapping) = mappings.iter().find(is_chosen) {
            primitive.material = mapping.material.or(primitive.material);
        }
    }
}

//! Chooses among the material variants of a glTF file (`KHR_materials_variants`).

use super::document::{Document, Mapping};

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

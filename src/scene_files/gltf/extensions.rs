//! Decides which glTF extensions a file may require, and reports the extensions that are ignored.

use super::document::Document;
use crate::scene::notices::{Tally, listed, quoted};
use crate::{Error, Result};

/// The glTF extensions that are supported.
const SUPPORTED: [&str; 22] = [
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    LEVELS_OF_DETAIL,
];

/// The extension that gives nodes and materials coarser levels of detail. Only the finest level is shown, which is the node or
/// the material that has the extension.
const LEVELS_OF_DETAIL: &str = "MSFT_lod";

/// Extensions that change nothing in a picture at rest. A file may require them: they are ignored, with a notice.
const WITHOUT_EFFECT: [&str; 24] = [
    // Sound.
    "KHR_audio",
    "KHR_audio_emitter",
    "MSFT_audio_emitter",
    "OMI_audio_emitter",
    "OMI_audio_ogg_vorbis",
    // Texts and numbers about the file and its parts.
    "AGI_stk_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "VRMC_vrm",
    // A promise about the topology of meshes, whose triangles are stored as usual.
    "EXT_mesh_manifold",
    // Physics, joints and reactions to a person, which begin to act after the state that the file stores.
    "AGI_articulations",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "OMI_collider",
    "OMI_physics_body",
    "OMI_physics_shape",
    "VRMC_springBone",
];

/// The maximum number of ignored extensions that a notice names, so that the notice stays short. If there are more, the
/// notice ends with "and others".
const MAX_NAMES: usize = 16;

/// Reports the extensions that are ignored, in a notice in `tally`. Fails if the file requires an extension without which its
/// picture would be wrong.
pub fn check(document: &Document, tally: &mut Tally) -> Result<()> {
    let (used, required) = (&document.extensions_used, &document.extensions_required);
    let lists = |list: &[String], name: &str| list.iter().any(|listed| listed == name);
    let is_supported = |name: &&str| SUPPORTED.contains(name);
    let is_refused = |name: &&str| !is_supported(name) && !WITHOUT_EFFECT.contains(name);
    if let Some(name) = required.iter().map(String::as_str).find(is_refused) {
        return Err(Error::input(format!(
            "requires the extension {}, which is not supported; export it without",
            quoted(name)
        )));
    }
    // Some files do not list among the used extensions what they require.
    let only_required =
        (WITHOUT_EFFECT.into_iter()).filter(|name| lists(required, name) && !lists(used, name));
    let ignored: Vec<String> = (used.iter().map(String::as_str))
        .filter(|name| !is_supported(name))
        .chain(only_required)
        .take(MAX_NAMES + 1)
        .map(|name| name.chars().take(60).collect::<String>())
        .map(|name| name.escape_debug().to_string())
        .collect();
    if !ignored.is_empty() {
        let text = "extensions that are not supported are ignored";
        tally.add(text, || listed(&ignored, MAX_NAMES));
    }
    if lists(used, LEVELS_OF_DETAIL) || lists(required, LEVELS_OF_DETAIL) {
        let text = "of several levels of detail only the finest is shown";
        tally.add(text, || LEVELS_OF_DETAIL.into());
    }
    Ok(())
}

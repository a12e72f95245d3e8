//! Finds the nodes of a glTF file that are not shown: hidden nodes (`KHR_node_visibility`), and coarser levels of detail
//! (`MSFT_lod`).

use super::document::Document;

/// For each node of the document, true if the node itself is hidden or is a coarser level of detail of another node of the
/// scene. Then its descendants are not shown either, which the caller passes on, because their own entries may be false.
/// `is_in_scene` tells for each node whether it belongs to the scene.
pub fn hidden(document: &Document, is_in_scene: &[bool]) -> Vec<bool> {
    let nodes = &document.nodes;
    let mut hidden: Vec<bool> = (nodes.iter())
        .map(|node| !node.extensions.visibility.visible)
        .collect();
    for (finest, node) in (0..).zip(nodes).filter(|(index, _)| is_in_scene[*index]) {
        for &coarse in &node.extensions.levels.ids {
            // An index out of range names nothing that could be shown.
            let coarse = usize::try_from(coarse)
                .ok()
                .filter(|&index| index != finest);
            if let Some(hidden) = coarse.and_then(|index| hidden.get_mut(index)) {
                *hidden = true;
            }
        }
    }
    hidden
}

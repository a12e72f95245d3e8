//! Reads scenes from glTF 2.0 files (`.gltf` and `.glb`).
//!
//! The `gltf` crate is used only to split a GLB file into its chunks; [`document`] gives the reasons why its
//! types are not used. Its validation and traversal are not used either: they panic or recurse without end on
//! some broken files. Instead, each index is checked when it is followed, and each range of an accessor is
//! checked before it is read.

mod accessors;
mod animations;
mod buffers;
mod deformations;
mod document;
mod draco;
mod extensions;
mod image_based;
mod instancing;
mod json;
mod lights;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod textures;
mod unfolding;
mod variants;
mod visibility;

pub(super) use document::SEEN_FROM_BEHIND;

use super::progress::Progress;
use super::scene_folder::SceneFolder;
use crate::scene::notices::Tally;
use crate::scene::{Instance, Material, Motion, Scene};
use crate::{Error, Result};
use accessors::{Accessors, get};
use buffers::Buffers;
use deformations::Deforming;
use materials::Uses;
use meshes::Meshes;
use textures::Textures;
use unfolding::Unfolding;

/// Reads a scene from the bytes of a glTF file. Files that it names are looked for in `folder`. The messages of errors name
/// the faulty element, but not the file, which the caller adds. The scene is not validated yet; the caller does that too.
pub(super) fn read(
    bytes: &[u8],
    folder: &SceneFolder<'_>,
    progress: &mut Progress<'_>,
) -> Result<Scene> {
    let (json, binary) = buffers::split(bytes)?;
    let mut tally = Tally::default();
    let mut document = json::parse(&json, &mut tally)?;
    extensions::check(&document, &mut tally)?;
    if let Some(name) = &folder.options.material_variant {
        variants::choose(&mut document, name);
    }

    let buffers = Buffers::load(&document, binary.as_deref(), folder, progress, &mut tally)?;
    let unfolding = Unfolding::of(buffers.total() + json.len() as u64);
    let mut contents = buffers.contents();
    let views = meshopt::decode(&mut document, &contents, &unfolding, progress)?;
    contents.extend(views.iter().map(|view| match view {
        Ok(bytes) => Ok(bytes.as_slice()),
        Err(fault) => Err(fault.as_str()),
    }));
    let elements = draco::decode(&mut document, &contents, &unfolding, progress)?;
    contents.extend(elements.iter().map(|element| Ok(element.as_slice())));
    let placed = nodes::placed(&document, &mut tally)?;
    let accessors = Accessors {
        document: &document,
        buffers: &contents,
        unfolding: &unfolding,
    };
    let mut animations = animations::read(&accessors, &placed, &mut tally)?;
    let uses = Uses::of(&document, &placed, |material| {
        animations.change_emission_of(material)
    });
    let (textures, images) = Textures::load(&accessors, &uses, folder, progress, &mut tally)?;
    for material in (0..document.materials.len()).filter(|i| textures.has_lost_emission(*i)) {
        animations.drop_emission_of(material);
    }
    let mut scene = Scene {
        materials: materials::read(&document.materials, &textures, &mut tally)?,
        environment: image_based::read(&accessors, folder, progress, &mut tally)?,
        images,
        material_variants: variants::names(&document),
        ..Scene::default()
    };
    let mut meshes = Meshes::new(accessors, &scene.materials);
    let mut cameras = Vec::new();
    // For each instance, where in `placed`, or after it in `copies`, its node is.
    let mut instance_nodes = Vec::new();
    // Copies of a mesh move with their node, as children of it would.
    let mut copies = Vec::new();
    // Where in the scene each of the file's meshes is, once it has been read.
    let mut read: Vec<Option<u32>> = vec![None; document.meshes.len()];
    let mut light_nodes = Vec::new();
    let mut deformations = Vec::new();
    for (node_index, placed_node) in (0_u32..).zip(&placed) {
        let is_shown = placed_node.is_shown;
        if let Some(light) =
            lights::of_node(&document, placed_node, &mut tally)?.filter(|_| is_shown)
        {
            scene.punctual_lights.push(light);
            light_nodes.push(Some(node_index));
        }
        if let Some(index) = placed_node.node.camera {
            let Some(source) = get(&document.cameras, index) else {
                return Err(out_of_range(
                    &placed_node.label(),
                    "camera",
                    index,
                    document.cameras.len(),
                ));
            };
            if let Some(camera) = nodes::camera(placed_node, index, source, &mut tally)? {
                cameras.push((index, camera, node_index));
            }
        }
        if let Some(index) = placed_node.node.mesh.filter(|_| is_shown) {
            let Some(source) = get(&document.meshes, index) else {
                return Err(out_of_range(
                    &placed_node.label(),
                    "mesh",
                    index,
                    document.meshes.len(),
                ));
            };
            let weights =
                deformations::rest_weights(&document, placed_node.node, &placed_node.label())?;
            if placed_node.node.skin.is_some()
                || animations.change_weights_of(placed_node.index)
                || weights.iter().any(|weight| *weight != 0.0)
            {
                if placed_node.node.extensions.instancing.is_some() {
                    let text = "meshes that deform are not copied by EXT_mesh_gpu_instancing";
                    tally.add(text, || placed_node.label());
                }
                // Each node deforms a mesh of its own.
                let tracks = animations.weights_of(placed_node.index);
                let mut deforming =
                    Deforming::new(&accessors, placed_node, source, &placed, &mut tally)?;
                let file_index = index as usize;
                let mut mesh = meshes.read(file_index, source, Some(&mut deforming), &mut tally)?;
                progress.decoded(scene.meshes.len(), document.meshes.len())?;
                let index = scene.meshes.len();
                // Its rest shape is repaired now, because later its vertices must keep their order.
                let sources = mesh.prepare_to_deform(index, &scene.materials, &mut tally);
                let world_to_object = deforming.world_to_object(&placed);
                deformations.push(deforming.finish(
                    index as u32,
                    &mesh,
                    &sources,
                    &weights,
                    tracks,
                    world_to_object,
                ));
                scene.meshes.push(mesh);
                let is_skinned = placed_node.node.skin.is_some();
                instance_nodes.push((!is_skinned).then_some(node_index));
                scene.instances.push(Instance {
                    name: placed_node.node.name.clone(),
                    mesh: index as u32,
                    object_to_world: match is_skinned {
                        true => world_to_object.inverse(),
                        false => placed_node.to_world,
                    },
                });
                continue;
            }
            let copied = instancing::transforms(&accessors, placed_node)?;
            if copied.as_ref().is_some_and(Vec::is_empty) {
                continue;
            }
            let index = index as usize;
            let mesh = match read[index] {
                Some(mesh) => mesh,
                None => {
                    scene
                        .meshes
                        .push(meshes.read(index, source, None, &mut tally)?);
                    progress.decoded(scene.meshes.len(), document.meshes.len())?;
                    scene.meshes.len() as u32 - 1
                }
            };
            read[index] = Some(mesh);
            let mut add = |node, object_to_world| {
                instance_nodes.push(Some(node));
                scene.instances.push(Instance {
                    name: placed_node.node.name.clone(),
                    mesh,
                    object_to_world,
                });
            };
            match copied {
                None => add(node_index, placed_node.to_world),
                Some(copied) => {
                    for in_node in copied {
                        let node = (placed.len() + copies.len()) as u32;
                        add(node, placed_node.to_world * in_node);
                        copies.push((node_index, in_node));
                    }
                }
            }
        }
    }
    if meshes.default_material_used {
        scene.materials.push(Material::default());
    }
    cameras.sort_by_key(|(index, ..)| *index);
    let camera_nodes = cameras.iter().map(|(.., node)| Some(*node)).collect();
    scene.cameras = cameras.into_iter().map(|(_, camera, _)| camera).collect();
    scene.motion = animations.motion(
        &placed,
        &copies,
        instance_nodes,
        camera_nodes,
        light_nodes,
        deformations,
    );
    // Even what never changes may be kept elsewhere by its keys than by its node.
    scene.take_pose(0.0)?;
    scene.motion = scene.motion.take().and_then(Motion::simplified);
    scene.notices.extend(tally.into_lines());
    Ok(scene)
}

fn out_of_range(what: &str, kind: &str, index: u64, count: usize) -> Error {
    damaged(format!(
        "{what}: {kind} {index} is out of range, there are {count}"
    ))
}

/// The error for a damaged glTF file. Its message is `fault`, followed by the advice to export the file again.
fn damaged(fault: impl std::fmt::Display) -> Error {
    Error::input(format!("{fault}; the file is damaged, export it again"))
}

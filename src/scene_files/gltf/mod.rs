//! Reads scenes from glTF 2.0 files (`.gltf` and `.glb`).
//!
//! The `gltf` crate is used only to split a GLB file into its chunks; [`document`] gives the reasons why its
//! types are not used. Its validation and traversal are not used either: they panic or recurse without end on
//! some broken files. Instead, each index is checked when it is followed, and each range of an accessor is
//! checked before it is read.

mod accessors;
mod animations;
mod buffers;
mod document;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod textures;
mod unfolding;

use super::progress::Progress;
use super::scene_folder::SceneFolder;
use crate::base::memory;
use crate::scene::notices::Tally;
use crate::scene::{Instance, Material, Motion, Scene};
use crate::{Error, Result};
use accessors::{Accessors, get};
use buffers::Buffers;
use document::Document;
use materials::Uses;
use meshes::Meshes;
use textures::Textures;
use unfolding::Unfolding;

/// The glTF extensions that are supported. A file that requires another extension is refused. If a file only uses another
/// extension without requiring it, the extension is ignored, with a notice.
const EXTENSIONS: [&str; 9] = [
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// The estimated memory of one object or list of the JSON, in bytes (1 KiB). It includes the parts of the scene that are
/// made from the object, such as an instance that is made from a node. [`memory_of`] adds up such estimates, and a file that
/// needs too much memory is refused.
const OBJECT_BYTES: u64 = 1 << 10;

/// The estimated memory of a string, in bytes, without its text. [`memory_of`] adds it for each comma before a string, which
/// is an element of a list or the name of a member. A string at the start of a list or an object follows no comma; its
/// memory is part of [`OBJECT_BYTES`]. For a list that begins with a number, [`memory_of`] adds `STRING_BYTES` in place of
/// [`OBJECT_BYTES`].
const STRING_BYTES: u64 = 128;

/// The estimated memory of a number in a list, in bytes. [`memory_of`] adds it for each comma that no string follows. The
/// first number of a list follows no comma; its memory is part of the [`STRING_BYTES`] that are added for the list.
const NUMBER_BYTES: u64 = 16;

/// The maximum number of unsupported extensions that a notice names, so that the notice stays short. If there are more, the
/// notice ends with "and others".
const MAX_EXTENSIONS: usize = 16;

/// Reads a scene from the bytes of a glTF file. Files that it names are looked for in `folder`. The messages of errors name
/// the faulty element, but not the file, which the caller adds. The scene is not validated yet; the caller does that too.
pub(super) fn read(
    bytes: &[u8],
    folder: &SceneFolder<'_>,
    progress: &mut Progress<'_>,
) -> Result<Scene> {
    let (json, binary) = buffers::split(bytes)?;
    check_memory(&json)?;
    let document = parse(&json)?;
    check_extensions(&document)?;
    let mut tally = Tally::default();
    notice_ignored(&document, &mut tally);

    let placed = nodes::placed(&document)?;
    let buffers = Buffers::load(&document, binary.as_deref(), folder, progress, &mut tally)?;
    let slices = buffers.slices();
    let unfolding = Unfolding::of(buffers.total() + json.len() as u64);
    let accessors = Accessors {
        document: &document,
        buffers: &slices,
        unfolding: &unfolding,
    };
    let animations = animations::read(&accessors, &placed, &mut tally)?;
    let uses = Uses::of(&document, &placed, |material| {
        animations.change_emission_of(material)
    });
    let (textures, images) = Textures::load(&accessors, &uses, folder, progress, &mut tally)?;
    let mut scene = Scene {
        materials: materials::read(&document.materials, &textures, &mut tally)?,
        images,
        ..Scene::default()
    };
    let mut meshes = Meshes::new(accessors, &scene.materials);
    let mut cameras = Vec::new();
    // For each instance, where in `placed` its node is.
    let mut instance_nodes = Vec::new();
    // Where in the scene each of the file's meshes is, once it has been read.
    let mut read: Vec<Option<u32>> = vec![None; document.meshes.len()];
    let mut light_nodes = Vec::new();
    for (node_index, placed_node) in (0_u32..).zip(&placed) {
        if let Some(light) = lights::of_node(&document, placed_node)? {
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
        if let Some(index) = placed_node.node.mesh {
            let Some(source) = get(&document.meshes, index) else {
                return Err(out_of_range(
                    &placed_node.label(),
                    "mesh",
                    index,
                    document.meshes.len(),
                ));
            };
            if placed_node.node.skin.is_some() {
                tally.add("skins are ignored, the mesh stands as modelled", || {
                    placed_node.label()
                });
            }
            let index = index as usize;
            let mesh = match read[index] {
                Some(mesh) => mesh,
                None => {
                    scene.meshes.push(meshes.read(index, source, &mut tally)?);
                    progress.decoded(scene.meshes.len(), document.meshes.len())?;
                    scene.meshes.len() as u32 - 1
                }
            };
            read[index] = Some(mesh);
            instance_nodes.push(Some(node_index));
            scene.instances.push(Instance {
                name: placed_node.node.name.clone(),
                mesh,
                object_to_world: placed_node.to_world,
            });
        }
    }
    if meshes.default_material_used {
        scene.materials.push(Material::default());
    }
    cameras.sort_by_key(|(index, ..)| *index);
    let camera_nodes = cameras.iter().map(|(.., node)| Some(*node)).collect();
    scene.cameras = cameras.into_iter().map(|(_, camera, _)| camera).collect();
    scene.motion = animations.motion(&placed, instance_nodes, camera_nodes, light_nodes);
    // Even what never changes may be kept elsewhere by its keys than by its node.
    scene.take_pose(0.0)?;
    scene.motion = scene.motion.take().and_then(Motion::simplified);
    scene.notices.extend(tally.into_lines());
    Ok(scene)
}

/// Checks that there is enough memory for the data that the JSON describes, as [`memory_of`] estimates it, and otherwise
/// fails. This check comes before the JSON is parsed, because a small file can describe very many elements.
fn check_memory(json: &[u8]) -> Result<()> {
    memory::check(memory_of(json)).map_err(|cause| {
        Error::input(format!(
            "its JSON has too many elements: {cause}; split the file"
        ))
    })
}

/// An upper estimate of the memory that the parsed JSON and the data made from it take, in bytes. It counts the objects,
/// lists, strings and numbers of the JSON.
fn memory_of(json: &[u8]) -> u64 {
    let mut bytes = 0;
    let mut rest = json;
    while let Some((byte, after)) = rest.split_first() {
        rest = after;
        let next = || after.trim_ascii_start().first();
        bytes += match byte {
            b'"' => {
                rest = after_string(after);
                0
            }
            b'[' if matches!(next(), Some(b'-' | b'0'..=b'9')) => STRING_BYTES,
            // The reader takes a list of an object's members for the object.
            b'{' | b'[' => OBJECT_BYTES,
            b',' if next() == Some(&b'"') => STRING_BYTES,
            b',' => NUMBER_BYTES,
            _ => 0,
        };
    }
    bytes
}

/// The rest of `json` after the end of a string, so that brackets and commas in strings are not counted as elements. `json`
/// must begin with the first character of the string, after its opening quote. The result is empty if the string never ends.
fn after_string(json: &[u8]) -> &[u8] {
    let mut rest = json;
    while let Some(at) = rest.iter().position(|byte| matches!(byte, b'"' | b'\\')) {
        let length = if rest[at] == b'"' { 1 } else { 2 };
        rest = rest.get(at + length..).unwrap_or_default();
        if length == 1 {
            return rest;
        }
    }
    &[]
}

fn parse(json: &[u8]) -> Result<Document> {
    let document: Document = match serde_json::from_slice(json) {
        Ok(document) => document,
        Err(cause) => {
            // glTF 1.0 has other types throughout: say that rather than where they differ first.
            #[derive(serde::Deserialize)]
            struct Probe {
                asset: document::Asset,
            }
            if let Ok(probe) = serde_json::from_slice::<Probe>(json) {
                check_version(&probe.asset)?;
            }
            return Err(not_json(json, &cause));
        }
    };
    check_version(&document.asset)?;
    Ok(document)
}

/// The error for JSON that cannot be read as a glTF document. Its message contains the fault and the path of the faulty
/// element, such as the name of a list and an index.
fn not_json(json: &[u8], cause: &serde_json::Error) -> Error {
    // Read again to find the element: to follow it in every file would slow loading down.
    let json = &mut serde_json::Deserializer::from_slice(json);
    let fault = serde_path_to_error::deserialize::<_, Document>(json);
    let location = match fault.map_err(|fault| fault.path().to_string()) {
        Err(element) if element != "." => {
            format!(", in {}", crate::scene::notices::quoted_end(&element))
        }
        _ => String::new(),
    };
    damaged(format!("its JSON cannot be read: {cause}{location}"))
}

fn check_version(asset: &document::Asset) -> Result<()> {
    let wanted = asset.min_version.as_ref().unwrap_or(&asset.version);
    let supported = match &asset.min_version {
        Some(minimum) => minimum == "2.0",
        None => asset.version.starts_with("2."),
    };
    if supported {
        return Ok(());
    }
    Err(Error::input(format!(
        "asset version {} is not supported; export it as glTF 2.0",
        crate::scene::notices::quoted(wanted)
    )))
}

fn check_extensions(document: &Document) -> Result<()> {
    match document
        .extensions_required
        .iter()
        .find(|name| !EXTENSIONS.contains(&name.as_str()))
    {
        None => Ok(()),
        Some(name) => Err(Error::input(format!(
            "requires the extension {}, which is not supported; export it without",
            crate::scene::notices::quoted(name)
        ))),
    }
}

fn notice_ignored(document: &Document, tally: &mut Tally) {
    let ignored: Vec<String> = document
        .extensions_used
        .iter()
        .filter(|name| !EXTENSIONS.contains(&name.as_str()))
        .take(MAX_EXTENSIONS + 1)
        .map(|name| name.chars().take(60).collect::<String>())
        .map(|name| name.escape_debug().to_string())
        .collect();
    if !ignored.is_empty() {
        tally.add(
            "extensions that are not supported are ignored",
            || match ignored.get(..MAX_EXTENSIONS) {
                Some(first) if first.len() < ignored.len() => first.join(", ") + " and others",
                _ => ignored.join(", "),
            },
        );
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_of_json_are_counted_outside_of_strings() {
        for (json, bytes) in [
            (r#" "[{,\"[{,\\" "#, 0),
            ("{}", OBJECT_BYTES),
            ("[ [],\n[]]", 3 * OBJECT_BYTES + NUMBER_BYTES),
            ("[ -1 , 2,3]", STRING_BYTES + 2 * NUMBER_BYTES),
            (r#"["","" , ""]"#, OBJECT_BYTES + 2 * STRING_BYTES),
            (r#"{"a":1,"b":["#, 2 * OBJECT_BYTES + STRING_BYTES),
            (r#""\"#, 0),
        ] {
            assert_eq!(memory_of(json.as_bytes()), bytes, "{json}");
        }
    }
}

//! Writes scenes as binary glTF 2.0 (`.glb`), so that other programs can open generated scenes.

mod animations;
mod cameras;
mod lights;
mod materials;
mod meshes;
#[cfg(test)]
mod tests;

use crate::base::files::write_atomically;
use crate::scene::{Motion, Scene};
use crate::{Error, Result};
use glam::{DAffine3, Vec3};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

const FLOAT: u32 = 5126;

/// Writes a scene to `path` as binary glTF: meshes with one primitive per part, instances as nodes, materials with their
/// textures (as PNG), lights, cameras, and animations, whose keys are stored in f32. The environment is left
/// out, the deformation of meshes, which have their shape at time 0, and the shear of texture transforms, which glTF cannot express.
///
/// # Errors
/// An image's number of texels is not its width × height, or the image cannot be encoded as PNG; the file would have more
/// than the 4 GiB that the format allows; or the file cannot be written.
pub fn write_glb(scene: &Scene, path: &Path) -> Result<()> {
    let mut binary = Binary::default();
    let document = document(scene, &mut binary)?;
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() as u64 + 8 + binary.bytes.len() as u64;
    let too_large = |_| {
        Error::failed(format!(
            "cannot write {}: {total} bytes, but .glb holds at most 4294967295",
            path.display()
        ))
    };
    let length = u32::try_from(total).map_err(too_large)?;
    write_atomically(path, |file| {
        let words = |words: &[u32]| {
            words
                .iter()
                .flat_map(|w| w.to_le_bytes())
                .collect::<Vec<u8>>()
        };
        file.write_all(b"glTF")?;
        file.write_all(&words(&[2, length, text.len() as u32]))?;
        file.write_all(b"JSON")?;
        file.write_all(&text)?;
        file.write_all(&words(&[binary.bytes.len() as u32]))?;
        file.write_all(b"BIN\0")?;
        file.write_all(&binary.bytes)
    })
}

/// The bytes of the GLB file's binary chunk (vertices, indices, keyframes, images), and the JSON of the buffer views and
/// accessors through which the rest of the JSON refers to these bytes.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    /// Appends `values` to the binary chunk, and returns the index of their accessor. Each component of a value must have
    /// four bytes. `accessor` is the JSON of the accessor without its buffer view. `target` is the number by which glTF
    /// marks a buffer view of vertices or of indices; `None` for other data, such as keyframes.
    fn push<T: bytemuck::Pod>(
        &mut self,
        values: &[T],
        target: Option<u32>,
        mut accessor: Value,
    ) -> usize {
        let view = self.push_bytes(bytemuck::cast_slice(values));
        if let Some(target) = target {
            self.views[view]["target"] = json!(target);
        }
        accessor["bufferView"] = json!(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Appends bytes to the binary chunk, which is then padded to a multiple of four bytes, and returns the index of a new
    /// buffer view of these bytes.
    fn push_bytes(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        }));
        self.bytes.extend_from_slice(bytes);
        // Accessors of components of four bytes must be aligned to them.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }
}

/// Splits `light`, a linear RGB value, into a colour with channels of at most 1 and a strength of at least 1. The product of
/// both is `light`. glTF stores both, because it limits the channels of colours to 1.
fn color_and_strength(light: Vec3) -> (Vec3, f32) {
    let strength = light.max_element().max(1.0);
    (light / strength, strength)
}

fn document(scene: &Scene, binary: &mut Binary) -> Result<Value> {
    let meshes: Vec<Value> = (scene.meshes.iter())
        .map(|mesh| meshes::mesh(mesh, binary))
        .collect();
    let mut textures = materials::Textures::default();
    let mut materials: Vec<Value> = (scene.materials.iter())
        .map(|material| materials::material(material, &mut textures))
        .collect();
    let images = materials::images(&scene.images, binary)?;
    let still = Motion::default();
    let motion = scene.motion.as_ref().unwrap_or(&still);
    let mut nodes = animations::nodes(motion);
    let (mut roots, mut moving_roots) = (Vec::new(), Vec::new());
    moving_roots.extend((0..nodes.len()).filter(|&node| motion.nodes[node].parent.is_none()));
    // A moving object becomes a child of a node of the motion, without a transform in its own node.
    let mut place = |mut node: Value, parent: Option<u32>, to_world: &DAffine3| {
        let index = nodes.len();
        match parent {
            Some(parent) => animations::add_child(&mut nodes[parent as usize], index),
            None => {
                node["matrix"] = json!(animations::matrix(to_world));
                roots.push(index);
            }
        }
        nodes.push(node);
    };
    let parent = |list: &[Option<u32>], index: usize| list.get(index).copied().flatten();
    for (index, instance) in scene.instances.iter().enumerate() {
        let node = json!({ "name": instance.name, "mesh": instance.mesh });
        place(
            node,
            parent(&motion.instances, index),
            &instance.object_to_world,
        );
    }
    let mut cameras = Vec::new();
    for (index, camera) in scene.cameras.iter().enumerate() {
        let node = json!({ "name": camera.name, "camera": index });
        place(
            node,
            parent(&motion.cameras, index),
            &camera.camera_to_world,
        );
        cameras.push(cameras::camera(camera, scene));
    }
    for (index, light) in scene.punctual_lights.iter().enumerate() {
        place(
            lights::node(index, light),
            parent(&motion.lights, index),
            &light.light_to_world,
        );
    }
    roots.append(&mut moving_roots);
    animations::rest_emission(motion, &mut materials);
    let mut used = BTreeSet::new();
    if !motion.emission.is_empty() {
        used.insert(animations::POINTER);
    }
    if !scene.punctual_lights.is_empty() {
        used.insert(lights::EXTENSION);
    }
    if textures.has_transform {
        used.insert(materials::TEXTURE_TRANSFORM);
    }
    let extensions = materials.iter().filter_map(|m| m["extensions"].as_object());
    let used: BTreeSet<&str> = (extensions.flat_map(|extensions| extensions.keys()))
        .map(String::as_str)
        .chain(used)
        .collect();
    let used = used.into_iter().map(Value::from).collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "Headwater" },
        "scene": 0,
        "scenes": [{ "name": scene.name, "nodes": roots }],
    });
    if scene.motion.is_some() {
        document["animations"] = json!([animations::animation(motion, binary)]);
    }
    if !scene.punctual_lights.is_empty() {
        document["extensions"] = lights::lights(&scene.punctual_lights);
    }
    // glTF forbids empty arrays.
    for (key, values) in [
        ("nodes", nodes),
        ("meshes", meshes),
        ("materials", materials),
        ("textures", textures.textures),
        ("samplers", textures.samplers),
        ("images", images),
        ("cameras", cameras),
        ("accessors", std::mem::take(&mut binary.accessors)),
        ("bufferViews", std::mem::take(&mut binary.views)),
        ("extensionsUsed", used),
    ] {
        if !values.is_empty() {
            document[key] = Value::Array(values);
        }
    }
    if !binary.bytes.is_empty() {
        document["buffers"] = json!([{ "byteLength": binary.bytes.len() }]);
    }
    Ok(document)
}

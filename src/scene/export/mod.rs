//! Scenes as binary glTF 2.0.

mod animations;

use super::{Material, Mesh, Motion, Scene};
use crate::files::write_atomically;
use crate::{Error, Result};
use glam::DAffine3;
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::Path;

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Writes a scene to `path` as .glb: meshes with a primitive for each part, instances as nodes,
/// cameras, and the motion of all and of the lights, in f32. Textures, their coordinates and vertex colours
/// are left out.
///
/// # Errors
/// More than the 4 GiB that the format allows, or the file cannot be written.
pub fn write_glb(scene: &Scene, path: &Path) -> Result<()> {
    let mut binary = Binary::default();
    let document = document(scene, &mut binary);
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

/// The binary chunk and the views and accessors into it.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    /// Appends values and returns the index of their accessor; vertices and indices have a target.
    /// All components are four bytes, so that everything stays aligned.
    fn push<T: bytemuck::Pod>(
        &mut self,
        values: &[T],
        target: Option<u32>,
        mut accessor: Value,
    ) -> usize {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.bytes.extend_from_slice(bytes);
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn document(scene: &Scene, binary: &mut Binary) -> Value {
    let meshes: Vec<Value> = scene.meshes.iter().map(|m| mesh(m, binary)).collect();
    let mut materials: Vec<Value> = scene.materials.iter().map(material).collect();
    let still = Motion::default();
    let motion = scene.motion.as_ref().unwrap_or(&still);
    let mut nodes = animations::nodes(motion);
    let (mut roots, mut moving_roots) = (Vec::new(), Vec::new());
    moving_roots.extend((0..nodes.len()).filter(|&node| motion.nodes[node].parent.is_none()));
    // What moves is a child of one of the motion's nodes, without a transform of its own.
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
        let mut perspective = json!({ "yfov": camera.vertical_fov, "znear": 0.01 });
        if let Some(aspect) = camera.aspect_ratio {
            perspective["aspectRatio"] = json!(aspect);
        }
        cameras.push(json!({ "type": "perspective", "perspective": perspective }));
    }
    roots.append(&mut moving_roots);
    animations::rest_emission(motion, &mut materials);
    let mut used = Vec::new();
    if !motion.emission.is_empty() {
        used.push(animations::POINTER.to_owned());
    }
    for name in materials
        .iter()
        .filter_map(|m| m["extensions"].as_object())
        .flat_map(Map::keys)
    {
        if !used.contains(name) {
            used.push(name.clone());
        }
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "Headwater" },
        "scene": 0,
        "scenes": [{ "name": scene.name, "nodes": roots }],
    });
    if scene.motion.is_some() {
        document["animations"] = json!([animations::animation(motion, binary)]);
    }
    // glTF forbids empty arrays.
    for (key, values) in [
        ("nodes", nodes),
        ("meshes", meshes),
        ("materials", materials),
        ("cameras", cameras),
        ("accessors", std::mem::take(&mut binary.accessors)),
        ("bufferViews", std::mem::take(&mut binary.views)),
        (
            "extensionsUsed",
            used.into_iter().map(Value::String).collect(),
        ),
    ] {
        if !values.is_empty() {
            document[key] = Value::Array(values);
        }
    }
    if !binary.bytes.is_empty() {
        document["buffers"] = json!([{ "byteLength": binary.bytes.len() }]);
    }
    document
}

fn mesh(mesh: &Mesh, binary: &mut Binary) -> Value {
    let low = mesh
        .positions
        .iter()
        .copied()
        .reduce(glam::Vec3::min)
        .unwrap_or_default();
    let high = mesh
        .positions
        .iter()
        .copied()
        .reduce(glam::Vec3::max)
        .unwrap_or_default();
    let positions = json!({
        "componentType": FLOAT, "type": "VEC3", "count": mesh.positions.len(),
        "min": low.to_array(), "max": high.to_array(),
    });
    let mut attributes =
        json!({ "POSITION": binary.push(&mesh.positions, Some(ARRAY_BUFFER), positions) });
    if !mesh.normals.is_empty() {
        let normals =
            json!({ "componentType": FLOAT, "type": "VEC3", "count": mesh.normals.len() });
        attributes["NORMAL"] = json!(binary.push(&mesh.normals, Some(ARRAY_BUFFER), normals));
    }
    let primitives: Vec<Value> = mesh
        .parts
        .iter()
        .map(|part| {
            let first = part.first_triangle as usize;
            let triangles = &mesh.triangles[first..first + part.triangle_count as usize];
            let indices = json!({
                "componentType": UNSIGNED_INT, "type": "SCALAR", "count": 3 * triangles.len(),
            });
            json!({
                "attributes": attributes,
                "indices": binary.push(triangles, Some(ELEMENT_ARRAY_BUFFER), indices),
                "material": part.material,
            })
        })
        .collect();
    json!({ "name": mesh.name, "primitives": primitives })
}

fn material(material: &Material) -> Value {
    let mut value = json!({
        "name": material.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": material.base_color.extend(1.0).to_array(),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        },
    });
    if material.double_sided {
        value["doubleSided"] = json!(true);
    }
    let mut extensions = Map::new();
    if material.is_emissive() {
        // glTF limits the factor to 1, so the rest goes into the strength.
        let strength = material.emission.max_element().max(1.0);
        value["emissiveFactor"] = json!((material.emission / strength).to_array());
        if strength > 1.0 {
            extensions.insert(
                "KHR_materials_emissive_strength".into(),
                json!({ "emissiveStrength": strength }),
            );
        }
    }
    if material.specular != 1.0 || material.specular_color != glam::Vec3::ONE {
        extensions.insert(
            "KHR_materials_specular".into(),
            json!({
                "specularFactor": material.specular,
                "specularColorFactor": material.specular_color.to_array(),
            }),
        );
    }
    if material.ior != 1.5 {
        extensions.insert("KHR_materials_ior".into(), json!({ "ior": material.ior }));
    }
    if !extensions.is_empty() {
        value["extensions"] = Value::Object(extensions);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{load, procedural};

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        for procedural in procedural::list() {
            let scene = procedural::generate(procedural.name, &[]).unwrap();
            let path = folder.path().join(format!("{}.glb", procedural.name));
            write_glb(&scene, &path).unwrap();
            let back = load::load(&path).unwrap();
            assert_eq!(back.notices, Vec::<String>::new());
            let differs = difference(&scene, &back);
            assert_eq!(differs, None, "{}", procedural.name);
        }
    }

    #[test]
    fn what_moves_moves_when_it_is_read_again() {
        let scene = procedural::generate("motion", &[]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("motion.glb");
        write_glb(&scene, &path).unwrap();
        let back = load::load(&path).unwrap();
        for step in 0..40 {
            let time = 0.43 * f64::from(step);
            let (a, b) = (scene.pose_at(time).unwrap(), back.pose_at(time).unwrap());
            for (a, b) in a.instances.iter().zip(&b.instances) {
                let (place, other) = (a.object_to_world, b.object_to_world);
                assert!(place.abs_diff_eq(other, 1e-5), "{} at {time} s", a.name);
            }
            let place = a.cameras[0].camera_to_world;
            assert!(place.abs_diff_eq(b.cameras[0].camera_to_world, 1e-5));
            for (a, b) in a.materials.iter().zip(&b.materials) {
                assert!(
                    a.emission.abs_diff_eq(b.emission, 1e-4),
                    "{} at {time} s",
                    a.name
                );
            }
        }
        assert_ne!(
            scene.pose_at(0.0).unwrap().content_hash(),
            scene.pose_at(0.4).unwrap().content_hash()
        );
    }

    #[test]
    fn every_factor_survives() {
        let mut scene = procedural::generate("cornell", &[]).unwrap();
        scene.materials[0] = crate::scene::Material {
            name: "all of it".into(),
            base_color: glam::Vec3::new(0.1, 0.2, 0.3),
            metallic: 0.4,
            roughness: 0.6,
            specular: 0.7,
            specular_color: glam::Vec3::new(0.8, 0.9, 1.5),
            ior: 1.7,
            emission: glam::Vec3::new(0.0, 3.0, 1e6),
            double_sided: !scene.materials[0].double_sided,
            ..crate::scene::Material::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all.glb");
        write_glb(&scene, &path).unwrap();
        let back = load::load(&path).unwrap();
        assert_eq!(difference(&scene, &back), None);
    }

    /// The first thing in which two scenes differ. Emission is stored as colour times strength, so
    /// it may lose its last bits.
    fn difference(a: &Scene, b: &Scene) -> Option<String> {
        let mut b = b.clone();
        if a.materials.len() == b.materials.len() {
            for (a, b) in a.materials.iter().zip(&mut b.materials) {
                if (a.emission - b.emission).length() <= 1e-6 * a.emission.length() {
                    b.emission = a.emission;
                }
            }
        }
        // A file may order meshes and corners differently, so they are compared by instance; and a
        // file that is read has no negative zeros.
        let items = |s: &Scene| {
            let corner =
                |m: &Mesh, i: u32| (m.positions[i as usize], m.normals.get(i as usize).copied());
            let mesh = |m: &Mesh| {
                let triangles = m.triangles.iter();
                let corners: Vec<_> = triangles.map(|t| t.map(|i| corner(m, i))).collect();
                format!("{} {:?} {corners:?}", m.name, m.parts)
            };
            let meshes: Vec<String> = s.meshes.iter().map(mesh).collect();
            // Keys are stored in f32, so moving instances may differ slightly.
            let still = (s.instances.iter().enumerate())
                .filter(|(i, _)| !s.motion.as_ref().is_some_and(|m| m.moves_instance(*i)));
            let placed = still.map(|(_, i)| {
                let place = format!("{} {:?} ", i.name, i.object_to_world);
                place + &meshes[i.mesh as usize]
            });
            let materials = s.materials.iter().map(|m| format!("{m:?}"));
            let cameras = s.cameras.iter().map(|c| format!("{c:.12?}"));
            materials
                .chain(cameras)
                .chain(placed)
                .map(|text| {
                    let text = text.replace("-0.0,", "0.0,").replace("-0.0)", "0.0)");
                    text.replace("-0.000000000000", "0.000000000000")
                })
                .collect::<Vec<_>>()
        };
        let (a, b) = (items(a), items(&b));
        if a.len() != b.len() {
            return Some(format!("{} items, {} items", a.len(), b.len()));
        }
        let (a, b) = a.iter().zip(&b).find(|(a, b)| a != b)?;
        let at = a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count();
        let near = |text: &str| {
            text.chars()
                .skip(at.saturating_sub(80))
                .take(160)
                .collect::<String>()
        };
        Some(format!("{}\n{}", near(a), near(b)))
    }
}

//! Files that the tests of loading write.

use headwater::scene::Scene;
use headwater::scene_files::load;
use serde_json::{Value, json};
use std::path::PathBuf;
use tempfile::TempDir;

/// A temporary folder of scene files that is deleted at the end of the test.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    /// Writes a scene file and loads it; panics if it is refused.
    pub fn load(&self, name: &str, content: impl AsRef<[u8]>) -> Scene {
        load(&self.write(name, content)).unwrap()
    }

    /// Writes a scene file that must be refused, and returns the message. The status must be 2, and the message one line
    /// that names the file.
    pub fn refuse(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let error = load(&self.write(name, content)).expect_err(name);
        let text = error.to_string();
        assert_eq!(error.exit_status(), 2, "{text}");
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(text.contains(name), "{text:?} names the file");
        text
    }
}

/// The JSON and the binary chunk of a glTF file.
#[derive(Clone)]
pub struct Gltf {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Gltf {
    /// A triangle in the plane z = 0 with normals, 16-bit indices, a material, a node and a camera.
    ///
    /// Accessors: 0 positions, 1 normals, 2 indices. Nodes: 0 "root" has the mesh, 1 the camera.
    pub fn triangle() -> Self {
        let mut file = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0, 1] }],
                "nodes": [
                    { "name": "root", "mesh": 0 },
                    { "name": "eye", "camera": 0, "translation": [0, 0, 5] },
                ],
                "cameras": [{
                    "type": "perspective",
                    "perspective": { "yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1 },
                }],
                "materials": [{ "name": "paint" }],
                "meshes": [{
                    "name": "leaf",
                    "primitives": [{
                        "attributes": { "POSITION": 0, "NORMAL": 1 },
                        "indices": 2,
                        "material": 0,
                    }],
                }],
                "accessors": [],
                "bufferViews": [],
                "buffers": [{ "byteLength": 0 }],
            }),
            binary: vec![],
        };
        file.add_vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        file.add_vectors(&[[0.0, 0.0, 1.0]; 3]);
        file.add_indices(5123, &[0, 1, 2]);
        file
    }

    /// Appends bytes as a buffer view, and returns the index of the view.
    pub fn add_view(&mut self, bytes: &[u8]) -> usize {
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({
            "buffer": 0,
            "byteOffset": self.binary.len(),
            "byteLength": bytes.len(),
        }));
        let index = views.len() - 1;
        self.binary.extend_from_slice(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.json["buffers"][0]["byteLength"] = self.binary.len().into();
        index
    }

    /// Appends an accessor, and returns its index.
    pub fn add_accessor(&mut self, accessor: Value) -> usize {
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    pub fn add_vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let view = self.add_view(&floats(vectors));
        self.add_accessor(json!({
            "bufferView": view, "componentType": 5126, "count": vectors.len(), "type": "VEC3",
        }))
    }

    pub fn add_indices(&mut self, component: u32, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices
            .iter()
            .flat_map(|i| {
                let size = [1, 2, 4][match component {
                    5121 => 0,
                    5123 => 1,
                    _ => 2,
                }];
                i.to_le_bytes().into_iter().take(size)
            })
            .collect();
        let view = self.add_view(&bytes);
        self.add_accessor(json!({
            "bufferView": view, "componentType": component, "count": indices.len(),
            "type": "SCALAR",
        }))
    }

    /// A copy of the file with a change of its JSON.
    pub fn with(&self, change: impl FnOnce(&mut Value)) -> Self {
        let mut file = self.clone();
        change(&mut file.json);
        file
    }

    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// The file as binary glTF (`.glb`).
    pub fn glb(&self) -> Vec<u8> {
        glb(self.json.to_string().as_bytes(), &self.binary)
    }

    /// The JSON file (`.gltf`), whose buffer is the file at `uri`.
    pub fn with_uri(&self, uri: &str) -> String {
        let file = self.with(|json| json["buffers"][0]["uri"] = uri.into());
        file.json.to_string()
    }
}

pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    let word = |file: &mut Vec<u8>, word: usize| file.extend((word as u32).to_le_bytes());
    word(&mut file, 2);
    word(&mut file, 12 + 8 + json.len() + 8 + binary.len());
    word(&mut file, json.len());
    file.extend(b"JSON");
    file.extend(json);
    word(&mut file, binary.len());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

pub fn floats(vectors: &[[f32; 3]]) -> Vec<u8> {
    vectors
        .as_flattened()
        .iter()
        .flat_map(|f| f.to_le_bytes())
        .collect()
}

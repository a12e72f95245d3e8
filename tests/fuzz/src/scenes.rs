//! Scenes of the corpus: each feature of glTF and of OBJ at least once.

use crate::Files;
use headwater::procedural;
use headwater::scene_files::export;
use headwater_fuzz::files::{Gltf, floats};
use headwater_fuzz::images;
use serde_json::{Value, json};

/// The largest procedural scene of the corpus, in bytes: mutations of larger ones are slow.
const LARGEST: usize = 1 << 15;

/// `.gltf` files.
pub fn gltf() -> Files {
    let mut files: Files = (features().iter())
        .map(|(name, file)| (format!("{name}.gltf"), images::in_one(file).into()))
        .collect();
    for (name, uri) in [
        ("beside", "wall.png"),
        ("outside", "../wall.png"),
        ("lost", "lost.png"),
    ] {
        files.push((format!("{name}.gltf"), images::shown(uri).into()));
    }
    let inside = images::shown(&format!("data:image/png;base64,{}", images::small_png()));
    files.push(("data-image.gltf".into(), inside.into()));
    let external = Gltf::triangle().with_uri("triangle.bin");
    files.push(("external.gltf".into(), external.into()));
    files
}

/// `.glb` files: those of [`gltf`], and the procedural scenes that are small.
pub fn glb() -> headwater::Result<Files> {
    let mut files: Files = (features().into_iter())
        .map(|(name, file)| (format!("{name}.glb"), file.glb()))
        .collect();
    files.push(("chunks.glb".into(), with_another_chunk(&Gltf::triangle())));
    let folder = tempfile::tempdir().map_err(|e| headwater::Error::failed(e.to_string()))?;
    for name in [
        "cornell",
        "cornell-glossy",
        "furnace",
        "two-rooms",
        "motion",
        "conservatory",
    ] {
        let path = folder.path().join("scene.glb");
        export::write_glb(&procedural::generate(name, &[])?, &path)?;
        let bytes = std::fs::read(&path).map_err(|e| headwater::Error::reading(&path, e))?;
        if bytes.len() <= LARGEST {
            files.push((format!("{name}.glb"), bytes));
        }
    }
    Ok(files)
}

/// A `.glb` file with a chunk of an unknown type between its JSON and its bytes.
fn with_another_chunk(file: &Gltf) -> Vec<u8> {
    let bytes = file.glb();
    let json = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let (before, after) = bytes.split_at(20 + json);
    let mut bytes = [before, b"\x04\0\0\0WHATmore", after].concat();
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    bytes
}

fn push(list: &mut Value, item: Value) {
    match list {
        Value::Array(items) => items.push(item),
        _ => *list = json!([item]),
    }
}

/// An accessor of integers or floats, given by their bytes.
fn accessor(file: &mut Gltf, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
    let view = file.add_view(bytes);
    file.add_accessor(json!({
        "bufferView": view, "componentType": component, "count": count, "type": kind,
    }))
}

fn float_bytes(numbers: &[f32]) -> Vec<u8> {
    numbers
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect()
}

/// A triangle with texture coordinates, tangents and images in buffer views.
fn textured() -> Gltf {
    let mut file = Gltf::triangle();
    let coordinates = float_bytes(&[0.0, 0.0, 1.0, 0.0, 0.0, 2.0]);
    let first = accessor(&mut file, &coordinates, 5126, "VEC2", 3);
    let second = accessor(&mut file, &[0, 0, 255, 0, 51, 255], 5121, "VEC2", 3);
    let tangents = float_bytes(&[1.0, 0.0, 0.0, 1.0].repeat(3));
    let tangents = accessor(&mut file, &tangents, 5126, "VEC4", 3);
    let attributes = &mut file.primitive()["attributes"];
    attributes["TEXCOORD_0"] = first.into();
    attributes["TEXCOORD_1"] = second.into();
    attributes["TANGENT"] = tangents.into();
    for (name, bytes) in images::textures() {
        let wanted = ["rgb8.png", "rgb8.jpg", "rgba8.webp"];
        if wanted.contains(&name.as_str()) {
            let view = file.add_view(&bytes);
            push(
                &mut file.json["images"],
                json!({ "bufferView": view, "name": name }),
            );
        }
    }
    file.with(|json| {
        json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }, {}]);
        json["textures"] = json!([
            { "source": 0, "sampler": 0 },
            { "source": 1 },
            { "source": 0, "extensions": { "EXT_texture_webp": { "source": 2 } } },
        ]);
        json["extensionsUsed"] = json!(["EXT_texture_webp", "KHR_texture_transform", "other"]);
        json["materials"][0] = json!({
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.5, 0.5, 0.9],
                "baseColorTexture": { "index": 0, "extensions": { "KHR_texture_transform": {
                    "offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3], "texCoord": 1,
                } } },
                "metallicRoughnessTexture": { "index": 1, "texCoord": 1 },
            },
            "normalTexture": { "index": 2, "scale": 0.5 },
            "occlusionTexture": { "index": 1 },
            "emissiveTexture": { "index": 1 },
            "emissiveFactor": [1, 0.5, 0],
            "alphaMode": "MASK",
            "alphaCutoff": 0.4,
            "doubleSided": true,
        });
    })
}

/// A moving node with one channel for each path and interpolation.
fn moving() -> Gltf {
    let mut file = Gltf::triangle();
    let times = accessor(&mut file, &float_bytes(&[0.5, 1.0]), 5126, "SCALAR", 2);
    let vectors = accessor(&mut file, &float_bytes(&[0.5; 6]), 5126, "VEC3", 2);
    let spline = accessor(&mut file, &float_bytes(&[0.5; 18]), 5126, "VEC3", 6);
    let turns = float_bytes(&[0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
    let turns = accessor(&mut file, &turns, 5126, "VEC4", 2);
    let numbers = accessor(&mut file, &float_bytes(&[1.0, 2.0]), 5126, "SCALAR", 2);
    let bytes = [0, 0, 0, 127, 0, 127, 0, 0];
    let small_turns = accessor(&mut file, &bytes, 5120, "VEC4", 2);
    file.json["accessors"][small_turns]["normalized"] = true.into();
    let sampler = |output: usize, interpolation: &str| json!({ "input": times, "output": output, "interpolation": interpolation });
    let node = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    let pointer = |sampler: usize, pointer: &str| {
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        json!({ "sampler": sampler, "target": { "path": "pointer", "extensions": extensions } })
    };
    let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
    file.json["animations"] = json!([{
        "samplers": [
            sampler(vectors, "LINEAR"), sampler(spline, "CUBICSPLINE"), sampler(turns, "STEP"),
            sampler(numbers, "LINEAR"), sampler(small_turns, "LINEAR"),
        ],
        "channels": [
            node(0, 0, "translation"), node(2, 0, "rotation"), node(0, 0, "scale"), node(1, 1, "translation"),
            node(4, 1, "rotation"), node(0, 1, "weights"), node(1, 0, "translation"),
            pointer(0, "/materials/0/emissiveFactor"), pointer(3, strength), pointer(1, "/nodes/1/scale"),
        ],
    }]);
    file.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    file
}

/// Lights of each kind, factors of each extension, cameras of both kinds, and a tree of nodes.
fn lit() -> Gltf {
    Gltf::triangle().with(|json| {
        json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 5, "range": 10 },
            { "type": "directional", "color": [1, 0.5, 0] },
            { "type": "spot", "name": "s", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.5 } },
        ] } });
        for light in 0..3 {
            let extensions = json!({ "KHR_lights_punctual": { "light": light } });
            push(&mut json["nodes"], json!({ "rotation": [0, 0.6, 0, 0.8], "extensions": extensions }));
        }
        json["nodes"][0]["children"] = json!([2, 3]);
        json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1]);
        json["nodes"][2]["children"] = json!([4]);
        json["nodes"][4]["mesh"] = 0.into();
        json["nodes"][3]["camera"] = 1.into();
        push(&mut json["cameras"], json!({ "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 1 } }));
        json["materials"] = json!([
            { "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 5 },
                "KHR_materials_ior": { "ior": 1.3 },
                "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 2, 3] },
            }, "emissiveFactor": [1, 1, 1] },
            { "alphaMode": "BLEND", "extensions": { "KHR_materials_unlit": {} } },
        ]);
        let mut unlit = json["meshes"][0]["primitives"][0].clone();
        unlit["material"] = 1.into();
        push(&mut json["meshes"][0]["primitives"], unlit);
    })
}

/// Sparse accessors, strips and fans, colours, quantized attributes, strides, primitives without a material.
fn packed() -> Gltf {
    let mut file = Gltf::triangle();
    let indices = file.add_view(&[0, 2]);
    let values = file.add_view(&floats(&[[0.0, 0.0, 1.0], [0.0, 2.0, 1.0]]));
    file.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let strip = file.add_indices(5121, &[0, 1, 2, 1]);
    let fan = file.add_indices(5125, &[0, 1, 2, 0]);
    let shorts: Vec<u8> = [0_i16, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let view = file.add_view(&shorts);
    file.json["bufferViews"][view]["byteStride"] = 8.into();
    let short_positions = file.add_accessor(json!({
        "bufferView": view, "componentType": 5122, "count": 3, "type": "VEC3",
    }));
    let colors = accessor(&mut file, &[255, 0, 128, 255].repeat(3), 5121, "VEC4", 3);
    file.json["accessors"][colors]["normalized"] = true.into();
    let float_colors = accessor(&mut file, &floats(&[[0.5; 3]; 3]), 5126, "VEC3", 3);
    let zeros = file.add_accessor(json!({ "componentType": 5126, "count": 3, "type": "VEC3" }));
    let primitives = &mut file.json["meshes"][0]["primitives"];
    for primitive in [
        json!({ "attributes": { "POSITION": 0, "COLOR_0": colors }, "indices": strip, "mode": 5 }),
        json!({ "attributes": { "POSITION": 0, "COLOR_0": float_colors }, "indices": fan, "mode": 6 }),
        json!({ "attributes": { "POSITION": short_positions, "NORMAL": zeros }, "targets": [{}] }),
        json!({ "attributes": { "POSITION": zeros } }),
        json!({ "attributes": { "NORMAL": 1 } }),
        json!({ "attributes": { "POSITION": 0 }, "mode": 1 }),
    ] {
        push(primitives, primitive);
    }
    file
}

/// A triangle with texture coordinates, an image and a normal map, but without tangents.
fn without_tangents() -> Gltf {
    let mut file = Gltf::triangle();
    let coordinates = float_bytes(&[0.0, 0.0, 1.0, 0.0, 0.0, 2.0]);
    let coordinates = accessor(&mut file, &coordinates, 5126, "VEC2", 3);
    file.primitive()["attributes"]["TEXCOORD_0"] = coordinates.into();
    file.with(|json| {
        json["images"] = json!([{ "uri": "wall.png" }]);
        json["textures"] = json!([{ "source": 0 }]);
        json["materials"][0]["normalTexture"] = json!({ "index": 0 });
    })
}

/// Two triangles that share vertices without normals, 16-bit texture coordinates, colours, joints and weights.
fn shared() -> Gltf {
    let mut file = Gltf::triangle();
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.5],
        [0.0, 1.0, 0.0],
    ];
    let positions = file.add_vectors(&corners);
    let indices = file.add_indices(5123, &[0, 1, 2, 0, 2, 3]);
    let words = |words: &[u16]| -> Vec<u8> { words.iter().flat_map(|w| w.to_le_bytes()).collect() };
    let coordinates = words(&[0, 0, 65535, 0, 65535, 65535, 0, 65535]);
    let coordinates = accessor(&mut file, &coordinates, 5123, "VEC2", 4);
    let colors = words(&[65535, 0, 9000, 65535].repeat(4));
    let colors = accessor(&mut file, &colors, 5123, "VEC4", 4);
    let joints = accessor(&mut file, &words(&[0; 16]), 5123, "VEC4", 4);
    let weights = accessor(
        &mut file,
        &words(&[65535, 0, 0, 0].repeat(4)),
        5123,
        "VEC4",
        4,
    );
    for normalized in [coordinates, colors, weights] {
        file.json["accessors"][normalized]["normalized"] = true.into();
    }
    file.primitive()["attributes"] = json!({
        "POSITION": positions, "TEXCOORD_0": coordinates, "COLOR_0": colors, "JOINTS_0": joints, "WEIGHTS_0": weights,
    });
    file.primitive()["indices"] = indices.into();
    file.with(|json| {
        json["skins"] = json!([{ "joints": [0] }]);
        json["nodes"][0]["skin"] = 0.into();
    })
}

/// Textures of specular lobes, an unknown alpha mode, and a KTX2 texture without another source.
fn other_textures() -> Gltf {
    without_tangents().with(|json| {
        json["textures"] = json!([
            { "source": 0 },
            { "extensions": { "KHR_texture_basisu": { "source": 1 } } },
        ]);
        push(
            &mut json["images"],
            json!({ "uri": "wall.ktx2", "mimeType": "image/ktx2" }),
        );
        json["extensionsUsed"] = json!(["KHR_texture_basisu", "KHR_materials_specular"]);
        json["materials"][0] = json!({
            "alphaMode": "GLASS",
            "extensions": { "KHR_materials_specular": {
                "specularTexture": { "index": 0 }, "specularColorTexture": { "index": 0 },
            } },
        });
        push(
            &mut json["materials"],
            json!({ "emissiveTexture": { "index": 1 } }),
        );
    })
}

/// A mesh that Draco has compressed to `stream`.
fn draco(stream: &[u8]) -> Gltf {
    let mut file = Gltf::triangle();
    let view = file.add_view(stream);
    for accessor in [0, 1] {
        file.json["accessors"][accessor] =
            json!({ "componentType": 5126, "count": 20, "type": "VEC3" });
    }
    file.json["accessors"][2] = json!({ "componentType": 5123, "count": 72, "type": "SCALAR" });
    file.primitive()["extensions"] = json!({ "KHR_draco_mesh_compression": {
        "bufferView": view, "attributes": { "POSITION": 3, "NORMAL": 2 },
    } });
    file.with(|json| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]))
}

/// A mesh whose normals and indices meshoptimizer has compressed: three octahedral normals, and one triangle.
fn meshopt() -> Gltf {
    let mut file = Gltf::triangle();
    let mut normals = [0; 37];
    (normals[0], normals[35]) = (0xA0, 127);
    let indices = [0xD1, 0, 4, 4, 0, 0, 0, 0];
    let compressions = [
        (1, normals.to_vec(), "ATTRIBUTES", "OCTAHEDRAL", 4),
        (2, indices.to_vec(), "INDICES", "NONE", 2),
    ];
    for (accessor, bytes, mode, filter, stride) in compressions {
        let view = file.add_view(&bytes);
        file.json["bufferViews"][view]["extensions"] = json!({ "EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": file.json["bufferViews"][view]["byteOffset"],
            "byteLength": bytes.len(), "byteStride": stride, "count": 3,
            "mode": mode, "filter": filter,
        } });
        file.json["bufferViews"][view]["buffer"] = 1.into();
        if mode == "ATTRIBUTES" {
            file.json["bufferViews"][view]["byteStride"] = stride.into();
        }
        file.json["accessors"][accessor]["bufferView"] = view.into();
    }
    file.json["accessors"][1]["componentType"] = 5120.into();
    file.json["accessors"][1]["normalized"] = true.into();
    push(
        &mut file.json["buffers"],
        json!({
            "byteLength": 64, "extensions": { "EXT_meshopt_compression": { "fallback": true } },
        }),
    );
    file.with(|json| json["extensionsRequired"] = json!(["EXT_meshopt_compression"]))
}

/// A node with a matrix that an animation moves, and a camera that is scaled to nothing.
fn odd_nodes() -> Gltf {
    moving().with(|json| {
        json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1]);
        json["nodes"][1]["scale"] = json!([0, 0, 0]);
    })
}

fn asset(asset: Value) -> Gltf {
    Gltf::triangle().with(|json| json["asset"] = asset)
}

/// Instances that move, material variants, hidden nodes, levels of detail, and a root that is a child too.
fn copied() -> Gltf {
    let mut file = moving();
    let places = file.add_vectors(&[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    file.with(|json| {
        json["extensions"] = json!({ "KHR_materials_variants": {
            "variants": [{ "name": "a" }, { "name": "b" }],
        } });
        json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": {
            "mappings": [{ "material": 0, "variants": [0] }],
        } });
        json["nodes"][0]["extensions"] = json!({
            "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places, "SCALE": places } },
            "MSFT_lod": { "ids": [1] },
        });
        let extensions = json!({ "KHR_node_visibility": { "visible": false } });
        push(
            &mut json["nodes"],
            json!({ "mesh": 0, "extensions": extensions }),
        );
        let last = json["nodes"].as_array().map_or(0, Vec::len) - 1;
        json["nodes"][1]["children"] = json!([last]);
        push(&mut json["scenes"][0]["nodes"], last.into());
    })
}

fn features() -> Vec<(&'static str, Gltf)> {
    vec![
        ("plain", Gltf::triangle()),
        ("textured", textured()),
        ("moving", moving()),
        ("lit", lit()),
        ("packed", packed()),
        ("without-tangents", without_tangents()),
        ("shared", shared()),
        ("other-textures", other_textures()),
        (
            "draco-high",
            draco(include_bytes!("../../loading/compression/high.drc")),
        ),
        (
            "draco-low",
            draco(include_bytes!("../../loading/compression/low.drc")),
        ),
        (
            "draco-sequential",
            draco(include_bytes!("../../loading/compression/sequential.drc")),
        ),
        ("meshopt", meshopt()),
        ("odd-nodes", odd_nodes()),
        ("copied", copied()),
        ("old", asset(json!({ "version": "1.0" }))),
        (
            "minimum",
            asset(json!({ "version": "2.0", "minVersion": "2.1" })),
        ),
        (
            "required",
            Gltf::triangle().with(|json| {
                json["extensionsRequired"] = json!(["KHR_materials_sheen"]);
            }),
        ),
        (
            "no-scenes",
            Gltf::triangle().with(|json| {
                let fields = json.as_object_mut().expect("an object");
                fields.remove("scene");
                fields.remove("scenes");
            }),
        ),
    ]
}

/// `.obj` files, each its own material library.
pub fn obj() -> Files {
    let polygons = "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv .2 .1 0\nv 0 1 0 1 0 0\nvn 0 0 1\ns 1\n\
        f 1//1 2//1 3//1 4//1 -1//1\nfo 1 2 3\ng b\nf -1 -2 -3\nl 1 2\np 1\ncurv 0 1 1 2\nusemtl none\nf 1 2 4\n";
    let materials = "mtllib scene.obj\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
        usemtl x\nf 1/1/1 2/2/1 3/3/1\nusemtl y\nf 1/1 2/2 4/3\nusemtl z\nf 1 3 4\nusemtl x\nf 2/1 3/2 4/3\n\
        newmtl x\nKd 1 .5 0\nKe 0 0 1\nPr .5\nPm 1\nmap_Kd wall.png\nmap_Ke -clamp on wall.jpg\nmap_Bump b.png\n\
        newmtl y\nmap_Kd -s 2 3 1 -o .1 .2 0 -t 0 0 0 -mm 0 1 -bm 1 -boost 0 small.webp\nmap_Pr -imfchan r wall.png\n\
        map_Pm wall.png\nnorm -blendu on -cc off -texres 4 -type sphere wall.png\nd -halo .5\nTr .5\n\
        newmtl z\nKd .5\nPr 0\nd 1\nmap_Pm wall.jpg\n";
    let lines = "# head\nmtllib scene.obj lost.mtl\r\nv 0 0 \\\n 0 # x\nv 1 0 0\nv 0 1 0\no na\u{ef}ve\nf 1 2 3\n";
    let names = "mtllib my scene.mtl\nmtllib scene.obj\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
        usemtl lost\nf 1/1 2/2 3/3\nusemtl sizes\nf 1/1 3/3 2/2\nnewmtl lost\nmap_Kd lost.png\n\
        newmtl sizes\nmap_Pr wall.png\nmap_Pm small.webp\n";
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    let mut kinds = format!("mtllib scene.obj\n{corners}usemtl k\nf 1/1 2/2 3/3\nnewmtl k\n");
    // More kinds of textures than a notice lists.
    for kind in 0..20 {
        kinds += &format!("map_{kind} wall.png\n");
    }
    // Vertex colours, smoothing groups, opacity from images of several sizes, and what is written otherwise or wrongly.
    let tolerated = "V 0 0 0 255 0 9\nv 1 0 0 1 2 3\nv 0 1 0 9 9 9 9\nv 1 1 1\nvn nan 0 0\nvt nan\nvt 1 0\nvt 0 1\ns 1\n\
        usemtl Material #1\nf 1/1/1 2/2 3/3\nf 2/1 3/2 4/3\ns 2\no next\nusemtl B\nf 1/1 3/2 4/3\ns off\nusemtl c\n\
        f 4/1 2/2 1/3\nmtllib SCENE.OBJ\nNEWMTL Material #1\nKd x\nKe -1 2 1e30\nd 0\nTr 0\nmap_d wall.png\nmap_Kd small.webp\n\
        newmtl b\nd 0\nmap_d small.webp\nmap_Kd small.webp\nmap_Bump -bm 2 normal.png\nPc 1\n\
        newmtl c\nmap_d wall.jpg\nmap_Kd textures\nPr 2\n# end \\\nfoo 1\n";
    let mut latin = lines.as_bytes().to_vec();
    latin.extend(b"g caf\xe9\nf 3 2 1\n");
    vec![
        ("polygons.obj".into(), polygons.into()),
        ("materials.obj".into(), materials.into()),
        ("lines.obj".into(), lines.into()),
        ("latin.obj".into(), latin),
        ("names.obj".into(), names.into()),
        ("kinds.obj".into(), kinds.into()),
        ("tolerated.obj".into(), tolerated.into()),
    ]
}

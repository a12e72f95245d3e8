//! Tests of skins and morph targets in glTF files: posed vertices equal an f64 twin of glTF's formulas, and wrong values are
//! scaled with a notice or refused.

use crate::files::{Folder, Gltf, floats};
use glam::{DAffine3, DMat4, DQuat, DVec3, Vec3};
use headwater::scene::Scene;
use serde_json::{Value, json};

fn load(file: &Gltf) -> Scene {
    Folder::new().load("scene.glb", file.glb())
}

fn add_floats(file: &mut Gltf, kind: &str, components: usize, numbers: &[f32]) -> usize {
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let view = file.add_view(&bytes);
    file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": numbers.len() / components, "type": kind,
    }))
}

const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// The weights of the second joint at the corners, in bytes; the first joint has the rest.
const SECOND: [u8; 3] = [0, 51, 255];

fn bind() -> [DAffine3; 2] {
    [
        DAffine3::from_translation(DVec3::new(0.5, 0.0, 0.25)),
        DAffine3::from_scale_rotation_translation(
            DVec3::new(2.0, 1.0, 0.5),
            DQuat::from_rotation_y(0.5),
            DVec3::new(0.0, -0.5, 0.0),
        ),
    ]
}

/// The triangle with a skin of two joints: node 2, which is scaled by `scale` along x, and its child, node 3. The node of the
/// mesh has a transform of its own, which has no effect.
fn skinned(scale: f64) -> Gltf {
    let mut file = Gltf::triangle();
    let matrices: Vec<f32> = bind()
        .iter()
        .flat_map(|m| DMat4::from(*m).to_cols_array())
        .map(|v| v as f32)
        .collect();
    let matrices = add_floats(&mut file, "MAT4", 16, &matrices);
    let view = file.add_view(&[0, 1, 0, 0].repeat(3));
    let joints = file.add_accessor(json!({
        "bufferView": view, "componentType": 5121, "count": 3, "type": "VEC4",
    }));
    let weights: Vec<u8> = SECOND.iter().flat_map(|w| [255 - w, *w, 0, 0]).collect();
    let view = file.add_view(&weights);
    let weights = file.add_accessor(json!({
        "bufferView": view, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4",
    }));
    file.primitive()["attributes"]["JOINTS_0"] = joints.into();
    file.primitive()["attributes"]["WEIGHTS_0"] = weights.into();
    file.json["skins"] =
        json!([{ "name": "body", "joints": [2, 3], "inverseBindMatrices": matrices }]);
    let nodes = file.json["nodes"].as_array_mut().unwrap();
    nodes[0]["skin"] = 0.into();
    nodes[0]["translation"] = json!([9, 9, 9]);
    nodes.push(
        json!({ "name": "hip", "translation": [1, 2, 3], "scale": [scale, 1, 1], "children": [3] }),
    );
    nodes.push(json!({ "name": "knee", "translation": [0, 1, 0] }));
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    file
}

/// The corners in the world, with the knee turned around z by `angle`, by glTF's formula.
fn twin(scale: f64, angle: f64) -> [DVec3; 3] {
    let hip = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0))
        * DAffine3::from_scale(DVec3::new(scale, 1.0, 1.0));
    let knee = hip * DAffine3::from_translation(DVec3::Y) * DAffine3::from_rotation_z(angle);
    let [first, second] = [hip * bind()[0], knee * bind()[1]];
    let mut corners = CORNERS;
    for (corner, weight) in corners.iter_mut().zip(SECOND) {
        let weight = f64::from(weight) / 255.0;
        *corner = first.transform_point3(*corner) * (1.0 - weight)
            + second.transform_point3(*corner) * weight;
    }
    corners
}

/// The corners of the only triangle in the world, and its normal at the first corner.
fn shown(scene: &Scene) -> ([DVec3; 3], DVec3) {
    let instance = &scene.instances[0];
    let mesh = &scene.meshes[instance.mesh as usize];
    let corners = mesh.triangles[0].map(|i| {
        let corner = mesh.positions[i as usize].as_dvec3();
        instance.object_to_world.transform_point3(corner)
    });
    let to_world = instance.object_to_world.matrix3.inverse().transpose();
    let normal = mesh.normals[mesh.triangles[0][0] as usize].as_dvec3();
    (corners, (to_world * normal).normalize())
}

fn assert_near(found: [DVec3; 3], expected: [DVec3; 3]) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(
            (found - expected).length() < 2e-6,
            "{found} is not {expected}"
        );
    }
}

/// Without an animation the mesh has its posed shape, and nothing moves. A joint that mirrors keeps the front and the outside.
#[test]
fn a_skin_poses_its_mesh() {
    for scale in [1.0, -2.0] {
        let scene = load(&skinned(scale));
        assert!(scene.notices.is_empty() && scene.motion.is_none());
        let (corners, normal) = shown(&scene);
        assert_near(corners, twin(scale, 0.0));
        let [a, b, c] = corners;
        let side = scene.instances[0]
            .object_to_world
            .matrix3
            .determinant()
            .signum();
        let front = (b - a).cross(c - a).normalize() * side;
        assert_eq!(side, scale.signum());
        assert!(
            front.z > 0.1 && normal.dot(front) > 0.5,
            "{scale}: {front}, {normal}"
        );
    }
}

#[test]
fn a_skin_follows_its_joints() {
    let mut file = skinned(1.0);
    let times = add_floats(&mut file, "SCALAR", 1, &[0.0, 2.0]);
    let half = 0.6_f32;
    let turn = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.sin(), half.cos()];
    let values = add_floats(&mut file, "VEC4", 4, &turn);
    file.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": values }],
        "channels": [{ "sampler": 0, "target": { "node": 3, "path": "rotation" } }],
    }]);
    let scene = load(&file);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    assert_near(shown(&scene).0, twin(1.0, 0.0));
    for (time, angle) in [(1.0, 0.6), (2.0, 1.2), (5.0, 1.2)] {
        assert_near(shown(&scene.pose_at(time).unwrap()).0, twin(1.0, angle));
    }
}

/// A triangle with two morph targets: a dense one, and a sparse one that moves one corner only.
fn morphed() -> Gltf {
    let mut file = Gltf::triangle();
    let dense = file.add_vectors(&[[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 3.0]]);
    let tilt = file.add_vectors(&[[1.0, 0.0, 0.0]; 3]);
    let indices = file.add_view(&[2, 0, 0, 0]);
    let values = file.add_view(&floats(&[[5.0, 0.0, 0.0]]));
    let sparse = file.add_accessor(json!({
        "componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": { "bufferView": indices, "componentType": 5121 },
            "values": { "bufferView": values },
        },
    }));
    file.primitive()["targets"] =
        json!([{ "POSITION": dense, "NORMAL": tilt }, { "POSITION": sparse }]);
    file.json["meshes"][0]["weights"] = json!([0.5, 0.0]);
    file
}

fn morph_twin([a, b]: [f64; 2]) -> [DVec3; 3] {
    let mut corners = CORNERS;
    for (corner, offset) in corners.iter_mut().zip([1.0, 2.0, 3.0]) {
        *corner += a * offset * DVec3::Z;
    }
    corners[2] += b * 5.0 * DVec3::X;
    corners
}

#[test]
fn morph_targets_have_the_weights_of_mesh_or_node() {
    let scene = load(&morphed());
    assert!(scene.notices.is_empty() && scene.motion.is_none());
    let (corners, normal) = shown(&scene);
    assert_near(corners, morph_twin([0.5, 0.0]));
    assert!((normal - DVec3::new(0.5, 0.0, 1.0).normalize()).length() < 1e-6);
    let of_node = morphed().with(|json| json["nodes"][0]["weights"] = json!([0.0, -1.0]));
    assert_near(shown(&load(&of_node)).0, morph_twin([0.0, -1.0]));
}

#[test]
fn weights_are_animated_by_all_interpolations() {
    let weights = |interpolation: &str, values: &[f32]| {
        let mut file = morphed();
        let times = add_floats(&mut file, "SCALAR", 1, &[0.0, 2.0]);
        let values = add_floats(&mut file, "SCALAR", 1, values);
        file.json["animations"] = json!([{
            "samplers": [{ "input": times, "output": values, "interpolation": interpolation }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        }]);
        let scene = load(&file);
        assert!(scene.notices.is_empty(), "{:?}", scene.notices);
        scene
    };
    let keys = [0.0, 1.0, 1.0, 3.0];
    let at = |scene: &Scene, time: f64| shown(&scene.pose_at(time).unwrap()).0;
    let linear = weights("LINEAR", &keys);
    assert_near(shown(&linear).0, morph_twin([0.0, 1.0]));
    assert_near(at(&linear, 0.5), morph_twin([0.25, 1.5]));
    let step = weights("STEP", &keys);
    assert_near(at(&step, 1.9), morph_twin([0.0, 1.0]));
    assert_near(at(&step, 2.0), morph_twin([1.0, 3.0]));
    // For each key the incoming slopes, the values and the outgoing slopes of both targets.
    let spline = [0.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0, 3.0, 0.0, 0.0];
    let spline = weights("CUBICSPLINE", &spline);
    // h10(1/2) · length · slope = 1/8 · 2 · 2.
    assert_near(at(&spline, 1.0), morph_twin([0.5 + 0.5, 2.0]));
}

#[test]
fn weights_that_do_not_sum_to_1_are_scaled() {
    let mut file = skinned(1.0);
    let weights = [
        [0.5, 0.0, 0.0, 0.0],
        [0.4, 0.1, 0.0, 0.0],
        [0.0, 3.0, 0.0, 0.0],
    ];
    let weights = add_floats(&mut file, "VEC4", 4, weights.as_flattened());
    file.primitive()["attributes"]["WEIGHTS_0"] = weights.into();
    let scene = load(&file);
    assert_near(shown(&scene).0, twin(1.0, 0.0));
    let text = "weights of joints that do not sum to 1 are scaled: 3 times, first mesh 0 \"leaf\" primitive 0";
    assert_eq!(scene.notices, [text]);
}

#[test]
fn faults_of_deformations_are_named() {
    let refused = |file: Gltf, expected: &str| {
        let text = Folder::new().refuse("scene.glb", file.glb());
        assert!(
            text.contains(expected),
            "{text:?} does not say {expected:?}"
        );
    };
    let with = |change: &dyn Fn(&mut Value)| skinned(1.0).with(change);
    refused(
        with(&|json| json["nodes"][0]["skin"] = 7.into()),
        "skin 7 is out of range",
    );
    refused(
        with(&|json| json["skins"][0]["joints"] = json!([2])),
        "vertex 1 has the joint 1, but its skin has 1",
    );
    refused(
        with(&|json| json["skins"][0]["joints"] = json!([])),
        "skin 0 \"body\": it has no joints",
    );
    refused(
        with(&|json| json["skins"][0]["joints"] = json!([2, 9])),
        "its joint 1, node 9, is not in the scene",
    );
    refused(
        with(&|json| json["skins"][0]["joints"] = json!([2, 3, 3])),
        "does not have a matrix for each of the 3 joints",
    );
    let mut file = skinned(1.0);
    let flat = add_floats(&mut file, "MAT4", 16, &[0.0; 32]);
    file.json["skins"][0]["inverseBindMatrices"] = flat.into();
    let notices = load(&file).notices;
    assert!(
        notices[0].starts_with("inverse bind matrices without an inverse"),
        "{notices:?}"
    );
    let with = |change: &dyn Fn(&mut Value)| morphed().with(change);
    refused(
        with(&|json| json["meshes"][0]["weights"] = json!([1.0])),
        "has 1 weights for 2 morph targets",
    );
    refused(
        with(&|json| json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = 2.into()),
        "POSITION of target 0 of mesh 0",
    );
    let mut file = morphed();
    let short = file.add_vectors(&[[0.0, 0.0, 1.0]]);
    file.primitive()["targets"][1]["POSITION"] = short.into();
    refused(file, "has 1 elements for 3 positions");
    let primitives = with(&|json| {
        let mut second = json["meshes"][0]["primitives"][0].clone();
        second["targets"] = json!([]);
        json["meshes"][0]["primitives"]
            .as_array_mut()
            .unwrap()
            .push(second);
    });
    refused(
        primitives,
        "has 0 morph targets, but the first primitive of its mesh has 2",
    );
}

/// A mesh keeps its shape where all weights are 0 and none is animated; such nodes share it.
#[test]
fn targets_without_weight_change_nothing() {
    let file = morphed().with(|json| {
        json["meshes"][0]["weights"] = json!([0, 0]);
        json["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "mesh": 0 }));
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    });
    let scene = load(&file);
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    assert_eq!(scene.meshes[0].positions[1], Vec3::X);
}

/// A mesh that no instance shows has no deformation: here its node is flat. The deformation of the skin is then the first.
#[test]
fn deformations_of_flat_nodes_are_left_out() {
    let mut file = skinned(1.0);
    let up = file.add_vectors(&[[0.0, 0.0, 1.0]; 3]);
    let times = add_floats(&mut file, "SCALAR", 1, &[0.0, 2.0]);
    let weights = add_floats(&mut file, "SCALAR", 1, &[0.0, 1.0]);
    let half = 0.6_f32;
    let turn = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.sin(), half.cos()];
    let turns = add_floats(&mut file, "VEC4", 4, &turn);
    file.json["meshes"].as_array_mut().unwrap().push(json!({
        "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0,
            "targets": [{ "POSITION": up }],
        }],
    }));
    let nodes = file.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "flat", "mesh": 1, "scale": [0, 0, 0] }));
    // The flat node comes before that of the skin.
    file.json["scenes"][0]["nodes"] = json!([4, 0, 1, 2]);
    file.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": weights }, { "input": times, "output": turns }],
        "channels": [
            { "sampler": 0, "target": { "node": 4, "path": "weights" } },
            { "sampler": 1, "target": { "node": 3, "path": "rotation" } },
        ],
    }]);
    let mut scene = load(&file);
    assert_eq!((scene.meshes.len(), scene.instances.len()), (2, 1));
    let motion = scene.motion.as_ref().unwrap();
    let deforming: Vec<u32> = motion.deformations.iter().map(|d| d.mesh).collect();
    assert_eq!(deforming, [scene.instances[0].mesh]);
    assert_near(shown(&scene.pose_at(1.0).unwrap()).0, twin(1.0, 0.6));
    let before = scene.content_hash();
    scene.validate().unwrap();
    assert_eq!(scene.content_hash(), before);
}

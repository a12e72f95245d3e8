//! Writes the motion of a scene as glTF nodes and a glTF animation.

use super::{Binary, FLOAT};
use crate::scene::motion::tracks::{Animated, Interpolation, Keyed, Track};
use crate::scene::motion::{Emission, Motion, Transform};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::{Value, json};

/// The name of the glTF extension with which an animation can change the emission of a material. A file that uses it must
/// list it among its extensions.
pub const POINTER: &str = "KHR_animation_pointer";

/// The JSON of one glTF node for each node of the motion, in the same order. The channels of the animation refer to nodes by
/// their indices in this list. The JSON of a node contains the transform that applies without the animation, and the indices
/// of the node's children in this list.
pub fn nodes(motion: &Motion) -> Vec<Value> {
    let mut nodes: Vec<Value> = motion
        .nodes
        .iter()
        .map(|node| match &node.transform {
            Transform::Fixed(transform) => json!({ "matrix": matrix(transform) }),
            Transform::Moving(moving) => json!({
                "translation": moving.translation.rest.to_array(),
                "rotation": moving.rotation.rest.to_array(),
                "scale": moving.scale.rest.to_array(),
            }),
        })
        .collect();
    for (index, node) in motion.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            add_child(&mut nodes[parent as usize], index);
        }
    }
    nodes
}

/// Adds a child to the JSON of the node `parent`, so that the child moves with it. `child` is the index of the child's node
/// in the file.
pub fn add_child(parent: &mut Value, child: usize) {
    match parent["children"].as_array_mut() {
        Some(children) => children.push(json!(child)),
        None => parent["children"] = json!([child]),
    }
}

/// A transform as the 16 numbers of a glTF matrix, column by column, for the JSON of a node.
pub fn matrix(transform: &DAffine3) -> [f64; 16] {
    DMat4::from(*transform).to_cols_array()
}

/// Writes the emission that applies without the animation into the JSON of each material with an animated emission, as a
/// colour and a strength. Programs that ignore the animation show this emission. `materials` contains the JSON of all
/// materials, in the order of the scene.
pub fn rest_emission(motion: &Motion, materials: &mut [Value]) {
    for Emission {
        material,
        color,
        strength,
    } in &motion.emission
    {
        let material = &mut materials[*material as usize];
        material["emissiveFactor"] = json!(color.rest.to_array());
        material["extensions"]["KHR_materials_emissive_strength"] =
            json!({ "emissiveStrength": strength.rest });
    }
}

/// The JSON of one animation that contains all keyframes of the motion, with one sampler and one channel for each property
/// that has keyframes. The times and values of the keyframes are appended to `binary`. Node `i` of the file must be node `i`
/// of the motion.
pub fn animation(motion: &Motion, binary: &mut Binary) -> Value {
    let mut writer = Writer {
        binary,
        samplers: Vec::new(),
        channels: Vec::new(),
    };
    let vector = |v: DVec3| v.as_vec3().to_array().to_vec();
    let quaternion = |q: DQuat| q.as_quat().to_array().to_vec();
    for (index, node) in motion.nodes.iter().enumerate() {
        if let Transform::Moving(moving) = &node.transform {
            let target = |path: &str| json!({ "node": index, "path": path });
            writer.add(&moving.translation, "VEC3", vector, target("translation"));
            writer.add(&moving.rotation, "VEC4", quaternion, target("rotation"));
            writer.add(&moving.scale, "VEC3", vector, target("scale"));
        }
    }
    for Emission {
        material,
        color,
        strength,
    } in &motion.emission
    {
        let target = |path: &str| {
            let pointer = format!("/materials/{material}/{path}");
            json!({ "path": "pointer", "extensions": { POINTER: { "pointer": pointer } } })
        };
        writer.add(color, "VEC3", vector, target("emissiveFactor"));
        let path = "extensions/KHR_materials_emissive_strength/emissiveStrength";
        writer.add(strength, "SCALAR", |v| vec![v as f32], target(path));
    }
    json!({ "channels": writer.channels, "samplers": writer.samplers })
}

struct Writer<'a> {
    binary: &'a mut Binary,
    samplers: Vec<Value>,
    channels: Vec<Value>,
}

impl Writer<'_> {
    fn add<T: Keyed>(
        &mut self,
        animated: &Animated<T>,
        kind: &str,
        numbers: impl Fn(T) -> Vec<f32>,
        target: Value,
    ) {
        let Some(track) = &animated.track else { return };
        let Track {
            interpolation,
            times,
            values,
        } = track;
        let times: Vec<f32> = times.iter().map(|&t| t as f32).collect();
        let input = json!({
            "componentType": FLOAT, "type": "SCALAR", "count": times.len(),
            "min": [times[0]], "max": [times[times.len() - 1]],
        });
        let output = json!({ "componentType": FLOAT, "type": kind, "count": values.len() });
        let values: Vec<f32> = values.iter().flat_map(|&v| numbers(v)).collect();
        self.channels
            .push(json!({ "sampler": self.samplers.len(), "target": target }));
        self.samplers.push(json!({
            "input": self.binary.push(&times, None, input),
            "output": self.binary.push(&values, None, output),
            "interpolation": match interpolation {
                Interpolation::Step => "STEP",
                Interpolation::Linear => "LINEAR",
                Interpolation::CubicSpline => "CUBICSPLINE",
            },
        }));
    }
}

//! Tests of animations in glTF files.

use crate::files::{Folder, Gltf};
use glam::{DQuat, DVec3, Vec3};
use headwater::scene::Scene;
use serde_json::{Value, json};

/// A glTF file whose node 0 is animated: its property `path` takes `values` (of the accessor type `kind`) at `times`, in
/// seconds.
pub fn animated(
    path: &str,
    kind: &str,
    interpolation: &str,
    times: &[f32],
    values: &[f32],
) -> Gltf {
    let mut file = Gltf::triangle();
    let input = add_numbers(&mut file, "SCALAR", 1, times);
    let components = match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        _ => 4,
    };
    let output = add_numbers(&mut file, kind, components, values);
    file.json["animations"] = json!([{
        "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }],
    }]);
    file
}

fn add_numbers(file: &mut Gltf, kind: &str, components: usize, numbers: &[f32]) -> usize {
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let view = file.add_view(&bytes);
    file.add_accessor(json!({
        "bufferView": view, "componentType": 5126, "count": numbers.len() / components, "type": kind,
    }))
}

fn load(file: &Gltf) -> Scene {
    Folder::new().load("scene.glb", file.glb())
}

fn moved(scene: &Scene, time: f64) -> DVec3 {
    let scene = scene.pose_at(time).unwrap();
    scene.instances[0].object_to_world.translation
}

#[test]
fn a_node_goes_through_its_keys() {
    let keys = [1.0, 0.0, 0.0, 3.0, 4.0, 0.0];
    let scene = load(&animated(
        "translation",
        "VEC3",
        "LINEAR",
        &[1.0, 2.0],
        &keys,
    ));
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let position = scene.instances[0].object_to_world.translation;
    assert_eq!(position, DVec3::X, "as at time 0");
    assert_eq!(moved(&scene, 1.5), DVec3::new(2.0, 2.0, 0.0));
    assert_eq!(moved(&scene, 9.0), DVec3::new(3.0, 4.0, 0.0));
    let step = load(&animated("translation", "VEC3", "STEP", &[1.0, 2.0], &keys));
    assert_eq!(moved(&step, 1.999), DVec3::X);
    let spline = [
        [0.0; 3],
        [0.0; 3],
        [0.0; 3], // from rest
        [0.0; 3],
        [1.0, 2.0, 3.0],
        [0.0; 3],
    ];
    let spline = spline.as_flattened();
    let spline = load(&animated(
        "translation",
        "VEC3",
        "CUBICSPLINE",
        &[0.0, 4.0],
        spline,
    ));
    assert_eq!(moved(&spline, 2.0), DVec3::new(0.5, 1.0, 1.5));
    assert_eq!(moved(&spline, 1.0), DVec3::new(1.0, 2.0, 3.0) * 0.15625);
}

/// The part of an animation from time 0 on is right, even if its keys begin earlier or several of them are at one time.
#[test]
fn keys_may_be_before_time_0_and_at_one_time() {
    let at = |x: f32| [x, 0.0, 0.0];
    let keys = [at(0.0), at(4.0), at(9.0), at(1.0)].concat();
    let before = "keys before time 0 are shown only at a negative --start-time";
    let jump = "several keys are at one time, where the value jumps to the last of them";
    let input = "animations[0].samplers[0].input";
    let load = |times: &[f32]| load(&animated("translation", "VEC3", "LINEAR", times, &keys));

    let scene = load(&[-3.0, 1.0, 1.0, 2.0]);
    assert_eq!(
        scene.notices,
        [before, jump].map(|text| format!("{text}: {input}"))
    );
    assert_eq!(
        scene.instances[0].object_to_world.translation.x, 3.0,
        "as at time 0"
    );
    for (time, x) in [(0.0, 3.0), (0.5, 3.5), (1.0, 9.0), (1.5, 5.0), (2.0, 1.0)] {
        assert_eq!(moved(&scene, time).x, x, "{time}");
    }
    let scene = load(&[-4.0, -3.0, -2.0, -1.0]);
    assert_eq!(scene.notices, [format!("{before}: {input}")]);
    assert_eq!([0.0, 5.0].map(|time| moved(&scene, time).x), [1.0; 2]);

    // A quarter turn around y from −1 s to 1 s.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn = [0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half];
    let scene = self::load(&animated("rotation", "VEC4", "LINEAR", &[-1.0, 1.0], &turn));
    let x = scene.instances[0].object_to_world.matrix3.x_axis;
    let expected = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_4) * DVec3::X;
    assert!((x - expected).length() < 1e-7, "{x}");
}

#[test]
fn children_and_cameras_follow_and_their_own_keys_add() {
    let mut file = animated(
        "rotation",
        "VEC4",
        "LINEAR",
        &[0.0, 1.0],
        &[
            0.0,
            0.0,
            0.0,
            1.0, //
            0.0,
            0.707_106_77,
            0.0,
            0.707_106_77,
        ],
    );
    file.json["nodes"] = json!([
        { "children": [1, 2], "translation": [10, 0, 0] },
        { "mesh": 0, "translation": [0, 0, 2] },
        { "camera": 0, "translation": [1, 0, 0], "scale": [2, 2, 2] },
        { "mesh": 0 },
    ]);
    file.json["scenes"] = json!([{ "nodes": [0, 3] }]);
    let times = add_numbers(&mut file, "SCALAR", 1, &[0.0, 1.0]);
    let sizes = add_numbers(&mut file, "VEC3", 3, &[1.0, 1.0, 1.0, 1.0, 3.0, 1.0]);
    let animation = json!({
        "samplers": [{ "input": times, "output": sizes }],
        "channels": [{ "sampler": 0, "target": { "node": 1, "path": "scale" } }],
    });
    file.json["animations"]
        .as_array_mut()
        .unwrap()
        .push(animation);
    let scene = load(&file);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    let motion = scene.motion.as_ref().unwrap();
    assert!(motion.moves_instance(0) && !motion.moves_instance(1));
    assert_eq!(motion.seconds(), 1.0);
    for time in [0.0, 0.3, 1.0] {
        let turn = DQuat::from_rotation_y(time * std::f64::consts::FRAC_PI_2);
        let posed = scene.pose_at(time).unwrap();
        let transform = posed.instances[0].object_to_world;
        let expected = DVec3::X * 10.0 + turn * (DVec3::Z * 2.0);
        assert!((transform.translation - expected).length() < 1e-6, "{time}");
        let up = transform.matrix3.y_axis;
        assert!(
            (up - DVec3::Y * (1.0 + 2.0 * time)).length() < 1e-6,
            "{time}"
        );
        let eye = scene.camera_at(0, time).unwrap().camera_to_world;
        assert_eq!(eye, posed.cameras[0].camera_to_world);
        assert!((eye.translation - (DVec3::X * 10.0 + turn * DVec3::X)).length() < 1e-6);
        assert!((eye.matrix3.z_axis - turn * DVec3::Z).length() < 1e-6);
        assert_eq!(posed.instances[1].object_to_world, glam::DAffine3::IDENTITY);
    }
    assert!(scene.camera_at(1, 0.0).is_err());
}

#[test]
fn normalized_integers_are_numbers() {
    let turn = |components: u32, bytes: &[u8], count: usize| {
        let mut file = animated("rotation", "VEC4", "STEP", &[0.0, 1.0], &[0.0; 8]);
        let view = file.add_view(bytes);
        let output = file.add_accessor(json!({
            "bufferView": view, "componentType": components, "normalized": true,
            "count": count, "type": "VEC4",
        }));
        file.json["animations"][0]["samplers"][0]["output"] = output.into();
        let scene = load(&file).pose_at(1.0).unwrap();
        scene.instances[0].object_to_world.matrix3.x_axis
    };
    let identity_then_half = |one: &[u8], zero: &[u8]| -> Vec<u8> {
        [zero, zero, zero, one, zero, zero, one, zero].concat()
    };
    // Half a turn around z.
    for (component, one, zero) in [
        (5120, &[127_u8][..], &[0_u8][..]),
        (5121, &[255], &[0]),
        (5122, &[0xff, 0x7f], &[0, 0]),
        (5123, &[0xff, 0xff], &[0, 0]),
    ] {
        let x = turn(component, &identity_then_half(one, zero), 2);
        assert!((x - DVec3::NEG_X).length() < 1e-12, "{component}: {x}");
    }
    let negative = turn(5120, &[0, 0, 0, 127, 0, 0, 0x81, 0], 2);
    assert!((negative - DVec3::NEG_X).length() < 1e-12);
}

#[test]
fn what_a_material_emits_goes_through_its_keys() {
    let mut file = animated(
        "pointer",
        "VEC3",
        "LINEAR",
        &[0.0, 1.0],
        &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0],
    );
    let pointer = |path: &str| {
        json!({ "path": "pointer", "extensions": {
            "KHR_animation_pointer": { "pointer": format!("/materials/0/{path}") }
        } })
    };
    let input = add_numbers(&mut file, "SCALAR", 1, &[0.0, 0.5]);
    let output = add_numbers(&mut file, "SCALAR", 1, &[4.0, 8.0]);
    let animation = &mut file.json["animations"][0];
    animation["channels"][0]["target"] = pointer("emissiveFactor");
    let strength = "extensions/KHR_materials_emissive_strength/emissiveStrength";
    let channels = animation["channels"].as_array_mut().unwrap();
    channels.push(json!({ "sampler": 1, "target": pointer(strength) }));
    let samplers = animation["samplers"].as_array_mut().unwrap();
    samplers.push(json!({ "input": input, "output": output, "interpolation": "STEP" }));
    file.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let scene = load(&file);
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    assert_eq!(scene.materials[0].emission, Vec3::ZERO);
    assert_eq!(
        scene.emissive_triangle_count(),
        1,
        "a light though dark at first"
    );
    for (time, emission) in [
        (0.25, Vec3::new(1.0, 0.5, 0.0)),
        (0.5, Vec3::new(4.0, 2.0, 0.0)),
        (2.0, Vec3::new(8.0, 4.0, 0.0)),
    ] {
        assert_eq!(scene.pose_at(time).unwrap().materials[0].emission, emission);
    }
}

#[test]
fn what_never_changes_does_not_move() {
    let still = animated(
        "translation",
        "VEC3",
        "LINEAR",
        &[0.0, 1.0],
        &[1.0, 2.0, 3.0, 1.0, 2.0, 3.0],
    );
    let scene = load(&still);
    assert_eq!(scene.motion, None);
    let position = scene.instances[0].object_to_world.translation;
    assert_eq!(
        position,
        DVec3::new(1.0, 2.0, 3.0),
        "its keys hold all the same"
    );
    // A node that carries nothing may move as it likes.
    let mut file = animated(
        "translation",
        "VEC3",
        "LINEAR",
        &[0.0, 1.0],
        &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0],
    );
    file.json["nodes"].as_array_mut().unwrap().push(json!({}));
    file.json["animations"][0]["channels"][0]["target"]["node"] = 2.into();
    for nodes in [json!([0, 1]), json!([0, 1, 2])] {
        file.json["scenes"] = json!([{ "nodes": nodes }]);
        assert_eq!(
            load(&file).content_hash(),
            load(&Gltf::triangle()).content_hash()
        );
    }
}

#[test]
fn what_cannot_be_followed_is_said_once_and_the_first_of_two_wins() {
    let mut file = animated(
        "translation",
        "VEC3",
        "LINEAR",
        &[0.0, 1.0],
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    );
    let more = add_numbers(&mut file, "VEC3", 3, &[0.0, 0.0, 0.0, 0.0, 9.0, 0.0]);
    let mut second = file.json["animations"][0].clone();
    second["samplers"][0]["output"] = more.into();
    file.json["animations"].as_array_mut().unwrap().push(second);
    let pointer = |pointer: &str| {
        json!({ "target": { "path": "pointer", "extensions": {
            "KHR_animation_pointer": { "pointer": pointer }
        } } })
    };
    let ignored = json!([
        pointer("/materials/0/pbrMetallicRoughness/baseColorFactor"),
        pointer("nonsense"),
        pointer("/nodes/first/translation"),
        { "target": { "path": "translation" } },
        { "target": { "node": 0, "path": "weights" } },
    ]);
    let animation = json!({ "channels": ignored, "samplers": [] });
    file.json["animations"]
        .as_array_mut()
        .unwrap()
        .push(animation);
    let scene = load(&file);
    assert_eq!(moved(&scene, 1.0), DVec3::X);
    assert_eq!(
        scene.notices,
        [
            "several animations change one property, the first one is used: animations[1].channels[0]",
            "animations of properties that cannot be animated are ignored: 5 times, first \
             animations[2].channels[0] (\"/materials/0/pbrMetallicRoughness/baseColorFactor\")",
        ]
    );
}

#[test]
fn bad_keys_are_errors_that_name_them() {
    let two = [0.0, 1.0];
    let six = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0];
    let good = || animated("translation", "VEC3", "LINEAR", &two, &six);
    let times = |times: &[f32]| animated("translation", "VEC3", "LINEAR", times, &six);
    let changed =
        |change: &dyn Fn(&mut Value)| good().with(|json| change(&mut json["animations"][0]));
    let turned = |values: &[f32]| animated("rotation", "VEC4", "LINEAR", &two, values);
    let input = "animations[0].samplers[0].input: ";
    let output = "animations[0].samplers[0].output: ";
    let channel = "animations[0].channels[0]: ";
    let cases: Vec<(Gltf, String)> = vec![
        (times(&[1.0, 0.5]), format!("{input}key 1 is at 0.5 s, before the preceding key, which is at 1 s")),
        (times(&[0.0, f32::NAN]), format!("{input}key 1 is at NaN s")),
        (times(&[0.0, f32::INFINITY]), format!("{input}key 1 is at inf s")),
        (times(&[f32::NEG_INFINITY, 0.0]), format!("{input}key 0 is at -inf s")),
        (times(&[]), format!("{input}there are no keys")),
        (times(&[0.0, 1.0, 2.0]), format!("{output}there are 2 values for 3 keys, not 3")),
        (
            animated("translation", "VEC3", "CUBICSPLINE", &two, &six),
            format!("{output}there are 2 values for 2 keys, not 6"),
        ),
        (
            animated("scale", "VEC3", "STEP", &two, &[1.0, 1.0, 1.0, 1.0, f32::NAN, 1.0]),
            format!("{output}the value of key 1 is not finite"),
        ),
        (
            turned(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
            format!("{output}the value of key 1 is not a unit quaternion"),
        ),
        (
            animated("translation", "VEC4", "LINEAR", &two, &[0.0; 8]),
            "animations[0].samplers[0].output): is \"VEC4\" of component type 5126, it must be VEC3".into(),
        ),
        (changed(&|a| a["samplers"][0]["input"] = 99.into()), "accessor 99 (animations[0].samplers[0].input) is out of range".into()),
        (changed(&|a| a["samplers"][0]["input"] = json!(null)), format!("{input}it is missing")),
        (changed(&|a| a["samplers"][0]["interpolation"] = "SPLINE".into()), "animations[0].samplers[0].interpolation: \"SPLINE\"".into()),
        (changed(&|a| a["channels"][0]["sampler"] = 7.into()), format!("{channel}sampler 7 is out of range, there are 1")),
        (changed(&|a| a["channels"][0]["sampler"] = json!(null)), format!("{channel}it has no sampler")),
        (changed(&|a| a["channels"][0]["target"]["node"] = 9.into()), format!("{channel}node 9 is out of range, there are 2")),
        (
            changed(&|a| a["channels"][0]["target"] = json!({ "path": "pointer", "extensions": {
                "KHR_animation_pointer": { "pointer": "/materials/5/emissiveFactor" } } })),
            format!("{channel}material 5 is out of range, there are 1"),
        ),
        (
            good().with(|json| json["nodes"][0]["matrix"] = json!([1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1])),
            format!("{channel}node 0 \"root\" has a matrix, which cannot be animated"),
        ),
    ];
    let folder = Folder::new();
    for (file, expected) in cases {
        let text = folder.refuse("bad.glb", file.glb());
        assert!(text.contains(&expected), "{text:?} says {expected:?}");
    }
    let mut file = animated(
        "pointer",
        "VEC3",
        "LINEAR",
        &two,
        &[0.0, 0.0, 0.0, -1.0, 0.0, 0.0],
    );
    file.json["animations"][0]["channels"][0]["target"]["extensions"] =
        json!({ "KHR_animation_pointer": { "pointer": "/materials/0/emissiveFactor" } });
    let text = folder.refuse("bad.glb", file.glb());
    assert!(
        text.contains(&format!(
            "{output}the emission of key 1 must be within 0 and 1e12"
        )),
        "{text:?}"
    );
    // Far away at a time is told when that time comes, and never rendered.
    let far = load(&animated(
        "translation",
        "VEC3",
        "LINEAR",
        &two,
        &[0.0, 0.0, 0.0, 1e30, 0.0, 0.0],
    ));
    let text = far.pose_at(0.5).unwrap_err().to_string();
    assert!(
        text.contains("instance 0") && text.contains("0.5 s"),
        "{text:?}"
    );
}

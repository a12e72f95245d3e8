//! Tests of punctual lights in glTF files.

use crate::files::{Folder, Gltf};
use glam::{DVec3, Vec3};
use headwater::scene::PunctualShape;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A triangle, and a node with this light that is turned by 90 degrees around x and moved.
fn lit(light: &Value) -> Gltf {
    Gltf::triangle().with(|json| {
        json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
        json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
        let nodes = json["nodes"].as_array_mut().unwrap();
        let half = 0.5_f64.sqrt();
        nodes.push(json!({
            "name": "lamp",
            "translation": [1, 2, 3],
            "rotation": [-half, 0, 0, half],
            "scale": [2, 2, 2],
            "extensions": { "KHR_lights_punctual": { "light": 0 } },
        }));
        let last = nodes.len() - 1;
        json["scenes"][0]["nodes"]
            .as_array_mut()
            .unwrap()
            .push(last.into());
    })
}

/// A radius is no part of the extension: the light stays a point.
#[test]
fn radii_of_lights_are_ignored_with_a_notice() {
    let notices = |radius: Value| {
        let light = json!({ "type": "point", "extras": { "radius": radius } });
        let scene = Folder::new().load("scene.glb", lit(&light).glb());
        assert_eq!(scene.punctual_lights[0].shape, PunctualShape::Point);
        scene.notices
    };
    let text = "radii of punctual lights are ignored; an emissive surface has soft shadows: light 0 of node 2 \"lamp\"";
    assert_eq!(notices(json!(0.25)), [text]);
    assert_eq!(notices(json!(0.0)), [""; 0]);
    assert_eq!(notices(json!("wide")), [""; 0]);
}

#[test]
fn punctual_lights_stand_where_their_nodes_are() {
    let spot = |inner, outer| PunctualShape::Spot { inner, outer };
    for (light, shape, intensity, range) in [
        (
            json!({ "type": "point" }),
            PunctualShape::Point,
            Vec3::ONE,
            None,
        ),
        (
            json!({ "type": "directional", "intensity": 3.0, "color": [1, 0.5, 0] }),
            PunctualShape::Directional,
            Vec3::new(3.0, 1.5, 0.0),
            None,
        ),
        (
            json!({ "type": "spot", "range": 4.5 }),
            spot(0.0, FRAC_PI_4),
            Vec3::ONE,
            Some(4.5),
        ),
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": FRAC_PI_2 } }),
            spot(0.1, FRAC_PI_2),
            Vec3::ONE,
            None,
        ),
        // As Blender writes a spot whose edge is sharp, also one of a right angle, which f32 rounds up.
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 1.570_796_4, "outerConeAngle": 1.570_796_4 } }),
            spot(FRAC_PI_2, FRAC_PI_2),
            Vec3::ONE,
            None,
        ),
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 0.5, "outerConeAngle": 0.5 } }),
            spot(0.5, 0.5),
            Vec3::ONE,
            None,
        ),
    ] {
        let scene = Folder::new().load("scene.glb", lit(&light).glb());
        assert_eq!(scene.notices, Vec::<String>::new());
        let [found] = &scene.punctual_lights[..] else {
            panic!("{:?}", scene.punctual_lights);
        };
        assert_eq!(
            (found.shape, found.intensity, found.range),
            (shape, intensity, range)
        );
        assert_eq!(found.name, "lamp");
        assert_eq!(found.position(), DVec3::new(1.0, 2.0, 3.0));
        assert!((found.direction() - DVec3::NEG_Y).length() < 1e-12);
        assert!(scene.why_black(true, [0.0]).is_none());
    }
}

#[test]
fn lights_follow_their_nodes() {
    let mut file = lit(&json!({ "type": "point" }));
    let floats =
        |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let times = file.add_view(&floats(&[0.0, 1.0]));
    let times = file.add_accessor(json!({
        "bufferView": times, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1],
    }));
    let positions = file.add_view(&floats(&[1.0, 2.0, 3.0, 5.0, 2.0, 3.0]));
    let positions = file.add_accessor(json!({
        "bufferView": positions, "componentType": 5126, "count": 2, "type": "VEC3",
    }));
    let file = file.with(|json| {
        let node = json["nodes"].as_array().unwrap().len() - 1;
        json["animations"] = json!([{
            "samplers": [{ "input": times, "output": positions }],
            "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }],
        }]);
    });
    let scene = Folder::new().load("scene.glb", file.glb());
    assert!(scene.motion.as_ref().unwrap().moves_things());
    let later = scene.pose_at(0.5).unwrap();
    assert_eq!(
        later.punctual_lights[0].position(),
        DVec3::new(3.0, 2.0, 3.0)
    );
}

#[test]
fn broken_lights_are_refused() {
    for (light, said) in [
        (json!({ "type": "laser" }), "laser"),
        (json!({}), "type"),
        (json!({ "type": "point", "intensity": -1 }), "intensity"),
        (json!({ "type": "point", "intensity": 2e30 }), "2e30"),
        (
            json!({ "type": "directional", "intensity": 2e12 }),
            "within 0 and 1e12",
        ),
        (json!({ "type": "point", "range": 0 }), "range"),
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 0.6, "outerConeAngle": 0.5 } }),
            "cone angles",
        ),
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 0, "outerConeAngle": 0 } }),
            "cone angles",
        ),
        (
            json!({ "type": "spot", "spot": { "outerConeAngle": 2.0 } }),
            "cone angles",
        ),
    ] {
        let line = Folder::new().refuse("scene.glb", lit(&light).glb());
        assert!(line.contains(said) && line.contains("lamp"), "{line}");
    }
    let file = lit(&json!({ "type": "point" })).with(|json| {
        json["extensions"]["KHR_lights_punctual"]["lights"] = json!([]);
    });
    let line = Folder::new().refuse("scene.glb", file.glb());
    assert!(line.contains("light 0 is out of range"), "{line}");
}

//! Punctual lights of glTF files, and environments from files.

use crate::files::{Folder, Gltf};
use glam::{DVec3, Vec3};
use headwater::image::Image;
use headwater::scene::{Environment, PunctualShape};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::path::Path;

/// A triangle beside a node with this light, turned by a right angle around x and moved.
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
        assert!(scene.is_lit());
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
    let places = file.add_view(&floats(&[1.0, 2.0, 3.0, 5.0, 2.0, 3.0]));
    let places = file.add_accessor(json!({
        "bufferView": places, "componentType": 5126, "count": 2, "type": "VEC3",
    }));
    let file = file.with(|json| {
        let node = json["nodes"].as_array().unwrap().len() - 1;
        json["animations"] = json!([{
            "samplers": [{ "input": times, "output": places }],
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
        (json!({ "type": "point", "range": 0 }), "range"),
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 0.5, "outerConeAngle": 0.5 } }),
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

/// Writes an environment whose texels are all this, but for one.
fn write_exr(path: &Path, texel: f32) {
    let mut picture = Image::new(8, 4);
    let mut texels = [[1.0, 2.0, 3.0]; 32];
    texels[13][1] = texel;
    picture.set_vectors("", ["R", "G", "B"], &texels);
    picture.write(path, 0.0).unwrap();
}

/// Eight by four texels of radiance (1, 0.5, 0.25), uncompressed.
fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    bytes.extend([128, 64, 32, 129].repeat(32));
    bytes
}

#[test]
fn environments_are_read_from_exr_and_hdr() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sky.exr");
    write_exr(&path, 7.0);
    let open = |path: &Path| Environment::open(path.to_str().unwrap());
    let environment = open(&path).unwrap();
    assert_eq!((environment.width, environment.height), (8, 4));
    assert_eq!(environment.texels[13], Vec3::new(1.0, 7.0, 3.0));
    let path = folder.path().join("sky.HDR");
    std::fs::write(&path, hdr()).unwrap();
    let environment = open(&path).unwrap();
    assert_eq!(*environment.texels, [Vec3::new(1.0, 0.5, 0.25); 32]);
}

#[test]
fn broken_environments_end_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |name: &str, bytes: &[u8], said: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let error = Environment::open(path.to_str().unwrap()).unwrap_err();
        let line = error.to_string();
        assert!(error.exit_status() == 2 && line.contains(name), "{line}");
        assert!(!line.contains('\n') && line.contains(said), "{line}");
    };
    for (name, texel) in [
        ("nan", f32::NAN),
        ("infinite", f32::INFINITY),
        ("below", -1.0),
        ("above", 1e13),
    ] {
        let path = folder.path().join("made.exr");
        write_exr(&path, texel);
        refuse(
            &format!("{name}.exr"),
            &std::fs::read(&path).unwrap(),
            "texel 5, 1",
        );
    }
    let whole = hdr();
    refuse("cut.hdr", &whole[..whole.len() - 30], "");
    refuse("empty.hdr", b"", "");
    refuse("text.hdr", b"a text", "");
    refuse(
        "lying.hdr",
        &[&whole[..36], b"-Y 4000000 +X 4000000\n"].concat(),
        "",
    );
    refuse("text.exr", b"a text", "");
    refuse("sky.jpg", b"", ".exr or .hdr");
    let missing = Environment::open("/nowhere/sky.exr")
        .unwrap_err()
        .to_string();
    assert!(missing.contains("/nowhere/sky.exr"), "{missing}");
}

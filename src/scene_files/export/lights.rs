//! Writes punctual lights as JSON of the glTF extension `KHR_lights_punctual`.

use super::color_and_strength;
use crate::scene::{PunctualLight, PunctualShape};
use serde_json::{Value, json};

/// The name of the glTF extension for punctual lights (points, spots and directional lights). A file with such lights must
/// list it among its extensions.
pub const EXTENSION: &str = "KHR_lights_punctual";

/// The value of `extensions` in the root object of the file. It lists the JSON of all punctual lights, in the order of
/// `lights`; nodes refer to a light by its index in this list.
pub fn lights(lights: &[PunctualLight]) -> Value {
    let lights: Vec<Value> = lights.iter().map(light).collect();
    json!({ EXTENSION: { "lights": lights } })
}

/// The JSON of a node that places a punctual light; `index` is the light's index in the list that [`lights`] writes. The
/// caller adds the transform.
pub fn node(index: usize, light: &PunctualLight) -> Value {
    json!({ "name": light.name, "extensions": { EXTENSION: { "light": index } } })
}

fn light(light: &PunctualLight) -> Value {
    let (color, intensity) = color_and_strength(light.intensity);
    let kind = match light.shape {
        PunctualShape::Point => "point",
        PunctualShape::Spot { .. } => "spot",
        PunctualShape::Directional => "directional",
    };
    let mut value = json!({
        "name": light.name, "type": kind, "color": color.to_array(), "intensity": intensity,
    });
    if let PunctualShape::Spot { inner, outer } = light.shape {
        value["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
    }
    if let Some(range) = light.range {
        value["range"] = json!(range);
    }
    value
}

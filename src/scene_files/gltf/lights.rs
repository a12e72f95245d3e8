//! Reads the punctual lights of a glTF file from the extension `KHR_lights_punctual`.

use super::damaged;
use super::document::{Document, Light};
use super::nodes::Placed;
use crate::Result;
use crate::scene::notices::Tally;
use crate::scene::validate::punctual::check_cone;
use crate::scene::{PunctualLight, PunctualShape};
use glam::Vec3;
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;

/// The punctual light that a node places in the scene; `None` if the node has none. A radius among the extras of the light is
/// ignored, with a notice in `tally`, because glTF does not define one. Fails if the index of the light is out
/// of range, its type is unknown, or the angles of its cone are wrong.
pub fn of_node(
    document: &Document,
    placed: &Placed<'_>,
    tally: &mut Tally,
) -> Result<Option<PunctualLight>> {
    let Some(named) = &placed.node.extensions.light else {
        return Ok(None);
    };
    let lights = &document.extensions.lights.lights;
    let Some(light) = super::get(lights, named.light) else {
        return Err(super::out_of_range(
            &placed.label(),
            "light",
            named.light,
            lights.len(),
        ));
    };
    let what = format!("light {} of {}", named.light, placed.label());
    let radius = light.extras.get("radius").and_then(Value::as_f64);
    if radius.is_some_and(|radius| radius > 0.0) {
        let text = "radii of punctual lights are ignored; an emissive surface has soft shadows";
        tally.add(text, || what.clone());
    }
    Ok(Some(PunctualLight {
        name: placed.name_or(&light.name),
        light_to_world: placed.to_world,
        shape: shape(&what, light)?,
        intensity: Vec3::from_array(light.color) * light.intensity,
        range: light.range,
    }))
}

fn shape(what: &str, light: &Light) -> Result<PunctualShape> {
    match light.kind.as_str() {
        "point" => Ok(PunctualShape::Point),
        "directional" => Ok(PunctualShape::Directional),
        "spot" => {
            // Files have π/2 rounded to f32, which may be above it.
            let is_rounded = |angle: f64| (FRAC_PI_2..FRAC_PI_2 + 1e-6).contains(&angle);
            let rounded = |angle: f64| if is_rounded(angle) { FRAC_PI_2 } else { angle };
            let inner = rounded(light.spot.inner_cone_angle);
            let outer = rounded(light.spot.outer_cone_angle);
            check_cone(what, inner, outer)?;
            Ok(PunctualShape::Spot { inner, outer })
        }
        other => Err(damaged(format!(
            "{what}: its type is {}, not point, spot or directional",
            crate::scene::notices::quoted(other)
        ))),
    }
}

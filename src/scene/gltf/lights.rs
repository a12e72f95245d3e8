//! Punctual lights: `KHR_lights_punctual`.

use super::damaged;
use super::document::{Document, Light};
use super::nodes::Placed;
use crate::scene::{PunctualLight, PunctualShape};
use crate::{Error, Result};
use glam::Vec3;

/// The light of a node, if it has one.
pub fn of_node(document: &Document, place: &Placed<'_>) -> Result<Option<PunctualLight>> {
    let Some(named) = &place.node.extensions.light else {
        return Ok(None);
    };
    let lights = &document.extensions.lights.lights;
    let Some(light) = super::get(lights, named.light) else {
        return Err(super::out_of_range(
            &place.label(),
            "light",
            named.light,
            lights.len(),
        ));
    };
    let what = format!("light {} of {}", named.light, place.label());
    Ok(Some(PunctualLight {
        name: place.name_or(&light.name),
        light_to_world: place.to_world,
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
            let (inner, outer) = (light.spot.inner_cone_angle, light.spot.outer_cone_angle);
            // Cones over π/2 would light what is behind them; the extension forbids them. It forbids equal angles too, but
            // Blender writes them for a spot with a sharp edge.
            if !(inner >= 0.0
                && inner <= outer
                && outer > 0.0
                && outer <= std::f64::consts::FRAC_PI_2 + 1e-6)
            {
                return Err(Error::input(format!(
                    "{what}: its cone angles are {inner} and {outer}; they must be 0 ≤ inner ≤ outer ≤ π/2, and outer above 0"
                )));
            }
            Ok(PunctualShape::Spot {
                inner,
                outer: outer.min(std::f64::consts::FRAC_PI_2),
            })
        }
        other => Err(damaged(format!(
            "{what}: its type is {}, not point, spot or directional",
            crate::scene::notices::quoted(other)
        ))),
    }
}

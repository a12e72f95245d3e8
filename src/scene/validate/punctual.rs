//! Checks of punctual lights (points, spots and directional lights). If the renderer cannot use a light, its scene is
//! refused.

use super::{BRIGHTEST, LARGEST_COORDINATE, is_within};
use crate::scene::{PunctualLight, PunctualShape};
use crate::{Error, Result};
use std::f64::consts::FRAC_PI_2;

/// The largest intensity of a point or a spot light, in W/sr; more is refused. A light of this intensity causes an
/// irradiance of [`BRIGHTEST`], in W/m², on a surface at a distance of 10⁹ scene units.
const MOST_INTENSE: f32 = 1e30;

/// Checks the half angles of a spot's cones, in radians, and fails unless 0 ≤ `inner` ≤ `outer` ≤ π/2 and `outer` is above
/// 0. A wider cone would light the space behind the spot. `KHR_lights_punctual` also forbids equal angles, but they are
/// accepted, because Blender writes them for a spot with a sharp edge. `what` is the name of the light in messages.
pub fn check_cone(what: &str, inner: f64, outer: f64) -> Result<()> {
    if inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2 {
        return Ok(());
    }
    Err(Error::input(format!(
        "{what}: its cone angles are {inner} and {outer}; they must be 0 ≤ inner ≤ outer ≤ π/2, and outer above 0"
    )))
}

/// Checks that the transform, intensity, cone angles and range of a light are within their limits, and fails at the first
/// that is not. `what` is the name of the light in messages.
pub(super) fn check_punctual(what: &str, light: &PunctualLight) -> Result<()> {
    let PunctualLight {
        name: _,
        light_to_world,
        shape,
        intensity,
        range,
    } = light;
    let wrong = |fault: String| Err(Error::input(format!("{what}: {fault}")));
    if !light_to_world.is_finite()
        || light_to_world.translation.abs().max_element() > LARGEST_COORDINATE
    {
        return wrong(format!(
            "its transform is not finite, or it is further than {LARGEST_COORDINATE:e} from the origin; correct it in the modelling tool"
        ));
    }
    let limit = match shape {
        PunctualShape::Directional => BRIGHTEST,
        PunctualShape::Point | PunctualShape::Spot { .. } => MOST_INTENSE,
    };
    if !is_within(*intensity, limit) {
        return wrong(format!(
            "intensity × colour is {:?}; it must be within 0 and {limit:e}",
            intensity.to_array()
        ));
    }
    if let PunctualShape::Spot { inner, outer } = shape {
        check_cone(what, *inner, *outer)?;
    }
    if let Some(range) = range
        && !(*range > 0.0 && range.is_finite())
    {
        return wrong(format!("its range is {range}; it must be positive"));
    }
    Ok(())
}

//! Checks of the layers of a material: clear coat, anisotropy, transmission, volume and dispersion.

use crate::scene::Layers;
use crate::scene::notices::Tally;
use crate::{Error, Result};
use glam::Vec3;

/// Checks that the numbers of a material's layers are in range. Numbers outside are moved to the end of the range, with one
/// notice in `tally`; an attenuation distance of 0 or less counts as infinite. Fails at the first number that is NaN, and
/// where an angle or a scale is infinite. `what` is the name of the material in messages.
pub(super) fn check_layers(what: &str, layers: &mut Layers, tally: &mut Tally) -> Result<()> {
    let Layers {
        coat,
        anisotropy,
        transmission,
        volume,
        dispersion,
    } = layers;
    for (name, value) in [
        (
            "the scale of the clear coat's normal texture",
            coat.normal_scale,
        ),
        ("anisotropy rotation", anisotropy.rotation),
    ] {
        if !value.is_finite() {
            return Err(Error::input(format!(
                "{what}: {name} is {value}; it must be finite"
            )));
        }
    }
    let Vec3 { x, y, z } = &mut volume.attenuation_color;
    for (name, value, largest) in [
        ("clear coat factor", &mut coat.factor, 1.0),
        ("clear coat roughness", &mut coat.roughness, 1.0),
        ("anisotropy strength", &mut anisotropy.strength, 1.0),
        ("transmission factor", &mut transmission.factor, 1.0),
        ("thickness", &mut volume.thickness, f32::MAX),
        (
            "attenuation distance",
            &mut volume.attenuation_distance,
            f32::INFINITY,
        ),
        ("attenuation colour", x, 1.0),
        ("attenuation colour", y, 1.0),
        ("attenuation colour", z, 1.0),
        ("dispersion", dispersion, f32::MAX),
    ] {
        if value.is_nan() {
            return Err(Error::input(format!(
                "{what}: {name} is NaN; it must be a number"
            )));
        }
        let clamped = value.clamp(0.0, largest);
        if clamped != *value {
            *value = clamped;
            tally.add(
                "values of coats, anisotropy, transmission and volumes outside of their range are clamped",
                || format!("{name} of {what}"),
            );
        }
    }
    if volume.attenuation_distance == 0.0 {
        volume.attenuation_distance = f32::INFINITY;
        tally.add("attenuation distances of 0 count as infinite", || {
            what.into()
        });
    }
    Ok(())
}

//! Checks of cameras and their lenses.

use super::LARGEST_COORDINATE;
use crate::scene::Camera;
use crate::scene::camera::{Lens, Projection};
use crate::{Error, Result};
use glam::{DAffine3, DMat3};

impl Camera {
    /// The same camera with `lens` instead of a pinhole.
    ///
    /// # Errors
    /// The camera is orthographic, or a value of `lens` is outside of its range.
    pub fn with_lens(mut self, lens: Lens) -> Result<Self> {
        match &mut self.projection {
            Projection::Perspective { lens: own, .. } => *own = Some(lens),
            Projection::Orthographic { .. } => {
                return Err(Error::input(
                    "an orthographic camera has no lens; use a perspective camera, or no aperture",
                ));
            }
        }
        check_camera("the lens", &self)?;
        Ok(self)
    }
}

/// Checks that a picture can be rendered from a camera; `what` is the name of the camera in messages.
///
/// # Errors
/// The field of view is not above 0 and below π; the height of an orthographic picture, the diameter of a lens or its focus
/// distance is outside of its range; the aspect ratio is not positive and finite; the transform is not a rotation and a
/// translation; or a coordinate of the camera exceeds [`LARGEST_COORDINATE`].
pub fn check_camera(what: &str, camera: &Camera) -> Result<()> {
    let wrong = |fault: String| Err(Error::input(format!("{what}: {fault}")));
    match camera.projection {
        Projection::Perspective { vertical_fov, .. }
            if !(vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI) =>
        {
            return wrong(format!(
                "its vertical field of view is {vertical_fov} radians; it must be within 0 and π"
            ));
        }
        Projection::Orthographic { height } if !(height > 0.0 && height <= LARGEST_COORDINATE) => {
            return wrong(format!(
                "its picture is {height:?} scene units high; the height must be above 0 and at most {LARGEST_COORDINATE:e}"
            ));
        }
        Projection::Perspective {
            lens: Some(lens), ..
        } => check_lens(&lens).or_else(wrong)?,
        _ => {}
    }
    if let Some(aspect) = camera.aspect_ratio
        && !(aspect > 0.0 && aspect.is_finite())
    {
        return wrong(format!(
            "its aspect ratio is {aspect}; it must be positive and finite"
        ));
    }
    if !is_rigid(&camera.camera_to_world) {
        return wrong("its transform is not a rotation and a finite translation".into());
    }
    if camera.camera_to_world.translation.abs().max_element() > LARGEST_COORDINATE {
        return wrong(format!(
            "it is further than {LARGEST_COORDINATE:e} from the origin; scale the scene down"
        ));
    }
    Ok(())
}

/// Checks the values of a lens. The text of an error begins with the name of the wrong value.
fn check_lens(lens: &Lens) -> std::result::Result<(), String> {
    let Lens {
        diameter,
        focus_distance,
    } = *lens;
    if !(diameter > 0.0 && diameter <= LARGEST_COORDINATE) {
        return Err(format!(
            "its diameter is {diameter:?} scene units; it must be above 0 and at most {LARGEST_COORDINATE:e}"
        ));
    }
    // Closer, the rays would be almost parallel to the lens, and a picture would show nothing but noise.
    if !(focus_distance > 0.0 && focus_distance >= 1e-3 * diameter) {
        return Err(format!(
            "its focus distance is {focus_distance:?} scene units; it must be above 0 and at least a thousandth of its diameter, {diameter:?}"
        ));
    }
    Ok(())
}

fn is_rigid(transform: &DAffine3) -> bool {
    let m = transform.matrix3;
    transform.is_finite()
        && (m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-6)
        && m.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::look_at;
    use glam::DVec3;

    fn lens(diameter: f64, focus_distance: f64) -> Projection {
        Projection::Perspective {
            vertical_fov: 0.5,
            lens: Some(Lens {
                diameter,
                focus_distance,
            }),
        }
    }

    #[test]
    fn every_projection_is_checked() {
        let parallel = |height| Projection::Orthographic { height };
        let check = |projection| {
            let camera = Camera {
                projection,
                ..look_at(DVec3::ONE, DVec3::ZERO, 1.0)
            };
            check_camera("it", &camera)
        };
        for (projection, said) in [
            (parallel(0.0), "picture is 0"),
            (parallel(-1.0), "picture is -1"),
            (parallel(f64::NAN), "picture is NaN"),
            (parallel(f64::INFINITY), "picture is inf"),
            (lens(0.0, 1.0), "diameter is 0"),
            (lens(-0.5, 1.0), "diameter is -0.5"),
            (lens(f64::NAN, 1.0), "diameter is NaN"),
            (lens(f64::INFINITY, 1.0), "diameter is inf"),
            (lens(0.1, 0.0), "focus distance is 0"),
            (lens(0.1, f64::NAN), "focus distance is NaN"),
            (lens(1.0, 1e-4), "thousandth"),
        ] {
            let text = check(projection).expect_err(said).to_string();
            assert!(text.contains(said), "{text}");
        }
        for projection in [parallel(1e-3), lens(0.1, 2.0), lens(0.1, f64::INFINITY)] {
            check(projection).unwrap();
        }
    }
}

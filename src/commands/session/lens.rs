//! The lens that `--aperture` and `--focus` give to the camera of a session.

use crate::commands::arguments::ViewArgs;
use crate::commands::notice;
use crate::device_scene::GpuScene;
use crate::gpu::Device;
use crate::render::presets::Preset;
use crate::render::{Clock, Renderer, View};
use crate::scene::Camera;
use crate::scene::camera::{Lens, Projection};
use crate::{Error, Result};
use std::sync::Arc;

/// Checks `--aperture` and `--focus`, before the scene is uploaded.
///
/// # Errors
/// A value is outside of its range, or `camera` is orthographic and so has no lens.
pub(super) fn check(args: &ViewArgs, camera: &Camera) -> Result<()> {
    let (aperture, focus) = (args.aperture, args.focus);
    if !(aperture >= 0.0 && aperture.is_finite()) {
        return Err(Error::input(format!(
            "--aperture {aperture:?}: the diameter of a lens is a finite number of scene units, 0 or above"
        )));
    }
    if let Some(focus) = focus.filter(|focus| focus.is_nan() || *focus <= 0.0) {
        return Err(Error::input(format!(
            "--focus {focus:?}: the distance must be above 0, in scene units"
        )));
    }
    if aperture == 0.0 {
        return Ok(());
    }
    if matches!(camera.projection, Projection::Orthographic { .. }) {
        return Err(Error::input(format!(
            "--aperture {aperture:?}: camera '{}' is orthographic, which has no lens; choose another by --camera or --look-at",
            camera.name
        )));
    }
    // Any distance that fits: what the centre shows is known later.
    with_lens(camera.clone(), aperture, focus.unwrap_or(aperture)).map(drop)
}

/// The `camera` with the lens of `--aperture`, focused on the distance of `--focus`; without it, on what the centre of the
/// picture shows at the time of frame 0, which a notice states.
///
/// # Errors
/// The centre of the picture shows no surface, or one that is too close to the lens; or the device fails.
pub(super) fn add(
    args: &ViewArgs,
    camera: Camera,
    device: &Arc<Device>,
    scene: &Arc<GpuScene>,
    clock: &Clock,
) -> Result<Camera> {
    if let Some(focus) = args.focus {
        return with_lens(camera, args.aperture, focus);
    }
    let view = View {
        camera: camera.clone(),
        width: 1,
        height: 1,
        seed: 0,
        bounces: 0,
        jitter: false,
    };
    let settings = Preset::named("path-tracing")?.settings()?;
    let mut renderer = Renderer::new(device, scene.clone(), &view, &settings)?;
    renderer.set_time(clock.start_time);
    // One pixel, whose ray is the camera's axis.
    let seen = renderer.primary_surfaces()?;
    let distance = seen.first().map_or(0.0, |surface| surface.depth);
    if distance == 0.0 {
        return Err(Error::input(
            "--aperture: the centre of the picture shows no surface to focus on; set --focus DISTANCE",
        ));
    }
    notice(&format!(
        "the lens is focused at {distance} scene units, on what the centre of the picture shows; --focus sets another distance"
    ));
    with_lens(camera, args.aperture, f64::from(distance))
}

/// The `camera` with a lens; errors name the options.
fn with_lens(camera: Camera, diameter: f64, focus_distance: f64) -> Result<Camera> {
    let lens = Lens {
        diameter,
        focus_distance,
    };
    let camera = camera.with_lens(lens);
    camera.map_err(|error| Error::input(format!("--aperture and --focus: {error}")))
}

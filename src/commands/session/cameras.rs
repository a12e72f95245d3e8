//! Chooses the camera of a session, and describes cameras as text, so that pictures and profiles of different cameras
//! can be told apart.

use crate::commands::arguments::ViewArgs;
use crate::commands::notice;
use crate::scene::camera::{Projection, framing_camera};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};
use glam::DVec3;

/// Chooses the scene's camera with the index or name in `args.camera`; without it, chooses the first one. Returns the camera
/// at `time`, in seconds, and its index. If none is wanted and the scene has no cameras, returns a camera that sees the whole
/// scene, without an index. Returns an error if no camera has the wanted index or name.
pub(super) fn choose_camera(
    scene: &Scene,
    args: &ViewArgs,
    time: f64,
) -> Result<(Camera, Option<usize>)> {
    let own = |index: usize| Ok((scene.camera_at(index, time)?, Some(index)));
    let Some(wanted) = args.camera.as_deref() else {
        if !scene.cameras.is_empty() {
            return own(0);
        }
        notice("the scene has no camera, so one was made that frames it; --look-at sets another");
        return Ok((framing_camera(scene, args.aspect()), None));
    };
    let by_index = wanted.parse::<usize>().ok();
    let by_index = by_index.filter(|index| *index < scene.cameras.len());
    let by_name = || scene.cameras.iter().position(|c| c.name == wanted);
    by_index.or_else(by_name).map(own).unwrap_or_else(|| {
        let listed: Vec<String> = scene
            .cameras
            .iter()
            .enumerate()
            .map(|(i, c)| format!("{i} '{}'", c.name))
            .collect();
        Err(Error::input(format!(
            "no camera '{wanted}'; the scene has: {}",
            if listed.is_empty() {
                "none".into()
            } else {
                listed.join(", ")
            }
        )))
    })
}

/// The position, the directions of the axes and the projection of a camera as text, with all digits and angles in radians,
/// so that different cameras have different texts. Pictures and profiles store it; a reference is resumed, and two
/// profiles are compared, only if their texts are equal.
pub fn camera_text(camera: &Camera) -> String {
    let transform = camera.camera_to_world;
    let text = |v: DVec3| format!("{:?} {:?} {:?}", v.x, v.y, v.z);
    let projection = match camera.projection {
        Projection::Perspective { vertical_fov, lens } => {
            let lens = lens.map(|lens| {
                let (diameter, focus) = (lens.diameter, lens.focus_distance);
                format!("; aperture {diameter:?}; focus {focus:?}")
            });
            format!("vertical fov {vertical_fov:?}{}", lens.unwrap_or_default())
        }
        Projection::Orthographic { height } => format!("orthographic height {height:?}"),
    };
    format!(
        "eye {}; back {}; up {}; {projection}",
        text(transform.translation),
        text(transform.matrix3.z_axis),
        text(transform.matrix3.y_axis),
    )
}

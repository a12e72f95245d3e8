//! Preparations for measuring candidates on a scene, which `advise` shares with the options `--budget-ms` and
//! `--target-relmse` of `render`: checks, and the motion of the camera.

use super::session::OpenedScene;
use crate::advice::chain::{Course, Purpose};
use crate::{Error, Result};

/// The number of frames per second of the scene's time with which `advise` measures a moving scene.
pub const FRAMES_PER_SECOND: f64 = 24.0;

/// The distance by which a camera that does not move by itself is moved sideways in each measured frame, as a
/// fraction of the diagonal of the box around the scene.
const STEP: f64 = 0.001;

/// Checks, before the measurement begins, that errors and times of the scene can be measured. `name` is the
/// name of the scene for the message.
///
/// # Errors
/// The scene has no light in the frames to be measured, or the device has no time stamps.
pub fn check_measurable(scene: &OpenedScene, name: &str) -> Result<()> {
    if scene.black.is_some() {
        return Err(Error::input(format!(
            "{name}: without light, nothing can be measured"
        )));
    }
    if scene.device.info.timestamp_period == 0.0 {
        return Err(Error::failed(format!(
            "device '{}' measures no times; --device chooses another",
            scene.device.info.name
        )));
    }
    Ok(())
}

/// The motion of the camera and of the scene in the measured frames. Nothing moves unless `purpose` is
/// [`Purpose::Motion`]. `last` is the time of the last frame in the scene, in seconds. If `steps` is true, a
/// camera that does not move by itself is moved sideways by a constant distance per frame.
///
/// # Errors
/// The scene's camera has no direction at the time of the first or the last frame.
pub fn course(purpose: Purpose, scene: &OpenedScene, last: f64, steps: bool) -> Result<Course> {
    let mut course = Course {
        purpose,
        clock: None,
        camera: None,
        view: (scene.view.camera.clone(), 0.0),
    };
    if course.purpose != Purpose::Motion {
        return Ok(course);
    }
    course.clock = scene.clock;
    if let (Some(camera), Some(clock)) = (&scene.camera, scene.clock) {
        let [first, last] = [clock.time(0), last].map(|time| camera.at(time));
        if first?.camera_to_world != last?.camera_to_world {
            course.camera = scene.camera.clone();
            return Ok(course);
        }
    }
    if steps {
        course.view.1 = STEP * scene.diagonal;
    }
    Ok(course)
}

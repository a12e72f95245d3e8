//! The clock of an animation, which computes the time in the scene that each frame shows. Before a frame is rendered, the
//! scene and its camera are moved to this time.

use crate::scene::Scene;
use crate::{Error, Result};

/// A clock of an animation: it maps the index of a frame to the time in the scene that the frame shows. The positions of all
/// objects and of the camera in the frame follow from this time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// The time in the scene that frame 0 shows, in seconds.
    pub start_time: f64,
    /// The number of frames per second of scene time, which is positive. `None`: the clock is stopped, and all frames show
    /// the start time.
    pub fps: Option<f64>,
}

impl Clock {
    /// Checks that the start time and the number of frames per second can be used, before anything is rendered with them.
    /// The arguments are the names of these two values for error messages, such as `--start-time` and `--fps`.
    ///
    /// # Errors
    /// The start time is not finite, or the number of frames per second is not positive and finite.
    pub fn check(&self, start_time: &str, fps: &str) -> Result<()> {
        if let Some(value) = self.fps.filter(|fps| !(*fps > 0.0 && fps.is_finite())) {
            return Err(Error::input(format!(
                "{fps} {value}: it must be positive and finite; without it time stands still"
            )));
        }
        if !self.start_time.is_finite() {
            return Err(Error::input(format!(
                "{start_time} takes a finite number of seconds"
            )));
        }
        Ok(())
    }

    /// The time in the scene, in seconds, that the frame with the index `frame` shows. If the clock is stopped, it is the
    /// start time.
    pub fn time(&self, frame: u32) -> f64 {
        match self.fps {
            Some(fps) => self.start_time + f64::from(frame) / fps,
            None => self.start_time,
        }
    }

    /// Returns a stopped clock, whose frames all show the same time: the time that this clock (`self`) computes for the
    /// frame with the index `frame`. With a stopped clock, path tracing can add up many samples of one point in time of an
    /// animation.
    pub fn stopped_at(&self, frame: u32) -> Self {
        Self {
            start_time: self.time(frame),
            fps: None,
        }
    }

    /// If the clock is stopped and `scene` moves, replaces `scene` by a scene that does not move: everything in it, such as
    /// objects and cameras, stays as it is at the start time. A scene that does not move costs less to render. Does nothing
    /// if the clock runs.
    ///
    /// # Errors
    /// At the start time an instance is too far away to be rendered, or a camera has no direction.
    pub fn freeze_if_stopped(&self, scene: &mut Scene) -> Result<()> {
        if self.fps.is_none() && scene.motion.is_some() {
            *scene = scene.pose_at(self.start_time)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_show_their_times() {
        let running = Clock {
            start_time: -1.0,
            fps: Some(4.0),
        };
        assert_eq!([0, 1, 6].map(|n| running.time(n)), [-1.0, -0.75, 0.5]);
        let stopped = running.stopped_at(6);
        assert_eq!([0, 1, 6].map(|n| stopped.time(n)), [0.5; 3]);
    }
}

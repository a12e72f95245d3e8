//! The time in the scene that each frame shows.

use crate::scene::Scene;
use crate::{Error, Result};

/// The time that each frame shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// The time of frame 0, in seconds.
    pub start_time: f64,
    /// The number of frames per second; without it, all frames show the same time.
    pub fps: Option<f64>,
}

impl Clock {
    /// Refuses invalid values. `start_time` and `fps` are the names of the two in messages.
    ///
    /// # Errors
    /// A time that is not finite, or a number of frames per second that is not positive and finite.
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

    /// The time that a frame shows, in seconds.
    pub fn time(&self, frame: u32) -> f64 {
        match self.fps {
            Some(fps) => self.start_time + f64::from(frame) / fps,
            None => self.start_time,
        }
    }

    /// A clock that is stopped at the time of a frame.
    pub fn stopped_at(&self, frame: u32) -> Self {
        Self {
            start_time: self.time(frame),
            fps: None,
        }
    }

    /// Replaces a moving scene by its pose at the start time if the clock is stopped: it then costs no more to
    /// render than one that never moves.
    ///
    /// # Errors
    /// At that time something is further away than can be rendered, or a camera has no direction.
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

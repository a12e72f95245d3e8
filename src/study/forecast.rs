//! Estimates the fraction of a study that is done, for reports of progress, from the durations of the steps that are done
//! and the number of steps to come. A step is one frame, or one sample per pixel of a reference.

use std::collections::BTreeMap;
use std::time::Duration;

/// A kind of work on a scene, for which the forecast counts and times steps separately. All its steps on one scene take
/// about the same time, so the mean duration of those that are done predicts the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effort {
    /// The study renders references, which are path-traced pictures that runs are compared with. A step is one sample per
    /// pixel.
    References,
    /// The study renders the runs of configurations; a run is the frames of one configuration with one seed. A step is one
    /// frame.
    Runs,
    /// The study renders controls, which are runs of path tracing with about as much noise as a configuration. The blocks of
    /// pixels of the configuration are compared with the blocks of its control. A step is one frame.
    Controls,
    /// The study renders a run again, to find data races, which change its bits, or to count rays. A step is one frame.
    Repeats,
}

/// For each scene and kind of work ([`Effort`]), the number of steps that are done, their total time, and the number of
/// steps to come. From these it estimates the fraction of the study that is done, which progress reports show.
#[derive(Debug, Default)]
pub struct Forecast {
    stages: BTreeMap<(String, Effort), Stage>,
}

#[derive(Debug, Default)]
struct Stage {
    to_come: u64,
    done: u64,
    seconds: f64,
}

impl Forecast {
    /// Sets the number of steps of one kind of work that are still to come on the scene with the name `scene`. It replaces
    /// the number that was set before. A study sets all numbers before its work begins, and corrects them when it knows what
    /// is left.
    pub fn set_to_come(&mut self, scene: &str, effort: Effort, steps: u64) {
        self.stage(scene, effort).to_come = steps;
    }

    /// Raises the number of steps of one kind of work that are still to come on the scene with the name `scene` to `steps`.
    /// If the number is larger already, nothing changes. A study calls this before it renders runs, and passes the number of
    /// frames of all runs that are not stored yet.
    pub fn raise_to_come(&mut self, scene: &str, effort: Effort, steps: u64) {
        let stage = self.stage(scene, effort);
        stage.to_come = stage.to_come.max(steps);
    }

    /// Ends the work on the scene with the name `scene`: the numbers of steps to come become 0 for all kinds of work on it.
    /// Without this, expected steps that were not needed would keep the fraction that is done below 1.
    pub fn close(&mut self, scene: &str) {
        for ((name, _), stage) in &mut self.stages {
            if name == scene {
                stage.to_come = 0;
            }
        }
    }

    /// Records that `steps` steps of one kind of work on the scene with the name `scene` are done, and that together they
    /// took the time `took`. The number of steps to come is reduced by `steps`, but not below 0. The mean duration of the
    /// steps that are done predicts those to come.
    pub fn done(&mut self, scene: &str, effort: Effort, steps: u64, took: Duration) {
        let stage = self.stage(scene, effort);
        stage.to_come = stage.to_come.saturating_sub(steps);
        stage.done += steps;
        stage.seconds += took.as_secs_f64();
    }

    /// The estimated fraction of the study that is done, in [0, 1]: the time of the steps that are done, divided by the sum
    /// of this time and the predicted time of the steps to come. It is 0 before the first step is done.
    pub fn fraction(&self) -> f64 {
        let passed: f64 = self.stages.values().map(|stage| stage.seconds).sum();
        let left: f64 = (self.stages.iter())
            .filter(|(_, stage)| stage.to_come > 0)
            .map(|((_, effort), stage)| stage.to_come as f64 * self.step_seconds(*effort, stage))
            .sum();
        if passed > 0.0 {
            passed / (passed + left)
        } else {
            0.0
        }
    }

    fn stage(&mut self, scene: &str, effort: Effort) -> &mut Stage {
        self.stages.entry((scene.to_owned(), effort)).or_default()
    }

    /// The predicted duration of one step, in seconds: the mean over the steps of `stage` (one kind of work on one scene)
    /// that are done. If none is done, it is the mean over the steps of the kind `effort` on all scenes. If none of these is
    /// done, it is the mean over all steps that are done, or 0 before the first one.
    fn step_seconds(&self, effort: Effort, stage: &Stage) -> f64 {
        let mean = |stages: &mut dyn Iterator<Item = &Stage>| {
            let (mut steps, mut seconds) = (0, 0.0);
            for stage in stages {
                steps += stage.done;
                seconds += stage.seconds;
            }
            (steps > 0).then(|| seconds / steps as f64)
        };
        let same_effort = self.stages.iter().filter(|((_, e), _)| *e == effort);
        mean(&mut std::iter::once(stage))
            .or_else(|| mean(&mut same_effort.map(|(_, stage)| stage)))
            .or_else(|| mean(&mut self.stages.values()))
            .unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn the_fraction_is_one_of_time_over_all_scenes() {
        let mut forecast = Forecast::default();
        for scene in ["a", "b"] {
            forecast.set_to_come(scene, Effort::References, 100);
            forecast.set_to_come(scene, Effort::Runs, 10);
        }
        assert_eq!(forecast.fraction(), 0.0);
        forecast.done("a", Effort::References, 100, SECOND);
        // Nothing is known of runs: one is taken to be like a sample. 1 s of 1 + 1 + 0.1 + 0.1.
        assert!((forecast.fraction() - 1.0 / 2.2).abs() < 1e-12);
        forecast.done("a", Effort::Runs, 10, 9 * SECOND);
        // Scene b is taken to be like a.
        assert!((forecast.fraction() - 0.5).abs() < 1e-12);
        forecast.done("b", Effort::References, 100, 4 * SECOND);
        assert!((forecast.fraction() - 14.0 / 23.0).abs() < 1e-12);
        forecast.close("b");
        assert_eq!(forecast.fraction(), 1.0);
    }

    #[test]
    fn what_is_found_to_be_missing_is_added() {
        let mut forecast = Forecast::default();
        forecast.set_to_come("a", Effort::Runs, 10);
        forecast.done("a", Effort::Runs, 10, SECOND);
        forecast.raise_to_come("a", Effort::Runs, 30);
        assert_eq!(forecast.fraction(), 0.25);
        forecast.raise_to_come("a", Effort::Runs, 3);
        assert_eq!(forecast.fraction(), 0.25);
        // More steps than were expected are no debt.
        forecast.done("a", Effort::Runs, 40, SECOND);
        assert_eq!(forecast.fraction(), 1.0);
    }
}

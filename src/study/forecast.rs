//! Estimates the fraction of a study that is done, from the durations of its steps so far and the number of steps to come.

use std::collections::BTreeMap;
use std::time::Duration;

/// A kind of work on a scene, whose steps take about equal time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effort {
    /// Rendering references. A step is one sample per pixel.
    References,
    /// Rendering the runs of configurations. A step is one frame.
    Runs,
    /// Rendering the path-traced controls that blocks are compared with. A step is one frame.
    Controls,
    /// Repeating runs, to find races and to count rays. A step is one frame.
    Repeats,
}

/// The steps of a study that are done and those to come, for each scene and kind of work. From them follows the fraction of
/// the study that is done, which progress reports show.
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
    /// Sets the number of steps that are still to come on a scene, for one kind of work. It replaces the earlier number.
    pub fn expect(&mut self, scene: &str, effort: Effort, steps: u64) {
        self.stage(scene, effort).to_come = steps;
    }

    /// Raises the number of steps that are still to come on a scene, for one kind of work, to `steps`; a number that is
    /// larger already stays. A study calls it before it renders runs, with the number of steps that it finds missing.
    pub fn expect_at_least(&mut self, scene: &str, effort: Effort, steps: u64) {
        let stage = self.stage(scene, effort);
        stage.to_come = stage.to_come.max(steps);
    }

    /// Ends the work on a scene: no steps of any kind are to come.
    pub fn close(&mut self, scene: &str) {
        for ((name, _), stage) in &mut self.stages {
            if name == scene {
                stage.to_come = 0;
            }
        }
    }

    /// Records that `steps` steps of one kind of work on a scene are done, and that together they took the time `took`. The
    /// steps to come are reduced by them, and their mean duration estimates the rest.
    pub fn done(&mut self, scene: &str, effort: Effort, steps: u64, took: Duration) {
        let stage = self.stage(scene, effort);
        stage.to_come = stage.to_come.saturating_sub(steps);
        stage.done += steps;
        stage.seconds += took.as_secs_f64();
    }

    /// The fraction of the study that is done, in [0, 1]: the time that its steps took, divided by that time and the
    /// estimated time of the steps to come. It is 0 before the first step.
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

    /// The expected duration of a step of one kind, in seconds: the mean on this scene or, if there is none yet, over all
    /// scenes or, without these, over all kinds of work.
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
            forecast.expect(scene, Effort::References, 100);
            forecast.expect(scene, Effort::Runs, 10);
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
        forecast.expect("a", Effort::Runs, 10);
        forecast.done("a", Effort::Runs, 10, SECOND);
        forecast.expect_at_least("a", Effort::Runs, 30);
        assert_eq!(forecast.fraction(), 0.25);
        forecast.expect_at_least("a", Effort::Runs, 3);
        assert_eq!(forecast.fraction(), 0.25);
        // More steps than were expected are no debt.
        forecast.done("a", Effort::Runs, 40, SECOND);
        assert_eq!(forecast.fraction(), 1.0);
    }
}

//! Estimates the fraction of a study that is done, for reports of progress, from the durations of the steps that are done
//! and the number of steps to come. A step is one frame, or one sample per pixel of a reference.

use std::collections::BTreeMap;
use std::time::Duration;

/// A kind of work on a scene, for which the forecast counts and times steps separately.
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

/// A part of the work of a study whose steps take about the same time, so that the steps that are done predict the others.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Task {
    /// The name of the scene in the plan on which the work is done.
    pub scene: String,
    /// The kind of the work, which decides whether a step is a sample per pixel or a frame.
    pub effort: Effort,
    /// The name of the configuration that is rendered; empty for references, which several configurations
    /// share.
    pub configuration: String,
}

/// For each [`Task`], the number of steps that are done, their total time, and the number of steps to come. From these it
/// estimates the fraction of the study that is done, which progress reports show.
#[derive(Debug, Default)]
pub struct Forecast {
    stages: BTreeMap<Task, Stage>,
}

#[derive(Debug, Default)]
struct Stage {
    to_come: u64,
    /// The steps of the first report and the steps of all later reports. They are kept apart, because the
    /// time of the first ones can contain the compilation of shaders.
    done: [Done; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct Done {
    steps: u64,
    seconds: f64,
}

impl Forecast {
    /// Sets the number of steps of a task that are still to come, which replaces the number that was set before.
    pub fn set_to_come(&mut self, task: Task, steps: u64) {
        self.stages.entry(task).or_default().to_come = steps;
    }

    /// Records that `steps` steps of a task are done, and that together they took the time `took`. The number of steps to
    /// come is reduced by `steps`, but not below 0.
    pub fn done(&mut self, task: Task, steps: u64, took: Duration) {
        let stage = self.stages.entry(task).or_default();
        stage.to_come = stage.to_come.saturating_sub(steps);
        let is_later = usize::from(stage.done[0].steps > 0);
        stage.done[is_later].steps += steps;
        stage.done[is_later].seconds += took.as_secs_f64();
    }

    /// The estimated fraction of the study that is done, in [0, 1]: the time of the steps that are done, divided by the sum
    /// of this time and the predicted time of the steps to come. It is 0 before the first step is done.
    pub fn fraction(&self) -> f64 {
        let done = self.stages.values().flat_map(|stage| stage.done);
        let passed: f64 = done.map(|done| done.seconds).sum();
        let left: f64 = (self.stages.iter())
            .filter(|(_, stage)| stage.to_come > 0)
            .map(|(task, stage)| stage.to_come as f64 * self.step_seconds(task))
            .sum();
        if passed > 0.0 {
            passed / (passed + left)
        } else {
            0.0
        }
    }

    /// The predicted duration of one step of a task, in seconds: the mean over its steps that are done, without its first
    /// report if there are later ones. If none is done, it is the mean over the steps of the same kind on the same scene,
    /// then over those of the same kind, and then over all; 0 before the first one.
    fn step_seconds(&self, task: &Task) -> f64 {
        let mean = |is_like: &dyn Fn(&Task) -> bool| {
            let like = self.stages.iter().filter(|(other, _)| is_like(other));
            let (mut steps, mut seconds) = (0, 0.0);
            for (_, stage) in like {
                let [first, later] = stage.done;
                let typical = if later.steps > 0 { later } else { first };
                steps += typical.steps;
                seconds += typical.seconds;
            }
            (steps > 0).then(|| seconds / steps as f64)
        };
        mean(&|other| other == task)
            .or_else(|| mean(&|other| other.effort == task.effort && other.scene == task.scene))
            .or_else(|| mean(&|other| other.effort == task.effort))
            .or_else(|| mean(&|_| true))
            .unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn task(scene: &str, effort: Effort) -> Task {
        Task {
            scene: scene.to_owned(),
            effort,
            configuration: String::new(),
        }
    }

    #[test]
    fn the_fraction_is_one_of_time_over_all_scenes() {
        let mut forecast = Forecast::default();
        for scene in ["a", "b"] {
            forecast.set_to_come(task(scene, Effort::References), 100);
            forecast.set_to_come(task(scene, Effort::Runs), 10);
        }
        assert_eq!(forecast.fraction(), 0.0);
        forecast.done(task("a", Effort::References), 100, SECOND);
        // Nothing is known of runs: one is taken to be like a sample. 1 s of 1 + 1 + 0.1 + 0.1.
        assert!((forecast.fraction() - 1.0 / 2.2).abs() < 1e-12);
        forecast.done(task("a", Effort::Runs), 10, 9 * SECOND);
        // Scene b is taken to be like a.
        assert!((forecast.fraction() - 0.5).abs() < 1e-12);
        forecast.done(task("b", Effort::References), 100, 4 * SECOND);
        assert!((forecast.fraction() - 14.0 / 23.0).abs() < 1e-12);
        forecast.set_to_come(task("b", Effort::Runs), 0);
        assert_eq!(forecast.fraction(), 1.0);
    }

    #[test]
    fn compilation_in_the_first_steps_is_not_expected_again() {
        let mut forecast = Forecast::default();
        let runs = task("a", Effort::Runs);
        forecast.set_to_come(runs.clone(), 20);
        forecast.done(runs.clone(), 1, 10 * SECOND);
        forecast.done(runs.clone(), 1, SECOND);
        assert!((forecast.fraction() - 11.0 / 29.0).abs() < 1e-12);
        // More steps than were expected are no debt.
        forecast.done(runs, 40, SECOND);
        assert_eq!(forecast.fraction(), 1.0);
    }
}

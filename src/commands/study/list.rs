//! `study --list`: prints the plans that come with the program.

use crate::Result;
use crate::commands::print;
use crate::study::plan::{Plan, Resolved, rendered_on};
use crate::study::plans::PLANS;
use std::fmt::Write as _;

/// The time that one sample of one pixel takes with path tracing and one scattering event, in microseconds,
/// on two CPU cores with lavapipe. It is a rough mean over the procedural scenes; each further scattering
/// event takes about as long.
const MICROSECONDS: f64 = 1.2;
/// The time of one frame of resampling, divided by the time of one sample per pixel of path tracing: a rough
/// mean over presets and scenes.
const RESAMPLING: f64 = 2.5;

/// Prints each plan with its purpose, its numbers of scenes, configurations and runs, and a rough time.
///
/// # Errors
/// A plan is wrong, which a test excludes, or stdout cannot be written.
pub fn run() -> Result<()> {
    let mut text = String::new();
    for (name, _) in PLANS {
        let plan = Plan::open(name)?;
        let configurations = plan.resolve()?;
        let scenes = plan.scenes.iter();
        let cells = scenes.map(|scene| rendered_on(&configurations, &scene.name).count());
        let runs = cells.sum::<usize>() as u64 * u64::from(plan.seeds);
        let _ = writeln!(
            text,
            "{name}: {}\n    {}, {}, {runs} runs, about {} on two CPU cores",
            plan.purpose,
            counted(plan.scenes.len(), "scene"),
            counted(configurations.len(), "configuration"),
            duration(seconds(&plan, &configurations))
        );
    }
    print(text.trim_end())
}

/// Formats a number with a noun, such as `3 scenes`; the noun gets an `s` unless the number is 1.
fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// A rough estimate of the time that the whole study takes on two CPU cores, in seconds. It does not include
/// seeds that the study adds if an interval is too wide.
fn seconds(plan: &Plan, configurations: &[Resolved]) -> f64 {
    let pixels = f64::from(plan.width).powi(2) * 9.0 / 16.0;
    let sample = MICROSECONDS * 1e-6 * pixels * f64::from(plan.bounces);
    let mut samples = 0.0;
    for scene in &plan.scenes {
        let blocks = plan.blocks(scene);
        samples += f64::from(blocks.size * blocks.count);
        for own in rendered_on(configurations, &scene.name) {
            let cost = match crate::study::costs::is_path_tracing(own) {
                true => 1.0,
                false => RESAMPLING,
            };
            samples += cost * f64::from(plan.seeds) * f64::from(own.frames);
        }
    }
    samples * sample
}

/// Formats a duration, given in seconds, as text in whole minutes or hours, because the estimate is not more
/// precise.
fn duration(seconds: f64) -> String {
    match seconds {
        ..45.0 => "a minute".to_owned(),
        ..5400.0 => format!("{:.0} minutes", (seconds / 60.0).ceil()),
        _ => format!("{:.0} hours", seconds / 3600.0),
    }
}

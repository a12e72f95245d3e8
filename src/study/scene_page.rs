//! Makes the page of one scene of a study from the results, costs, references and pictures that exist so far.

use super::comparison::Comparison;
use super::costs::Cost;
use super::exhibit::exhibit;
use super::identity::Identity;
use super::ledger::Ledger;
use super::manifest::Manifest;
use super::plan::{Plan, Resolved};
use super::planned_scene::PlannedScene;
use super::results::Row;
use super::subject::path_tracing;
use crate::Result;
use crate::base::shell_word::quoted;
use crate::page::{Page, Point};
use crate::render::presets;

/// One scene of a study with the results of its configurations, from which its page is made.
pub struct Scene<'a> {
    /// The plan of the study, which states the width of the pictures and the numbers of seeds and frames.
    pub plan: &'a Plan,
    /// The scene with its camera and environment, as the plan describes it.
    pub planned: &'a PlannedScene,
    /// The hashes by which the references and pictures of the scene are found, and the size of its pictures;
    /// `None` if it was not loaded yet.
    pub identity: Option<&'a Identity>,
    /// The configurations of the scene with their rows and costs, in the order of the plan.
    pub results: Vec<(&'a Resolved, &'a Row, &'a Cost)>,
}

impl Scene<'_> {
    /// The width and the height of the pictures, in pixels; (0, 0) for a scene that was not loaded yet.
    pub fn size(&self) -> (u32, u32) {
        self.identity.map_or((0, 0), |identity| identity.size)
    }

    /// Makes the page of the scene. The points are the configurations in the order of `comparison`. `None` if
    /// the scene was not loaded yet or has no reference.
    ///
    /// # Errors
    /// A file of a reference cannot be read.
    pub fn page(
        &self,
        comparison: &Comparison<'_>,
        manifest: &Manifest,
        ledger: &mut Ledger,
    ) -> Result<Option<Page>> {
        let Some(identity) = self.identity else {
            return Ok(None);
        };
        let blocks = self.plan.blocks(self.planned);
        let most = self.plan.most_blocks(blocks);
        // The page shows the reference of path tracing, or else that of the first configuration.
        let base = comparison
            .yardstick()
            .map(|index| comparison.entries[index]);
        let base = base.map(|entry| entry.configuration);
        let Some(base) = base.or(self.results.first().map(|(first, ..)| *first)) else {
            return Ok(None);
        };
        let library = &mut ledger.library;
        let Some(references) = library.references(identity, base, blocks, most)? else {
            return Ok(None);
        };
        let reference = references.last();
        let light = path_tracing(&base.settings);
        let mut points = Vec::new();
        for (index, entry) in comparison.entries.iter().enumerate() {
            let configuration = entry.configuration;
            let frames =
                (ledger.pictures).read(&identity.run_key(configuration, blocks)?, identity.size);
            // Other light has another reference, which is not on the page.
            let frames = frames.filter(|_| path_tracing(&configuration.settings) == light);
            points.push(Point {
                name: configuration.name.clone(),
                settings: presets::changes(&configuration.settings)?,
                command: self.command(configuration)?,
                milliseconds: entry.milliseconds(),
                is_timed: true,
                error: entry.error(),
                interval: entry.interval(),
                bias: bias(entry.row),
                at_equal_time: (entry.cost.error_at_equal_time)
                    .map(|ratio| (ratio.value, ratio.interval)),
                seeds: entry.row.seeds,
                standing: comparison.standing(index),
                exhibit: frames.map(|frames| {
                    let is_steady = !references.differ();
                    exhibit(entry, frames, reference, identity.size, is_steady)
                }),
            });
        }
        let mut facts = facts(self.plan, manifest);
        let (width, height) = identity.size;
        facts.insert(0, ("Scene".to_owned(), self.planned.name.clone()));
        facts.extend(
            [
                ("Size", format!("{width} × {height} pixels")),
                (
                    "Reference",
                    format!("{} samples per pixel", reference.samples),
                ),
                (
                    "Pictures",
                    "the last frame of the run with seed 0".to_owned(),
                ),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        Ok(Some(Page {
            title: format!(
                "Which settings for `{}`?",
                self.planned.name.replace('`', "'")
            ),
            overview: Some("../index.html".to_owned()),
            answer: comparison.answer(identity.size),
            points,
            yardstick: comparison.yardstick(),
            timed_size: identity.size,
            size: identity.size,
            reference: reference.mean.clone(),
            facts,
        }))
    }

    /// The command line of `headwater render` that renders the picture of a configuration, which the page
    /// shows for the user.
    fn command(&self, configuration: &Resolved) -> Result<String> {
        let Plan { bounces, width, .. } = self.plan;
        let mut command = format!(
            "headwater render {} {} --bounces {bounces}",
            quoted(&self.planned.name),
            presets::options(&configuration.settings)?
        );
        for (option, value) in [
            ("environment", &self.planned.environment),
            ("look-at", &self.planned.look_at),
        ] {
            if let Some(value) = value {
                command += &format!(" --{option} {}", quoted(value));
            }
        }
        // Views of studies have no jitter.
        command += &format!(" --width {width} --jitter off");
        let clock = configuration.clock;
        if clock.start_time != 0.0 {
            command += &format!(" --start-time {}", clock.start_time);
        }
        if let Some(fps) = clock.fps {
            command += &format!(" --fps {fps}");
        }
        let sums = if configuration.accumulate {
            " --accumulate"
        } else {
            ""
        };
        let frames = configuration.frames;
        Ok(format!("{command} --frames {frames}{sums} -o picture.exr"))
    }
}

/// The bias of the channel with the largest bias, as a fraction of the reference's mean, and the half-width
/// of its 95 % interval. Without a measured bias, (0, ∞).
fn bias(row: &Row) -> (f64, f64) {
    let Some((bias, _)) = row.deciding() else {
        return (0.0, f64::INFINITY);
    };
    let channels = bias.relative.into_iter().zip(bias.half_widths(0.95));
    let largest = channels.max_by(|(a, _), (b, _)| a.abs().total_cmp(&b.abs()));
    largest.unwrap_or((0.0, f64::INFINITY))
}

/// The conditions of the whole study, such as the plan and the device, as pairs of a name and a value. The
/// overview and the pages of the scenes list them.
pub fn facts(plan: &Plan, manifest: &Manifest) -> Vec<(String, String)> {
    let frames = match plan.fps {
        Some(fps) => format!("{} in each run, {fps} per second of the scene", plan.frames),
        None => format!("{} in each run", plan.frames),
    };
    let shard = manifest.shard;
    let mut facts = vec![
        ("Plan", manifest.request.plan.clone()),
        ("Question", plan.purpose.clone()),
        ("Device", manifest.device.clone()),
        ("Driver", manifest.driver.clone()),
        ("Version", manifest.commit.clone()),
        ("Frames", frames),
        (
            "Seeds",
            format!("{} or more for each configuration", plan.seeds),
        ),
        ("Bounces", format!("at most {}", plan.bounces)),
    ];
    if !shard.is_whole() {
        let part = format!("shard {} of {} of the study", shard.index + 1, shard.count);
        facts.push(("Part", part));
    }
    facts.retain(|(_, value)| !value.is_empty());
    let facts = facts.into_iter();
    facts
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

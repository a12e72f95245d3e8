//! Makes the contents of the HTML page that `advise` writes: the answer, the measured candidates, and their
//! pictures.

use super::{Args, command};
use crate::Result;
use crate::advice::chain::Purpose;
use crate::advice::exhibit::Gallery;
use crate::advice::front::{Front, Point, Verdict};
use crate::advice::sentence;
use crate::commands::session::OpenedScene;
use crate::page::{Answer, Exhibit, Page, Standing};
use crate::render::presets::changes;

/// Makes the page from the measurements `front` and the pictures `gallery`. `fps` is the number of frames per
/// second in the commands that the page shows; with `None`, they have no option `--fps`.
///
/// # Errors
/// The settings of a candidate are invalid. A test ensures that they are valid, so this does not happen.
pub fn page(
    args: &Args,
    scene: &OpenedScene,
    front: &Front,
    gallery: Gallery,
    fps: Option<f64>,
) -> Result<Page> {
    let is_decided = !matches!(front.verdict, Verdict::Undecided(_));
    let measured = front.points();
    let is_path_tracing = |p: &&Point| p.candidate.is_path_tracing().unwrap_or(false);
    let yardstick = measured.iter().position(is_path_tracing);
    let mut points = Vec::new();
    for (rank, point) in measured.iter().enumerate() {
        let candidate = &point.candidate;
        let standing = match rank {
            0 if is_decided => Standing::Advised,
            _ if yardstick.is_some_and(|y| point.is_empty(measured[y])) => Standing::Empty,
            _ if rank < front.finalists.len() => Standing::Finalist,
            _ => Standing::LeftOut,
        };
        let exhibit = gallery.of(candidate).cloned();
        let path_traced = yardstick.map(|y| measured[y].error_in(point.milliseconds));
        let at_equal_time = path_traced.and_then(|other| {
            let [low, high] = other.interval?;
            let ratio = |other| point.error.value / other;
            Some((ratio(other.value), [ratio(high), ratio(low)]))
        });
        points.push(crate::page::Point {
            name: candidate.name.clone(),
            settings: changes(&candidate.settings()?)?,
            command: command(args, &candidate.options(), fps, front.purpose.frames()),
            milliseconds: point.milliseconds,
            is_timed: point.is_timed,
            error: point.error.value,
            // The first references of the race were too noisy for an interval to be honest.
            interval: (point.error.interval).filter(|_| rank < front.finalists.len()),
            bias: (point.bias.relative, point.bias.half_width),
            at_equal_time: (Some(rank) != yardstick).then_some(at_equal_time).flatten(),
            seeds: point.chains,
            standing,
            exhibit: exhibit.map(|exhibit| at_wanted_size(exhibit, point.milliseconds)),
        });
    }
    Ok(Page {
        title: format!("Which preset for `{}`?", args.view.scene.replace('`', "'")),
        overview: None,
        answer: Answer {
            is_decided,
            sentence: sentence::advice(front),
            details: sentence::details(front),
        },
        points,
        yardstick,
        timed_size: front.wanted_size,
        size: front.size,
        reference: gallery.reference,
        facts: facts(args, scene, front),
    })
}

/// Scales the times of the passes, which were measured in frames of the race's size, so that their sum is
/// `milliseconds`, the time of a frame of the size that the user wants.
fn at_wanted_size(mut exhibit: Exhibit, milliseconds: f64) -> Exhibit {
    let sum: f64 = exhibit.passes.iter().map(|(_, time)| time).sum();
    if sum > 0.0 {
        for (_, time) in &mut exhibit.passes {
            *time *= milliseconds / sum;
        }
    }
    exhibit
}

fn facts(args: &Args, scene: &OpenedScene, front: &Front) -> Vec<(String, String)> {
    let info = &scene.device.info;
    let purpose = match front.purpose {
        Purpose::Still => "single frames without history",
        Purpose::Steady => "late frames of a camera at rest",
        Purpose::Motion => "late frames of a moving camera",
        Purpose::Mean => "the mean of frames of a camera at rest",
    };
    let times = if front.finalists.iter().all(|point| point.is_timed) {
        "measured at this size for all that came into the final"
    } else {
        "scaled with the number of pixels"
    };
    [
        ("Scene", args.view.scene.clone()),
        ("Hash of the scene", scene.scene_hash.clone()),
        ("Frames", purpose.to_owned()),
        ("Device", info.name.clone()),
        ("Driver", info.driver.clone()),
        ("Version", env!("HEADWATER_COMMIT").to_owned()),
        (
            "Wanted size",
            format!(
                "{} × {} pixels; times {times}",
                front.wanted_size.0, front.wanted_size.1
            ),
        ),
        (
            "Size of the pictures",
            format!(
                "{} × {} pixels; times of passes are scaled from it",
                front.size.0, front.size.1
            ),
        ),
        (
            "References",
            format!(
                "two, with {} samples per pixel each",
                front.reference_samples
            ),
        ),
        (
            "Time",
            format!(
                "{:.0} s, and {:.0} s for the compilation of shaders",
                front.seconds, front.compilation_seconds
            ),
        ),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

//! One run: renders the frames of one configuration with one seed, and measures them against references.

use super::plan::Resolved;
use super::reference::References;
use crate::Result;
use crate::gpu::PassTime;
use crate::metrics::error::{Errors, error_correlation};
use crate::metrics::statistics::median;
use crate::render::Renderer;
use crate::render::counters::Counts;
use crate::scene::MovingCamera;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// The times of passes: the name of each pass and its time in milliseconds, in the order in which the passes run.
pub type Milliseconds = Vec<(String, f64)>;

/// The results of one run, as the store keeps them. Lists with one entry for each frame begin with frame 0.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Run {
    /// The name of the scene in the plan.
    pub scene: String,
    /// The name of the configuration in the plan.
    pub configuration: String,
    /// The hash, as 16 hexadecimal digits, of everything that the run depends on, except the seed. A run with other settings
    /// has another key.
    pub key: String,
    /// The seed, from which all random numbers of the run follow.
    pub seed: u32,
    /// The RMSE of each frame against its reference, in linear RGB.
    pub rmse: Vec<f64>,
    /// The RMSE of each frame after it and its reference are clamped to [0, 1].
    pub rmse_clamped: Vec<f64>,
    /// The relMSE of each frame against its reference: the mean of (a − b)² / (b² + 0.01) for values a of the frame and b of
    /// the reference.
    pub relmse: Vec<f64>,
    /// The temporal correlation of each frame, in [−1, 1]: Pearson's correlation of its errors with those of the previous
    /// frame; 0 for frame 0.
    #[serde(default)]
    pub correlation: Vec<f64>,
    /// The median ratio of each frame to its reference, which is 1 without bias:
    /// [`Reference::median_ratio`](super::reference::Reference::median_ratio).
    #[serde(default)]
    pub median: Vec<f64>,
    /// The mean radiance of each channel, without directly visible emission, over the last frame. If frames show one time
    /// and do not depend on each other, it is the mean over all frames.
    pub mean: [f64; 3],
    /// The mean luminance of each block of 8 × 8 pixels, row by row, over the same frames as [`Self::mean`] and without
    /// emission.
    pub blocks: Vec<f64>,
    /// The time of each pass in a frame, as the median over frames. Frame 0, which has no history, is left out if there are
    /// others, and so are first runs of passes.
    pub milliseconds: Milliseconds,
    /// The times of passes when they ran for the first time, in which some drivers compile them.
    #[serde(default)]
    pub first_runs: Milliseconds,
    /// The counts of each pass in the last frame, such as the number of rays; empty unless the renderer counts.
    #[serde(skip)]
    pub counts: Vec<Counts>,
    /// The memory on the device that resampling keeps for each pixel, in bytes.
    #[serde(default)]
    pub bytes_per_pixel: f64,
    /// The number of values that the renderer rejected (NaN, infinite, negative, or too large), over all frames.
    pub rejected: u32,
    /// The duration of the whole run, with its measurements, in seconds; 0 if it was not recorded.
    #[serde(default)]
    pub seconds: f64,
}

impl Run {
    /// True if the lists of the run have the lengths for `frames` frames and `blocks` blocks. Otherwise its line in the file
    /// was edited or damaged, and the run is rendered again.
    pub fn has_lengths(&self, frames: usize, blocks: usize) -> bool {
        let of_frames = [
            &self.rmse,
            &self.rmse_clamped,
            &self.relmse,
            &self.correlation,
            &self.median,
        ];
        of_frames.iter().all(|list| list.len() == frames) && self.blocks.len() == blocks
    }

    /// True if the means of channels and of blocks are equal to the last bit, which stands for equal pictures. Errors are
    /// not compared: a study with `--quick` and one without have different references.
    pub fn same_as(&self, other: &Self) -> bool {
        (self.mean, &self.blocks) == (other.mean, &other.blocks)
    }
}

/// Renders the frames of one configuration with one seed, and measures each against its reference. `renderer` is made for
/// the configuration. `camera` is the camera whose motion the frames follow; `None` if it does not move.
///
/// # Errors
/// The device fails, or the scene cannot be rendered at a frame's time.
pub fn measure(
    renderer: &mut Renderer,
    configuration: &Resolved,
    seed: u32,
    references: &References,
    camera: Option<&MovingCamera>,
) -> Result<Run> {
    let began = Instant::now();
    renderer.restart(seed)?;
    let mut run = Run {
        configuration: configuration.name.clone(),
        seed,
        bytes_per_pixel: renderer.bytes_per_pixel(),
        ..Run::default()
    };
    let mut before: Option<Vec<[f32; 3]>> = None;
    let mut times: Vec<Milliseconds> = Vec::new();
    let mut judged: Vec<([f64; 3], Vec<f64>)> = Vec::new();
    for index in 0..configuration.frames {
        renderer.set_moment(configuration.clock.time(index), camera)?;
        let reference = references.of(index);
        let (passes, picture): (_, Vec<[f32; 3]>) = if configuration.accumulate {
            let passes = renderer.add_samples(index, 1)?;
            let mean = renderer.sums()?.mean(index + 1);
            let mean = mean.iter().map(|p| p.as_vec3().to_array()).collect();
            (passes, mean)
        } else {
            (
                PassTime::by_name(renderer.single_frame(index)?),
                renderer.frame_radiance()?,
            )
        };
        let (first_runs, rest): (Vec<_>, Vec<_>) =
            passes.into_iter().partition(|pass| pass.first_run);
        let named = |pass: PassTime| (pass.name, pass.milliseconds);
        run.first_runs.extend(first_runs.into_iter().map(named));
        times.push(rest.into_iter().map(named).collect());
        // A frame with history has in it what came before; the others are as good as further seeds
        // where they show one time.
        if configuration.accumulate || renderer.has_history() || references.differ() {
            judged.clear();
        }
        judged.push(reference.reduce(&picture));
        run.counts = renderer.counts()?;
        let errors = Errors::between(&picture, &reference.mean);
        run.rmse.push(errors.rmse);
        run.rmse_clamped.push(errors.rmse_clamped);
        run.relmse.push(errors.relmse);
        run.median.push(reference.median_ratio(&picture));
        let last = before.as_deref().map(|before| {
            let before = [before, &references.of(index - 1).mean];
            error_correlation(before, [&picture, &reference.mean])
        });
        run.correlation.push(last.unwrap_or(0.0));
        before = Some(picture);
    }
    let each = 1.0 / judged.len() as f64;
    for (mean, blocks) in judged {
        run.blocks.resize(blocks.len(), 0.0);
        let parts = run.mean.iter_mut().zip(mean);
        for (sum, value) in parts.chain(run.blocks.iter_mut().zip(blocks)) {
            *sum += value * each;
        }
    }
    run.milliseconds = medians(&times[usize::from(times.len() > 1)..]);
    run.rejected = renderer.rejected()?;
    run.seconds = began.elapsed().as_secs_f64();
    Ok(run)
}

/// The median time of each pass over all entries of `all`, which are the times of several frames or runs. The passes are
/// those of the last entry, in its order.
pub fn medians<'a>(all: impl IntoIterator<Item = &'a Milliseconds>) -> Milliseconds {
    let all: Vec<&Milliseconds> = all.into_iter().collect();
    let of_pass = |name: &str| {
        let passes = all
            .iter()
            .copied()
            .flatten()
            .filter(|(pass, _)| pass == name);
        median(passes.map(|(_, milliseconds)| *milliseconds))
    };
    let passes = all.last().copied().into_iter().flatten();
    passes
        .map(|(name, _)| (name.clone(), of_pass(name)))
        .collect()
}

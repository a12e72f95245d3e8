//! Renders one run, which is the frames of one configuration with one seed, and measures the frames against references.

use super::pictures::LastFrames;
use super::plan::Resolved;
use super::reference::References;
use crate::Result;
use crate::gpu::PassTime;
use crate::metrics::error::{SquaredErrors, error_correlation};
use crate::metrics::statistics::median;
use crate::render::Renderer;
use crate::render::counters::Counts;
use crate::scene::MovingCamera;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// The times of passes, which results state as the cost of a configuration: pairs of the name of a pass and its time in
/// milliseconds, in the order in which the passes are executed.
pub type Milliseconds = Vec<(String, f64)>;

/// The results of one run, which is the frames of one configuration with one seed. The bias is estimated from the runs with
/// many seeds. The store writes each run to its file, so that a study can continue. Lists with one entry for each frame
/// begin with frame 0.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Run {
    /// The name of the scene in the plan, for readers of the file. The store finds a run by [`Self::key`] and
    /// seed.
    pub scene: String,
    /// The name of the configuration in the plan, for readers of the file. The store finds a run by
    /// [`Self::key`] and seed.
    pub configuration: String,
    /// A hash, as 16 hexadecimal digits, of everything that the run depends on except its seed. The store finds finished
    /// runs by key and seed, so a change of the settings, for example, makes new runs necessary.
    pub key: String,
    /// The seed from which all random numbers of the run are made. Runs with different seeds have independent noise.
    pub seed: u32,
    /// The mean squared error of each frame of the run against the reference of its time, in linear RGB and in the square of
    /// the scene's unit of radiance. As in the next two lists, the noise of the reference is taken out
    /// ([`SquaredErrors`]), so that a value can be slightly negative.
    pub mse: Vec<f64>,
    /// The mean squared error of each frame of the run against the reference of its time, with the pixel values clamped to
    /// [0, 1], so that a few very bright pixels do not dominate.
    pub clamped_mse: Vec<f64>,
    /// The relMSE of each frame of the run against the reference of its time: the mean over pixels and channels of (a − t)²
    /// / (b² + 0.01), where a is the value in the frame, t the truth, and b the value in the reference.
    pub relmse: Vec<f64>,
    /// For each frame, Pearson's correlation of the errors of all pixels with their errors in the previous frame. It is in
    /// [−1, 1]: 1 means that both frames have the same noise, 0 that their noise is independent. Frame 0 has 0.
    pub correlation: Vec<f64>,
    /// For each frame, the median of the ratio of a pixel's luminance to its luminance in the reference
    /// ([`Reference::median_ratio`](super::reference::Reference::median_ratio)). If it is below 1, most lit pixels are too
    /// dark, which a few very bright pixels can hide in the mean.
    pub median: Vec<f64>,
    /// The mean radiance of each channel (linear RGB, in the scene's unit) over the pixels, without emission that the camera
    /// sees directly. It is the mean over all frames if they show the same time and do not use earlier frames (no history,
    /// no accumulation); otherwise it is of the last frame only. The test for bias compares it with the reference.
    pub mean: [f64; 3],
    /// The mean luminance of each block of 8 × 8 pixels, row by row, without directly visible emission. The means are over
    /// the same frames as [`Self::mean`]. They show a bias that cancels over the picture.
    pub blocks: Vec<f64>,
    /// For each frame, the time of each pass in milliseconds. The first execution of each pass, which may contain its
    /// compilation, is left out.
    pub milliseconds: Vec<Milliseconds>,
    /// The times of passes that this run executed for the first time since the renderer was made, in milliseconds. Results
    /// state them apart from the other times, because some drivers compile a pass then. Empty if all passes had been
    /// executed before this run.
    pub first_runs: Milliseconds,
    /// The counts of each pass in the last frame, such as the number of rays. Empty unless the renderer counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counts: Vec<Counts>,
    /// The memory on the device that resampling keeps between passes and frames, in bytes for each pixel of the picture; 0
    /// for path tracing.
    pub bytes_per_pixel: f64,
    /// The number of radiances and weights (of candidates and reservoirs) that shaders rejected because they were NaN,
    /// infinite, negative or too large, over all frames of the run. Each was replaced by 0.
    pub rejected: u32,
    /// The duration of the whole run, including the measurement of its frames, in seconds. It predicts the duration of
    /// further runs.
    pub seconds: f64,
}

impl Run {
    /// True if each list of the run with one entry per frame has `frames` entries, and the list with one entry per block of
    /// pixels has `blocks`. If false, the run's line in the file was edited or damaged, and the caller renders the run again.
    pub fn has_lengths(&self, frames: usize, blocks: usize) -> bool {
        let of_frames = [
            &self.mse,
            &self.clamped_mse,
            &self.relmse,
            &self.correlation,
            &self.median,
        ];
        of_frames.iter().all(|list| list.len() == frames)
            && self.milliseconds.len() == frames
            && self.blocks.len() == blocks
    }

    /// True if both runs have the same means of channels and of blocks, to the last bit; then their pictures count as equal.
    /// If a run and its repetition differ, a pass has a data race. Errors such as the relMSE are not compared, because they
    /// also depend on the references, and the option `--quick` changes these.
    pub fn same_as(&self, other: &Self) -> bool {
        (self.mean, &self.blocks) == (other.mean, &other.blocks)
    }
}

/// Renders the frames of one configuration with one seed, and measures each against its reference. `renderer` must have been
/// made for the settings of the configuration. `camera` is the moving camera from which the frames are seen; with `None`,
/// the renderer's camera stands still. The last frames are returned too, as pictures for pages.
///
/// # Errors
/// The device fails, or the scene cannot be rendered at a frame's time.
pub fn measure(
    renderer: &mut Renderer,
    configuration: &Resolved,
    seed: u32,
    references: &References,
    camera: Option<&MovingCamera>,
) -> Result<(Run, LastFrames)> {
    let began = Instant::now();
    renderer.restart(seed)?;
    let mut run = Run {
        configuration: configuration.name.clone(),
        seed,
        bytes_per_pixel: renderer.bytes_per_pixel(),
        ..Run::default()
    };
    let mut frames = LastFrames::default();
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
        run.milliseconds.push(rest.into_iter().map(named).collect());
        // A frame with history has in it what came before; the others are as good as further seeds
        // where they show one time.
        if configuration.accumulate || renderer.has_history() || references.differ() {
            judged.clear();
        }
        judged.push(reference.reduce(&picture));
        run.counts = renderer.counts()?;
        let errors = SquaredErrors::between(&picture, &reference.halves);
        run.mse.push(errors.mse);
        run.clamped_mse.push(errors.clamped_mse);
        run.relmse.push(errors.relmse);
        run.median.push(reference.median_ratio(&picture));
        frames.push(picture);
        let correlation = frames.before.as_deref().map(|before| {
            let before = (before, &references.of(index - 1).halves);
            error_correlation(before, (&frames.last, &reference.halves))
        });
        run.correlation.push(correlation.unwrap_or(0.0));
    }
    let each = 1.0 / judged.len() as f64;
    for (mean, blocks) in judged {
        run.blocks.resize(blocks.len(), 0.0);
        let parts = run.mean.iter_mut().zip(mean);
        for (sum, value) in parts.chain(run.blocks.iter_mut().zip(blocks)) {
            *sum += value * each;
        }
    }
    run.rejected = renderer.rejected()?;
    run.seconds = began.elapsed().as_secs_f64();
    Ok((run, frames))
}

/// The median time of each pass in one frame of `runs`, in the order in which the passes are executed. Frame 0, which has no
/// history, is left out if there are other frames.
pub fn frame_times(runs: &[&Run]) -> Milliseconds {
    let frames = runs.iter().flat_map(|run| {
        let skipped = usize::from(run.milliseconds.len() > 1);
        &run.milliseconds[skipped..]
    });
    medians(frames)
}

/// The median time of each pass over all entries of `all`, where each entry has the times of one frame. The result has the
/// passes in the order of their first occurrence; it is empty if there are none.
fn medians<'a>(all: impl Iterator<Item = &'a Milliseconds>) -> Milliseconds {
    let mut passes: Vec<(&str, Vec<f64>)> = Vec::new();
    for (name, ms) in all.flatten() {
        match passes.iter_mut().find(|(known, _)| known == name) {
            Some((_, times)) => times.push(*ms),
            None => passes.push((name, vec![*ms])),
        }
    }
    let passes = passes.into_iter();
    passes
        .map(|(name, times)| (name.to_owned(), median(times.into_iter())))
        .collect()
}

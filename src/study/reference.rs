//! References: path-traced pictures with a small and known error, with which the runs of studies are compared. Each is
//! rendered once, in blocks of samples, and stored in one file for each block, whose name begins with a hash of everything
//! that the reference depends on.

use crate::base::input_files;
use crate::base::progress::Watch;
use crate::device_scene::GpuScene;
use crate::gpu::Device;
use crate::image::Image;
use crate::metrics::error::median_ratio;
use crate::metrics::statistics::Estimate;
use crate::render::{Renderer, Settings, View};
use crate::scene::lights::luminance;
use crate::{Error, Result};
use glam::{DVec3, Vec3};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The side of a block of pixels, in pixels. Studies test the mean luminance of each block of a picture for bias, because a
/// bias can cancel over the whole picture. Blocks at the right and lower edges of the picture may be smaller.
pub const BLOCK: usize = 8;
/// The largest difference from the reference that rounding alone can cause in a pixel, as a fraction of the pixel's value.
/// Smaller differences do not count as bias. The limit has a margin: sums of thousands of samples have a precision of at
/// least 24 bits, so their relative error is below 10⁻⁷.
const ROUNDING: f64 = 1e-6;
/// The seed of all references. It is far from the seeds of runs, so that the random numbers of a reference differ from those
/// of every run.
const SEED: u32 = 0x5EED_0000;
/// The maximum number of samples per pixel that one call of the renderer adds to a reference. After each call, the study
/// reports its progress and can stop after a signal. If a call renders a picture in strips of rows, the study also does so
/// after each strip.
const AT_ONCE: u32 = 16;
/// The maximum number of samples per pixel of a block, which is the unit of work for a reference and has its
/// own file.
const MAX_BLOCK_SAMPLES: u32 = 1024;
/// The number of blocks into which the samples of a small reference are divided, so that even its error is
/// estimated from several blocks.
const FEWEST_BLOCKS: u32 = 8;
/// The number of blocks, counted from the first one, with which the errors of runs are measured: one for each of the two
/// pictures of [`Reference::halves`].
pub const MEASURING_BLOCKS: u32 = 2;

/// The division of the samples of a reference into blocks. Each block is rendered separately; in a study that
/// is divided into shards, different machines render different blocks. The blocks are added in the order of
/// their index, so that a reference always has the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleBlocks {
    /// The number of samples per pixel of a block, at least 2. The standard error of the block is estimated
    /// from them.
    pub size: u32,
    /// The number of blocks that the plan requests for the reference, at least [`MEASURING_BLOCKS`].
    pub count: u32,
}

impl SampleBlocks {
    /// Divides the samples of a reference into blocks that have at least `samples` samples per pixel
    /// together. If `quick` is true, only a quarter of these blocks is used. The blocks keep their size, so
    /// that a later study without `--quick` uses them again.
    pub fn new(samples: u32, quick: bool) -> Self {
        let size = samples.div_ceil(FEWEST_BLOCKS).clamp(2, MAX_BLOCK_SAMPLES);
        let count = samples.div_ceil(size);
        let count = if quick { count.div_ceil(4) } else { count };
        Self {
            size,
            count: count.max(MEASURING_BLOCKS),
        }
    }

    /// The range of the indices of the samples in the block with the index `block`. The index can exceed
    /// [`Self::count`], if a reference gets more samples than the plan states.
    pub fn samples_of(self, block: u32) -> Range<u32> {
        let first = block * self.size;
        first..first + self.size
    }
}

/// The inputs of a reference, which is a path-traced picture that runs are compared with: what it shows, and how it is
/// rendered.
pub struct Shot<'a> {
    /// The device that renders the reference.
    pub device: &'a Arc<Device>,
    /// The scene, uploaded to `device`.
    pub scene: &'a Arc<GpuScene>,
    /// The time in the scene that the reference shows, in seconds.
    pub time: f64,
    /// The camera as it is at `time`, the size of the picture, and the maximum number of bounces. Its seed has no effect,
    /// because all references use the same seed.
    pub view: View,
    /// The settings of path tracing with which the reference is rendered.
    pub settings: &'a Settings,
}

impl Shot<'_> {
    /// Makes a renderer of the reference whose paths have at most `bounces` scattering events. With 0, the picture shows
    /// only emitters that the camera sees directly.
    fn renderer(&self, bounces: u32) -> Result<Renderer> {
        let view = View {
            seed: SEED,
            bounces,
            ..self.view.clone()
        };
        let mut renderer = Renderer::new(self.device, self.scene.clone(), &view, self.settings)?;
        renderer.set_time(self.time);
        Ok(renderer)
    }

    /// Renders the blocks that have no file yet, and writes a file for each. `files` has the path and the samples of each
    /// block. `watch` is called with the number of samples per pixel that are done; an error from it ends the work, and the
    /// files that are complete stay.
    ///
    /// # Errors
    /// The device or the disk fails, path tracing rejected values, or `watch` returns an error.
    pub fn render(&self, files: &[(PathBuf, Range<u32>)], watch: &mut Watch) -> Result<()> {
        let missing = files.iter().filter(|(path, _)| !path.exists());
        let mut renderers = None;
        let mut done = 0;
        for (path, samples) in missing {
            let (emission, renderer) = match &mut renderers {
                Some(made) => made,
                None => {
                    let mut emitters = self.renderer(0)?;
                    emitters.add_samples(0, 1)?;
                    let emission = in_f32(emitters.sums()?.mean(1));
                    renderers.insert((emission, self.renderer(self.view.bounces)?))
                }
            };
            renderer.restart(SEED)?;
            for first in samples.clone().step_by(AT_ONCE as usize) {
                let count = AT_ONCE.min(samples.end - first);
                let mut watch =
                    |fraction: f64| watch(f64::from(done) + fraction * f64::from(count));
                renderer.add_samples_watched(first, count, &mut watch)?;
                done += count;
            }
            watch(f64::from(done))?;
            if renderer.rejected()? > 0 {
                return Err(Error::failed(format!(
                    "{}: path tracing refused values, so the reference would be too dark",
                    path.display()
                )));
            }
            let (sums, count) = (renderer.sums()?, samples.len() as u32);
            let mut image = Image::new(self.view.width, self.view.height);
            image.set_vectors("", COLORS, &in_f32(sums.mean(count)));
            image.set_vectors("stderr.", COLORS, &in_f32(sums.standard_error(count)));
            image.set_vectors("emission.", COLORS, emission);
            image.write(path, 0.0)?;
        }
        Ok(())
    }
}

const COLORS: [&str; 3] = ["R", "G", "B"];

fn in_f32(values: Vec<DVec3>) -> Vec<[f32; 3]> {
    values.iter().map(|v| v.as_vec3().to_array()).collect()
}

/// A path-traced picture with a small and known error, with which runs are compared. Its lists have one RGB value for each
/// pixel, row by row from the top.
#[derive(Clone)]
pub struct Reference {
    /// The width of the picture, in pixels. The height follows from the number of pixels.
    pub width: u32,
    /// The mean of the radiance of each pixel over all samples, in linear RGB and in the scene's unit.
    pub mean: Vec<[f32; 3]>,
    /// The standard error of [`Self::mean`] for each pixel and channel. It is at least 0 and in the unit of the mean. The
    /// intervals of a bias include it.
    pub error: Vec<[f32; 3]>,
    /// The radiance of the emitter that each pixel shows directly, in the unit of [`Self::mean`]; 0 where it shows none. It
    /// is subtracted from pictures before their means are compared, because it has no noise, and because bright emitters
    /// would hide the relative error of the lit surfaces.
    pub emission: Vec<[f32; 3]>,
    /// The number of samples per pixel from which [`Self::mean`] and [`Self::error`] are computed. Confidence intervals that
    /// include the error of the reference depend on it too, because the quantile of Student's distribution does.
    pub samples: u32,
    /// Two pictures of the same view, from different samples, with which the errors of runs are measured
    /// ([`SquaredErrors`](crate::metrics::error::SquaredErrors)). They do not change when the reference gets
    /// more samples, so that the errors of earlier runs of a study stay valid.
    pub halves: [Vec<[f32; 3]>; 2],
    /// For each block of samples, an estimate of the variance of one sample's picture mean: the variance of
    /// the block's mean, summed over the channels, times the number of its samples. The spread of these
    /// values states how well the variance of the whole reference is known.
    variances: Vec<f64>,
    /// For each pixel, two sums over the blocks, from which [`Self::mean`] and [`Self::error`] are computed:
    /// of the mean times the number of samples, and of the squared standard error times the square of this
    /// number.
    sums: Vec<[DVec3; 2]>,
}

impl Reference {
    /// Reads a reference from its first [`MEASURING_BLOCKS`] blocks. `files` has the path of each block and
    /// the indices of its samples. The picture must have `width` × `height` pixels.
    ///
    /// # Errors
    /// A file cannot be read, is damaged, or is not a block of a reference with a picture of `width` × `height` pixels.
    pub fn read((width, height): (u32, u32), files: &[(PathBuf, Range<u32>)]) -> Result<Self> {
        let pixels = width as usize * height as usize;
        let black = vec![[0.0; 3]; pixels];
        let mut reference = Self {
            width,
            mean: black.clone(),
            error: black.clone(),
            emission: black.clone(),
            samples: 0,
            halves: [black.clone(), black],
            variances: Vec::new(),
            sums: vec![[DVec3::ZERO; 2]; pixels],
        };
        for (half, (path, samples)) in files.iter().enumerate().take(MEASURING_BLOCKS as usize) {
            reference.halves[half] = reference.add(path, samples.len() as u32)?;
        }
        Ok(reference)
    }

    /// Makes a reference for tests, with the given mean and standard error of each pixel, as if it had
    /// `samples` samples per pixel. Both halves are equal to the mean.
    #[cfg(test)]
    pub fn known(width: u32, mean: Vec<[f32; 3]>, error: Vec<[f32; 3]>, samples: u32) -> Self {
        Self {
            width,
            emission: vec![[0.0; 3]; mean.len()],
            samples,
            halves: [mean.clone(), mean.clone()],
            variances: Vec::new(),
            sums: Vec::new(),
            mean,
            error,
        }
    }

    /// Adds the block in the file `path`, which has `count` samples per pixel, to the mean and the error.
    /// Blocks must be added in the order of their index. Returns the mean radiance of each pixel in this
    /// block.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn add(&mut self, path: &Path, count: u32) -> Result<Vec<[f32; 3]>> {
        let unusable = |why: &str| {
            Error::input(format!(
                "{}: {why}; delete this file, and the study makes it again",
                path.display()
            ))
        };
        let image = Image::read(path).map_err(|error| match input_files::open(path) {
            Ok(_) => unusable("the reference is damaged"),
            Err(_) => error,
        })?;
        let pixels = self.sums.len();
        let vectors = |prefix: &str| -> Result<Vec<[f32; 3]>> {
            let channel = |c| image.floats(&format!("{prefix}{c}")).unwrap_or_default();
            let [r, g, b] = COLORS.map(channel);
            if [r, g, b].iter().any(|c| c.len() != pixels) {
                return Err(unusable("it is not a reference of this view"));
            }
            Ok((0..pixels).map(|i| [r[i], g[i], b[i]]).collect())
        };
        let (mean, error) = (vectors("")?, vectors("stderr.")?);
        self.emission = vectors("emission.")?;
        self.samples += count;
        let (own, all) = (f64::from(count), f64::from(self.samples));
        let in_f64 = |value: &[f32; 3]| Vec3::from(*value).as_dvec3();
        let mut variance = 0.0;
        for (i, [means, squares]) in self.sums.iter_mut().enumerate() {
            let error = in_f64(&error[i]);
            *means += own * in_f64(&mean[i]);
            *squares += own * own * error * error;
            variance += own * error.length_squared() / (pixels * pixels) as f64;
            self.mean[i] = (*means / all).as_vec3().to_array();
            self.error[i] = [0, 1, 2].map(|c| (squares[c].sqrt() / all) as f32);
        }
        self.variances.push(variance);
        Ok(mean)
    }

    /// Reduces a picture to the means that are tested for a bias, after it has subtracted the reference's emission from each
    /// pixel. Returns the mean radiance of each channel over the whole picture, and the mean luminance of each block (a
    /// square of [`BLOCK`] × [`BLOCK`] pixels), row by row.
    pub fn reduce(&self, picture: &[[f32; 3]]) -> ([f64; 3], Vec<f64>) {
        self.means(|i, c| f64::from(picture[i][c]) - f64::from(self.emission[i][c]))
    }

    /// The median, over pixels, of the ratio of a pixel's luminance in `picture` to its mean luminance in [`Self::halves`].
    /// Pixels that are black there or show an emitter are left out. If the median is below 1, most of the other pixels are too
    /// dark; it is 1 if there are no other pixels.
    pub fn median_ratio(&self, picture: &[[f32; 3]]) -> f64 {
        let [first, second] = &self.halves;
        let pixels = picture
            .iter()
            .zip(first.iter().zip(second))
            .zip(&self.emission);
        let lit = pixels.filter(|(_, emission)| **emission == [0.0; 3]);
        let of = |pixel: &[f32; 3]| luminance((*pixel).into());
        median_ratio(
            lit.map(|((picture, (first, second)), _)| {
                (of(picture), 0.5 * (of(first) + of(second)))
            }),
        )
    }

    /// The largest differences from the reference that rounding alone can cause, one for each mean that [`Self::reduce`]
    /// returns, and in the unit of that mean. If a difference and its standard error are both at most as large as the limit,
    /// the difference does not count as a bias. Rounding matters for a picture without noise, which differs from the
    /// reference only in the last bits of its sums. The limits also cover the rounding of directly visible emission, because
    /// the sums contain it.
    pub fn rounding(&self) -> ([f64; 3], Vec<f64>) {
        self.means(|i, c| {
            let emission = f64::from(self.emission[i][c]).abs();
            ROUNDING * emission.max(f64::from(self.mean[i][c]).abs())
        })
    }

    /// The positive values by which biases are divided, so that bright and dark scenes are comparable: one for the mean of
    /// each channel, and one for the mean luminance of blocks of pixels. They are the means of the reference without
    /// emission. A mean that is 0, or so small that it may be only rounding, is replaced by that of the brightest channel.
    /// If all channels are black, the mean emission replaces it or, without emission, the value 1.
    pub fn scale(&self) -> ([f64; 3], f64) {
        let (mean, blocks) = self.reduce(&self.mean);
        let (rounding, rounded_blocks) = self.rounding();
        let average = |blocks: &[f64]| blocks.iter().sum::<f64>() / blocks.len() as f64;
        let lit = |c: usize| Some(mean[c].abs()).filter(|mean| *mean > rounding[c]);
        let any = [0, 1, 2].into_iter().filter_map(lit).fold(0.0, f64::max);
        let emission = rounding.into_iter().fold(0.0, f64::max) / ROUNDING;
        let instead = [any, emission, 1.0].into_iter().find(|scale| *scale > 0.0);
        let instead = instead.unwrap_or(1.0);
        let luminance = Some(average(&blocks)).filter(|l| *l > average(&rounded_blocks));
        (
            [0, 1, 2].map(|c| lit(c).unwrap_or(instead)),
            luminance.unwrap_or(instead),
        )
    }

    /// The means of a picture that is given by `value`, a function from the index of a pixel and the index of a channel to
    /// the radiance there. Returns the mean of each channel over the whole picture, and the mean luminance of each block (a
    /// square of [`BLOCK`] × [`BLOCK`] pixels), row by row.
    fn means(&self, value: impl Fn(usize, usize) -> f64) -> ([f64; 3], Vec<f64>) {
        let pixels = self.mean.len();
        let mut mean = [0.0; 3];
        let mut blocks = self.empty_blocks();
        for i in 0..pixels {
            for (c, mean) in mean.iter_mut().enumerate() {
                *mean += value(i, c) / pixels as f64;
            }
            let (sum, count) = &mut blocks[self.block_of(i)];
            *sum += 0.2126 * value(i, 0) + 0.7152 * value(i, 1) + 0.0722 * value(i, 2);
            *count += 1.0;
        }
        let blocks = blocks.into_iter().map(|(sum, count)| sum / count);
        (mean, blocks.collect())
    }

    /// The mean radiance of each channel over the picture, without emission, in the unit of [`Self::mean`], with its
    /// standard error. The mean of a configuration's pictures minus this value is the bias. The standard error is computed
    /// as if the errors of pixels were independent.
    pub fn mean_estimates(&self) -> [Estimate; 3] {
        let (mean, _) = self.reduce(&self.mean);
        let count = self.error.len() as f64;
        [0, 1, 2].map(|c| {
            let squares: f64 = self.error.iter().map(|e| f64::from(e[c]).powi(2)).sum();
            self.estimate(mean[c], squares.sqrt() / count)
        })
    }

    /// The half-width of the 99 % interval of a channel's mean over the picture, as a fraction of that mean. It is the
    /// largest over the channels that are not black; 0 if all are black. If a plan expects `unbiased`, a
    /// reference with too large a half-width gets more samples (except with the option `--quick`), because no number of runs
    /// could then make the interval of a bias narrow enough.
    pub fn half_width(&self) -> f64 {
        self.half_width_by(u64::from(self.samples))
    }

    /// The value of [`Self::half_width`] with Student's quantile for `samples` samples per pixel instead of that for the
    /// reference's own number. The standard errors are still those of this reference. [`Self::samples_for`] predicts with it
    /// how many samples per pixel a reference needs.
    fn half_width_by(&self, samples: u64) -> f64 {
        let (rounding, _) = self.rounding();
        (self.mean_estimates().into_iter().zip(rounding))
            .filter(|(e, rounding)| e.mean.abs() > *rounding)
            .map(|(e, _)| Estimate { samples, ..e }.relative_half_width(0.99))
            .fold(0.0, f64::max)
    }

    /// The number of samples per pixel with which [`Self::half_width`] would be at most `half_width`. A row recommends this
    /// number if its reference is too noisy. Rare bright paths make the variance of most blocks of samples too small, so the
    /// upper end of its 95 % interval over the blocks is used.
    pub fn samples_for(&self, half_width: f64) -> f64 {
        // With as many as are asked for Student's interval is a normal one.
        let normal = self.half_width_by(u64::from(u32::MAX));
        let variance = Estimate::of(&self.variances);
        let doubt = match self.variances.len() {
            ..2 => 1.0,
            _ => 1.0 + variance.relative_half_width(0.9).min(4.0),
        };
        doubt * (normal / half_width).powi(2) * f64::from(self.samples)
    }

    /// The mean luminance of each block (a square of [`BLOCK`] × [`BLOCK`] pixels) without emission, row by row, in the unit
    /// of [`Self::mean`], with its standard error in the same unit. The blocks of runs are compared with these values. The
    /// channels of a pixel are assumed to be fully correlated, so the error of its luminance is the weighted sum of the
    /// errors of its channels.
    pub fn block_estimates(&self) -> Vec<Estimate> {
        let (_, means) = self.reduce(&self.mean);
        let mut squares = self.empty_blocks();
        for (i, e) in self.error.iter().enumerate() {
            let error =
                0.2126 * f64::from(e[0]) + 0.7152 * f64::from(e[1]) + 0.0722 * f64::from(e[2]);
            let (sum, count) = &mut squares[self.block_of(i)];
            *sum += error * error;
            *count += 1.0;
        }
        means
            .into_iter()
            .zip(squares)
            .map(|(mean, (sum, count))| self.estimate(mean, sum.sqrt() / count))
            .collect()
    }

    fn estimate(&self, mean: f64, standard_error: f64) -> Estimate {
        Estimate {
            mean,
            standard_error,
            samples: u64::from(self.samples),
        }
    }

    fn blocks_across(&self) -> usize {
        blocks_of_side(self.width as usize)
    }

    fn block_of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.width as usize, pixel / self.width as usize);
        y / BLOCK * self.blocks_across() + x / BLOCK
    }

    fn empty_blocks(&self) -> Vec<(f64, f64)> {
        let rows = self.mean.len() / self.width as usize;
        vec![(0.0, 0.0); blocks_of_side(rows) * self.blocks_across()]
    }
}

/// The number of blocks (squares of [`BLOCK`] × [`BLOCK`] pixels) along one side of a picture, including a block that is cut
/// at the edge. `pixels` is the length of the side in pixels.
pub fn blocks_of_side(pixels: usize) -> usize {
    pixels.div_ceil(BLOCK)
}

/// The references with which the frames of a run are compared: one for all frames or, if frames show different times of a
/// moving scene, one for each frame.
pub struct References(Vec<Arc<Reference>>);

impl References {
    /// Takes the references of a run in the order of its frames, at least one. If there is only one, it is the reference of
    /// all frames.
    pub fn new(references: Vec<Arc<Reference>>) -> Self {
        Self(references)
    }

    /// True if each frame has its own reference, because frames show different times of a moving scene. Then only the last
    /// frame of a run is tested for bias, because the mean of several times has no reference.
    pub fn differ(&self) -> bool {
        self.0.len() > 1
    }

    /// The reference with which the frame with the index `frame` is compared. The index is counted from 0.
    pub fn of(&self, frame: u32) -> &Reference {
        &self.0[(frame as usize).min(self.0.len() - 1)]
    }

    /// The reference of the last frame. The test for bias compares [`Run::mean`](super::run::Run::mean) with it. If that
    /// mean is over several frames, the frames show the same time, so this is the reference of all of them.
    pub fn last(&self) -> &Reference {
        &self.0[self.0.len() - 1]
    }
}

//! References: path-traced pictures with a small and known error. Each is rendered once, and stored under the hash of all
//! its inputs.

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
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// The width and height, in pixels, of a block of a picture, whose mean luminance is tested for bias. Blocks at the right
/// and lower edges of a picture may be smaller.
pub const BLOCK: usize = 8;
/// The largest relative difference of a pixel's value that rounding can cause; sums of thousands of samples keep at least 24
/// bits. Such differences do not count as bias.
const ROUNDING: f64 = 1e-6;
/// The seed of all references, far from the seeds of runs, so that runs and references have different random numbers.
const SEED: u32 = 0x5EED_0000;
/// The number of samples per pixel that the renderer adds in one call. Progress is reported, and a signal to stop is
/// noticed, after each call and between the parts of a picture that are rendered one after another.
const AT_ONCE: u32 = 16;

/// The inputs of a reference (a path-traced picture that runs are compared with): what it shows, and how it is rendered.
pub struct Shot<'a> {
    /// The device that renders the reference.
    pub device: &'a Arc<Device>,
    /// The scene on the device that renders the reference.
    pub scene: &'a Arc<GpuScene>,
    /// The time in the scene that the reference shows, in seconds.
    pub time: f64,
    /// The camera at the time of the reference, the size of the picture, and the number of bounces. Its seed has no effect.
    pub view: View,
    /// The settings of path tracing.
    pub settings: &'a Settings,
    /// The number of samples per pixel of the reference.
    pub samples: u32,
}

impl Shot<'_> {
    /// A renderer of the shot, with at most `bounces` scattering events. With 0 it renders only emitters that the camera
    /// sees directly.
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
}

/// A path-traced picture with a small and known error. Its lists have one RGB value for each pixel, row by row from the top.
pub struct Reference {
    /// The width of the picture, in pixels.
    pub width: u32,
    /// The mean radiance of each pixel over all samples.
    pub mean: Vec<[f32; 3]>,
    /// The standard error of the mean of each pixel and channel, at least 0, in the unit of the mean.
    pub error: Vec<[f32; 3]>,
    /// The radiance of the emitters that each pixel shows directly. It is subtracted from pictures before their means are
    /// compared, because it has no noise, and because bright emitters would hide the relative error of the lit surfaces.
    pub emission: Vec<[f32; 3]>,
    /// The number of samples per pixel of which `mean` is the mean. More samples make `error` smaller.
    pub samples: u32,
}

impl Reference {
    /// Reads the reference from the file `path`, or renders it and writes it there. `watch` receives the fraction that is
    /// rendered, in [0, 1], and can end the work by an error.
    ///
    /// # Errors
    /// The device or the disk fails, the file is damaged or not a reference of this view, path tracing rejected values, or
    /// `watch` returns an error.
    pub fn obtain(path: &Path, shot: &Shot, watch: &mut Watch) -> Result<Self> {
        let (view, samples) = (&shot.view, shot.samples);
        let mut renderer = shot.renderer(0)?;
        renderer.add_samples(0, 1)?;
        let in_f32 = |values: Vec<DVec3>| -> Vec<[f32; 3]> {
            values.iter().map(|v| v.as_vec3().to_array()).collect()
        };
        let emission = in_f32(renderer.sums()?.mean(1));
        let unusable = |why: &str| {
            Error::input(format!(
                "{}: {why}; delete this file, and the study makes it again",
                path.display()
            ))
        };
        let image = if path.exists() {
            Image::read(path).map_err(|error| match input_files::open(path) {
                Ok(_) => unusable("the reference is damaged"),
                Err(_) => error,
            })?
        } else {
            let mut renderer = shot.renderer(view.bounces)?;
            for first in (0..samples).step_by(AT_ONCE as usize) {
                let count = AT_ONCE.min(samples - first);
                let mut watch = |fraction: f64| {
                    watch((f64::from(first) + fraction * f64::from(count)) / f64::from(samples))
                };
                renderer.add_samples_watched(first, count, &mut watch)?;
                watch(1.0)?;
            }
            if renderer.rejected()? > 0 {
                return Err(Error::failed(format!(
                    "{}: path tracing refused values, so the reference would be too dark",
                    path.display()
                )));
            }
            let sums = renderer.sums()?;
            let mut image = Image::new(view.width, view.height);
            let (mean, error) = (sums.mean(samples), sums.standard_error(samples));
            image.set_vectors("", ["R", "G", "B"], &in_f32(mean));
            image.set_vectors("stderr.", ["R", "G", "B"], &in_f32(error));
            image.write(path, 0.0)?;
            image
        };
        let pixels = view.width as usize * view.height as usize;
        let vectors = |prefix: &str| -> Result<Vec<[f32; 3]>> {
            let channel = |c| image.floats(&format!("{prefix}{c}")).unwrap_or_default();
            let (r, g, b) = (channel("R"), channel("G"), channel("B"));
            if [r, g, b].iter().any(|c| c.len() != pixels) {
                return Err(unusable("it is not a reference of this view"));
            }
            Ok((0..pixels).map(|i| [r[i], g[i], b[i]]).collect())
        };
        Ok(Self {
            width: view.width,
            mean: vectors("")?,
            error: vectors("stderr.")?,
            emission,
            samples,
        })
    }

    /// The mean of each channel over a picture, and the mean luminance of each of its blocks, row by row. The reference's
    /// emission is subtracted from `picture` first.
    pub fn reduce(&self, picture: &[[f32; 3]]) -> ([f64; 3], Vec<f64>) {
        self.means(|i, c| f64::from(picture[i][c]) - f64::from(self.emission[i][c]))
    }

    /// The median, over the pixels that are lit in the reference and show no emitter, of a picture's luminance divided by
    /// the reference's luminance. It is 1 if there is no such pixel.
    pub fn median_ratio(&self, picture: &[[f32; 3]]) -> f64 {
        let pixels = picture.iter().zip(&self.mean).zip(&self.emission);
        let lit = pixels.filter(|(_, emission)| **emission == [0.0; 3]);
        let of = |pixel: &[f32; 3]| luminance((*pixel).into());
        median_ratio(lit.map(|((picture, mean), _)| (of(picture), of(mean))))
    }

    /// The largest differences, in the means that [`Self::reduce`] returns, that rounding alone can cause. A picture without
    /// noise equals the reference except for the last bits of its sums, which include the emission.
    pub fn rounding(&self) -> ([f64; 3], Vec<f64>) {
        self.means(|i, c| {
            let emission = f64::from(self.emission[i][c]).abs();
            ROUNDING * emission.max(f64::from(self.mean[i][c]).abs())
        })
    }

    /// The positive values that biases are divided by: one for each channel's mean, and one for the luminance of all blocks.
    /// They are the means of the reference without emission where these are more than rounding. A black channel has the mean
    /// of the brightest channel instead or, if all channels are black, the emission.
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

    /// The means over the picture of a value that is given by pixel and channel: the mean of each channel, and the mean
    /// luminance of each block, row by row.
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

    /// The mean radiance of each channel without emission, with its standard error, in which pixels count as independent.
    pub fn mean_estimates(&self) -> [Estimate; 3] {
        let (mean, _) = self.reduce(&self.mean);
        let count = self.error.len() as f64;
        [0, 1, 2].map(|c| {
            let squares: f64 = self.error.iter().map(|e| f64::from(e[c]).powi(2)).sum();
            self.estimate(mean[c], squares.sqrt() / count)
        })
    }

    /// The half-width of the 99 % interval of a channel's mean, as a fraction of the mean; the largest over the channels
    /// that are not black. A study is refused if it is too large.
    pub fn half_width(&self) -> f64 {
        self.half_width_by(u64::from(self.samples))
    }

    /// The value of [`Self::half_width`] with Student's quantile for `samples` samples per pixel and the standard errors of
    /// this reference. Black channels are left out.
    fn half_width_by(&self, samples: u64) -> f64 {
        let (rounding, _) = self.rounding();
        (self.mean_estimates().into_iter().zip(rounding))
            .filter(|(e, rounding)| e.mean.abs() > *rounding)
            .map(|(e, _)| Estimate { samples, ..e }.relative_half_width(0.99))
            .fold(0.0, f64::max)
    }

    /// The number of samples per pixel with which [`Self::half_width`] would be `half_width`.
    pub fn samples_for(&self, half_width: f64) -> f64 {
        // With as many as are asked for Student's interval is a normal one.
        let normal = self.half_width_by(u64::from(u32::MAX));
        (normal / half_width).powi(2) * f64::from(self.samples)
    }

    /// The mean luminance of each block without emission, row by row, with its standard error. The channels of a pixel are
    /// correlated, so their errors are added, not the squares of their errors.
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

/// The number of blocks ([`BLOCK`]) along a side of a picture; `pixels` is the length of the side in pixels.
pub fn blocks_of_side(pixels: usize) -> usize {
    pixels.div_ceil(BLOCK)
}

/// The references that the frames of a run are compared with: one for all frames or, in a moving scene, one for each frame.
pub struct References(Vec<Arc<Reference>>);

impl References {
    /// The references of a run, in the order of its frames. A single reference holds for all frames.
    pub fn new(references: Vec<Arc<Reference>>) -> Self {
        Self(references)
    }

    /// True if each frame has its own reference, because the frames show different times.
    pub fn differ(&self) -> bool {
        self.0.len() > 1
    }

    /// The reference of the frame with this index, counted from 0.
    pub fn of(&self, frame: u32) -> &Reference {
        &self.0[(frame as usize).min(self.0.len() - 1)]
    }

    /// The reference of the last frame, with which the test for bias is made.
    pub fn last(&self) -> &Reference {
        &self.0[self.0.len() - 1]
    }
}

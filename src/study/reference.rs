//! References: rendered once, and kept under the hash of all their inputs.

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

/// The side of a block in pixels.
pub const BLOCK: usize = 8;
/// The largest relative change of a pixel by rounding: sums of thousands of samples keep at least 24 bits.
const ROUNDING: f64 = 1e-6;
/// The seed of references, far from the seeds of runs.
const SEED: u32 = 0x5EED_0000;
/// The number of samples per pixel that are rendered at once; progress is reported, and a signal noticed, after them and
/// between the strips of a picture.
const AT_ONCE: u32 = 16;

/// The subject of a reference, and the settings that it is made with.
pub struct Shot<'a> {
    /// The device that renders it.
    pub device: &'a Arc<Device>,
    /// The scene.
    pub scene: &'a Arc<GpuScene>,
    /// The time that the scene shows, in seconds.
    pub time: f64,
    /// The view at that time, with any seed.
    pub view: View,
    /// Settings of the path tracing.
    pub settings: &'a Settings,
    /// The number of samples per pixel.
    pub samples: u32,
}

impl Shot<'_> {
    /// A renderer of the shot, with at most `bounces` scattering events.
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

/// A picture with a small error, row by row from the top.
pub struct Reference {
    /// The width in pixels.
    pub width: u32,
    /// Mean radiance.
    pub mean: Vec<[f32; 3]>,
    /// Standard error of the mean.
    pub error: Vec<[f32; 3]>,
    /// The light of emitters that the camera sees directly. It needs no resampling, and with it the relative error of a
    /// picture's mean would be too small for the lit surfaces.
    pub emission: Vec<[f32; 3]>,
    /// The number of samples per pixel from which it was made.
    pub samples: u32,
}

impl Reference {
    /// Reads the reference from `path`, or makes it and keeps it there. `watch` receives the fraction of it that is made, and
    /// can end the work.
    ///
    /// # Errors
    /// The device or the disk fails, the file is not a reference of this view, or `watch` ends it.
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
                let mut watch = |share: f64| {
                    watch((f64::from(first) + share * f64::from(count)) / f64::from(samples))
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
                return Err(unusable("it is no reference of this view"));
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

    /// Means of a picture's channels, and of its blocks' luminance, emission left out.
    pub fn reduce(&self, picture: &[[f32; 3]]) -> ([f64; 3], Vec<f64>) {
        self.means(|i, c| f64::from(picture[i][c]) - f64::from(self.emission[i][c]))
    }

    /// The median ratio of a picture's luminance to the reference's luminance, over the pixels that are lit and show no
    /// emitter.
    pub fn median_ratio(&self, picture: &[[f32; 3]]) -> f64 {
        let pixels = picture.iter().zip(&self.mean).zip(&self.emission);
        let lit = pixels.filter(|(_, emission)| **emission == [0.0; 3]);
        let of = |pixel: &[f32; 3]| luminance((*pixel).into());
        median_ratio(lit.map(|((picture, mean), _)| (of(picture), of(mean))))
    }

    /// The largest differences of these means that rounding alone can cause: a picture without noise equals the reference
    /// except for the last bits of its sums, which include the emission.
    pub fn rounding(&self) -> ([f64; 3], Vec<f64>) {
        self.means(|i, c| {
            let emission = f64::from(self.emission[i][c]).abs();
            ROUNDING * emission.max(f64::from(self.mean[i][c]).abs())
        })
    }

    /// The values to which biases of the channels' means and of the blocks' luminance are relative: the means of the reference
    /// where they are more than rounding. The bias of a black channel is relative to the brightest channel's mean or, if all
    /// channels are black, to the emission. They are never 0.
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

    /// Means of the channels of something in each pixel, and of its blocks' luminance.
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

    /// The estimates of the channels' means from the reference.
    pub fn mean_estimates(&self) -> [Estimate; 3] {
        let (mean, _) = self.reduce(&self.mean);
        let count = self.error.len() as f64;
        [0, 1, 2].map(|c| {
            let squares: f64 = self.error.iter().map(|e| f64::from(e[c]).powi(2)).sum();
            self.estimate(mean[c], squares.sqrt() / count)
        })
    }

    /// The largest 99 % half-width of the channels' means, relative to the mean.
    pub fn half_width(&self) -> f64 {
        self.half_width_by(u64::from(self.samples))
    }

    /// [`Self::half_width`] with Student's quantile for `samples` samples. The error of a black channel is 0.
    fn half_width_by(&self, samples: u64) -> f64 {
        let (rounding, _) = self.rounding();
        (self.mean_estimates().into_iter().zip(rounding))
            .filter(|(e, rounding)| e.mean.abs() > *rounding)
            .map(|(e, _)| Estimate { samples, ..e }.relative_half_width(0.99))
            .fold(0.0, f64::max)
    }

    /// The number of samples per pixel with which the half-width would be `half_width`.
    pub fn samples_for(&self, half_width: f64) -> f64 {
        // With as many as are asked for Student's interval is a normal one.
        let normal = self.half_width_by(u64::from(u32::MAX));
        (normal / half_width).powi(2) * f64::from(self.samples)
    }

    /// The estimates of the blocks' luminance from the reference. The channels of a pixel are correlated, so their errors add
    /// up.
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

/// The number of blocks along a side of `pixels` pixels.
pub fn blocks_of_side(pixels: usize) -> usize {
    pixels.div_ceil(BLOCK)
}

/// The references of a run's frames.
pub struct References(Vec<Arc<Reference>>);

impl References {
    /// One reference for all frames, or one for each frame.
    pub fn new(references: Vec<Arc<Reference>>) -> Self {
        Self(references)
    }

    /// True if each frame has a separate reference.
    pub fn differ(&self) -> bool {
        self.0.len() > 1
    }

    /// The reference of a frame.
    pub fn of(&self, frame: u32) -> &Reference {
        &self.0[(frame as usize).min(self.0.len() - 1)]
    }

    /// The reference of the last frame.
    pub fn last(&self) -> &Reference {
        &self.0[self.0.len() - 1]
    }
}

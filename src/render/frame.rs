//! The frame: which passes run, in which order, on which buffers.

use super::camera::gpu_camera;
use super::energy;
use super::settings::{Energy, Heuristic, Settings};
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::layouts::{
    COUNTER_CUT_SHORT, COUNTER_REJECTED, COUNTERS, FrameConstants, HEURISTIC_BALANCE,
    HEURISTIC_POWER, PixelSums, PrimarySurface, Strip,
};
use crate::scene::Camera;
use crate::tracing::{GpuScene, shaders};
use crate::{Error, Result};
use std::sync::Arc;

/// Specialisation constant: whether energy is compensated.
const ENERGY_COMPENSATED: u32 = 1;

/// Loop turns allowed for a ray where a driver counts them. The night city takes up to 128, which are
/// those of the slowest of eight rays at each step.
const TURNS_A_RAY: u32 = 512;

/// What is seen: a camera, the image's size, and how rays are drawn.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera in the scene's world.
    pub camera: Camera,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The run's seed.
    pub seed: u32,
    /// Scattering events at most.
    pub bounces: u32,
    /// Rays over the whole pixel instead of through its centre.
    pub jitter: bool,
}

crate::bindings! {
    /// What the pass `path_trace` is bound to.
    pub struct PathTrace {
        [offers scene: Offered]
        uniform frame,
        write sums,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `primary` is bound to.
    pub struct Primary {
        [offers scene: Offered]
        uniform frame,
        write primary,
    }
}

/// The scene's resources and the tables that materials look up.
pub struct Offered {
    scene: Arc<GpuScene>,
    specular_albedo: Buffer,
}

impl Offered {
    fn resources(&self) -> Vec<(&'static str, crate::gpu::Resource<'_>)> {
        let mut resources = self.scene.resources();
        let table = crate::gpu::Resource::Read(&self.specular_albedo);
        resources.push(("specular_albedo", table));
        resources
    }
}

/// Renders one view of a scene; each pixel's samples add up over calls.
pub struct Renderer {
    device: Arc<Device>,
    constants: FrameConstants,
    offered: Offered,
    path_trace: ComputePass,
    primary: Option<ComputePass>,
    frame: Buffer,
    /// The picture from top to bottom, each strip with its pixels' sums.
    strips: Vec<(Strip, Buffer)>,
    counters: Buffer,
}

impl Renderer {
    /// Makes the passes and buffers that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has, or a shader that it refuses.
    pub fn new(
        device: &Arc<Device>,
        scene: Arc<GpuScene>,
        view: &View,
        settings: &Settings,
    ) -> Result<Self> {
        let compensated = settings.energy == Energy::Compensated;
        let special = [(ENERGY_COMPENSATED, u32::from(compensated))];
        let table = if compensated {
            energy::albedo_table()
        } else {
            Vec::new()
        };
        let plain = Usage::default();
        let uniform = Usage {
            uniform: true,
            ..plain
        };
        let constants = FrameConstants {
            camera: gpu_camera(&view.camera, scene.origin, view.width, view.height),
            width: view.width,
            height: view.height,
            interleave: device.info.interleave(),
            seed: view.seed,
            first_sample: 0,
            samples: 1,
            bounces: view.bounces,
            jitter: view.jitter.into(),
            heuristic: match settings.heuristic {
                Heuristic::Balance => HEURISTIC_BALANCE,
                Heuristic::Power => HEURISTIC_POWER,
            },
            lights: scene.light_count,
            roulette_start: settings.roulette.start,
            roulette_floor: settings.roulette.floor,
        };
        let renderer = Self {
            path_trace: shaders::tracing_pass(device, "path_trace", &scene, &special)?,
            primary: None,
            frame: Buffer::new(device, "frame", size_of::<FrameConstants>() as u64, uniform)?,
            strips: strips_of::<PixelSums>(device, "sums", view.width, view.height)?,
            counters: Buffer::new(device, "counters", u64::from(COUNTERS) * 4, plain)?,
            offered: Offered {
                specular_albedo: Buffer::from_slice(device, "specular_albedo", &table, plain)?,
                scene,
            },
            constants,
            device: device.clone(),
        };
        let mut recording = Recording::new(device)?;
        for (_, sums) in &renderer.strips {
            recording.clear(sums);
        }
        recording.clear(&renderer.counters);
        recording.finish()?;
        Ok(renderer)
    }

    /// Adds `samples` samples, numbered from `first`, to every pixel.
    ///
    /// # Errors
    /// The device fails, or its driver is known to end loops early and did.
    pub fn add_samples(&mut self, first: u32, samples: u32) -> Result<Vec<PassTime>> {
        self.add_samples_watched(first, samples, &mut |_| Ok(()))
    }

    /// [`Self::add_samples`]; `watch` is told between strips which share of the work is done. It can
    /// end the work by an error: the pixels then differ in how many samples they have.
    ///
    /// # Errors
    /// Those of [`Self::add_samples`] and of `watch`.
    pub fn add_samples_watched(
        &mut self,
        first: u32,
        samples: u32,
        watch: &mut dyn FnMut(f64) -> Result<()>,
    ) -> Result<Vec<PassTime>> {
        let mut times = Vec::new();
        let at_once = self.samples_at_once();
        for done in (0..samples).step_by(at_once as usize) {
            self.constants.first_sample = first + done;
            self.constants.samples = at_once.min(samples - done);
            self.frame.write(&[self.constants])?;
            for (number, (strip, sums)) in self.strips.iter().enumerate() {
                if number > 0 {
                    let of_strips = number as f64 / self.strips.len() as f64;
                    let samples_done = of_strips * f64::from(self.constants.samples);
                    watch((f64::from(done) + samples_done) / f64::from(samples))?;
                }
                let bindings = PathTrace {
                    scene: &self.offered,
                    frame: &self.frame,
                    sums,
                    counters: &self.counters,
                };
                let groups = strip.groups(self.constants.width);
                let mut recording = Recording::new(&self.device)?;
                recording.pass(&self.path_trace, &bindings, strip, groups)?;
                PassTime::add(&mut times, recording.finish()?);
            }
        }
        // Elsewhere the counters are looked at when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters()?;
        }
        Ok(times)
    }

    /// Samples of a dispatch at most, so that a driver that counts a loop's turns lets it end.
    fn samples_at_once(&self) -> u32 {
        self.device.info.loop_turns.map_or(u32::MAX, |turns| {
            let rays = self.constants.bounces.saturating_add(1).saturating_mul(2);
            (turns / TURNS_A_RAY / rays).max(1)
        })
    }

    /// The counters; fails if the driver ended loops early, which leaves pixels dark.
    fn counters(&self) -> Result<Vec<u32>> {
        let counters: Vec<u32> = self.counters.read(COUNTERS as usize)?;
        match counters[COUNTER_CUT_SHORT as usize] {
            0 => Ok(counters),
            count => Err(Error::failed(format!(
                "driver '{}' ended the loops of {count} pixels early; use fewer bounces or a newer driver",
                self.device.info.driver
            ))),
        }
    }

    /// What the camera sees through each pixel's centre, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn primary_surfaces(&mut self, settings: &Settings) -> Result<Vec<PrimarySurface>> {
        if self.primary.is_none() {
            let compensated = settings.energy == Energy::Compensated;
            let special = [(ENERGY_COMPENSATED, u32::from(compensated))];
            let scene = &self.offered.scene;
            self.primary = Some(shaders::tracing_pass(
                &self.device,
                "primary",
                scene,
                &special,
            )?);
        }
        self.frame.write(&[self.constants])?;
        let FrameConstants { width, height, .. } = self.constants;
        let mut surfaces = Vec::with_capacity(width as usize * height as usize);
        if let Some(pass) = &self.primary {
            let strips = cut::<PrimarySurface>(&self.device, "primary", width, height)?;
            // One strip after the other, in the same memory; the first is as large as any.
            let most = strips.first().map_or(0, |strip| strip.pixels(width));
            let bytes = (most * size_of::<PrimarySurface>()) as u64;
            let primary = Buffer::new(&self.device, "primary", bytes, Usage::default())?;
            for strip in strips {
                let bindings = Primary {
                    scene: &self.offered,
                    frame: &self.frame,
                    primary: &primary,
                };
                let mut recording = Recording::new(&self.device)?;
                recording.pass(pass, &bindings, &strip, strip.groups(width))?;
                recording.finish()?;
                surfaces.extend(primary.read::<PrimarySurface>(strip.pixels(width))?);
            }
        }
        Ok(surfaces)
    }

    /// Each pixel's sums, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn sums(&self) -> Result<Vec<PixelSums>> {
        let FrameConstants { width, height, .. } = self.constants;
        let mut all = Vec::with_capacity(width as usize * height as usize);
        for (strip, sums) in &self.strips {
            all.extend(sums.read::<PixelSums>(strip.pixels(width))?);
        }
        Ok(all)
    }

    /// Replaces each pixel's sums by those of an earlier run, as many as the picture has pixels.
    ///
    /// # Errors
    /// The device fails.
    pub fn set_sums(&self, sums: &[PixelSums]) -> Result<()> {
        let mut rest = sums;
        for (strip, buffer) in &self.strips {
            let (own, after) = rest
                .split_at_checked(strip.pixels(self.constants.width))
                .ok_or_else(|| Error::failed("the earlier run has too few pixels"))?;
            buffer.write(own)?;
            rest = after;
        }
        Ok(())
    }

    /// Values refused so far because they were NaN, negative or beyond [`crate::layouts::MOST_RADIANCE`].
    ///
    /// # Errors
    /// The device fails, or its driver ended loops early.
    pub fn rejected(&self) -> Result<u32> {
        Ok(self.counters()?[COUNTER_REJECTED as usize])
    }
}

/// A buffer of one `T` a pixel for each strip of the picture.
fn strips_of<T>(
    device: &Arc<Device>,
    name: &str,
    width: u32,
    height: u32,
) -> Result<Vec<(Strip, Buffer)>> {
    cut::<T>(device, name, width, height)?
        .into_iter()
        .map(|strip| {
            let size = (strip.pixels(width) * size_of::<T>()) as u64;
            Ok((strip, Buffer::new(device, name, size, Usage::default())?))
        })
        .collect()
}

/// The strips of a picture that keeps one `T` a pixel.
fn cut<T>(device: &Device, name: &str, width: u32, height: u32) -> Result<Vec<Strip>> {
    let bytes = size_of::<T>() as u64;
    let info = &device.info;
    let total = u64::from(width) * u64::from(height) * bytes;
    if total > info.device_memory {
        return Err(Error::input(format!(
            "a picture of {width} × {height} needs {total} bytes for its {name}, but device '{}' has {}",
            info.name, info.device_memory
        )));
    }
    let most = info.max_storage_buffer_range.min(info.max_buffer_size);
    Strip::cut(width, height, bytes, most)
}

//! A frame of reservoir resampling, pass by pass from the top.

mod constants;

use super::counters::{Counters, Counts};
use super::direct_aovs::{DirectAovs, Left};
use super::offered::Offered;
use super::settings::{Direct, Reservoirs, Reuse, Settings};
use super::strips::check_side;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::layouts::{
    DirectAov, FrameConstants, GpuCamera, Pilot, PixelSums, RestirConstants, SampleData,
    SpatialStep, TILE,
};
use crate::{Error, Result};
use glam::{DVec3, Vec3};
use std::sync::Arc;

crate::bindings! {
    /// What the pass `surfaces` is bound to.
    pub struct Surfaces {
        [offers scene: Offered]
        uniform restir,
        write sample_data,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `pilots` is bound to.
    pub struct Pilots {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        write pilots,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `initial_direct` is bound to.
    pub struct InitialDirect {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read pilots,
        write reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `temporal_direct` is bound to.
    pub struct TemporalDirect {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read previous_sample_data,
        read history,
        write reservoirs,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `spatial_direct` is bound to.
    pub struct SpatialDirect {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read neighbours,
        write reservoirs,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `shade` is bound to.
    pub struct Shade {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read reservoirs,
        write color,
        write counters,
    }
}

/// Specialisation constant: whether BSDF candidates begin with pilots.
const PILOTS: u32 = 10;

/// Every pass that counts.
const PASSES: &[&str] = &[
    "surfaces",
    "pilots",
    "initial_direct",
    "temporal_direct",
    "spatial_direct",
    "shade",
];

/// The passes that find direct light, those of them that the settings need: a driver takes seconds to
/// compile one.
struct DirectPasses {
    pilots: Option<ComputePass>,
    initial: ComputePass,
    temporal: Option<ComputePass>,
    spatial: Option<ComputePass>,
    shade: ComputePass,
}

impl DirectPasses {
    fn new(reuse: Reuse, pilots: bool, pass: &dyn Fn(&str) -> Result<ComputePass>) -> Result<Self> {
        let if_needed = |needed: bool, name: &str| needed.then(|| pass(name)).transpose();
        Ok(Self {
            pilots: if_needed(pilots, "pilots")?,
            initial: pass("initial_direct")?,
            temporal: if_needed(reuse.is_temporal(), "temporal_direct")?,
            spatial: if_needed(reuse.is_spatial(), "spatial_direct")?,
            shade: pass("shade")?,
        })
    }
}

/// The passes and buffers of a frame, and what the next frame reads of this one.
pub struct Frame {
    device: Arc<Device>,
    offered: Arc<Offered>,
    direct: Direct,
    layout: Reservoirs,
    constants: RestirConstants,
    jitter: bool,
    surfaces: ComputePass,
    direct_passes: Option<DirectPasses>,
    direct_aovs: Option<DirectAovs>,
    restir: Buffer,
    color: Buffer,
    pilots: Buffer,
    counters: Counters,
    /// Primary surfaces of this frame and, with temporal reuse, of the last: the first is the one
    /// that the next frame overwrites.
    sample_data: Vec<Buffer>,
    /// Each pass reads one and writes the other; the first is the one to be written next.
    reservoirs: Vec<Buffer>,
    /// The frame whose samples the buffers hold.
    last: Option<u32>,
    sums: Vec<[DVec3; 2]>,
}

impl Frame {
    /// Makes the passes and buffers that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has or binds, or a shader that it refuses.
    pub fn new(
        device: &Arc<Device>,
        offered: &Arc<Offered>,
        frame: &FrameConstants,
        settings: &Settings,
        counting: bool,
    ) -> Result<Self> {
        let direct = settings.direct.clone();
        let pilots = direct.draws_pilots();
        let layout = &settings.reservoirs;
        let (width, height) = (frame.width, frame.height);
        let pixels = u64::from(width) * u64::from(height);
        let slots = layout.slots(width, height);
        let needed = [
            ("sample_data", slots * size_of::<SampleData>() as u64),
            ("reservoirs", slots * layout.bytes()),
            ("color", pixels * 12),
            // A pass that names a buffer must find one.
            (
                "pilots",
                if pilots { slots } else { 1 } * size_of::<Pilot>() as u64,
            ),
        ];
        check_side("wide", width)?;
        check_side("high", height)?;
        let info = &device.info;
        let most = info.max_storage_buffer_range.min(info.max_buffer_size);
        if let Some((name, bytes)) = needed.iter().find(|(_, bytes)| *bytes > most) {
            return Err(Error::input(format!(
                "a picture of {width} × {height} needs {bytes} bytes for its {name}, but device '{}' binds at most {most}; choose a smaller picture, or --preset path-tracing",
                info.name
            )));
        }
        let buffer = |which: usize| {
            let (name, bytes) = needed[which];
            Buffer::new(device, name, bytes, Usage::default())
        };
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let lamp_luminance = offered.scene.lamp_luminance;
        let constants = constants::of(frame, &direct, slots as u32, lamp_luminance);
        let counters = Counters::new(device, PASSES, counting)?;
        let pass = |name: &str| {
            let mut special = [layout.constants(), counters.constants(name).to_vec()].concat();
            special.push((PILOTS, pilots.into()));
            offered.pass(name, &special)
        };
        let temporal = direct.reuse.is_temporal();
        let mut made = Self {
            surfaces: pass("surfaces")?,
            direct_passes: (frame.bounces > 0)
                .then(|| DirectPasses::new(direct.reuse, pilots, &pass))
                .transpose()?,
            direct_aovs: None,
            restir: Buffer::new(
                device,
                "restir",
                size_of::<RestirConstants>() as u64,
                uniform,
            )?,
            color: buffer(2)?,
            pilots: buffer(3)?,
            sample_data: (0..if temporal { 2 } else { 1 })
                .map(|_| buffer(0))
                .collect::<Result<_>>()?,
            reservoirs: (0..if direct.reuse == Reuse::None { 1 } else { 2 })
                .map(|_| buffer(1))
                .collect::<Result<_>>()?,
            counters,
            last: None,
            sums: Vec::new(),
            jitter: frame.jitter != 0,
            constants,
            layout: *layout,
            direct,
            offered: offered.clone(),
            device: device.clone(),
        };
        made.restart(frame.seed)?;
        Ok(made)
    }

    /// Begins anew with another seed, without history or sums.
    ///
    /// # Errors
    /// The device fails.
    pub fn restart(&mut self, seed: u32) -> Result<()> {
        self.constants.seed = seed;
        self.last = None;
        self.sums.clear();
        // A shader that reads a reservoir which no pass wrote finds it empty, instead of the number of a
        // light that does not exist and whose address may be nobody's.
        let mut recording = Recording::new(&self.device)?;
        for buffer in self.sample_data.iter().chain(&self.reservoirs) {
            recording.clear(buffer);
        }
        recording.finish()?;
        self.counters.clear()
    }

    /// Whether a frame depends on the one before it.
    pub fn has_history(&self) -> bool {
        self.direct.reuse.is_temporal()
    }

    /// Renders the frame of this number as `camera` sees it; what the frame before it left is its
    /// history.
    ///
    /// # Errors
    /// The device fails.
    pub fn render(&mut self, number: u32, camera: GpuCamera) -> Result<Vec<PassTime>> {
        self.advance(number, camera)?;
        let groups = [
            self.constants.width.div_ceil(TILE),
            self.constants.height.div_ceil(TILE),
            1,
        ];
        let scene = self.offered.as_ref();
        let (restir, color, counters) = (&self.restir, &self.color, &self.counters.buffer);
        let mut recording = Recording::new(&self.device)?;

        let sample_data = &self.sample_data[0];
        let surfaces = Surfaces {
            scene,
            restir,
            sample_data,
            color,
            counters,
        };
        recording.pass(&self.surfaces, &surfaces, &(), groups)?;

        // Which of the reservoir buffers holds this frame's.
        let mut current = 0;
        if let Some(passes) = &self.direct_passes {
            let pilots = &self.pilots;
            if let Some(pass) = &passes.pilots {
                let bound = Pilots {
                    scene,
                    restir,
                    sample_data,
                    pilots,
                    counters,
                };
                recording.pass(pass, &bound, &(), groups)?;
            }
            let initial = InitialDirect {
                scene,
                restir,
                sample_data,
                pilots,
                reservoirs: &self.reservoirs[current],
                color,
                counters,
            };
            recording.pass(&passes.initial, &initial, &(), groups)?;

            if let Some(pass) = passes.temporal.as_ref().filter(|_| self.last.is_some()) {
                let temporal = TemporalDirect {
                    scene,
                    restir,
                    sample_data,
                    previous_sample_data: &self.sample_data[1],
                    history: &self.reservoirs[1],
                    reservoirs: &self.reservoirs[current],
                    counters,
                };
                recording.pass(pass, &temporal, &(), groups)?;
            }

            if let Some(pass) = &passes.spatial {
                for step in 0..self.constants.spatial_passes {
                    let spatial = SpatialDirect {
                        scene,
                        restir,
                        sample_data,
                        neighbours: &self.reservoirs[current],
                        reservoirs: &self.reservoirs[1 - current],
                        counters,
                    };
                    let step = SpatialStep { number: step };
                    recording.pass(pass, &spatial, &step, groups)?;
                    current = 1 - current;
                }
            }

            let shade = Shade {
                scene,
                restir,
                sample_data,
                reservoirs: &self.reservoirs[current],
                color,
                counters,
            };
            recording.pass(&passes.shade, &shade, &(), groups)?;
        }
        let mut times = Vec::new();
        PassTime::add(&mut times, recording.finish()?);
        // Elsewhere the counters are looked at when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters.assert_whole()?;
        }

        // The next frame overwrites what is oldest and reads the rest as history.
        self.sample_data.reverse();
        if current == 0 {
            self.reservoirs.reverse();
        }
        self.last = Some(number);
        Ok(times)
    }

    /// What the last frame left in its reservoirs, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn direct_aovs(&mut self) -> Result<Vec<DirectAov>> {
        let aovs = match self.direct_aovs.take() {
            Some(aovs) => aovs,
            None => DirectAovs::new(&self.device, &self.offered, &self.layout)?,
        };
        // The newest of each lies last.
        let left = Left {
            constants: &self.constants,
            restir: &self.restir,
            sample_data: &self.sample_data[self.sample_data.len() - 1],
            reservoirs: &self.reservoirs[self.reservoirs.len() - 1],
        };
        let seen = aovs.look(&left);
        self.direct_aovs = Some(aovs);
        seen
    }

    /// Renders a frame and adds it to the sums.
    ///
    /// # Errors
    /// The device fails.
    pub fn add_frame(&mut self, number: u32, camera: GpuCamera) -> Result<Vec<PassTime>> {
        let times = self.render(number, camera)?;
        let color = self.color()?;
        self.sums.resize(color.len(), [DVec3::ZERO; 2]);
        for ([sum, square], value) in self.sums.iter_mut().zip(color) {
            let value = value.as_dvec3();
            *sum += value;
            *square += value * value;
        }
        Ok(times)
    }

    /// The last frame's radiance, row by row from the top.
    ///
    /// # Errors
    /// The device fails.
    pub fn color(&self) -> Result<Vec<Vec3>> {
        self.color
            .read(self.constants.width as usize * self.constants.height as usize)
    }

    /// Each pixel's sums over the frames added.
    pub fn sums(&self) -> Vec<PixelSums> {
        let pair = |value: DVec3| {
            let high = value.as_vec3();
            (high, (value - high.as_dvec3()).as_vec3())
        };
        self.sums
            .iter()
            .map(|[sum, square]| {
                let ((sum, sum_low), (square, square_low)) = (pair(*sum), pair(*square));
                PixelSums {
                    sum,
                    sum_low,
                    square,
                    square_low,
                }
            })
            .collect()
    }

    /// Values refused so far because they were NaN, negative or out of range.
    ///
    /// # Errors
    /// The device fails, or its driver ended loops early.
    pub fn rejected(&self) -> Result<u32> {
        self.counters.rejected()
    }

    /// What each pass counted since the last call, if counting was asked for.
    ///
    /// # Errors
    /// The device fails.
    pub fn counts(&mut self) -> Result<Vec<Counts>> {
        self.counters.since_last()
    }

    /// Bytes of its buffers on the device.
    pub fn bytes(&self) -> u64 {
        let buffers = self.sample_data.iter().chain(&self.reservoirs);
        buffers
            .chain([&self.color, &self.pilots])
            .map(Buffer::size)
            .sum()
    }

    /// Tells the shaders of the next frame.
    fn advance(&mut self, number: u32, camera: GpuCamera) -> Result<()> {
        let constants = &mut self.constants;
        constants.frame = number;
        constants.previous_camera = constants.camera;
        constants.camera = camera;
        constants.previous_jitter_x = constants.jitter_x;
        constants.previous_jitter_y = constants.jitter_y;
        if self.jitter {
            // All pixels alike, so that what a pixel sees can be told from its depth alone.
            let [x, y] = constants::jitter(constants.seed, number);
            constants.jitter_x = x;
            constants.jitter_y = y;
        }
        self.restir.write(&[*constants])
    }
}

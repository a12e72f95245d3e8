//! A frame of reservoir resampling, pass by pass from the top.

mod constants;
mod resampled;

use super::counters::{Counters, Counts};
use super::kind::{Kind, PassNames};
use super::offered::Offered;
use super::reservoir_aovs::{self, Left};
use super::reservoirs::ReservoirLayout;
use super::settings::Settings;
use super::strips::check_side;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::layouts::{
    FrameConstants, GpuCamera, NONE, PILOT_WORDS, PixelSums, ReservoirAov, RestirConstants,
    SampleData, TILE,
};
use crate::{Error, Result};
use glam::{DVec3, Vec2, Vec3};
use resampled::{Common, Resampled, specialisation};
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

/// Specialisation constants: whether BSDF candidates begin with pilots, and how far these lie apart.
const PILOTS: u32 = 10;
const PILOT_STRIDE: u32 = 16;

/// Every pass that counts.
const PASSES: &[&str] = &[
    "surfaces",
    "pilots",
    DIRECT.initial,
    INDIRECT.initial,
    DIRECT.temporal,
    INDIRECT.temporal,
    DIRECT.spatial,
    INDIRECT.spatial,
    DIRECT.shade,
    INDIRECT.shade,
];
const DIRECT: PassNames = Kind::Direct.passes();
const INDIRECT: PassNames = Kind::Indirect.passes();

/// What is kept beside the picture, which costs time or memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tracking {
    /// Rays, lanes and neighbours, for [`super::Renderer::counts`].
    pub counts: bool,
    /// Where reservoirs' samples come from, for [`super::Renderer::reservoir_aovs`].
    pub origins: bool,
}

/// The passes and buffers of a frame, and what the next frame reads of this one.
pub struct Frame {
    device: Arc<Device>,
    offered: Arc<Offered>,
    /// What its shaders are told; where kinds of light differ, as those of direct light are.
    constants: RestirConstants,
    layout: ReservoirLayout,
    jitter: bool,
    surfaces: ComputePass,
    pilot_pass: Option<ComputePass>,
    /// The kinds of light that are looked for, direct light first.
    kinds: Vec<Resampled>,
    /// What passes of no kind read.
    restir: Buffer,
    color: Buffer,
    pilots: Buffer,
    counters: Counters,
    /// Primary surfaces of this frame and, with temporal reuse, of the last: the first is the one
    /// that the next frame overwrites.
    sample_data: Vec<Buffer>,
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
        tracking: Tracking,
    ) -> Result<Self> {
        let layout = ReservoirLayout {
            settings: settings.reservoirs,
            origins: tracking.origins,
        };
        let (width, height) = (frame.width, frame.height);
        check_side("wide", width)?;
        check_side("high", height)?;
        let pixels = u64::from(width) * u64::from(height);
        let slots = layout.slots(width, height);
        let wanted = [Kind::Direct, Kind::Indirect].map(|kind| {
            let resampling = Resampled::wanted(kind, settings, frame.bounces);
            resampling.map(|resampling| (kind, resampling))
        });
        let [direct, indirect] = wanted;
        // The first BSDF ray is a candidate of direct light and the beginning of a path.
        let paths = indirect.is_some();
        let direct_pilots = direct.is_some() && settings.direct.draws_pilots(paths);
        let draws_pilots = direct_pilots || paths;

        let color_bytes = pixels * 12;
        let sample_data_bytes = slots * size_of::<SampleData>() as u64;
        // With indirect light they lie among its reservoirs. A pass that names a buffer must find one.
        let own_pilots = direct_pilots && indirect.is_none();
        let pilot_stride = match indirect {
            Some((kind, _)) => Resampled::reservoir_bytes(kind, settings, &layout),
            None => u64::from(4 * PILOT_WORDS),
        };
        let pilot_count = if own_pilots { slots } else { 1 };
        let pilot_bytes = pilot_count * pilot_stride;
        let mut needed = vec![
            ("sample_data", sample_data_bytes),
            ("color", color_bytes),
            ("pilots", pilot_bytes),
        ];
        if tracking.origins {
            let bytes = pixels * size_of::<ReservoirAov>() as u64;
            needed.push(("reservoir_aovs", bytes));
        }
        for (kind, _) in wanted.iter().flatten() {
            let bytes = slots * Resampled::reservoir_bytes(*kind, settings, &layout);
            needed.push(("reservoirs", bytes));
        }
        let info = &device.info;
        let most = info.max_storage_buffer_range.min(info.max_buffer_size);
        if let Some((name, bytes)) = needed.iter().find(|(_, bytes)| *bytes > most) {
            return Err(Error::input(format!(
                "a picture of {width} × {height} needs {bytes} bytes for its {name}, but device '{}' binds at most {most}; choose a smaller picture, or --preset path-tracing",
                info.name
            )));
        }

        let counters = Counters::new(device, PASSES, tracking.counts)?;
        let pass = |name: &str, own: &[(u32, u32)]| {
            let counting = counters.constants(name);
            let pilots = (PILOTS, direct_pilots.into());
            let stride = (PILOT_STRIDE, (pilot_stride / 4) as u32);
            offered.pass(
                name,
                &[&layout.constants()[..], &counting, &[pilots, stride], own].concat(),
            )
        };
        let buffer = |name, bytes| Buffer::new(device, name, bytes, Usage::default());
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let kinds = (wanted.into_iter().flatten())
            .map(|(kind, resampling)| {
                Resampled::new(
                    device,
                    kind,
                    resampling,
                    settings,
                    &layout,
                    slots as u32,
                    pass,
                )
            })
            .collect::<Result<Vec<_>>>()?;
        let temporal = kinds.iter().any(|kind| kind.settings.reuse.is_temporal());
        let restir_bytes = size_of::<RestirConstants>() as u64;
        let mut made = Self {
            surfaces: pass("surfaces", &[])?,
            pilot_pass: draws_pilots.then(|| pass("pilots", &[])).transpose()?,
            kinds,
            restir: Buffer::new(device, "restir", restir_bytes, uniform)?,
            color: buffer("color", color_bytes)?,
            pilots: buffer("pilots", pilot_bytes)?,
            sample_data: (0..if temporal { 2 } else { 1 })
                .map(|_| buffer("sample_data", sample_data_bytes))
                .collect::<Result<_>>()?,
            counters,
            last: None,
            sums: Vec::new(),
            jitter: frame.jitter != 0,
            constants: constants::of_kind(
                &constants::of_frame(frame, offered, settings, slots as u32),
                &settings.direct.resampling(),
            ),
            layout,
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
        for buffer in self.buffers() {
            recording.clear(buffer);
        }
        recording.finish()?;
        self.counters.clear()
    }

    /// Whether a frame depends on the one before it.
    pub fn has_history(&self) -> bool {
        self.sample_data.len() > 1
    }

    /// Everything that is kept for each pixel.
    fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        let reservoirs = self.kinds.iter().flat_map(|kind| &kind.reservoirs);
        let shared = [&self.color, &self.pilots];
        self.sample_data.iter().chain(shared).chain(reservoirs)
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
        let sample_data = &self.sample_data[0];
        let indirect = self.kinds.iter().find(|kind| kind.kind == Kind::Indirect);
        let pilots = indirect.map_or(&self.pilots, |kind| &kind.reservoirs[0]);
        let mut recording = Recording::new(&self.device)?;

        let surfaces = Surfaces {
            scene,
            restir,
            sample_data,
            color,
            counters,
        };
        recording.pass(&self.surfaces, &surfaces, &(), groups)?;

        if let Some(pass) = &self.pilot_pass {
            let bound = Pilots {
                scene,
                restir,
                sample_data,
                pilots,
                counters,
            };
            recording.pass(pass, &bound, &(), groups)?;
        }

        let common = Common {
            scene,
            sample_data,
            previous_sample_data: self.last.and(self.sample_data.get(1)),
            pilots,
            color,
            counters,
            groups,
        };
        let newest = (self.kinds.iter())
            .map(|kind| kind.record(&mut recording, &common))
            .collect::<Result<Vec<_>>>()?;
        let mut times = Vec::new();
        PassTime::add(&mut times, recording.finish()?);
        // Elsewhere the counters are looked at when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters.assert_whole()?;
        }

        // The next frame overwrites what is oldest and reads the rest as history.
        self.sample_data.reverse();
        for (kind, newest) in self.kinds.iter_mut().zip(newest) {
            if newest == 0 {
                kind.reservoirs.reverse();
            }
        }
        self.last = Some(number);
        Ok(times)
    }

    /// What the last frame left in a kind's reservoirs, row by row from the top; all is empty before the
    /// first frame, and where that kind has no reservoirs.
    ///
    /// # Errors
    /// The device fails.
    pub fn reservoir_aovs(&self, kind: Kind) -> Result<Vec<ReservoirAov>> {
        let resampled =
            (self.kinds.iter()).find(|resampled| resampled.kind == kind && resampled.shares);
        let Some(resampled) = resampled.filter(|_| self.last.is_some()) else {
            let empty = ReservoirAov {
                light: NONE,
                source: Vec2::NEG_ONE,
                ..ReservoirAov::default()
            };
            let pixels = self.constants.width as usize * self.constants.height as usize;
            return Ok(vec![empty; pixels]);
        };
        let special = [
            &self.layout.constants()[..],
            &specialisation(&resampled.settings),
        ];
        let pass = self.offered.pass(kind.passes().aovs, &special.concat())?;
        // The newest of each lies last.
        let left = Left {
            constants: &resampled.constants,
            restir: &resampled.restir,
            sample_data: &self.sample_data[self.sample_data.len() - 1],
            reservoirs: &resampled.reservoirs[resampled.reservoirs.len() - 1],
        };
        reservoir_aovs::look(&self.device, &self.offered, &pass, &left)
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
        self.buffers().map(Buffer::size).sum()
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
        let constants = *constants;
        for kind in &mut self.kinds {
            kind.tell(&constants)?;
        }
        self.restir.write(&[constants])
    }
}

//! The integrator of reservoir resampling (ReSTIR): its passes and buffers. `frame.rs` records the passes of a frame in the
//! order in which they run.

mod bindings;
mod constants;
mod direct;
mod frame;
mod indirect;
mod pilots;
mod reservoir_aovs;
pub mod reservoir_layout;
mod reuse;
mod sizes;
mod specialisation;

pub use direct::DirectLight;
pub use indirect::IndirectLight;
pub use reuse::Reuse;

use super::Integrator;
use crate::base::progress::Watch;
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::render::Tracking;
use crate::render::counters::Counters;
use crate::render::frame_inputs::FrameInputs;
use crate::render::history::History;
use crate::render::light_samplers::{LightSamplers, SamplerInputs};
use crate::render::lighting::Lighting;
use crate::render::outputs::Accumulator;
use crate::render::resolved_settings::ResolvedSettings;
use crate::render::scene_bindings::SceneBindings;
use crate::render::settings::{IndirectMode, Resampling, Shift};
use crate::render::strips::check_side;
use crate::render::world_reservoirs::WorldLight;
use crate::shader_interface::{
    Fetch, GeometryAccess, GpuCamera, NONE, ReservoirAov, RestirConstants, Specialisation, TILE,
    ViewConstants, WorldConstants,
};
use crate::{Error, Result};
use glam::Vec2;
use pilots::Pilots;
use reservoir_aovs::FrameOutputs;
use reservoir_layout::ReservoirLayout;
use sizes::BufferSizes;
use specialisation::{with_layout, with_resampling};
use std::sync::Arc;

/// The integrator of reservoir resampling (ReSTIR), which renders each frame with one sample per pixel and reuses samples of
/// neighbouring pixels and of the previous frame. It consists of the passes of a frame, their buffers, and the data of a
/// frame that the next frame reuses.
pub struct Restir {
    /// The Vulkan device on which the passes run.
    pub device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    /// The constants of the current frame for the passes `surfaces` and `pilots`, which serve both direct and indirect
    /// light. The other passes read copies: one for direct and one for indirect light. Each copy also contains the settings
    /// of resampling for its kind of light.
    constants: RestirConstants,
    specialisation: Specialisation,
    /// The pass `surfaces`. It finds the primary surface of each pixel (the surface that the camera sees there), at which
    /// the other passes compute light, and writes the light that this surface emits to the picture.
    pub surfaces: ComputePass,
    /// The pass `pilots`, which traces the pilot of each pixel: its first BSDF ray, which direct and indirect light share.
    /// `None` if neither the BSDF candidates of direct light nor the paths of indirect light begin with pilots.
    pub pilot_pass: Option<ComputePass>,
    /// The passes and reservoirs of direct light; `None` if the settings, or a limit of 0 bounces, exclude direct light.
    pub direct: Option<DirectLight>,
    /// The passes and reservoirs of indirect light; `None` if the settings, or a limit of less than 2 bounces, exclude
    /// indirect light.
    pub indirect: Option<IndirectLight>,
    /// The uniform buffer on the device with the constants for the passes `surfaces` and `pilots`, which serve both direct
    /// and indirect light.
    pub restir: Buffer,
    color: Buffer,
    /// 1 for each pixel whose primary ray met a surface in the current frame, otherwise 0. `None` unless
    /// [`Tracking::coverage`] is true.
    covered: Option<Buffer>,
    /// The separate buffer of the pilots (the first BSDF ray of each pixel). `None` if there are no pilots, or if they are
    /// stored in the buffer of the reservoirs of indirect light.
    separate_pilots: Option<Buffer>,
    counters: Counters,
    /// The primary surface of each pixel (the surface that the camera sees there) in this frame. With temporal reuse, a
    /// second copy stores those of the previous frame, so that only reservoirs of similar surfaces are merged.
    sample_data: History<Buffer>,
    /// True if at least one frame was rendered since the renderer was made or restarted. If not, there is nothing to reuse,
    /// and debug AOVs show empty reservoirs.
    has_frame: bool,
}

impl Restir {
    /// Makes the passes and buffers that `settings` need. `light_nodes` is the number of nodes of the light BVH, 0 without
    /// one. If `jitter` is true, primary rays pass through random points of their pixels, otherwise through the centres.
    /// `tracking` selects the data that is collected besides the picture, such as counts.
    ///
    /// # Errors
    /// A buffer exceeds a limit or the free memory of the device, the picture is too large to be dispatched, or a shader's
    /// interface cannot be bound by name.
    pub fn new(
        device: &Arc<Device>,
        bindings: &Arc<SceneBindings>,
        view: &ViewConstants,
        jitter: bool,
        settings: &ResolvedSettings,
        light_nodes: u32,
        tracking: Tracking,
    ) -> Result<Self> {
        let layout = ReservoirLayout {
            settings: settings.reservoirs,
            origins: tracking.origins,
        };
        check_side("wide", view.width)?;
        check_side("high", view.height)?;
        let sizes = BufferSizes::of(view, settings, &layout);
        sizes.world.check()?;
        let by_address = bindings.scene.variant.geometry == GeometryAccess::BufferAddresses;
        sizes.check(device, by_address, view, settings, tracking)?;

        let has_direct = settings.renders(Lighting::Direct);
        let has_indirect = settings.renders(Lighting::Indirect);
        let direct_pilots = has_direct && settings.direct.draws_pilots(has_indirect);
        let counters = Counters::new(device, tracking.counts)?;
        let specialisation = Specialisation {
            pilots: direct_pilots,
            light_lists: settings.has_light_lists(),
            hash_grid: settings.hash_grid(),
            world_reservoirs: settings.world_reservoirs(),
            uses_reservoirs: settings.indirect.mode == IndirectMode::Restir,
            biased_shift: settings.indirect.shift == Shift::Biased,
            pilot_stride: (sizes.pilot_stride / 4) as u32,
            ..with_layout(bindings.specialisation, &layout)
        };
        let pass = |name: &str, specialisation: Specialisation| {
            bindings.pass(name, &counters.specialise(name, specialisation)?)
        };
        let surfaces = pass("surfaces", specialisation)?;
        let for_direct =
            with_resampling(specialisation, &settings.direct.resampling, &bindings.scene);
        let pilot_pass = (direct_pilots || has_indirect)
            .then(|| pass("pilots", for_direct))
            .transpose()?;
        let distant_fraction = bindings.scene.first_lights().distant_fraction();
        let for_shaders = |resampling: &Resampling| {
            constants::reuse_constants(resampling, &settings.light_bvh, distant_fraction)
        };
        let reuse = |lighting: Lighting, resampling: Resampling, bytes: u64| {
            let special = with_resampling(specialisation, &resampling, &bindings.scene);
            let initial = pass(lighting.passes().initial, special)?;
            let uses_reservoirs = settings.uses_reservoirs(lighting);
            let make = |name: &str| pass(name, special);
            let constants = for_shaders(&resampling);
            let reuse = Reuse::new(
                device,
                lighting,
                resampling,
                constants,
                uses_reservoirs,
                bytes,
                make,
            )?;
            Ok::<_, Error>((initial, reuse))
        };
        let direct = settings.light_samplers().map(|samplers| {
            let (initial, reuse) =
                reuse(Lighting::Direct, settings.direct.resampling, sizes.direct)?;
            let make = |name: &str| pass(name, for_direct);
            let samplers = LightSamplers::new(&SamplerInputs {
                device,
                scene: &bindings.scene,
                settings: samplers,
                view,
                reservoir_bytes: layout.bytes(Lighting::Direct),
                pass: &make,
            })?;
            Ok::<_, Error>(DirectLight {
                initial,
                samplers,
                reuse,
            })
        });
        let indirect = has_indirect.then(|| {
            let resampling = settings.indirect.effective_resampling();
            let (initial, reuse) = reuse(Lighting::Indirect, resampling, sizes.indirect)?;
            let make = |name: &str| pass(name, specialisation);
            let world = WorldLight::new(
                device,
                &settings.world_reservoirs,
                sizes.world,
                by_address,
                make,
            )?;
            Ok::<_, Error>(IndirectLight {
                initial,
                world,
                reuse,
            })
        });
        let (direct, indirect) = (direct.transpose()?, indirect.transpose()?);

        let is_temporal =
            |reuse: Option<&Reuse>| reuse.is_some_and(|reuse| reuse.resampling.reuse.is_temporal());
        let has_history = is_temporal(direct.as_ref().map(|light| &light.reuse))
            || is_temporal(indirect.as_ref().map(|light| &light.reuse));
        let buffer = |name, bytes| Buffer::new(device, name, bytes, Usage::default());
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let texels = Usage {
            texels: bindings.scene.variant.fetch == Fetch::Texels,
            ..Usage::default()
        };
        let world = (indirect.as_ref()).and_then(|light| light.world.as_ref());
        let world = world.map_or_else(WorldConstants::default, |world| world.constants);
        let restir_bytes = size_of::<RestirConstants>() as u64;
        let mut made = Self {
            surfaces,
            pilot_pass,
            direct,
            indirect,
            restir: Buffer::new(device, "restir", restir_bytes, uniform)?,
            color: buffer("color", sizes.color)?,
            covered: (tracking.coverage)
                .then(|| buffer("covered", sizes.color / 3))
                .transpose()?,
            separate_pilots: (sizes.separate_pilots > 0)
                .then(|| buffer("pilots", sizes.separate_pilots))
                .transpose()?,
            sample_data: History::new(
                (0..if has_history { 2 } else { 1 })
                    .map(|_| Buffer::new(device, "sample_data", sizes.sample_data, texels))
                    .collect::<Result<_>>()?,
            ),
            counters,
            has_frame: false,
            constants: RestirConstants {
                // Pilots are drawn with the settings of direct light.
                reuse: for_shaders(&settings.direct.resampling),
                world,
                ..constants::frame_constants(
                    view,
                    bindings,
                    settings,
                    light_nodes,
                    sizes.slots as u32,
                    jitter,
                )
            },
            specialisation,
            bindings: bindings.clone(),
            device: device.clone(),
        };
        if let Some(light) = &made.direct {
            let constants = &mut made.constants;
            (light.samplers.iter()).for_each(|sampler| sampler.set_constants(constants));
        }
        made.restart(view.seed)?;
        Ok(made)
    }

    /// Returns the reservoirs, and the passes that reuse them, of each kind of light that is rendered: first those of direct
    /// light, then those of indirect light.
    fn kinds(&self) -> impl Iterator<Item = &Reuse> {
        let direct = self.direct.iter().map(|light| &light.reuse);
        direct.chain(self.indirect.iter().map(|light| &light.reuse))
    }

    /// The world reservoirs (the reservoirs of path vertices), with the table that finds them; `None` if the settings use
    /// none.
    fn world(&self) -> Option<&WorldLight> {
        self.indirect.as_ref()?.world.as_ref()
    }

    /// All buffers with data of pixels or path vertices, which a restart clears so that no frame reads data of an earlier
    /// run. The buffers of light samplers are not among them.
    fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        let reservoirs = self.kinds().flat_map(|reuse| reuse.reservoirs.all());
        let shared = std::iter::once(&self.color)
            .chain(&self.covered)
            .chain(&self.separate_pilots);
        let world = self.world().into_iter().flat_map(WorldLight::buffers);
        self.sample_data
            .all()
            .iter()
            .chain(shared)
            .chain(reservoirs)
            .chain(world)
    }

    /// The inputs of the current frame that its passes have in common: buffers, which the passes bind, and numbers, such as
    /// the index of the frame. The functions that record the passes take them as an argument.
    pub fn inputs(&self) -> FrameInputs<'_> {
        let view = &self.constants.view;
        FrameInputs {
            scene: &self.bindings,
            sample_data: self.sample_data.current(),
            previous_sample_data: self.sample_data.previous(),
            color: &self.color,
            counters: &self.counters.buffer,
            frame: self.constants.frame,
            is_first: !self.has_frame,
            groups: [view.width.div_ceil(TILE), view.height.div_ceil(TILE), 1],
        }
    }

    /// The buffer with the pilots of the current frame (the first BSDF ray of each pixel). If indirect light is rendered, it
    /// is the buffer of its current reservoirs. Otherwise it is a separate buffer, or `None` if no pilots are traced.
    pub fn pilots(&self) -> Pilots<'_> {
        let indirect = self.indirect.as_ref();
        Pilots {
            buffer: indirect
                .map(|light| light.reuse.reservoirs.current())
                .or(self.separate_pilots.as_ref()),
        }
    }

    /// Begins the frame with the index `index`, seen by `camera`: sets the constants of the frame, and makes the data of
    /// the frame that was rendered last the data of the previous frame, which passes can reuse.
    pub(in crate::render) fn begin_frame(&mut self, index: u32, camera: GpuCamera) {
        let constants = &mut self.constants;
        constants.frame = index;
        constants.previous_camera = constants.view.camera;
        constants.view.camera = camera;
        constants.previous_jitter = constants.jitter;
        // Shaders compute the position of a surface from its pixel, this jitter, and its depth.
        constants.jitter = constants::jitter(constants.view.seed, index);
        constants.previous_lens_point = constants.lens_point;
        constants.lens_point = constants::lens_point(constants.view.seed, index);
        self.sample_data.advance();
        if let Some(world) = self
            .indirect
            .as_ref()
            .and_then(|light| light.world.as_ref())
        {
            world.begin_frame(&mut constants.world);
        }
        let constants = *constants;
        let direct = self.direct.iter_mut().map(|light| &mut light.reuse);
        let indirect = self.indirect.iter_mut().map(|light| &mut light.reuse);
        for reuse in direct.chain(indirect) {
            reuse.begin_frame(&constants);
        }
    }

    /// Records the upload of the current frame's constants to the uniform buffers of all passes. It must come before the
    /// passes, which read them.
    ///
    /// # Errors
    /// A uniform buffer is too small for the constants, which does not happen with the buffers of this type.
    pub(in crate::render) fn upload_constants<'a>(
        &'a self,
        recording: &mut Recording<'a>,
    ) -> Result<()> {
        recording.update(&self.restir, &self.constants)?;
        self.kinds()
            .try_for_each(|reuse| recording.update(&reuse.restir, &reuse.constants))
    }

    /// Ends a frame that was rendered, so that the next frame can reuse its data. On drivers that limit loop iterations, it
    /// also checks that no loop was ended early, because pixels would then be too dark.
    pub(in crate::render) fn end_frame(&mut self) -> Result<()> {
        self.has_frame = true;
        // On other drivers the counters are checked when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters.assert_whole()?;
        }
        Ok(())
    }
}

impl Integrator for Restir {
    fn has_history(&self) -> bool {
        self.sample_data.all().len() > 1 || self.world().is_some()
    }

    fn samples_per_call(&self) -> u32 {
        1
    }

    fn add(
        &mut self,
        first: u32,
        _samples: u32,
        camera: GpuCamera,
        sums: &mut Accumulator,
        _watch: &mut Watch<'_>,
    ) -> Result<Vec<PassTime>> {
        let mut times = self.render(first, camera, sums)?;
        times.extend(sums.add(&self.color, self.covered.as_ref())?);
        Ok(PassTime::by_name(times))
    }

    fn render(
        &mut self,
        index: u32,
        camera: GpuCamera,
        _sums: &mut Accumulator,
    ) -> Result<Vec<PassTime>> {
        self.begin_frame(index, camera);
        let mut recording = Recording::new(&self.device)?;
        self.record(&mut recording)?;
        let times = recording.finish()?;
        self.end_frame()?;
        Ok(times)
    }

    fn submit(
        &mut self,
        index: u32,
        camera: GpuCamera,
        _sums: &mut Accumulator,
    ) -> Result<Option<Vec<PassTime>>> {
        self.begin_frame(index, camera);
        let mut recording = Recording::new(&self.device)?;
        self.record(&mut recording)?;
        recording.submit()?;
        self.end_frame()?;
        Ok(None)
    }

    fn color(&self) -> Option<&Buffer> {
        Some(&self.color)
    }

    fn covered(&self) -> Option<&Buffer> {
        self.covered.as_ref()
    }

    fn restart(&mut self, seed: u32) -> Result<()> {
        self.constants.view.seed = seed;
        self.has_frame = false;
        self.sample_data.reset();
        self.kinds().for_each(|reuse| reuse.reservoirs.reset());
        // A shader that reads a reservoir which no pass wrote finds it empty, instead of the index of a light
        // that does not exist.
        let mut recording = Recording::new(&self.device)?;
        self.buffers().for_each(|buffer| recording.clear(buffer));
        recording.finish()?;
        self.counters.clear()
    }

    fn counters(&mut self) -> &mut Counters {
        &mut self.counters
    }

    fn bytes(&self) -> u64 {
        let samplers = self.direct.iter().flat_map(|light| light.samplers.iter());
        let shared = samplers.flat_map(|sampler| sampler.buffers().into_iter().map(|(_, b)| b));
        self.buffers().chain(shared).map(Buffer::size).sum()
    }

    /// Returns the contents of the reservoirs, one entry per pixel, as [`Integrator::reservoir_aovs`] describes. All entries
    /// describe empty reservoirs before the first frame, and also if the light that `lighting` selects is not rendered or is
    /// not stored in reservoirs.
    fn reservoir_aovs(&self, lighting: Lighting) -> Result<Vec<ReservoirAov>> {
        let reuse = match lighting {
            Lighting::Direct => self.direct.as_ref().map(|light| &light.reuse),
            Lighting::Indirect => self.indirect.as_ref().map(|light| &light.reuse),
        };
        let uses_reservoirs = lighting == Lighting::Direct || self.specialisation.uses_reservoirs;
        let Some(reuse) = reuse.filter(|_| uses_reservoirs && self.has_frame) else {
            let empty = ReservoirAov {
                light: NONE,
                source: Vec2::NEG_ONE,
                ..ReservoirAov::default()
            };
            let pixels = self.constants.view.width as usize * self.constants.view.height as usize;
            return Ok(vec![empty; pixels]);
        };
        let specialisation =
            with_resampling(self.specialisation, &reuse.resampling, &self.bindings.scene);
        let pass = self
            .bindings
            .pass(lighting.passes().aovs, &specialisation)?;
        let outputs = FrameOutputs {
            constants: &reuse.constants,
            restir: &reuse.restir,
            sample_data: self.sample_data.current(),
            reservoirs: reuse.reservoirs.current(),
            counters: &self.counters.buffer,
        };
        reservoir_aovs::read_reservoir_aovs(&self.device, &self.bindings, &pass, &outputs)
    }
}

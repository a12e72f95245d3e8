//! Reservoir resampling (ReSTIR): its passes and buffers. `frame.rs` records the passes of a frame.

use super::constants;
use super::direct::DirectLight;
use super::hash_grid::{self, HashGridLight};
use super::indirect::IndirectLight;
use super::light_lists::LightLists;
use super::pilots::Pilots;
use super::reuse::{FrameInputs, Reuse};
use super::world_reservoirs::{self, WorldLight};
use crate::gpu::{Buffer, ComputePass, Device, PassTime, Recording, Usage};
use crate::layouts::{
    GpuCamera, GridConstants, INDIRECT_COMPACT_WORDS, NONE, PILOT_WORDS, PixelSums, ReservoirAov,
    RestirConstants, ReuseConstants, SampleData, TILE, ViewConstants, WorldConstants,
};
use crate::render::Tracking;
use crate::render::counters::{Counters, Counts};
use crate::render::history::History;
use crate::render::kind::Kind;
use crate::render::outputs::display::Radiance;
use crate::render::outputs::reservoir_aovs::{self, FrameOutputs};
use crate::render::reservoir_layout::ReservoirLayout;
use crate::render::scene_bindings::SceneBindings;
use crate::render::settings::{Resampling, Settings};
use crate::render::specialisation::Specialisation;
use crate::render::strips::check_side;
use crate::tracing::{Fetch, GeometryAccess};
use crate::{Error, Result};
use glam::{DVec3, Vec2, Vec3};
use std::sync::Arc;

// A pilot fits into the reservoir that holds it.
const _: () = assert!(PILOT_WORDS <= INDIRECT_COMPACT_WORDS);

/// The passes and buffers of frames, and what the next frame reads of the previous one.
pub struct Restir {
    /// The device that renders.
    pub device: Arc<Device>,
    bindings: Arc<SceneBindings>,
    /// The constants of passes that belong to no kind of light.
    constants: RestirConstants,
    specialisation: Specialisation,
    /// The pass `surfaces`.
    pub surfaces: ComputePass,
    /// The pass `pilots`, where something begins with them.
    pub pilot_pass: Option<ComputePass>,
    /// Direct light, where there is any.
    pub direct: Option<DirectLight>,
    /// Indirect light, where there is any.
    pub indirect: Option<IndirectLight>,
    /// The buffer of `constants`.
    pub restir: Buffer,
    color: Buffer,
    /// Unused with indirect light, whose reservoirs hold the pilots.
    own_pilots: Buffer,
    counters: Counters,
    /// Primary surfaces.
    sample_data: History<Buffer>,
    /// Whether a frame was rendered since the start.
    has_frame: bool,
    sums: Vec<[DVec3; 2]>,
}

/// What a picture needs per pixel, before it is allocated.
struct Sizes {
    slots: u64,
    color: u64,
    sample_data: u64,
    own_pilots: u64,
    /// Bytes from one pilot to the next.
    pilot_stride: u64,
    direct: u64,
    indirect: u64,
    light_lists: u64,
    hash_grid: [(&'static str, u64); 3],
    world_vertices: [(&'static str, u64); 2],
    world_table: [(&'static str, u64); 3],
}

impl Sizes {
    fn of(view: &ViewConstants, settings: &Settings, layout: &ReservoirLayout) -> Self {
        let pixels = u64::from(view.width) * u64::from(view.height);
        let slots = layout.slots(view.width, view.height);
        let has = |kind: Kind| kind.is_wanted(settings, view.bounces);
        let pilot = u64::from(4 * PILOT_WORDS);
        // Indirect light without reservoirs keeps the buffer for its pilots.
        let indirect_bytes = if Kind::Indirect.is_shared(settings) {
            layout.bytes(Kind::Indirect)
        } else {
            pilot
        };
        let own_pilots =
            has(Kind::Direct) && settings.direct.draws_pilots(false) && !has(Kind::Indirect);
        let pilot_stride = if has(Kind::Indirect) {
            indirect_bytes
        } else {
            pilot
        };
        Self {
            slots,
            color: pixels * size_of::<Vec3>() as u64,
            sample_data: slots * size_of::<SampleData>() as u64,
            // A pass must find a buffer for each binding, even if it does not read it.
            own_pilots: pilot_stride * if own_pilots { slots } else { 1 },
            pilot_stride,
            direct: slots * layout.bytes(Kind::Direct),
            indirect: slots * indirect_bytes,
            light_lists: LightLists::bytes(settings, view),
            hash_grid: hash_grid::bytes(settings, view, layout),
            world_vertices: world_reservoirs::vertex_bytes(settings, view, slots),
            world_table: world_reservoirs::table_bytes(settings, view, slots),
        }
    }

    /// Refuses what a device cannot bind at once, or allocate for shaders that take addresses.
    fn check(
        &self,
        device: &Device,
        by_address: bool,
        view: &ViewConstants,
        settings: &Settings,
        tracking: Tracking,
    ) -> Result<()> {
        let (width, height) = (view.width, view.height);
        let mut needed = vec![
            ("sample_data", self.sample_data),
            ("color", self.color),
            ("pilots", self.own_pilots),
            ("light_lists", self.light_lists),
        ];
        needed.extend(self.hash_grid);
        needed.extend(self.world_vertices);
        needed.extend(self.world_table);
        if tracking.origins {
            let pixels = u64::from(width) * u64::from(height);
            let bytes = pixels * size_of::<ReservoirAov>() as u64;
            needed.push(("reservoir_aovs", bytes));
        }
        for (kind, bytes) in [(Kind::Direct, self.direct), (Kind::Indirect, self.indirect)] {
            if kind.is_wanted(settings, view.bounces) {
                needed.push(("reservoirs", bytes));
            }
        }
        let info = &device.info;
        let bound = info.max_storage_buffer_range.min(info.max_buffer_size);
        let is_vertices = |name: &str| self.world_vertices.iter().any(|(own, _)| *own == name);
        let limit = |name: &str| match by_address && is_vertices(name) {
            true => ("allocates", info.max_buffer_size),
            false => ("binds", bound),
        };
        match needed.iter().find(|(name, bytes)| *bytes > limit(name).1) {
            None => Ok(()),
            Some((name, bytes)) => {
                let (does, limit) = limit(name);
                let way_out = if is_vertices(name) && info.buffer_addresses && !by_address {
                    "use --geometry buffer-addresses, lower world_reservoirs.depth, or choose a smaller picture"
                } else if is_vertices(name) {
                    "lower world_reservoirs.depth, or choose a smaller picture"
                } else if self.world_table.iter().any(|(own, _)| own == name) {
                    "lower world_reservoirs.depth or .table, or choose a smaller picture"
                } else if *name == "light_lists" {
                    "lower light_bvh.list, raise light_bvh.tile, or choose a smaller picture"
                } else {
                    "choose a smaller picture, or --preset path-tracing"
                };
                Err(Error::input(format!(
                    "a picture of {width} × {height} needs {bytes} bytes for its {name}, but device '{}' {does} at most {limit}; {way_out}",
                    info.name
                )))
            }
        }
    }
}

impl Restir {
    /// Makes the passes and buffers that `settings` need.
    ///
    /// # Errors
    /// More memory than the device has or binds.
    pub fn new(
        device: &Arc<Device>,
        bindings: &Arc<SceneBindings>,
        view: &ViewConstants,
        jitter: bool,
        settings: &Settings,
        tracking: Tracking,
    ) -> Result<Self> {
        let layout = ReservoirLayout {
            settings: settings.reservoirs,
            origins: tracking.origins,
        };
        check_side("wide", view.width)?;
        check_side("high", view.height)?;
        let sizes = Sizes::of(view, settings, &layout);
        world_reservoirs::check(settings, view, sizes.slots)?;
        let by_address = bindings.scene.variant.geometry == GeometryAccess::BufferAddresses;
        sizes.check(device, by_address, view, settings, tracking)?;

        let has_direct = Kind::Direct.is_wanted(settings, view.bounces);
        let has_indirect = Kind::Indirect.is_wanted(settings, view.bounces);
        let direct_pilots = has_direct && settings.direct.draws_pilots(has_indirect);
        let counters = Counters::new(device, tracking.counts)?;
        let specialisation = Specialisation {
            pilots: direct_pilots,
            light_lists: settings.has_light_lists(),
            hash_grid: settings.hash_grid(),
            world_reservoirs: settings.world_reservoirs(),
            pilot_stride: (sizes.pilot_stride / 4) as u32,
            ..bindings.specialisation.with_layout(&layout)
        };
        let pass = |name: &str, specialisation: Specialisation| {
            bindings.pass(name, &counters.specialise(name, specialisation)?)
        };
        let surfaces = pass("surfaces", specialisation)?;
        let for_direct = specialisation.with_resampling(&settings.direct.resampling);
        let pilot_pass = (direct_pilots || has_indirect)
            .then(|| pass("pilots", for_direct))
            .transpose()?;
        let distant_share = bindings.scene.first_lights().distant_share();
        let for_shaders = |resampling: &Resampling| {
            ReuseConstants::new(resampling, &settings.light_bvh, distant_share)
        };
        let reuse = |kind: Kind, resampling: Resampling, bytes: u64| {
            let special = specialisation.with_resampling(&resampling);
            let initial = pass(kind.passes().initial, special)?;
            let shares = kind.is_shared(settings);
            let make = |name: &str| pass(name, special);
            let constants = for_shaders(&resampling);
            let reuse = Reuse::new(device, kind, resampling, constants, shares, bytes, make)?;
            Ok::<_, Error>((initial, reuse))
        };
        let direct = has_direct.then(|| {
            let (initial, reuse) = reuse(Kind::Direct, settings.direct.resampling, sizes.direct)?;
            let make = |name: &str| pass(name, for_direct);
            let lists = LightLists::new(device, settings, view, make)?;
            let scene = &bindings.scene;
            let grid = HashGridLight::new(device, scene, settings, view, &layout, make)?;
            Ok::<_, Error>(DirectLight {
                initial,
                lists,
                grid,
                reuse,
            })
        });
        let indirect = has_indirect.then(|| {
            let resampling = settings.indirect.effective_resampling();
            let (initial, reuse) = reuse(Kind::Indirect, resampling, sizes.indirect)?;
            let make = |name: &str| pass(name, specialisation);
            let world = WorldLight::new(device, settings, view, sizes.slots, by_address, make)?;
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
        let grid =
            (direct.as_ref()).map_or_else(GridConstants::default, |light| light.grid.constants);
        let world =
            (indirect.as_ref()).map_or_else(WorldConstants::default, |light| light.world.constants);
        let restir_bytes = size_of::<RestirConstants>() as u64;
        let mut made = Self {
            surfaces,
            pilot_pass,
            direct,
            indirect,
            restir: Buffer::new(device, "restir", restir_bytes, uniform)?,
            color: buffer("color", sizes.color)?,
            own_pilots: buffer("pilots", sizes.own_pilots)?,
            sample_data: History::new(
                (0..if has_history { 2 } else { 1 })
                    .map(|_| Buffer::new(device, "sample_data", sizes.sample_data, texels))
                    .collect::<Result<_>>()?,
            ),
            counters,
            has_frame: false,
            sums: Vec::new(),
            constants: RestirConstants {
                // The pilots are drawn as candidates of direct light are.
                reuse: for_shaders(&settings.direct.resampling),
                grid,
                world,
                ..constants::of_frame(view, bindings, settings, sizes.slots as u32, jitter)
            },
            specialisation,
            bindings: bindings.clone(),
            device: device.clone(),
        };
        made.restart(view.seed)?;
        Ok(made)
    }

    /// Begins anew with another seed, without history or sums.
    pub fn restart(&mut self, seed: u32) -> Result<()> {
        self.constants.view.seed = seed;
        self.has_frame = false;
        self.sample_data.reset();
        self.kinds().for_each(|reuse| reuse.reservoirs.reset());
        self.sums.clear();
        // A shader that reads a reservoir which no pass wrote finds it empty, instead of the index of a light
        // that does not exist.
        let mut recording = Recording::new(&self.device)?;
        self.buffers().for_each(|buffer| recording.clear(buffer));
        recording.finish()?;
        self.counters.clear()
    }

    /// Whether a frame depends on the one before it.
    pub fn has_history(&self) -> bool {
        let world = self.indirect.as_ref().map(|light| &light.world);
        self.sample_data.all().len() > 1 || world.is_some_and(|world| world.table.is_used())
    }

    /// The kinds of light that are resampled, direct light first.
    fn kinds(&self) -> impl Iterator<Item = &Reuse> {
        let direct = self.direct.iter().map(|light| &light.reuse);
        direct.chain(self.indirect.iter().map(|light| &light.reuse))
    }

    /// Everything that is kept for each pixel.
    fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        let reservoirs = self.kinds().flat_map(|reuse| reuse.reservoirs.all());
        let shared = [&self.color, &self.own_pilots];
        let world = (self.indirect.iter()).flat_map(|light| light.world.buffers());
        self.sample_data
            .all()
            .iter()
            .chain(shared)
            .chain(reservoirs)
            .chain(world)
    }

    /// What the passes of the frame share.
    pub fn inputs(&self) -> FrameInputs<'_> {
        let view = &self.constants.view;
        FrameInputs {
            scene: &self.bindings,
            sample_data: self.sample_data.current(),
            previous_sample_data: self.sample_data.previous(),
            color: &self.color,
            counters: &self.counters.buffer,
            is_first: !self.has_frame,
            groups: [view.width.div_ceil(TILE), view.height.div_ceil(TILE), 1],
        }
    }

    /// Where the frame's pilots are.
    pub fn pilots(&self) -> Pilots<'_> {
        let indirect = self.indirect.as_ref();
        Pilots {
            buffer: indirect.map_or(&self.own_pilots, |light| light.reuse.reservoirs.current()),
        }
    }

    /// Advances the history and the constants to a frame.
    pub(in crate::render) fn begin_frame(&mut self, index: u32, camera: GpuCamera) {
        let constants = &mut self.constants;
        constants.frame = index;
        constants.previous_camera = constants.view.camera;
        constants.view.camera = camera;
        constants.previous_jitter = constants.jitter;
        // The pixel and the depth then give the position of a surface.
        constants.jitter = constants::jitter(constants.view.seed, index);
        self.sample_data.advance();
        if let Some(light) = &self.indirect {
            light.world.begin_frame(&mut constants.world);
        }
        let constants = *constants;
        let direct = self.direct.iter_mut().map(|light| &mut light.reuse);
        let indirect = self.indirect.iter_mut().map(|light| &mut light.reuse);
        for reuse in direct.chain(indirect) {
            reuse.begin_frame(&constants);
        }
    }

    /// Records the upload of the frame's constants.
    ///
    /// # Errors
    /// Only those of every driver call, see [`crate::gpu`].
    pub(in crate::render) fn upload_constants<'a>(
        &'a self,
        recording: &mut Recording<'a>,
    ) -> Result<()> {
        recording.update(&self.restir, &self.constants)?;
        self.kinds()
            .try_for_each(|reuse| recording.update(&reuse.restir, &reuse.constants))
    }

    /// Notes that a frame was rendered.
    pub(in crate::render) fn end_frame(&mut self) -> Result<()> {
        self.has_frame = true;
        // On other drivers the counters are checked when the picture is read.
        if self.device.info.loop_turns.is_some() {
            self.counters.assert_whole()?;
        }
        Ok(())
    }

    /// What the last frame left in a kind's reservoirs, row by row from the top; all are empty before the first
    /// frame, and where that kind has no reservoirs.
    pub fn reservoir_aovs(&self, kind: Kind) -> Result<Vec<ReservoirAov>> {
        let reuse = match kind {
            Kind::Direct => self.direct.as_ref().map(|light| &light.reuse),
            Kind::Indirect => self.indirect.as_ref().map(|light| &light.reuse),
        };
        let shares = kind == Kind::Direct || self.specialisation.shares;
        let Some(reuse) = reuse.filter(|_| shares && self.has_frame) else {
            let empty = ReservoirAov {
                light: NONE,
                source: Vec2::NEG_ONE,
                ..ReservoirAov::default()
            };
            let pixels = self.constants.view.width as usize * self.constants.view.height as usize;
            return Ok(vec![empty; pixels]);
        };
        let specialisation = self.specialisation.with_resampling(&reuse.resampling);
        let pass = self.bindings.pass(kind.passes().aovs, &specialisation)?;
        let outputs = FrameOutputs {
            constants: &reuse.constants,
            restir: &reuse.restir,
            sample_data: self.sample_data.current(),
            reservoirs: reuse.reservoirs.current(),
            counters: &self.counters.buffer,
        };
        reservoir_aovs::read_reservoir_aovs(&self.device, &self.bindings, &pass, &outputs)
    }

    /// Renders a frame and adds it to the sums.
    pub fn add_frame(&mut self, index: u32, camera: GpuCamera) -> Result<Vec<PassTime>> {
        let times = self.render(index, camera)?;
        self.add_to_sums()?;
        Ok(times)
    }

    /// Makes the last frame the only one in the sums.
    pub fn keep_last_frame(&mut self) -> Result<()> {
        self.sums.clear();
        self.add_to_sums()
    }

    /// Adds the last frame to the sums.
    pub fn add_to_sums(&mut self) -> Result<()> {
        let color = self.color()?;
        self.sums.resize(color.len(), [DVec3::ZERO; 2]);
        for ([sum, square], value) in self.sums.iter_mut().zip(color) {
            let value = value.as_dvec3();
            *sum += value;
            *square += value * value;
        }
        Ok(())
    }

    /// The last frame's radiance, row by row from the top.
    pub fn color(&self) -> Result<Vec<Vec3>> {
        let view = &self.constants.view;
        self.color.read(view.width as usize * view.height as usize)
    }

    /// The same on the device.
    pub fn radiance(&self) -> Radiance<'_> {
        let view = &self.constants.view;
        Radiance {
            buffer: &self.color,
            stride: 3,
            first_pixel: 0,
            pixels: view.width * view.height,
        }
    }

    /// Each pixel's sums over the frames added.
    pub fn sums(&self) -> Vec<PixelSums> {
        self.sums.iter().map(PixelSums::of).collect()
    }

    /// Values rejected so far because they were NaN, negative or out of range.
    ///
    /// # Errors
    /// The device fails, or its driver ended loops early.
    pub fn rejected(&self) -> Result<u32> {
        self.counters.rejected()
    }

    /// What each pass counted since the last call, if counting was asked for.
    pub fn counts(&mut self) -> Result<Vec<Counts>> {
        self.counters.since_last()
    }

    /// Bytes of its buffers on the device.
    pub fn bytes(&self) -> u64 {
        let shared = (self.direct.iter()).flat_map(|light| {
            light
                .grid
                .buffers()
                .into_iter()
                .chain([&light.lists.buffer])
        });
        self.buffers().chain(shared).map(Buffer::size).sum()
    }
}

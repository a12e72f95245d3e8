//! Counters of passes on the device. Faults, such as values that shaders reject, are always counted, so that a wrong picture
//! is noticed. Rays, lanes in use, merged reservoirs and bytes show what a pass costs; they are counted only on request,
//! because this costs time.

use crate::gpu::{Buffer, Device, Recording, Usage};
use crate::shader_interface::Specialisation;
use crate::shader_interface::{
    COUNTER_CELLS, COUNTER_CUT_SHORT, COUNTER_DROPPED, COUNTER_HITS, COUNTER_MERGE_LANES,
    COUNTER_NEIGHBOURS, COUNTER_RAYS, COUNTER_READ, COUNTER_REJECTED, COUNTER_SLOTS,
    COUNTER_TRACE_LANES, COUNTER_VERTICES, COUNTER_WRITTEN, COUNTERS,
};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::sync::Arc;

/// The counts of one pass in the period since the previous call of [`Counters::since_last`]. Profiles and studies show them,
/// to explain the time of the pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// The name of the pass to which these counts belong, such as `initial_direct`. Reports show the counts under this
    /// name.
    pub pass: String,
    /// The number of rays that the pass traced. Many passes spend most of their time on tracing rays.
    pub rays: u64,
    /// Two sums over all times at which a subgroup traced rays: first the number of lanes that traced a ray, then the number
    /// of all lanes of the subgroup. The first divided by the second is the fraction of lanes in use; if it is low, the pass
    /// wastes time.
    pub trace_lanes: [u64; 2],
    /// Two sums over all times at which a subgroup evaluated a target function to merge reservoirs: first the number of
    /// lanes that evaluated it, then the number of all lanes of the subgroup. The first divided by the second is the
    /// fraction of lanes in use.
    pub merge_lanes: [u64; 2],
    /// The number of reservoirs that were merged into the reservoirs of pixels and of path vertices. The merged ones belong
    /// to neighbouring pixels, to pixels of the previous frame, or to path vertices of the previous frame (world
    /// reservoirs).
    pub neighbours: u64,
    /// The number of path vertices that have a world reservoir: a reservoir with a light sample that path vertices of the
    /// next frame can reuse. 0 without world reservoirs.
    #[serde(default)]
    pub vertices: u64,
    /// The number of cells of space that contain at least one path vertex with a world reservoir. A table of these cells
    /// finds world reservoirs by position.
    #[serde(default)]
    pub cells: u64,
    /// The number of slots in the table that finds world reservoirs (the reservoirs of path vertices) by position. Each slot
    /// can hold one cell of space, so `cells` / `slots` is the used fraction of the table.
    #[serde(default, rename = "places")]
    pub slots: u64,
    /// The number of path vertices whose world reservoir (a stored light sample) the next frame cannot find. Either the
    /// table of cells had no slot left for the vertex's cell of space, or another vertex of this cell took the same place in
    /// its list. This gives more noise, but no bias.
    #[serde(default)]
    pub dropped: u64,
    /// The number of the traced rays that hit a surface. Divided by `rays`, it is the fraction of hits.
    #[serde(default)]
    pub hits: u64,
    /// The number of bytes that the pass read from the buffers of frames: surfaces of pixels, reservoirs, pilots (the first
    /// BSDF ray of each pixel), light lists, world reservoirs (those of path vertices), radiance and its sums. Reads of the
    /// scene, and of the table that finds world reservoirs, do not count.
    #[serde(default)]
    pub bytes_read: u64,
    /// The number of bytes that the pass wrote to the buffers of frames: surfaces of pixels, reservoirs, pilots (the first
    /// BSDF ray of each pixel), light lists, world reservoirs (those of path vertices), radiance and its sums. Writes to the
    /// table that finds world reservoirs do not count.
    #[serde(default)]
    pub bytes_written: u64,
}

impl Counts {
    /// The mean fraction of lanes in use, in [0, 1], over all times at which a subgroup traced rays; `None` if no ray was
    /// traced. Reports show it: a low value means that the pass wastes time.
    pub fn tracing_fraction(&self) -> Option<f64> {
        fraction(self.trace_lanes)
    }

    /// The mean fraction of lanes in use, in [0, 1], over all times at which a subgroup evaluated a target function to merge
    /// reservoirs; `None` if nothing was merged. Reports show it: a low value means that the pass wastes time.
    pub fn merging_fraction(&self) -> Option<f64> {
        fraction(self.merge_lanes)
    }
}

fn fraction([busy, all]: [u64; 2]) -> Option<f64> {
    (all > 0).then(|| busy as f64 / all as f64)
}

/// The values of one counter, pass by pass. `all` has the counters of all passes, one pass after the other, and `counter` is
/// the index of the counter within those of a pass.
fn of_each_pass(all: &[u32], counter: u32) -> impl Iterator<Item = u32> {
    let own = all.iter().skip(counter as usize);
    own.step_by(COUNTERS as usize).copied()
}

/// The maximum number of passes that can have counters; making a further pass fails. Higher: more passes can be counted, in
/// a larger buffer.
const MAX_PASSES: usize = 32;
/// The length of the buffer with the counters of all passes, in words of 32 bits.
const LENGTH: usize = MAX_PASSES * COUNTERS as usize;

/// The counters of all passes of an integrator (path tracing or reservoir resampling), in one buffer on the device. Passes
/// add to them while they run. The host then reads them, to detect faults and to explain the cost of passes.
pub struct Counters {
    /// The buffer of counters on the device, which every pass binds. Each pass has one range of `COUNTERS` words in it.
    pub buffer: Buffer,
    device: Arc<Device>,
    /// The names of the passes that have a range in the buffer, in the order of the ranges. [`Self::specialise`] finds
    /// the range of a pass by its name, and [`Self::since_last`] reports its counts under it.
    passes: RefCell<Vec<String>>,
    counting: bool,
    /// The values of all counters at the last call of [`Self::since_last`], or all 0 after [`Self::clear`]. Reading does not
    /// reset the counters, so a count is the difference between a counter's value now and its value here, modulo 2³².
    seen: Vec<u32>,
}

impl Counters {
    /// Makes the counters of an integrator, all 0. Passes always count faults: values that shaders reject (NaN, negative or
    /// too large), and loops that the driver ended early. If `counting` is true, passes also count what explains their cost
    /// (all fields of [`Counts`]: rays, lanes in use, merged reservoirs, bytes and others), which costs time.
    pub fn new(device: &Arc<Device>, counting: bool) -> Result<Self> {
        let mut made = Self {
            buffer: Buffer::new(device, "counters", 4 * LENGTH as u64, Usage::default())?,
            device: device.clone(),
            passes: RefCell::new(Vec::new()),
            counting,
            seen: Vec::new(),
        };
        made.clear()?;
        Ok(made)
    }

    /// Reserves a range of counters for the pass named `pass`; passes with the same name share one range. Returns a copy
    /// of the specialisation constants `specialisation` with two changes: the index of the first counter of the range,
    /// and a flag that is true if the pass counts more than faults. The pass must be made with these constants, so that
    /// its shader counts in this range.
    ///
    /// # Errors
    /// All ranges of the buffer belong to other passes.
    pub fn specialise(&self, pass: &str, specialisation: Specialisation) -> Result<Specialisation> {
        let mut passes = self.passes.borrow_mut();
        let index = passes.iter().position(|name| name == pass);
        let index = index.unwrap_or_else(|| {
            passes.push(pass.to_owned());
            passes.len() - 1
        });
        if index >= MAX_PASSES {
            return Err(Error::failed(format!(
                "pass {pass}: there are counters for {MAX_PASSES} passes only"
            )));
        }
        Ok(Specialisation {
            counting: self.counting,
            first_counter: index as u32 * COUNTERS,
            ..specialisation
        })
    }

    /// Sets the counters of all passes to 0. It is called when a renderer is made or restarted. The next call of
    /// [`Self::since_last`] returns the counts since then.
    pub fn clear(&mut self) -> Result<()> {
        self.seen = vec![0; LENGTH];
        let mut recording = Recording::new(&self.device)?;
        recording.clear(&self.buffer);
        recording.finish().map(drop)
    }

    /// The counts of each pass since the last call of this method or of [`Self::clear`], one entry per pass, in the order in
    /// which the passes were made. Empty if the counters were made with `counting` = false.
    pub fn since_last(&mut self) -> Result<Vec<Counts>> {
        if !self.counting {
            return Ok(Vec::new());
        }
        let now: Vec<u32> = self.read()?;
        let before = std::mem::replace(&mut self.seen, now.clone());
        let counts = self
            .passes
            .get_mut()
            .iter()
            .enumerate()
            .map(|(index, pass)| {
                let first = index * COUNTERS as usize;
                let of = |counter: u32| {
                    let at = first + counter as usize;
                    u64::from(now[at].wrapping_sub(before[at]))
                };
                Counts {
                    pass: pass.clone(),
                    rays: of(COUNTER_RAYS),
                    trace_lanes: [of(COUNTER_TRACE_LANES), of(COUNTER_TRACE_LANES + 1)],
                    merge_lanes: [of(COUNTER_MERGE_LANES), of(COUNTER_MERGE_LANES + 1)],
                    neighbours: of(COUNTER_NEIGHBOURS),
                    vertices: of(COUNTER_VERTICES),
                    cells: of(COUNTER_CELLS),
                    slots: of(COUNTER_SLOTS),
                    dropped: of(COUNTER_DROPPED),
                    hits: of(COUNTER_HITS),
                    bytes_read: 4 * of(COUNTER_READ),
                    bytes_written: 4 * of(COUNTER_WRITTEN),
                }
            });
        Ok(counts.collect())
    }

    /// The values that shaders replaced by 0 since the counters were cleared: the name of each pass that did so, and its
    /// number of values. Shaders reject radiance and weights that are NaN, negative or too large. Such a value is a fault of a
    /// shader, and makes the picture too dark, so callers report the numbers or refuse the picture.
    ///
    /// # Errors
    /// The driver has ended a loop early, or the device fails.
    pub fn rejected(&self) -> Result<Vec<(String, u32)>> {
        let all = self.read()?;
        self.check_whole(&all)?;
        let passes = self.passes.borrow();
        let counts = passes
            .iter()
            .cloned()
            .zip(of_each_pass(&all, COUNTER_REJECTED));
        Ok(counts.filter(|(_, count)| *count > 0).collect())
    }

    /// Checks that the driver has ended no loop early since the counters were cleared. Some drivers end long loops, and the
    /// pixels that were computed in them are then too dark, so the picture must not be used.
    ///
    /// # Errors
    /// The driver has ended a loop early, or the device fails.
    pub fn assert_whole(&self) -> Result<()> {
        self.check_whole(&self.read()?)
    }

    fn check_whole(&self, all: &[u32]) -> Result<()> {
        match of_each_pass(all, COUNTER_CUT_SHORT).fold(0, u32::saturating_add) {
            0 => Ok(()),
            count => Err(Error::failed(format!(
                "driver '{}' ended the loops of {count} pixels early; use fewer bounces, samples or neighbours, or a newer driver",
                self.device.info.driver
            ))),
        }
    }

    fn read(&self) -> Result<Vec<u32>> {
        self.buffer.read(LENGTH)
    }
}

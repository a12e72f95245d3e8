//! Counters of passes. Faults, such as rejected values, are always counted; rays, lanes, neighbours and bytes only on
//! request, because this costs time.

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

/// The counts of one pass since the last call of [`Counters::since_last`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// The name of the pass.
    pub pass: String,
    /// The number of rays that were traced.
    pub rays: u64,
    /// Two sums over all times at which a subgroup traces rays: first the number of lanes that trace a ray, then the number
    /// of all lanes of the subgroup. Their ratio is the fraction of lanes in use.
    pub trace_lanes: [u64; 2],
    /// Two sums over all times at which a subgroup evaluates a target function in a merge: first the number of lanes that
    /// evaluate it, then the number of all lanes of the subgroup. Their ratio is the fraction of lanes in use.
    pub merge_lanes: [u64; 2],
    /// The number of reservoirs that pixels and path vertices merged with their own: those of neighbouring pixels, those of
    /// the previous frame, and world reservoirs (the reservoirs of path vertices).
    pub neighbours: u64,
    /// The number of path vertices that have a world reservoir, which holds a light sample for path vertices of the next
    /// frame.
    #[serde(default)]
    pub vertices: u64,
    /// The number of cells of space that hold at least one vertex in the table of world reservoirs (the reservoirs of path
    /// vertices).
    #[serde(default)]
    pub cells: u64,
    /// The number of slots in the table of world reservoirs (the reservoirs of path vertices). A slot can hold one cell of
    /// space.
    #[serde(default, rename = "places")]
    pub slots: u64,
    /// The number of path vertices whose world reservoir cannot be found by the next frame: their cell has no slot in the
    /// table, or another vertex took their slot in the list of the cell. This gives more noise, but no bias.
    #[serde(default)]
    pub dropped: u64,
    /// The number of rays that hit a surface.
    #[serde(default)]
    pub hits: u64,
    /// The number of bytes read from the buffers of frames: surfaces of pixels, reservoirs, pilots (the first BSDF rays),
    /// light lists, world reservoirs, radiance and its sums. Reads of the scene, and of the table that finds world
    /// reservoirs, do not count.
    #[serde(default)]
    pub bytes_read: u64,
    /// The number of bytes written to the buffers of frames: surfaces of pixels, reservoirs, pilots (the first BSDF rays),
    /// light lists, world reservoirs, radiance and its sums. Writes to the table that finds world reservoirs do not count.
    #[serde(default)]
    pub bytes_written: u64,
}

impl Counts {
    /// The fraction of lanes in use where rays are traced, in [0, 1]; `None` if no ray was traced.
    pub fn tracing_fraction(&self) -> Option<f64> {
        fraction(self.trace_lanes)
    }

    /// The fraction of lanes in use where merges evaluate target functions, in [0, 1]; `None` if there was no merge.
    pub fn merging_fraction(&self) -> Option<f64> {
        fraction(self.merge_lanes)
    }
}

fn fraction([busy, all]: [u64; 2]) -> Option<f64> {
    (all > 0).then(|| busy as f64 / all as f64)
}

/// The sum of one counter over all passes, at most `u32::MAX`. `counter` is its index among the counters of a pass.
fn sum(all: &[u32], counter: u32) -> u32 {
    let own = all.iter().skip(counter as usize).step_by(COUNTERS as usize);
    own.fold(0, |sum: u32, n| sum.saturating_add(*n))
}

/// The maximum number of passes with separate counters. Higher: more passes can be counted, in a larger buffer.
const MAX_PASSES: usize = 32;
/// The length of the buffer of counters, in words of 32 bits.
const LENGTH: usize = MAX_PASSES * COUNTERS as usize;

/// The counters of all passes of an integrator, in one buffer on the device.
pub struct Counters {
    /// The buffer of counters that each pass binds: one range of `COUNTERS` words per pass.
    pub buffer: Buffer,
    device: Arc<Device>,
    /// The names of the passes, in the order of their ranges in the buffer.
    passes: RefCell<Vec<String>>,
    counting: bool,
    /// The values of all counters at the last call of [`Self::since_last`]. Counters are not reset by that call and may wrap
    /// around, so only differences are used.
    seen: Vec<u32>,
}

impl Counters {
    /// Makes the counters of an integrator, all 0. With `counting`, passes also count rays, lanes, neighbours and bytes,
    /// which costs time; otherwise only faults (rejected values, and loops that the driver ended early).
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

    /// Returns a copy of `specialisation` with which the pass named `pass` counts: it has the index of the first counter of
    /// the pass, and whether the pass counts more than faults. Passes with the same name share their counters.
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

    /// Sets the counters of all passes to 0.
    pub fn clear(&mut self) -> Result<()> {
        self.seen = vec![0; LENGTH];
        let mut recording = Recording::new(&self.device)?;
        recording.clear(&self.buffer);
        recording.finish().map(drop)
    }

    /// The counts of each pass since the last call, in the order in which the passes were made. Empty if `counting` is off.
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

    /// The number of values that shaders rejected (such as NaN or infinity) since the counters were cleared, over all
    /// passes.
    ///
    /// # Errors
    /// The errors of [`Self::assert_whole`].
    pub fn rejected(&self) -> Result<u32> {
        let all = self.read()?;
        self.check_whole(&all)?;
        Ok(sum(&all, COUNTER_REJECTED))
    }

    /// Checks that the driver has ended no loop early since the counters were cleared. Pixels whose loops it ends are too
    /// dark.
    ///
    /// # Errors
    /// The driver has ended a loop early, or the device fails.
    pub fn assert_whole(&self) -> Result<()> {
        self.check_whole(&self.read()?)
    }

    fn check_whole(&self, all: &[u32]) -> Result<()> {
        match sum(all, COUNTER_CUT_SHORT) {
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

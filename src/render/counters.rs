//! Counters of passes: rejected values always; rays, lanes and neighbours on request.

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

/// The counts of one pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// The pass.
    pub pass: String,
    /// Rays traced.
    pub rays: u64,
    /// Lanes that traced them, and all lanes of their subgroups.
    pub trace_lanes: [u64; 2],
    /// Lanes that evaluated the targets of merges, and all lanes of their subgroups.
    pub merge_lanes: [u64; 2],
    /// Neighbours, or histories, that were merged.
    pub neighbours: u64,
    /// Vertices of paths with a world reservoir.
    #[serde(default)]
    pub vertices: u64,
    /// Cells of the table of world reservoirs that hold a vertex.
    #[serde(default)]
    pub cells: u64,
    /// Slots of that table.
    #[serde(default, rename = "places")]
    pub slots: u64,
    /// Vertices of paths that found no slot among world reservoirs.
    #[serde(default)]
    pub dropped: u64,
    /// Rays that hit something.
    #[serde(default)]
    pub hits: u64,
    /// Bytes read from sample data, reservoirs, pilots, light lists, points and samples of world reservoirs, colour and sums.
    #[serde(default)]
    pub bytes_read: u64,
    /// Bytes written to these buffers.
    #[serde(default)]
    pub bytes_written: u64,
}

impl Counts {
    /// The fraction of lanes in use where rays are traced, in [0, 1]; `None` without any.
    pub fn tracing_share(&self) -> Option<f64> {
        share(self.trace_lanes)
    }

    /// The fraction of lanes in use where merges evaluate targets, in [0, 1]; `None` without any.
    pub fn merging_share(&self) -> Option<f64> {
        share(self.merge_lanes)
    }
}

fn share([busy, all]: [u64; 2]) -> Option<f64> {
    (all > 0).then(|| busy as f64 / all as f64)
}

/// The sum of one counter over all passes.
fn sum(all: &[u32], counter: u32) -> u32 {
    let own = all.iter().skip(counter as usize).step_by(COUNTERS as usize);
    own.fold(0, |sum: u32, n| sum.saturating_add(*n))
}

/// The maximum number of passes with separate counters.
const MAX_PASSES: usize = 32;
/// The length of the buffer, in words.
const LENGTH: usize = MAX_PASSES * COUNTERS as usize;

/// The counters of the passes of an integrator.
pub struct Counters {
    /// The buffer that passes bind.
    pub buffer: Buffer,
    device: Arc<Device>,
    /// Names of the passes, in the order of their ranges.
    passes: RefCell<Vec<String>>,
    counting: bool,
    /// The values at the last call of [`Self::since_last`]. They are never reset and may wrap around, so only
    /// differences are used.
    seen: Vec<u32>,
}

impl Counters {
    /// Counters, all 0; with `counting`, also the counters that cost time.
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

    /// The specialisation of a pass with a range of counters. Passes with the same name use the same range.
    ///
    /// # Errors
    /// Too many passes.
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

    /// Sets all counters to 0.
    pub fn clear(&mut self) -> Result<()> {
        self.seen = vec![0; LENGTH];
        let mut recording = Recording::new(&self.device)?;
        recording.clear(&self.buffer);
        recording.finish().map(drop)
    }

    /// The counts of each pass since the last call; empty unless counting is on.
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

    /// The number of rejected values since the counters were cleared, over all passes.
    ///
    /// # Errors
    /// The errors of [`Self::assert_whole`].
    pub fn rejected(&self) -> Result<u32> {
        let all = self.read()?;
        self.check_whole(&all)?;
        Ok(sum(&all, COUNTER_REJECTED))
    }

    /// Fails if the driver has ended loops early since the counters were cleared, which leaves pixels dark.
    ///
    /// # Errors
    /// The driver did so, or the device fails.
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

//! Counters of passes: rejected values always; rays, lanes and neighbours on request.

use super::specialisation::Specialisation;
use crate::gpu::{Buffer, Device, Recording, Usage};
use crate::layouts::{
    COUNTER_CUT_SHORT, COUNTER_MERGE_LANES, COUNTER_NEIGHBOURS, COUNTER_RAYS, COUNTER_REJECTED,
    COUNTER_TRACE_LANES, COUNTERS,
};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What one pass counted.
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
}

impl Counts {
    /// Share of lanes in use, 0…1, where rays are traced; `None` without any.
    pub fn tracing_share(&self) -> Option<f64> {
        share(self.trace_lanes)
    }

    /// Share of lanes in use, 0…1, where merges evaluate targets; `None` without any.
    pub fn merging_share(&self) -> Option<f64> {
        share(self.merge_lanes)
    }
}

fn share([busy, all]: [u64; 2]) -> Option<f64> {
    (all > 0).then(|| busy as f64 / all as f64)
}

/// One counter of every pass, summed.
fn sum(all: &[u32], counter: u32) -> u32 {
    let own = all.iter().skip(counter as usize).step_by(COUNTERS as usize);
    own.fold(0, |sum: u32, n| sum.saturating_add(*n))
}

/// The counters of some passes.
pub struct Counters {
    /// What passes bind.
    pub buffer: Buffer,
    device: Arc<Device>,
    passes: &'static [&'static str],
    counting: bool,
    /// The numbers at the last look: they run on, and may pass 2³², so that only differences count.
    seen: Vec<u32>,
}

impl Counters {
    /// Counters for `passes`, all 0; with `counting`, for what costs time too.
    pub fn new(
        device: &Arc<Device>,
        passes: &'static [&'static str],
        counting: bool,
    ) -> Result<Self> {
        let length = passes.len() * COUNTERS as usize;
        let mut made = Self {
            buffer: Buffer::new(device, "counters", 4 * length as u64, Usage::default())?,
            device: device.clone(),
            passes,
            counting,
            seen: Vec::new(),
        };
        made.clear()?;
        Ok(made)
    }

    /// A pass's specialisation with its range of counters.
    pub fn specialise(&self, pass: &str, specialisation: Specialisation) -> Specialisation {
        let index = self.passes.iter().position(|name| *name == pass);
        Specialisation {
            counting: self.counting,
            first_counter: index.unwrap_or(0) as u32 * COUNTERS,
            ..specialisation
        }
    }

    /// Sets all to 0.
    pub fn clear(&mut self) -> Result<()> {
        self.seen = vec![0; self.passes.len() * COUNTERS as usize];
        let mut recording = Recording::new(&self.device)?;
        recording.clear(&self.buffer);
        recording.finish().map(drop)
    }

    /// What each pass counted since the last call; nothing unless counting was asked for.
    pub fn since_last(&mut self) -> Result<Vec<Counts>> {
        if !self.counting {
            return Ok(Vec::new());
        }
        let now: Vec<u32> = self.read()?;
        let before = std::mem::replace(&mut self.seen, now.clone());
        let counts = self.passes.iter().enumerate().map(|(number, pass)| {
            let first = number * COUNTERS as usize;
            let of = |counter: u32| {
                let at = first + counter as usize;
                u64::from(now[at].wrapping_sub(before[at]))
            };
            Counts {
                pass: (*pass).to_owned(),
                rays: of(COUNTER_RAYS),
                trace_lanes: [of(COUNTER_TRACE_LANES), of(COUNTER_TRACE_LANES + 1)],
                merge_lanes: [of(COUNTER_MERGE_LANES), of(COUNTER_MERGE_LANES + 1)],
                neighbours: of(COUNTER_NEIGHBOURS),
            }
        });
        Ok(counts.collect())
    }

    /// Values refused since the counters were cleared, over all passes.
    ///
    /// # Errors
    /// Those of [`Self::assert_whole`].
    pub fn rejected(&self) -> Result<u32> {
        let all = self.read()?;
        self.check_whole(&all)?;
        Ok(sum(&all, COUNTER_REJECTED))
    }

    /// Fails if the driver has ended loops early since then, which leaves pixels dark.
    ///
    /// # Errors
    /// It did, or the device fails.
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
        self.buffer.read(self.passes.len() * COUNTERS as usize)
    }
}

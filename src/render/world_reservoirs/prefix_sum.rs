//! Exclusive prefix sums, on the device.

use crate::Result;
use crate::gpu::{Buffer, ComputePass, Recording, in_rows};
use crate::shader_interface::{PREFIX_BLOCK, PrefixLevel};

crate::bindings! {
    /// Bindings of both passes of a prefix sum.
    pub struct PrefixValues {
        write values,
    }
}

/// The passes, for buffers of one size.
pub struct PrefixSum {
    sum: ComputePass,
    add: ComputePass,
    levels: Vec<PrefixLevel>,
}

impl PrefixSum {
    /// Makes the passes for the sums of `count` values, the first of which has the index `first`; `pass` makes a pass by name.
    ///
    /// # Errors
    /// A shader that the driver rejects.
    pub fn new(first: u64, count: u64, pass: impl Fn(&str) -> Result<ComputePass>) -> Result<Self> {
        Ok(Self {
            sum: pass("prefix_sum")?,
            add: pass("prefix_add")?,
            levels: (levels(count).into_iter())
                .map(|[from, count, sums]| PrefixLevel {
                    first: (first + from) as u32,
                    count: count as u32,
                    sums: (first + sums) as u32,
                })
                .collect(),
        })
    }

    /// The length of the array from the first value on, for sums of `count` values: the values, then the sums of their blocks,
    /// and so on.
    pub fn length(count: u64) -> u64 {
        let last = levels(count).pop();
        // The sum of the last block is written too.
        last.map_or(0, |[_, _, sums]| sums) + 1
    }

    /// Records the passes: each of these values in `values` becomes the sum of those before it.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(&'a self, recording: &mut Recording<'a>, values: &'a Buffer) -> Result<()> {
        let bindings = PrefixValues { values };
        let groups = |level: &PrefixLevel| in_rows(level.count.div_ceil(PREFIX_BLOCK));
        for level in &self.levels {
            recording.pass(&self.sum, &bindings, level, groups(level))?;
        }
        // The last level has one block.
        for level in self.levels.iter().rev().skip(1) {
            recording.pass(&self.add, &bindings, level, groups(level))?;
        }
        Ok(())
    }
}

/// The levels of a sum of `count` values: the values, the sums of their blocks, and so on, down to one block. Each level has
/// the index of its first value, its number of values, and the index of its first sum.
fn levels(count: u64) -> Vec<[u64; 3]> {
    let mut levels = Vec::new();
    let (mut first, mut count) = (0, count);
    loop {
        let sums = first + count;
        levels.push([first, count, sums]);
        let blocks = count.div_ceil(u64::from(PREFIX_BLOCK));
        if blocks <= 1 {
            return levels;
        }
        (first, count) = (sums, blocks);
    }
}

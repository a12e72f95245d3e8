//! Exclusive prefix sums on the device: each value of an array is replaced by the sum of all values before it. The table of
//! world reservoirs (reservoirs of path vertices) uses them to compute where each of its lists begins, from the lengths of
//! the lists.

use crate::Result;
use crate::gpu::{Buffer, ComputePass, Recording, in_rows};
use crate::shader_interface::{PREFIX_BLOCK, PrefixLevel};

crate::bindings! {
    /// Bindings of the passes `prefix_sum` and `prefix_add`. Together, these passes replace each 32-bit integer in the
    /// buffer `values` by the sum of all integers before it. The buffer also has space, after these integers, for the
    /// sums of blocks.
    pub struct PrefixValues {
        write values,
    }
}

/// A prefix sum on the device: each of a fixed number of values is replaced by the sum of the values before it. It has two
/// passes, and the levels on which the passes run: the values, the sums of blocks of values, and so on. The table of world
/// reservoirs uses it to turn the lengths of its lists into the indices at which the lists begin.
pub struct PrefixSum {
    sum: ComputePass,
    add: ComputePass,
    levels: Vec<PrefixLevel>,
}

impl PrefixSum {
    /// Makes the two passes that replace each of `count` values in a buffer by the sum of the values before it. The first of
    /// these values has the index `first` in the buffer. `pass` makes the compute pass with a given name.
    ///
    /// # Errors
    /// `pass` fails.
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

    /// The size, in 32-bit words, of the part of a buffer that a prefix sum of `count` values uses. This part contains the
    /// values, then the sums of their blocks, then the sums of blocks of these sums, and so on.
    pub fn length(count: u64) -> u64 {
        let last = levels(count).pop();
        // The pass also writes the sum of the last block.
        last.map_or(0, |[_, _, sums]| sums) + 1
    }

    /// Records the passes that replace each of the values in the buffer `values` by the sum of the values before it.
    ///
    /// # Errors
    /// The driver rejects a shader, or the names of the bindings differ from those in the shader.
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

/// The levels of a prefix sum of `count` values: the values, the sums of blocks of `PREFIX_BLOCK` values, and so on, until a
/// level is a single block. One dispatch sums one level. Each entry has three numbers: the index of the level's first value,
/// the number of its values, and the index of the sum of its first block.
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

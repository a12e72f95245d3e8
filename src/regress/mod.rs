//! Regression tests of drivers. They render small pictures, and compare them with golden frames: stored pictures, and stored
//! hashes of the buffers that each pass writes, made by a trusted driver. On the driver that made the golden frames, every
//! bit must be equal. On another driver, only the pictures are compared, and they must agree except for rounding.

mod cases;
mod golden;
mod junit;
mod verdict;

pub use cases::{Case, cases};
pub use golden::{Blessing, Golden, Goldens, Rendered, Step};
pub use junit::report;
pub use verdict::{SEEDS, Verdict, judge_exactly, judge_loosely, level};

//! Regression tests of drivers. The pictures of small frames, and the outputs of each of their passes, are compared with
//! golden frames, which a trusted driver made. On the driver that made them every bit must be equal; on another driver the
//! pictures must agree except for rounding.

mod cases;
mod golden;
mod junit;
mod verdict;

pub use cases::{Case, cases};
pub use golden::{Blessing, Golden, Goldens, Step};
pub use junit::report;
pub use verdict::{Rendered, Verdict, judge_exactly, judge_loosely};

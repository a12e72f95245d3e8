//! Regression tests of drivers: small frames whose pictures, and what each pass writes on the way, are compared with golden
//! ones. On the driver that made these every bit must be the same; on another the pictures must agree but for rounding.

mod cases;
mod golden;
mod junit;
mod verdict;

pub use cases::{Case, cases};
pub use golden::{Blessing, Golden, Goldens, Step};
pub use junit::report;
pub use verdict::{Rendered, Verdict, judge_exactly, judge_loosely};

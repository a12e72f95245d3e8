//! Advice on settings: for one scene, view and device, measures the frame time and the error of each
//! candidate (a preset, possibly with changed settings), and recommends one of them.
//!
//! The candidates are compared in a race: after each round, the worse ones are left out (successive halving).
//! Errors are measured against two references with independent noise, so that this noise does not change the
//! expected errors. The printed numbers come from seeds that the race did not use.

pub mod cache;
pub mod candidates;
pub mod chain;
pub mod choice;
pub mod exhibit;
pub mod front;
pub mod need;
pub mod race;
pub mod sentence;
pub mod sizing;
pub mod timing;
pub mod track;
pub mod truth;

pub use candidates::Candidate;
pub use front::{Front, Point};

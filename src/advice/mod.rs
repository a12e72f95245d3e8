//! Advice: measures, for one scene on one device, how much a frame of each preset costs and how far off it is, and says
//! which one to use.
//!
//! The candidates race by successive halving. Their errors are measured with two independent references, so that the noise
//! of the references is taken out, and the numbers that are printed come from seeds that the race did not use.

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

//! Rendering: settings and presets, the frame as a readable list of passes, and one file for each
//! technique.

pub mod camera;
pub mod energy;
pub mod frame;
pub mod presets;
pub mod settings;
mod strips;
pub mod sums;

pub use frame::{Renderer, View};
pub use settings::Settings;

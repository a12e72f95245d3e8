//! Rendering: settings and presets, the frame as a readable list of passes, and one file for each
//! technique.

pub mod aovs;
pub mod camera;
pub mod clock;
pub mod counters;
pub mod energy;
pub mod frame;
pub mod kind;
pub mod offered;
pub mod path_tracing;
pub mod presets;
pub mod renderer;
pub mod reservoir_aovs;
pub mod reservoirs;
pub mod settings;
mod strips;
pub mod sums;
pub mod view;

pub use clock::Clock;
pub use kind::Kind;
pub use renderer::Renderer;
pub use settings::Settings;
pub use view::View;

//! Rendering: settings and presets, the frame as a list of passes, the techniques that own the passes, and
//! the outputs besides the picture.

pub mod camera;
mod candidates;
pub mod clock;
pub mod counters;
pub mod energy;
mod frame;
mod history;
pub mod kind;
pub mod light_bvh;
pub mod outputs;
pub mod passes;
pub mod presets;
pub mod ray_list;
pub mod renderer;
pub mod reservoir_layout;
pub mod scene_bindings;
pub mod settings;
pub mod specialisation;
mod strips;
pub mod techniques;
mod tracking;
pub mod view;
mod world_vertices;

pub use clock::Clock;
pub use kind::Kind;
pub use renderer::Renderer;
pub use settings::Settings;
pub use tracking::Tracking;
pub use view::View;

//! Rendering: settings and presets, the passes of a frame, the integrators (path tracing and resampling) that make and run
//! these passes, and the outputs, such as the picture and its AOVs.

mod builder;
pub mod camera;
pub mod clock;
pub mod counters;
pub mod energy;
pub mod frame_inputs;
mod history;
pub mod integrators;
pub mod light_samplers;
pub mod lighting;
pub mod outputs;
pub mod presets;
pub mod ray_list;
pub mod renderer;
pub mod resolved_settings;
pub mod scene_bindings;
pub mod settings;
mod strips;
mod tracking;
pub mod view;
pub mod world_reservoirs;

pub use builder::RendererBuilder;
pub use clock::Clock;
pub use lighting::Lighting;
pub use renderer::Renderer;
pub use resolved_settings::ResolvedSettings;
pub use settings::Settings;
pub use tracking::Tracking;
pub use view::View;

//! The passes: what each `glsl/passes/NAME.comp` is bound to. The fields of a structure are the bindings of
//! the shader, matched by name; every pass also binds the scene.

mod grid;
mod initial_direct;
mod initial_indirect;
mod light_lists;
mod path_trace;
mod pilots;
mod primary;
mod reservoir_aovs;
mod shade;
mod spatial;
mod surfaces;
mod temporal;
mod tone_map;
mod world_reservoirs;

pub use grid::{ClaimGrid, FillGrid};
pub use initial_direct::InitialDirect;
pub use initial_indirect::InitialIndirect;
pub use light_lists::DrawLightLists;
pub use path_trace::PathTrace;
pub use pilots::TracePilots;
pub use primary::Primary;
pub use reservoir_aovs::ReservoirAovs;
pub use shade::Shade;
pub use spatial::Spatial;
pub use surfaces::Surfaces;
pub use temporal::Temporal;
pub use tone_map::ToneMapPicture;
pub use world_reservoirs::{CountVertices, InsertCells, PrefixValues, ScatterVertices};

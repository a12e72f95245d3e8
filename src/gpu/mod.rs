//! Vulkan, independent of rendering: devices, buffers, shared layouts, shaders, compute passes,
//! timestamps and debug labels.
//!
//! All `unsafe` code of the crate is in this module. Its safe interface guarantees three things:
//! every object outlives the commands that use it ([`Recording::finish`] waits for the device), a
//! global memory barrier separates the passes of a recording, and every descriptor is checked
//! against the shader's interface by name, kind and access.
//!
//! Functions that call the driver return an error if the device is lost or out of memory; their
//! `# Errors` sections list only what can fail besides.
//!
//! Each file uses only files before it: `messages`, `instance`, `device`, `commands`, `buffer`,
//! `sampled_image`, `acceleration`, `layout`, `reflection`, `specialise`, `compilation`, `pass`, `recording` (`compiler`
//! uses none).

pub mod acceleration;
pub mod buffer;
mod commands;
mod compilation;
pub mod compiler;
pub mod device;
pub mod instance;
pub mod layout;
pub mod messages;
pub mod pass;
mod recorder;
pub mod recording;
pub mod reflection;
pub mod sampled_image;
pub(crate) mod specialise;

pub use acceleration::{AccelerationStructure, BlasGeometry, TlasInstance};
pub use buffer::{Buffer, Usage};
pub use commands::PassTime;
pub use device::{Device, Features};
pub use instance::{DeviceInfo, DriverKind, Instance};
pub use pass::{Bindings, ComputePass, Resource};
pub use recording::{Recording, in_rows};
pub use sampled_image::SampledImage;

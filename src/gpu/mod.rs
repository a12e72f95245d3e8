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
//! Each file uses only files before it: `messages`, `instance`, `recorder`, `device`, `commands`, `buffer`,
//! `presentation`, `sampled_image`, `acceleration`, `layout`, `reflection`, `specialise`, `compilation`, `pass`, `recording` (`compiler`
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
pub mod presentation;
mod recorder;
pub mod recording;
pub mod reflection;
pub mod sampled_image;
pub(crate) mod specialise;

pub use acceleration::{AccelerationStructure, BlasGeometry, TlasInstance};
pub use buffer::{Buffer, Usage};
pub use device::{Compiled, Device, Features, Label, Output};
pub use instance::{DeviceInfo, DriverKind, Instance, InstanceOptions};
pub use pass::{Bindings, ComputePass, Resource};
pub use presentation::Presentation;
pub use recorder::PassTime;
pub use recording::{Recording, in_rows};
pub use sampled_image::SampledImage;

//! Vulkan, knowing no rendering: devices, buffers, shared layouts, shaders, one kind of compute
//! pass, timestamps and labels.
//!
//! All `unsafe` of the crate is below this module. The safe surface keeps these promises: every
//! object outlives the commands that use it (a recording is waited for before it returns), every
//! buffer access in a recording is separated by one global memory barrier between passes, and all
//! descriptors are checked against the shader's own interface by name, kind and access.
//!
//! Each file uses only files before it: `messages`, `instance`, `device`, `commands`, `buffer`,
//! `acceleration`, `layout`, `reflection`, `pass`, `recording` (`compiler` uses none).

pub mod acceleration;
pub mod buffer;
mod commands;
pub mod compiler;
pub mod device;
pub mod instance;
pub mod layout;
pub mod messages;
pub mod pass;
pub mod recording;
pub mod reflection;

pub use acceleration::{AccelerationStructure, BlasGeometry, TlasInstance};
pub use buffer::{Buffer, Usage};
pub use commands::PassTime;
pub use device::{Device, Features};
pub use instance::{DeviceInfo, DriverKind, Instance};
pub use pass::{Bindings, ComputePass, Resource};
pub use recording::Recording;

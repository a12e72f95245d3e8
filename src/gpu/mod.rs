//! Vulkan, independent of rendering: devices, buffers, shaders, compute passes, timestamps and debug labels.
//!
//! All `unsafe` code that calls Vulkan is in this module. Its safe interface guarantees three things. Every object outlives
//! the commands that use it, because [`Recording::finish`] waits for the commands, and because dropping an object waits for
//! commands that still run. A global memory barrier separates the passes of a recording. Every descriptor is checked against
//! the shader's interface: its name, its kind of resource, and whether the shader may write the resource.
//!
//! Functions that call the driver return an error if the device is lost or out of memory. Their `# Errors` sections list
//! only the other failures.
//!
//! Each file imports only files that stand before it in this list: `messages`, `device_info`, `instance`, `recorder`,
//! `records`, `device`, `waiting`, `commands`, `buffer`, `image_commands`, `presentation`, `sampled_image`, `acceleration`,
//! `reflection`, `specialise`, `dead_code`, `program`, `compilation`, `pass`, `recording`.

pub mod acceleration;
pub mod buffer;
mod commands;
mod compilation;
mod dead_code;
mod descriptor_sets;
pub mod device;
pub mod device_info;
mod image_commands;
pub mod instance;
pub mod messages;
pub mod pass;
pub mod presentation;
mod program;
mod recorder;
pub mod recording;
pub mod records;
pub mod reflection;
pub mod sampled_image;
pub(crate) mod specialise;
mod waiting;

pub use acceleration::{AccelerationStructure, BlasGeometry, TlasInstance};
pub use buffer::{Buffer, Usage};
pub use device::{Device, Features, Label};
pub use device_info::{DeviceInfo, DriverKind};
pub use instance::{Instance, InstanceOptions};
pub use pass::{Bindings, ComputePass, Offers, Resource};
pub use presentation::Presentation;
pub use recorder::PassTime;
pub use recording::{Recording, in_rows};
pub use records::{Compiled, CompilerReport, Output};
pub use sampled_image::SampledImage;

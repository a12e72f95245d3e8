//! Scenes from files: what is read from good ones, and that bad ones end in one line that names
//! the file and the element, never in a panic.

mod animations;
mod files;
mod garbage;
mod gltf;
mod obj;
mod progress;
#[path = "../support/mod.rs"]
mod support;

//! The targets: each loads one kind of file.

mod environment;
mod glb;
mod gltf;
mod obj;
mod picture;
mod plan;
mod settings;
mod texture;

/// A loader, called with the bytes of a file. True if the file has a readable header.
pub type Run = fn(&[u8]) -> bool;

/// All targets by their names.
pub const TARGETS: [(&str, Run); 8] = [
    ("gltf", gltf::run),
    ("glb", glb::run),
    ("obj", obj::run),
    ("texture", texture::run),
    ("environment", environment::run),
    ("picture", picture::run),
    ("settings", settings::run),
    ("plan", plan::run),
];

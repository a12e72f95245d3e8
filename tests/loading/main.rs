//! Scenes from files: valid ones are read completely; broken ones end in one line that names the file and the
//! element, never in a panic.

mod animations;
mod environments;
mod files;
mod garbage;
mod gltf;
mod images;
mod lights;
mod limits;
mod obj;
mod outside;
mod progress;
#[path = "../support/mod.rs"]
mod support;
mod textures;

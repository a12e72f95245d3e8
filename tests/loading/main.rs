//! Tests of scenes from files: a valid file is read completely, and a broken file ends in one line that names the file and
//! the element, never in a panic.

mod animations;
mod compression;
mod environments;
mod files;
mod garbage;
mod gltf;
mod gltf_extensions;
mod images;
mod lights;
mod limits;
mod obj;
mod outside;
mod progress;
#[path = "../support/mod.rs"]
mod support;
mod textures;
mod tolerance;

//! Tests of scenes from files: a valid file is read completely, and a broken file ends in one line that names the file and
//! the element, never in a panic.

mod animations;
mod compression;
mod deformations;
mod environments;
mod exr;
mod file_names;
mod files;
mod garbage;
mod gltf;
mod gltf_extensions;
mod hdr;
mod image_based;
mod images;
mod lights;
mod limits;
mod missing;
mod obj;
mod obj_materials;
mod obj_text;
mod obj_tobj;
mod obj_vertices;
mod outside;
mod progress;
#[path = "../support/mod.rs"]
mod support;
mod textures;
mod threads;
mod tolerance;

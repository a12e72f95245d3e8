//! Headwater is a headless Vulkan renderer that path traces real scenes with reservoir resampling (ReSTIR), and measures how
//! much accuracy each faster setting costs. This page is for users of the library; the project's README documents the
//! program.
//!
//! # A picture in a few lines
//!
//! ```
//! use headwater::{Renderer, Scene};
//!
//! fn main() -> headwater::Result<()> {
//!     // The name of a generated scene, or the path of a glTF or OBJ file.
//!     let scene = Scene::open("cornell")?;
//!     let mut renderer = Renderer::builder(&scene).preset("balanced")?.size(32, 32).build()?;
//!     // Frames 0 to 3; each is added to the sums of every pixel.
//!     renderer.add_samples(0, 4)?;
//!     // Mean radiance, linear sRGB, row by row from the top.
//!     let pixels = renderer.sums()?.mean(4);
//!     assert!(pixels[16 * 32 + 16].min_element() > 0.0);
//!     Ok(())
//! }
//! ```
//!
//! # A crate that uses Headwater
//!
//! It needs Rust 1.89 or newer, and these lines in its `Cargo.toml`:
//!
//! ```toml
//! [dependencies]
//! headwater = { path = "../headwater" } # the folder of the project
//! glam = "0.34" # vectors and matrices, in the version of Headwater's Cargo.toml: another version has other types
//! ```
//!
//! Vulkan must be installed; `eval "$(../headwater/tools/env)"` gives a machine without a GPU a software Vulkan. Call it in
//! each shell that builds or starts the crate: the software Vulkan is found by environment variables when the program
//! starts. It also sets `SHADERC_LIB_DIR` to a compiled shaderc. Without this variable, the build script of `shaderc-sys`
//! compiles shaderc, and needs cmake, git, python3 and a C++ compiler.
//!
//! # A scene in memory
//!
//! A program can fill a [`Scene`] itself. [`Scene::open`] checks a scene, and gives one without light a neutral environment.
//! A program that fills a scene must do both, with [`Scene::validate`] and [`Scene::surround`], before it makes a renderer:
//! [`Renderer::builder`] does not check the scene.
//!
//! ```no_run
//! use glam::{DAffine3, DVec3, Vec3};
//! use headwater::scene::camera::look_at;
//! use headwater::scene::{Instance, Material, Mesh, Part};
//! use headwater::{Renderer, Scene};
//!
//! /// A horizontal square with the side 2, whose front is its upper side. `material` is an index into the materials.
//! fn square(material: u32) -> Mesh {
//!     let corner = |x, z| Vec3::new(x, 0.0, z);
//!     Mesh {
//!         positions: vec![corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)],
//!         // Counter-clockwise, seen from the front.
//!         triangles: vec![[0, 1, 2], [0, 2, 3]],
//!         parts: vec![Part { first_triangle: 0, triangle_count: 2, material }],
//!         ..Mesh::default()
//!     }
//! }
//!
//! fn main() -> headwater::Result<()> {
//!     let instance = |name: &str, mesh, object_to_world| Instance { name: name.into(), mesh, object_to_world };
//!     let mut scene = Scene {
//!         name: "lamp".into(),
//!         materials: vec![
//!             Material::lambert("grey", Vec3::splat(0.5)),
//!             Material {
//!                 emission: Vec3::splat(10.0), // radiance in W/(m²·sr)
//!                 double_sided: true,          // both sides emit
//!                 ..Material::lambert("light", Vec3::ZERO)
//!             },
//!         ],
//!         meshes: vec![square(0), square(1)],
//!         instances: vec![
//!             instance("floor", 0, DAffine3::from_scale(DVec3::splat(4.0))),
//!             instance("lamp", 1, DAffine3::from_translation(DVec3::new(0.0, 3.0, 0.0))),
//!         ],
//!         // Position, target, and vertical field of view in radians.
//!         cameras: vec![look_at(DVec3::new(0.0, 2.0, 9.0), DVec3::Y, 0.8)],
//!         ..Scene::default()
//!     };
//!     scene.validate()?;
//!     // Without a name, only a scene that has no light gets an environment. This one has a lamp.
//!     scene.surround(None)?;
//!     for notice in &scene.notices {
//!         eprintln!("{notice}");
//!     }
//!     let mut renderer = Renderer::builder(&scene).size(640, 360).build()?;
//!     renderer.add_samples(0, 8)?;
//!     println!("{}", renderer.sums()?.mean(8)[180 * 640 + 320]);
//!     Ok(())
//! }
//! ```
//!
//! # Where to go from there
//!
//! | to | see |
//! |---|---|
//! | set the camera, size, seed or device | [`render::RendererBuilder`] |
//! | change a setting | [`Settings::parse_change`](render::Settings::parse_change), [`Settings::with`](render::Settings::with) |
//! | render an animation | [`Renderer::set_moment`](render::Renderer::set_moment), [`Renderer::single_frame`](render::Renderer::single_frame), [`Renderer::frame_radiance`](render::Renderer::frame_radiance) |
//! | look at surfaces and reservoirs | [`Renderer::primary_surfaces`](render::Renderer::primary_surfaces), [`Renderer::reservoir_aovs`](render::Renderer::reservoir_aovs) |
//! | build a scene in memory | [the example](#a-scene-in-memory), [`scene::Scene`]; generated scenes: [`procedural`] |
//! | write EXR or PNG | [`image`] |
//! | compare pictures | [`metrics`] |
//!
//! Data flows through the modules in this order: [`scene`] → [`gpu`] → [`device_scene`] → [`render`] → [`image`] →
//! [`metrics`].
#![warn(missing_docs)]

pub mod advice;
pub mod base;
pub mod commands;
pub mod device_scene;
pub mod gpu;
pub mod image;
pub mod metrics;
pub mod page;
pub mod procedural;
pub mod profile;
pub mod regress;
pub mod render;
pub mod scene;
pub mod scene_files;
pub mod study;

pub use base::error::{Error, Result};
pub use headwater_shader_interface as shader_interface;
pub use render::Renderer;
pub use scene::Scene;

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
//! Vulkan must be installed; `eval "$(tools/env)"` in the project's folder gives a machine without a GPU a software Vulkan.
//! It also sets `SHADERC_LIB_DIR` to a compiled shaderc. Where a crate that depends on Headwater is built without it, the
//! build script of `shaderc-sys` compiles shaderc, and needs cmake, git, python3 and a C++ compiler.
//!
//! # Where to go from there
//!
//! | to | see |
//! |---|---|
//! | set the camera, size, seed or device | [`render::RendererBuilder`] |
//! | change a setting | [`Settings::parse_change`](render::Settings::parse_change), [`Settings::with`](render::Settings::with) |
//! | render an animation | [`Renderer::set_moment`](render::Renderer::set_moment), [`Renderer::single_frame`](render::Renderer::single_frame), [`Renderer::frame_radiance`](render::Renderer::frame_radiance) |
//! | look at surfaces and reservoirs | [`Renderer::primary_surfaces`](render::Renderer::primary_surfaces), [`Renderer::reservoir_aovs`](render::Renderer::reservoir_aovs) |
//! | build a scene in memory | [`scene::Scene`], [`procedural`] |
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

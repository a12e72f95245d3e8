//! Pages: one HTML file that compares settings on one scene, and needs nothing else: it works offline, from any folder.
//!
//! This room knows neither scenes nor devices. It takes numbers, texts and pictures ([`contents`]), and returns the text of the
//! page ([`Page::html`]). An [`Overview`] leads to the pages of several scenes.

pub mod contents;
mod html;
mod overview;
mod pictures;

pub use contents::{Answer, Exhibit, FrameMap, Page, Point, Shared, Standing};
pub use overview::{Overview, OverviewRow, OverviewScene};

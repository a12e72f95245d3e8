//! Pages: HTML files that compare settings on one scene. A page needs no other file and works offline.
//!
//! This module does not use scenes or devices. It takes numbers, texts and pictures ([`contents`]), and
//! returns the text of the page ([`Page::html`]). An [`Overview`] has links to the pages of several scenes.

pub mod contents;
mod html;
mod overview;
mod pictures;

pub use contents::{Answer, Exhibit, FrameMap, Page, Point, Shared, Standing};
pub use overview::{Overview, OverviewRow, OverviewScene};

//! Tests of pictures against results that are known without the renderer: closed forms, and a path tracer on the CPU that
//! shares no code with it.

mod boxes;
mod closed_form;
mod comparison;
mod itself;
mod rooms;
#[path = "../support/mod.rs"]
mod support;

//! Tests of scenes that move. They must be traced and lit as if each moment had been loaded separately, resampled without
//! bias although the previous frame was different, and compared with references of the same moment.

mod bias;
mod figures;
mod moments;
mod named;
mod study;
#[path = "../support/mod.rs"]
mod support;
mod vectors;

use headwater::procedural;
use headwater::scene::Scene;

/// The generated scene `playroom` in which only the named things move, at a speed.
fn playroom(moving: &[&str], speed: f64) -> Scene {
    let names = ["camera", "object", "light", "toggle"];
    let settings = names.map(|name| {
        let speed = if moving.contains(&name) { speed } else { 0.0 };
        (name.to_owned(), speed.to_string())
    });
    procedural::generate("motion", &settings).unwrap()
}

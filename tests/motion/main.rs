//! Scenes that move: traced and lit as if each moment had been loaded by itself, resampled without bias although
//! the previous frame was different, and compared with references of the same moment.

mod bias;
mod moments;
mod study;
#[path = "../support/mod.rs"]
mod support;
mod vectors;

use headwater::procedural;
use headwater::scene::Scene;

/// The procedural scene with only what is named in motion, at a speed.
fn playroom(moving: &[&str], speed: f64) -> Scene {
    let names = ["camera", "object", "light", "toggle"];
    let settings = names.map(|name| {
        let speed = if moving.contains(&name) { speed } else { 0.0 };
        (name.to_owned(), speed.to_string())
    });
    procedural::generate("motion", &settings).unwrap()
}

//! Measures what a program gains by compiling only the code that a scene requires: frames by specialised shaders and by
//! shaders with all code (`variant=full`), in turns.
//!
//! `cargo bench --bench variants [-- [--preset NAME] [--environment FILE] [SCENES…]]` prints one line per scene, by default
//! with `accurate` and all generated scenes: `variants SCENE ms=… full=… same=… spirv=… spirv_full=… bytes=… pixel=… cold=…
//! warm=… cold_full=…`.
//!
//! - `ms`: median time of the passes of a frame, in milliseconds; `full`: the median ratio of the full shaders to it.
//! - `same`: whether both kinds of shaders gave the same bits.
//! - `spirv`, `spirv_full`: bytes of the shaders of all passes as drivers get them.
//! - `bytes`: bytes of the scene's buffers; `pixel`: bytes of the picture's buffers, per pixel.
//! - `cold`, `warm`: seconds of a whole process that renders one frame, without and with Mesa's cache of shaders;
//!   `cold_full`: without the cache, with the full shaders.
//!
//! The last line counts the distinct sets of specialisation constants.

#[path = "../support/mod.rs"]
mod support;

use headwater::device_scene::selection::{Request, select};
use headwater::device_scene::{GpuScene, SceneSizes};
use headwater::procedural;
use headwater::render::presets::Preset;
use headwater::render::settings::Variant;
use headwater::render::{Renderer, View};
use headwater::scene::Environment;
use headwater::scene::camera::{DEFAULT_ASPECT, framing_camera};
use headwater::scene::requirements::Requirements;
use headwater::scene_files::Options;
use std::collections::HashSet;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;
const BOUNCES: u32 = 5;
const ROUNDS: u32 = 15;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The seconds of a whole process that renders one frame. `cached`: with Mesa's cache of shaders; `full`: with
/// `variant=full`.
fn start_up(scene: &str, environment: Option<&str>, preset: &str, cached: bool, full: bool) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_headwater"));
    command.args([
        "render",
        scene,
        "--allow-missing",
        "--width",
        "160",
        "--preset",
        preset,
        "-o",
    ]);
    command
        .arg(folder.path().join("a.exr"))
        .stderr(Stdio::null());
    if let Some(environment) = environment {
        command.args(["--environment", environment]);
    }
    if full {
        command.args(["--set", "variant=full"]);
    }
    if !cached {
        command.env("MESA_SHADER_CACHE_DISABLE", "true");
    }
    let start = Instant::now();
    assert!(command.status().unwrap().success(), "{scene}");
    start.elapsed().as_secs_f64()
}

fn main() {
    let (mut preset, mut environment, mut scenes) = ("accurate".to_owned(), None, Vec::new());
    let mut arguments = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = arguments.next() {
        match word.as_str() {
            "--preset" => preset = arguments.next().expect("a preset"),
            "--environment" => environment = arguments.next(),
            _ => scenes.push(word),
        }
    }
    if scenes.is_empty() {
        scenes = procedural::list()
            .iter()
            .map(|scene| scene.name.to_owned())
            .collect();
    }
    let mut sets = HashSet::new();
    for name in &scenes {
        let options = Options {
            allow_missing: true,
            ..Options::default()
        };
        let mut scene =
            headwater::scene::Scene::open_watched(name, options, &mut |_, _, _| Ok(())).unwrap();
        scene.environment = environment
            .as_deref()
            .map(|file| Environment::open(file, &mut Vec::new()).unwrap());
        let view = View {
            camera: (scene.cameras.first().cloned())
                .unwrap_or_else(|| framing_camera(&scene, DEFAULT_ASPECT)),
            width: WIDTH,
            height: HEIGHT,
            seed: 1,
            bounces: BOUNCES,
            jitter: false,
        };
        let (_, info) = support::tests_device();
        let variant = select(&info, Request::default(), &SceneSizes::of(&scene))
            .unwrap()
            .variant;
        let (device, _) = support::open_device(Some(variant));
        let origin = view.camera.camera_to_world.translation;
        let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, variant).unwrap());
        let mut shaders = [0; 2];
        let variants = [Variant::Auto, Variant::Full].into_iter();
        let mut renderers: Vec<Renderer> = (variants.zip(&mut shaders))
            .map(|(variant, shaders)| {
                let mut settings = Preset::named(&preset).unwrap().settings().unwrap();
                settings.variant = variant;
                if variant == Variant::Auto {
                    sets.insert(uploaded.specialisation(false).words());
                }
                let before = device.records.shader_bytes();
                let mut renderer =
                    Renderer::new(&device, uploaded.clone(), &view, &settings).unwrap();
                // The first two frames compile, one without and one with history.
                renderer.single_frame(0).unwrap();
                renderer.single_frame(1).unwrap();
                *shaders = device.records.shader_bytes() - before;
                renderer
            })
            .collect();
        let (mut times, mut ratios, mut same) = (Vec::new(), Vec::new(), true);
        for frame in 2..ROUNDS + 2 {
            let both: Vec<f64> = (renderers.iter_mut())
                .map(|renderer| {
                    let passes = renderer.single_frame(frame).unwrap();
                    passes.iter().map(|pass| pass.milliseconds).sum::<f64>()
                })
                .collect();
            times.push(both[0]);
            ratios.push(both[1] / both[0]);
            let pictures: Vec<Vec<[u32; 3]>> = (renderers.iter())
                .map(|renderer| {
                    let radiance = renderer.frame_radiance().unwrap();
                    radiance.iter().map(|p| p.map(f32::to_bits)).collect()
                })
                .collect();
            same &= pictures[0] == pictures[1];
        }
        let bytes: u64 = uploaded.memory().iter().map(|(_, bytes)| bytes).sum();
        let shown = Path::new(name)
            .file_stem()
            .map_or(name.clone(), |stem| stem.to_string_lossy().into_owned());
        let start = |cached, full| start_up(name, environment.as_deref(), &preset, cached, full);
        start(true, false);
        println!(
            "variants {shown} ms={:.1} full={:.3} same={same} spirv={} spirv_full={} bytes={bytes} pixel={:.0} cold={:.1} warm={:.2} cold_full={:.1}",
            median(times),
            median(ratios),
            shaders[0],
            shaders[1],
            renderers[0].bytes_per_pixel(),
            start(false, false),
            start(true, false),
            start(false, true),
        );
        let [requires, _] = Requirements::of(&scene).features();
        println!("    requires {}", requires.join(", "));
    }
    println!("variants distinct={} of {}", sets.len(), scenes.len());
}

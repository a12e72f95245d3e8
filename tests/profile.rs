//! Tests that `profile` counts correctly, writes traces whose slices nest, and compares only comparable profiles.

mod support;

use headwater::device_scene::GpuScene;
use headwater::procedural;
use headwater::profile::Profile;
use headwater::render::presets::Preset;
use headwater::render::{Renderer, View};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use support::said;

fn profile(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_headwater"))
        .arg("profile")
        .args(arguments)
        .output()
        .unwrap()
}

/// Arguments of a frame whose bytes and rays can be counted by hand: four pixels that see the walls of `cornell`, with
/// direct light only.
const SMALL: [&str; 20] = [
    "cornell",
    "--jitter",
    "off",
    "--width",
    "2",
    "--height",
    "2",
    "--bounces",
    "1",
    "--frames",
    "2",
    "--warm-up",
    "1",
    "--preset",
    "accurate",
    "--set",
    "direct.reuse=none",
    "--set",
    "direct.visibility=final",
    "--json",
];

#[test]
fn bytes_and_rays_are_what_a_hand_counts() {
    let output = profile(&SMALL);
    assert!(output.status.success(), "{}", said(&output));
    let profile: Profile = serde_json::from_slice(&output.stdout).unwrap();
    let counts = |name: &str| {
        let pass = profile.passes.iter().find(|pass| pass.name == name);
        pass.unwrap_or_else(|| panic!("{name}: {:#?}", profile.passes))
            .counts
            .clone()
    };
    // Eight words of sample data and three of colour a pixel; the rays through the pixels all hit a wall.
    let surfaces = counts("surfaces");
    assert_eq!((surfaces.rays, surfaces.hits), (4, 4));
    assert_eq!(
        (surfaces.bytes_read, surfaces.bytes_written),
        (0, 4 * 11 * 4)
    );
    // Without BSDF candidates no ray; a compact reservoir has four words.
    let initial = counts("initial_direct");
    assert_eq!(initial.rays, 0);
    assert_eq!(
        (initial.bytes_read, initial.bytes_written),
        (4 * 8 * 4, 4 * 4 * 4)
    );
    // A shadow ray for each sample that was selected, and a pixel that is lit reads and writes its colour.
    let shade = counts("shade_direct");
    let lit = shade.rays - shade.hits;
    assert!(shade.rays <= 4 && lit > 0, "{shade:?}");
    assert_eq!(shade.bytes_read, 4 * (8 + 4) * 4 + lit * 3 * 4);
    assert_eq!(shade.bytes_written, lit * 3 * 4);
    // Pixels lie in tiles of 4 × 4.
    let mut memory = profile.memory.iter();
    let reservoirs = memory.find(|memory| memory.name == "reservoirs").unwrap();
    assert_eq!((reservoirs.count, reservoirs.bytes), (1, 16 * 4 * 4));
}

#[test]
fn lines_begin_with_what_they_are_about() {
    let output = profile(&SMALL[..SMALL.len() - 1]);
    let text = said(&output);
    for start in [
        "profile ",
        "device ",
        "frame median ",
        "host median ",
        "pass surfaces ",
        "memory reservoirs ",
        "memory_total ",
    ] {
        assert!(
            text.lines().any(|line| line.starts_with(start)),
            "{start}: {text}"
        );
    }
}

#[test]
fn world_reservoirs_tell_how_full_their_table_is() {
    let output = profile(&[
        "cornell",
        "--width=32",
        "--frames=1",
        "--warm-up=0",
        "--bounces=2",
        "--set=indirect.secondary=world-reservoirs",
        "--set=world_reservoirs.min_lights=0",
    ]);
    let text = said(&output);
    let mut lines = text.lines();
    let line = lines.find(|line| line.starts_with("world_reservoirs vertices "));
    let words = line.unwrap_or_else(|| panic!("{text}")).split_whitespace();
    let numbers: Vec<u32> = words.filter_map(|word| word.parse().ok()).collect();
    // A path has a second vertex unless it leaves the box through its open side. A fourth of a slot for each pixel is 256.
    assert!((500..32 * 32).contains(&numbers[0]), "{numbers:?}");
    assert!((1..256).contains(&numbers[1]), "{numbers:?}");
    assert_eq!(numbers[2], 256);
    assert!(numbers[3] < numbers[0], "{numbers:?}");
}

#[test]
fn only_profiles_of_one_subject_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (old, slow, fast) = (path("old.json"), path("slow.json"), path("fast.json"));
    let with = |more: &[&str]| profile(&[&SMALL[..SMALL.len() - 1], more].concat());
    let output = with(&["-o", &old]);
    assert!(output.status.success(), "{}", said(&output));
    let edited = |path: &str, factor: f64| {
        let mut profile: Profile = serde_json::from_slice(&std::fs::read(&old).unwrap()).unwrap();
        let passes = profile.passes.iter_mut().map(|pass| &mut pass.milliseconds);
        for spread in passes.chain([&mut profile.frame]) {
            spread.median *= factor;
            spread.p95 *= factor;
        }
        std::fs::write(path, serde_json::to_string(&profile).unwrap()).unwrap();
    };
    edited(&slow, 1e3);
    edited(&fast, 1e-3);
    let output = with(&["--against", &slow]);
    assert!(output.status.success(), "{}", said(&output));
    let output = with(&["--against", &fast]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        said(&output).contains("the frame takes +"),
        "{}",
        said(&output)
    );

    std::fs::write(path("damaged.json"), "{\"version\": 1, ").unwrap();
    for (arguments, status, expected) in [
        (
            &["--against", &old, "--seed", "7"][..],
            2,
            "a profile of another seed",
        ),
        (&["--against", &path("damaged.json")], 2, "is not a profile"),
        (&["--against", &path("missing.json")], 2, "cannot read"),
        (&["--trace", "/no/folder/t.json"], 1, "/no/folder/t.json"),
        (&["--max-slowdown", "-1"], 2, "--max-slowdown"),
        (&["--in-flight", "0"], 2, "--in-flight 0"),
    ] {
        let output = with(arguments);
        assert_eq!(
            output.status.code(),
            Some(status),
            "{arguments:?}: {}",
            said(&output)
        );
        assert!(
            String::from_utf8_lossy(&output.stderr).contains(expected),
            "{}",
            said(&output)
        );
    }
    let output = profile(&["cornell", "--frames", "0"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(!Path::new("/no/folder").exists());
}

/// Frames that are submitted without waiting for the previous one must have the same bits.
#[test]
fn frames_in_flight_have_the_same_bits() {
    let scene = procedural::generate("cornell", &[]).unwrap();
    let (device, selection) = support::open_device(None);
    let view = View {
        camera: scene.cameras[0].clone(),
        width: 32,
        height: 32,
        seed: 3,
        bounces: 3,
        jitter: false,
    };
    let origin = view.camera.camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, selection.variant).unwrap());
    let settings = Preset::named("accurate").unwrap().settings().unwrap();
    let pictures = [false, true].map(|in_flight| {
        let mut renderer = Renderer::new(&device, uploaded.clone(), &view, &settings).unwrap();
        for number in 0..4 {
            if in_flight {
                assert!(renderer.submit_frame(number).unwrap().is_none());
            } else {
                renderer.single_frame(number).unwrap();
            }
        }
        let radiance = renderer.frame_radiance().unwrap();
        let times = device.wait_for_running(0).unwrap();
        assert_eq!(times.len(), if in_flight { 4 } else { 0 });
        assert!(times.iter().all(|times| times.len() > 5));
        // What is dropped while it is in use waits.
        renderer.submit_frame(4).unwrap();
        drop(renderer);
        assert_eq!(device.wait_for_running(0).unwrap().len(), 1);
        radiance
    });
    assert!(pictures[0] == pictures[1]);
    support::assert_no_messages(&device);
}

mod thorough {
    use super::*;

    /// Every slice of a track must lie within the last slice that has begun and not ended, or begin after its end.
    #[test]
    fn traces_nest() {
        let folder = tempfile::tempdir().unwrap();
        let trace = folder.path().join("trace.json");
        let output = profile(&[
            "cornell",
            "--width",
            "32",
            "--frames",
            "3",
            "--warm-up",
            "2",
            "--trace",
            trace.to_str().unwrap(),
            "--json",
        ]);
        assert!(output.status.success(), "{}", said(&output));
        let trace: Value = serde_json::from_slice(&std::fs::read(trace).unwrap()).unwrap();
        let events = trace["traceEvents"].as_array().unwrap();
        let named = |kind: &str| -> Vec<&str> {
            let events = events.iter().filter(|event| event["name"] == kind);
            events
                .map(|event| event["args"]["name"].as_str().unwrap())
                .collect()
        };
        assert_eq!(named("process_name"), ["headwater"]);
        assert_eq!(named("thread_name"), ["host", "device"]);
        for track in [1, 2] {
            let mut open: Vec<(&str, f64)> = Vec::new();
            let mut frames = Vec::new();
            let mut last = 0.0;
            for event in events
                .iter()
                .filter(|e| e["ph"] == "X" && e["tid"] == track)
            {
                let name = event["name"].as_str().unwrap();
                let (start, length) = (
                    event["ts"].as_f64().unwrap(),
                    event["dur"].as_f64().unwrap(),
                );
                assert!(
                    start >= last && length >= 0.0,
                    "{name} at {start}, {length} long"
                );
                last = start;
                // Times are in microseconds, and differences of large ones are rounded.
                let rounding = 0.01;
                open.retain(|(_, end)| *end > start + rounding);
                if let Some((outer, end)) = open.last() {
                    assert!(
                        start + length <= end + rounding,
                        "{name} ends after {outer}"
                    );
                }
                match name.strip_prefix("frame ") {
                    Some(number) => {
                        assert!(open.is_empty(), "{name} within {open:?}");
                        frames.push(number.parse::<u32>().unwrap());
                    }
                    None => assert_eq!((track, open.len()), (2, 1), "{name} is outside of a frame"),
                }
                open.push((name, start + length));
            }
            assert_eq!(frames, [0, 1, 2, 3, 4]);
        }
        let passes = events.iter().filter(|e| e["name"] == "surfaces").count();
        assert_eq!(passes, 5);
        // Microseconds, where the profile has milliseconds.
        assert_eq!(trace["displayTimeUnit"], "ms");
        let profile: Profile = serde_json::from_slice(&output.stdout).unwrap();
        let timed = events.iter().filter(|e| e["ph"] == "X" && e["tid"] == 1);
        let timed = timed.skip(2).map(|e| e["dur"].as_f64().unwrap() * 1e-3);
        let mut timed: Vec<f64> = timed.collect();
        timed.sort_by(f64::total_cmp);
        assert!(
            (timed[1] - profile.host.median).abs() < 1e-6 * timed[1],
            "{timed:?}"
        );
    }
}

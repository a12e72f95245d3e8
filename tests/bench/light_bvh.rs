//! Measures the time to build the light BVH, the time to fit it to lights that have moved, and the fraction of it that a
//! walk visits.
//!
//! `cargo bench --bench light_bvh [-- SCENES…]` prints one line per scene, by default for scenes with 10³ to 3·10⁵ lights:
//! `light_bvh SCENE lights=… clusters=… nodes=… build=… published=… fit=… bytes=… walk=… published_walk=…`.
//!
//! Times are medians in milliseconds: `build` of the whole build with default settings; `published` of the boxes of
//! influence as published, with the scale that fits 1024 points on surfaces; `fit` of new boxes for the same tree, which
//! moving lights need in every frame, without the copy to the device. `bytes` is the size on the device. A walk is
//! `visited/found`: the mean numbers of nodes that it visits and finds at these points.

#[path = "../support/mod.rs"]
mod support;

use glam::{DVec3, Vec3};
use headwater::device_scene::light_bvh::{LightBvh, LightBvhOptions, walk};
use headwater::device_scene::selection::{Request, select};
use headwater::device_scene::{GpuScene, SceneSizes};
use headwater::metrics::statistics::median;
use headwater::scene::Scene;
use headwater::scene_files::Options;
use headwater::shader_interface::GpuLightNode;
use std::time::Instant;

const ROUNDS: usize = 9;

/// The median time of several runs of `work`, in milliseconds.
fn time(mut work: impl FnMut()) -> f64 {
    median((0..ROUNDS).map(|_| {
        let start = Instant::now();
        work();
        1e3 * start.elapsed().as_secs_f64()
    }))
}

/// The mean numbers of nodes that a walk at one of the points visits and finds, as `visited/found`.
fn walks(nodes: &[GpuLightNode], points: &[Vec3], joins: bool) -> String {
    let (mut visited, mut found) = (0_u32, 0_u32);
    for visit in points.iter().flat_map(|point| walk(nodes, *point)) {
        visited += 1;
        found += u32::from(match joins {
            true => !visit.inside || visit.is_leaf,
            false => visit.inside && visit.is_leaf,
        });
    }
    let mean = |sum| f64::from(sum) / points.len() as f64;
    format!("{:.1}/{:.1}", mean(visited), mean(found))
}

fn main() {
    let scenes: Vec<String> = (std::env::args().skip(1))
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    let all = [
        "statue-room",
        "atrium",
        "night-city:blocks=5",
        "night-city",
        "colourful-mess",
        "street",
        "night-city:tessellation=3",
        "night-city:tessellation=7",
    ];
    let scenes = match scenes.is_empty() {
        true => all.map(str::to_owned).to_vec(),
        false => scenes,
    };
    for name in scenes {
        let scene = Scene::open_watched(&name, Options::default(), &mut |_, _, _| Ok(())).unwrap();
        let (_, info) = support::tests_device();
        let selection = select(&info, Request::default(), &SceneSizes::of(&scene)).unwrap();
        let (device, _) = support::open_device(Some(selection.variant));
        let uploaded = GpuScene::new(&device, &scene, DVec3::ZERO, selection.variant).unwrap();
        let (lights, groups) = (uploaded.first_lights(), &uploaded.light_groups);
        let surfaces = uploaded.surface_points(1024).unwrap();
        let surfaces: Vec<Vec3> = surfaces.iter().map(|point| point.position).collect();
        let joined = LightBvhOptions {
            scale: None,
            cut: true,
            clusters: true,
            by_power: true,
            leaves_out_rare: false,
        };
        let published = LightBvhOptions {
            scale: None,
            cut: false,
            clusters: true,
            by_power: false,
            leaves_out_rare: false,
        };
        let bvh = LightBvh::new(lights, groups, &surfaces, joined);
        let contents = bvh.contents(lights);
        let published_bvh = LightBvh::new(lights, groups, &surfaces, published);
        let build = |options| {
            time(|| drop(LightBvh::new(lights, groups, &surfaces, options).contents(lights)))
        };
        let bytes = size_of_val(&contents.words()[..]);
        println!(
            "light_bvh {name} lights={} clusters={} nodes={} build={:.2} published={:.2} fit={:.2} bytes={bytes} \
             walk={} published_walk={}",
            lights.choices.len(),
            bvh.cluster_count(),
            contents.nodes.len(),
            build(joined),
            build(published),
            time(|| drop(bvh.contents(lights))),
            walks(&contents.nodes, &surfaces, true),
            walks(&published_bvh.contents(lights).nodes, &surfaces, false),
        );
    }
}

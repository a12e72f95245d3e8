//! Tests that a scene which is moved to a time equals a scene that was loaded in that state.

use crate::{playroom, support};
use glam::{DAffine3, DVec3};
use headwater::device_scene::GpuScene;
use headwater::render::presets::Preset;
use headwater::render::ray_list::RayTracer;
use headwater::render::settings::Candidates;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::Scene;
use headwater::scene::motion::{Node, Transform};
use headwater::shader_interface::{NONE, PixelSums, PrimarySurface, RayQuery, Tracer, Variant};
use std::sync::Arc;
use support::random::Random;

const TIMES: [f64; 4] = [0.0, 0.7, 3.3, 100.0];
const RAYS: usize = 20_000;

fn all() -> Scene {
    playroom(&["camera", "object", "light", "toggle"], 1.0)
}

/// One shader variant per tracer that the device supports.
fn each_tracer() -> Vec<Variant> {
    let tracers = [Tracer::ComputeBvh, Tracer::RayQuery];
    tracers
        .iter()
        .filter_map(|tracer| support::variants(*tracer).first().copied())
        .collect()
}

fn view(scene: &Scene, time: f64) -> View {
    View {
        camera: scene.camera_at(0, time).unwrap(),
        width: 96,
        height: 72,
        seed: 3,
        bounces: 3,
        jitter: false,
    }
}

/// Rays in all parts of the room.
fn rays(scene: &Scene) -> Vec<RayQuery> {
    let origin = scene.cameras[0].camera_to_world.translation;
    let bounds = scene.bounds().unwrap();
    let mut random = Random(11);
    (0..RAYS)
        .map(|_| {
            let unit = glam::DVec3::new(random.unit(), random.unit(), random.unit());
            RayQuery {
                origin: (bounds.min + unit * bounds.size() - origin).as_vec3(),
                t_max: 1e30,
                direction: random.direction().as_vec3(),
                any: 0,
            }
        })
        .collect()
}

/// In a scene that was posed at a time, both tracers must hit the same as in a scene that was uploaded in that pose,
/// whatever the pose was before.
#[test]
fn rays_meet_what_stands_there() {
    let scene = all();
    let origin = scene.cameras[0].camera_to_world.translation;
    for variant in each_tracer() {
        let (device, _) = support::open_device(Some(variant));
        let moving = Arc::new(GpuScene::new(&device, &scene, origin, variant).unwrap());
        let mut before = 0.0;
        for time in TIMES {
            moving.set_pose(time, before).unwrap();
            before = time;
            let still = scene.pose_at(time).unwrap();
            let fresh = Arc::new(GpuScene::new(&device, &still, origin, variant).unwrap());
            let [one, other] = [&moving, &fresh].map(|uploaded| {
                let tracer = RayTracer::new(&device, uploaded.clone(), &rays(&scene)).unwrap();
                tracer.run().unwrap();
                tracer.answers().unwrap()
            });
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-5 * (1.0 + b.abs());
            let pairs = one.iter().zip(&other);
            let differ = pairs.filter(|(a, b)| !near(a.t, b.t)).count();
            println!(
                "{} at {time} s: {differ} of {RAYS} differ",
                variant.tracer.name()
            );
            // What grazes an edge may fall on either side of it.
            assert!(
                differ <= RAYS / 2000,
                "{differ} of {RAYS} rays differ at {time} s"
            );
        }
        support::assert_no_messages(&device);
    }
}

/// The primary surfaces and the sums of the last frame of a scene that went through `times` (in seconds), one frame per
/// time.
fn pictures(
    variant: Variant,
    scene: &Scene,
    times: &[f64],
) -> (Vec<PrimarySurface>, Vec<PixelSums>) {
    let (device, _) = support::open_device(Some(variant));
    let first = view(scene, times[0]);
    let origin = scene.cameras[0].camera_to_world.translation;
    let uploaded = Arc::new(GpuScene::new(&device, scene, origin, variant).unwrap());
    let mut renderer = Renderer::new(&device, uploaded, &first, &Settings::default()).unwrap();
    for (number, time) in (0..).zip(times) {
        renderer.set_time(*time);
        renderer.set_camera(&scene.camera_at(0, *time).unwrap());
        renderer.single_frame(number).unwrap();
    }
    let pictures = (
        renderer.primary_surfaces().unwrap(),
        renderer.sums().unwrap().pixels,
    );
    support::assert_no_messages(&device);
    pictures
}

#[test]
fn the_way_to_a_time_leaves_no_trace() {
    let scene = all();
    for variant in each_tracer() {
        let (direct, lit) = pictures(variant, &scene, &[9.0, 9.0, 3.3]);
        let (by_steps, also_lit) = pictures(variant, &scene, &[0.5, 0.7, 3.3]);
        let bits = |sums: &[PixelSums]| bytemuck::cast_slice::<_, u8>(sums).to_vec();
        assert_eq!(bits(&lit), bits(&also_lit), "{}", variant.tracer.name());
        for (a, b) in direct.iter().zip(&by_steps) {
            assert_eq!(
                (a.depth, a.normal, a.instance),
                (b.depth, b.normal, b.instance)
            );
        }
    }
}

#[test]
fn surfaces_look_as_in_the_scene_that_stands_so() {
    let scene = all();
    for time in TIMES {
        let seen: Vec<Vec<PrimarySurface>> = each_tracer()
            .into_iter()
            .flat_map(|variant| {
                // The still one keeps the origin.
                let still = scene.pose_at(time).unwrap();
                [
                    pictures(variant, &scene, &[0.2, time]).0,
                    pictures(variant, &still, &[time]).0,
                ]
            })
            .collect();
        for other in &seen[1..] {
            let pairs = seen[0].iter().zip(other);
            let same = pairs.filter(|(a, b)| {
                a.instance == b.instance
                    && (a.depth - b.depth).abs() <= 1e-4 * a.depth
                    && a.normal.distance(b.normal) < 1e-3
                    && a.albedo.distance(b.albedo) < 1e-3
            });
            let (same, all) = (same.count(), other.len());
            assert!(
                all - same <= all / 300,
                "at {time} s {same} of {all} are the same"
            );
        }
        let things: std::collections::BTreeSet<u32> = seen[0].iter().map(|s| s.instance).collect();
        assert!(things.len() > 8 && !things.contains(&NONE), "{things:?}");
    }
}

/// The bits of a picture of direct light at a time, in which most light samples come from the light BVH.
fn lit_by_near_lights(scene: &Scene, time: f64) -> Vec<[u32; 3]> {
    let (device, selection) = support::open_device(None);
    let mut settings = Preset::named("accurate").unwrap().settings().unwrap();
    settings.direct.resampling.candidates = Candidates::LightBvh;
    // How many BSDF rays there are depends on the lights at time 0.
    (
        settings.direct.bsdf_samples,
        settings.direct.more_bsdf_samples,
    ) = (0, 0);
    let mut view = view(scene, 0.0);
    view.bounces = 1;
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
    renderer.set_time(time);
    renderer.single_frame(0).unwrap();
    let radiance = renderer.frame_radiance().unwrap();
    support::assert_no_messages(&device);
    radiance.iter().map(|p| p.map(f32::to_bits)).collect()
}

/// The light BVH must be fitted to the lights of the frame. A stale one would not bias the mean, since samples and densities
/// come from the same BVH, but it would give other samples, so the test compares bits.
#[test]
fn the_light_bvh_follows_its_lights() {
    let scene = playroom(&["toggle"], 1.0);
    // The fire flickers. The sign is on: in a scene that is loaded while it is off it would be no light.
    for time in [0.1, 0.6] {
        let moved = lit_by_near_lights(&scene, time);
        let fresh = lit_by_near_lights(&scene.pose_at(time).unwrap(), 0.0);
        assert!(moved == fresh, "at {time} s");
    }
}

mod thorough {
    use super::*;

    /// Transforms between frames, and the tolerances that they are compared with, must scale with the scene.
    #[test]
    fn a_tiny_scene_in_motion_looks_like_a_large_one() {
        let scene = all();
        let mut tiny = scene.clone();
        let scale = DAffine3::from_scale(DVec3::splat(2_f64.powi(-40)));
        for instance in &mut tiny.instances {
            instance.object_to_world = scale * instance.object_to_world;
        }
        tiny.cameras[0].camera_to_world.translation *= 2_f64.powi(-40);
        // Everything hangs from a node that scales it.
        let motion = tiny.motion.as_mut().unwrap();
        for node in &mut motion.nodes {
            node.parent = Some(node.parent.map_or(0, |parent| parent + 1));
        }
        motion.nodes.insert(
            0,
            Node {
                parent: None,
                transform: Transform::Fixed(scale),
            },
        );
        let attached = motion.instances.iter_mut().chain(&mut motion.cameras);
        attached.flatten().for_each(|node| *node += 1);
        let settings = Preset::named("accurate").unwrap().settings().unwrap();
        let variant = each_tracer()[0];
        let [large, small] = [scene, tiny].map(|scene| {
            let (device, _) = support::open_device(Some(variant));
            let origin = scene.cameras[0].camera_to_world.translation;
            let uploaded = Arc::new(GpuScene::new(&device, &scene, origin, variant).unwrap());
            let first = view(&scene, 0.0);
            let mut renderer = Renderer::new(&device, uploaded, &first, &settings).unwrap();
            for number in 0..4 {
                let time = f64::from(number) / 24.0;
                renderer.set_time(time);
                renderer.set_camera(&scene.camera_at(0, time).unwrap());
                renderer.single_frame(number).unwrap();
            }
            renderer.frame_radiance().unwrap()
        });
        let differ = large.iter().zip(&small).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "of {} pixels", large.len());
    }
}

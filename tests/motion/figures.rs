//! Tests of meshes that deform: bending and morphing figures must be lit without bias, their motion vectors and reservoirs must
//! follow the skin, and both tracers must see each moment as if it were loaded alone.

use crate::bias::{assert_seen, check_at, temporal};
use crate::support;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use headwater::device_scene::GpuScene;
use headwater::render::presets::Preset;
use headwater::render::{Lighting, Renderer, Settings, View};
use headwater::scene::motion::deformation::{
    Deformation, Influence, Joint, MorphTarget, Skin, Vertices,
};
use headwater::scene::motion::tracks::{Animated, Interpolation, Track};
use headwater::scene::motion::{AnimatedTransform, Node, Transform};
use headwater::scene::{Instance, Material, Mesh, Motion, Part, Scene};
use headwater::shader_interface::{Format, Tracer};
use std::sync::Arc;

/// The radius and the height of the tube.
const RADIUS: f32 = 0.22;
const HEIGHT: f32 = 1.3;
const SIDES: u32 = 12;
const RINGS: u32 = 10;

fn line<T>(times: [f64; 2], values: [T; 2]) -> Option<Track<T>> {
    Some(Track {
        interpolation: Interpolation::Linear,
        times: times.to_vec(),
        values: values.into(),
    })
}

/// The side of a tube along +Y, from the floor to its height, with smooth normals.
fn tube(material: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for side in 0..SIDES {
            let angle = std::f32::consts::TAU * side as f32 / SIDES as f32;
            let normal = Vec3::new(angle.cos(), 0.0, angle.sin());
            let height = HEIGHT * ring as f32 / RINGS as f32;
            mesh.positions.push(RADIUS * normal + height * Vec3::Y);
            mesh.normals.push(normal);
        }
    }
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let at = |ring: u32, side: u32| ring * SIDES + side % SIDES;
            let [a, b] = [side, side + 1].map(|side| at(ring, side));
            let [c, d] = [side, side + 1].map(|side| at(ring + 1, side));
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    mesh.parts = vec![Part {
        first_triangle: 0,
        triangle_count: mesh.triangles.len() as u32,
        material,
    }];
    mesh
}

fn rest(mesh: &Mesh) -> Vertices {
    Vertices {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        tangents: Vec::new(),
    }
}

/// The Cornell box with a tube that bends and grows by its two joints, and a shining one that morphs. They move for one second
/// at a `speed` of 1.
fn figures(speed: f64) -> Scene {
    let mut scene = headwater::procedural::generate("cornell", &[]).unwrap();
    scene.instances.truncate(scene.instances.len() - 2);
    let skin_material = scene.materials.len() as u32;
    scene
        .materials
        .push(Material::lambert("skin", Vec3::new(0.7, 0.5, 0.3)));
    scene.materials.push(Material {
        emission: Vec3::new(2.0, 1.5, 0.6),
        double_sided: true,
        ..Material::lambert("glow", Vec3::splat(0.2))
    });
    let mut bends = tube(skin_material);
    bends.name = "bends".into();
    let mut morphs = tube(skin_material + 1);
    morphs.name = "morphs".into();
    let times = [0.0, 1.0 / speed];
    let mut bend = AnimatedTransform::still(
        DVec3::Y * f64::from(HEIGHT) / 2.0,
        DQuat::IDENTITY,
        DVec3::ONE,
    );
    bend.rotation.track = line(times, [DQuat::IDENTITY, DQuat::from_rotation_z(1.2)]);
    bend.scale.track = line(times, [DVec3::ONE, DVec3::new(1.5, 1.1, 0.7)]);
    let at = DAffine3::from_translation(DVec3::new(0.35, 0.0, 0.2));
    let influences = bends.positions.iter().map(|p| {
        let upper = ((p.y / HEIGHT - 0.3) / 0.4).clamp(0.0, 1.0);
        [(0, 1.0 - upper), (1, upper)].map(|(joint, weight)| Influence { joint, weight })
    });
    let skin = Skin {
        joints: vec![
            Joint {
                node: 0,
                inverse_bind: DAffine3::IDENTITY,
            },
            Joint {
                node: 1,
                inverse_bind: DAffine3::from_translation(DVec3::NEG_Y * f64::from(HEIGHT) / 2.0),
            },
        ],
        first_influence: (0..=bends.positions.len() as u32).map(|i| 2 * i).collect(),
        influences: influences.flatten().collect(),
        world_to_object: at.inverse(),
    };
    let offsets = morphs.positions.iter().map(|p| {
        let bulge = (p.y / HEIGHT * std::f32::consts::PI).sin();
        Vec3::new(p.x, 0.0, p.z) * (1.2 * bulge) + Vec3::X * (0.3 * bulge) - Vec3::Y * (0.4 * p.y)
    });
    let target = MorphTarget {
        weight: Animated {
            rest: 0.0,
            track: line(times, [0.0, 1.0]),
        },
        positions: offsets.collect(),
        normals: vec![Vec3::Y * 0.3; morphs.normals.len()],
        tangents: Vec::new(),
    };
    let first = scene.meshes.len() as u32;
    let deformations = vec![
        Deformation {
            mesh: first,
            rest: rest(&bends),
            targets: Vec::new(),
            skin: Some(skin),
        },
        Deformation {
            mesh: first + 1,
            rest: rest(&morphs),
            targets: vec![target],
            skin: None,
        },
    ];
    scene.meshes.extend([bends, morphs]);
    let small = DAffine3::from_scale(DVec3::splat(0.4));
    let morphs_at = DAffine3::from_translation(DVec3::new(-0.45, 0.3, 0.3)) * small;
    for (name, mesh, object_to_world) in [("bends", first, at), ("morphs", first + 1, morphs_at)] {
        scene.instances.push(Instance {
            name: name.into(),
            mesh,
            object_to_world,
        });
    }
    scene.motion = Some(Motion {
        nodes: vec![
            Node {
                parent: None,
                transform: Transform::Fixed(at),
            },
            Node {
                parent: Some(0),
                transform: Transform::Moving(Box::new(bend)),
            },
        ],
        instances: vec![None; scene.instances.len()],
        cameras: vec![None; scene.cameras.len()],
        lights: Vec::new(),
        emission: Vec::new(),
        deformations,
    });
    scene.validate().unwrap();
    assert!(scene.notices.is_empty(), "{:?}", scene.notices);
    scene
}

/// The Cornell box whose floor grows between the first two of four frames a second, by a morph target.
fn floor_that_grows() -> Scene {
    let mut scene = headwater::procedural::generate("cornell", &[]).unwrap();
    let index = scene.instances[0].mesh;
    let mesh = &scene.meshes[index as usize];
    let offsets = (mesh.positions.iter()).map(|p| Vec3::new(0.6 * p.x, 0.0, 0.6 * p.z));
    let target = MorphTarget {
        weight: Animated {
            rest: 0.0,
            track: Some(Track {
                interpolation: Interpolation::Step,
                times: vec![0.0, 0.25],
                values: vec![0.0, 1.0],
            }),
        },
        positions: offsets.collect(),
        normals: Vec::new(),
        tangents: Vec::new(),
    };
    let deformation = Deformation {
        mesh: index,
        rest: rest(mesh),
        targets: vec![target],
        skin: None,
    };
    scene.motion = Some(Motion {
        instances: vec![None; scene.instances.len()],
        cameras: vec![None; scene.cameras.len()],
        deformations: vec![deformation],
        ..Motion::default()
    });
    scene.validate().unwrap();
    scene
}

fn view(scene: &Scene) -> View {
    View {
        camera: scene.cameras[0].clone(),
        width: 64,
        height: 48,
        seed: 0,
        bounces: 2,
        jitter: false,
    }
}

/// A renderer of the figures after two frames, at 1/24 s and 2/24 s.
fn renderer(scene: &Scene, tracer: Tracer, settings: &Settings) -> Option<Renderer> {
    renderer_at(2, scene, tracer, settings)
}

/// A renderer of the figures after the frames from 1/24 s to `last` / 24 s.
fn renderer_at(last: u32, scene: &Scene, tracer: Tracer, settings: &Settings) -> Option<Renderer> {
    let variant = *support::variants(tracer).first()?;
    let (device, selection) = support::open_device(Some(variant));
    let view = view(scene);
    let origin = view.camera.camera_to_world.translation;
    let uploaded = GpuScene::new(&device, scene, origin, selection.variant).unwrap();
    let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, settings).unwrap();
    for frame in 0..=last {
        renderer.set_time(f64::from(frame) / 24.0);
        renderer.single_frame(frame).unwrap();
    }
    assert_eq!(renderer.rejected().unwrap(), 0);
    support::assert_no_messages(&device);
    Some(renderer)
}

/// The distances and the normals that the camera sees are those of the moment as a scene of its own.
#[test]
fn each_moment_is_seen_as_if_it_were_loaded_alone() {
    check_seen_as_if_loaded_alone(2, &figures(4.0));
}

/// Shapes that do not change are not written again: neither while the figures are at rest, between 1/24 s and 5/24 s, nor
/// after it.
#[test]
fn figures_that_come_to_rest_are_seen_as_if_they_were_loaded_alone() {
    let mut scene = figures(24.0);
    let motion = scene.motion.as_mut().unwrap();
    let Transform::Moving(bend) = &mut motion.nodes[1].transform else {
        panic!("the second joint does not move");
    };
    let back = bend.rotation.track.as_mut().unwrap();
    back.times.extend([5.0 / 24.0, 7.0 / 24.0]);
    back.values.extend([back.values[1], back.values[0]]);
    for last in [4, 6] {
        check_seen_as_if_loaded_alone(last, &scene);
    }
}

fn check_seen_as_if_loaded_alone(last: u32, scene: &Scene) {
    let settings = Settings::default();
    for tracer in [Tracer::ComputeBvh, Tracer::RayQuery] {
        let Some(mut moving) = renderer_at(last, scene, tracer, &settings) else {
            continue;
        };
        let still = scene.pose_at(f64::from(last) / 24.0).unwrap();
        let mut still = renderer(&still, tracer, &settings).unwrap();
        let (seen, expected) = (
            moving.primary_surfaces().unwrap(),
            still.primary_surfaces().unwrap(),
        );
        let figures = [
            scene.instances.len() as u32 - 2,
            scene.instances.len() as u32 - 1,
        ];
        let shown = seen
            .iter()
            .filter(|s| figures.contains(&s.instance))
            .count();
        assert!(shown > 150, "{shown} pixels show the figures");
        let differ = seen.iter().zip(&expected).filter(|(a, b)| {
            a.instance != b.instance
                || (a.depth - b.depth).abs() > 1e-4 * b.depth
                || (a.normal - b.normal).length() > 0.01
        });
        let differ = differ.count();
        assert!(differ <= 2, "{tracer:?}: {differ} pixels differ");
    }
}

/// The figures, whose joints have the scale 0 at first, so that both the tube and its box are a point at time 0.
fn figure_that_pops_in() -> Scene {
    let mut scene = figures(4.0);
    let motion = scene.motion.as_mut().unwrap();
    let Transform::Fixed(at) = motion.nodes[0].transform else {
        panic!("the first joint moves");
    };
    let mut root = AnimatedTransform::still(at.translation, DQuat::IDENTITY, DVec3::ONE);
    root.scale.track = line([0.0, 1.0 / 24.0], [DVec3::ZERO, DVec3::ONE]);
    motion.nodes[0].transform = Transform::Moving(Box::new(root));
    let first = motion.deformations[0].mesh as usize;
    scene.meshes[first] = Mesh {
        positions: vec![Vec3::ZERO; scene.meshes[first].positions.len()],
        ..scene.meshes[first].clone()
    };
    scene.validate().unwrap();
    scene
}

/// A figure that grows from a point is shown in its size, not in that of the point.
#[test]
fn a_figure_that_grows_from_nothing_is_shown() {
    check_seen_as_if_loaded_alone(2, &figure_that_pops_in());
}

/// Motion vectors of the bending tube are those of its vertices.
#[test]
fn motion_vectors_follow_the_skin() {
    let scene = figures(4.0);
    let mut renderer = renderer(&scene, Tracer::ComputeBvh, &Settings::default()).unwrap();
    let surfaces = renderer.primary_surfaces().unwrap();
    let bends = scene.instances.len() as u32 - 2;
    let [now, before] = [2.0, 1.0].map(|frame| scene.pose_at(frame / 24.0).unwrap());
    let camera = &scene.cameras[0];
    let half = camera.projection.half_height();
    let pixel = |point: DVec3| {
        let seen = camera.camera_to_world.inverse().transform_point3(point);
        let plane = [seen.x / (half * 64.0 / 48.0), -seen.y / half].map(|x| x / -seen.z);
        [(plane[0] * 0.5 + 0.5) * 64.0, (plane[1] * 0.5 + 0.5) * 48.0]
    };
    let instance = &now.instances[bends as usize];
    let (mesh, old) = (
        &now.meshes[instance.mesh as usize],
        &before.meshes[instance.mesh as usize],
    );
    let (mut worst, mut longest, mut count) = (0.0_f64, 0.0_f64, 0);
    for (i, surface) in surfaces.iter().enumerate() {
        if surface.instance != bends {
            continue;
        }
        let (x, y) = ((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
        let direction = DVec3::new(
            (x / 64.0 * 2.0 - 1.0) * half * 64.0 / 48.0,
            -(y / 48.0 * 2.0 - 1.0) * half,
            -1.0,
        );
        let to_world = camera.camera_to_world;
        let point = to_world.translation
            + to_world.transform_vector3(direction).normalize() * f64::from(surface.depth);
        // The triangle whose plane and sides hold the point best.
        let place = |p: Vec3| instance.object_to_world.transform_point3(p.as_dvec3());
        let candidates = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| place(mesh.positions[i as usize]));
            let (e, f, p) = (b - a, c - a, point - a);
            let normal = e.cross(f);
            let area = normal.length_squared();
            let (v, w) = (p.cross(f).dot(normal) / area, e.cross(p).dot(normal) / area);
            let off = p.dot(normal).abs() / area.sqrt();
            let outside = (-v).max(-w).max(v + w - 1.0).max(0.0);
            (off + outside, t, v, w)
        });
        let (_, t, v, w) = candidates.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let [a, b, c] = t.map(|i| place(old.positions[i as usize]));
        let (there, here) = (pixel(a + v * (b - a) + w * (c - a)), [x, y]);
        let expected = [there[0] - here[0], there[1] - here[1]];
        let motion = [surface.motion.x, surface.motion.y].map(f64::from);
        worst = worst.max((motion[0] - expected[0]).hypot(motion[1] - expected[1]));
        longest = longest.max(expected[0].hypot(expected[1]));
        count += 1;
    }
    println!("{count} pixels, worst {worst:.5}, longest {longest:.3} pixels");
    assert!(count > 100 && longest > 0.5);
    assert!(worst < 0.01, "{worst}");
}

/// Nearly every pixel of a moving skin finds its history. With reuse over time alone, a pixel without history has a confidence
/// of 1.
#[test]
fn reservoirs_live_on_moving_skin() {
    let scene = figures(1.0);
    let settings = Preset::named("fast").unwrap().settings().unwrap();
    let mut renderer = renderer(&scene, Tracer::ComputeBvh, &settings).unwrap();
    let surfaces = renderer.primary_surfaces().unwrap();
    let reservoirs = renderer.reservoir_aovs(Lighting::Direct).unwrap();
    let bends = scene.instances.len() as u32 - 2;
    let on_skin = surfaces
        .iter()
        .zip(&reservoirs)
        .filter(|(s, _)| s.instance == bends);
    let confidence: Vec<f32> = on_skin.map(|(_, r)| r.confidence).collect();
    let alive = confidence.iter().filter(|c| **c > 1.0).count();
    println!("{alive} of {} pixels have a history", confidence.len());
    assert!(confidence.len() > 100);
    assert!(10 * alive >= 9 * confidence.len());
}

#[test]
fn normals_that_do_not_turn_with_the_skin_are_seen() {
    let fault = (
        "scene/previous_frame.glsl",
        "return before * (normal * now);",
        "return vec3(0.0);",
    );
    let test = "figures::reservoirs_live_on_moving_skin";
    let output = support::run_with_fault(test, fault, |command| command.arg("--nocapture"));
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(!output.status.success() && said.contains("pixels have a history"));
}

/// The Cornell box with the figures, fast enough that each frame is another shape.
fn check(bounces: u32, seeds: u32, name: &str, tracer: Option<Tracer>, change: fn(&mut Settings)) {
    check_at(bounces, seeds, name, figures(1.5), tracer, change);
}

fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

mod thorough {
    use super::*;

    #[test]
    fn the_preset_balanced() {
        check(2, 96, "balanced", None, |s| *s = preset("balanced"));
    }

    #[test]
    fn indirect_light_from_a_floor_that_grows() {
        check_at(2, 96, "morphing floor", floor_that_grows(), None, temporal);
    }

    #[test]
    fn previous_positions_that_are_those_of_this_frame_are_seen() {
        assert_seen(
            "figures::thorough::indirect_light_from_a_floor_that_grows",
            "scene/geometry.glsl",
            "load_instances(index + epoch * scene.at.instance_count)",
            "load_instances(index)",
        );
    }
}

/// Further techniques and faults, which take minutes.
mod largest {
    use super::*;

    #[test]
    fn direct_light() {
        check(1, 144, "direct", None, temporal);
    }

    #[test]
    fn direct_light_with_ray_query() {
        check(
            1,
            144,
            "direct, ray query",
            Some(Tracer::RayQuery),
            temporal,
        );
    }

    #[test]
    fn indirect_light() {
        check(2, 144, "indirect", None, temporal);
    }

    #[test]
    fn indirect_light_with_full_reservoirs() {
        check(2, 144, "indirect, full", None, |settings| {
            temporal(settings);
            settings.reservoirs.format = Format::Full;
        });
    }

    #[test]
    fn the_preset_fast() {
        check(2, 96, "fast", None, |s| *s = preset("fast"));
    }

    #[test]
    fn the_preset_accurate() {
        check(2, 96, "accurate", None, |s| *s = preset("accurate"));
    }

    #[test]
    fn an_area_that_is_left_out_is_seen() {
        assert_seen(
            "figures::thorough::indirect_light_from_a_floor_that_grows",
            "restir/samples/path_sample.glsl",
            "return ratio(measure.x, old_measure.x) * ",
            "return ",
        );
    }
}

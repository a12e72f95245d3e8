//! Tests of both tracers against an oracle in f64, with random rays, grazing rays and rays that aim at edges.

mod hostile;
#[path = "../support/mod.rs"]
mod support;

use glam::{DAffine3, DMat3, DVec3, Quat, Vec3};
use headwater::device_scene::GpuScene;
use headwater::device_scene::geometry::Geometry;
use headwater::device_scene::merge_static::merge_static;
use headwater::gpu::DriverKind;
use headwater::render::ray_list::RayTracer;
use headwater::render::{Renderer, Settings, View};
use headwater::scene::{AlphaMode, Instance, Material, Scene};
use headwater::shader_interface::{NONE, RayHit, RayQuery, Tracer, Variant};
use std::sync::Arc;
use support::brute_force;
use support::random::Random;

const RAYS: usize = 100_000;
/// The distance from an edge, relative to the coordinates there, up to which a different result is excused.
const NEAR_EDGE: f64 = 1e-5;

/// The corners of a triangle in world space.
fn corners(scene: &Scene, instance: u32, triangle: u32) -> [DVec3; 3] {
    let placed = &scene.instances[instance as usize];
    let mesh = &scene.meshes[placed.mesh as usize];
    mesh.triangles[triangle as usize].map(|i| {
        placed
            .object_to_world
            .transform_point3(mesh.positions[i as usize].as_dvec3())
    })
}

/// The fraction of light, in [0, 1], that a triangle covers. Without textures it is equal over the whole triangle.
fn coverage(scene: &Scene, instance: u32, triangle: u32) -> f64 {
    let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
    let part = mesh.parts.iter().find(|p| p.range().contains(&triangle));
    let material = &scene.materials[part.unwrap().material as usize];
    match material.alpha_mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask { cutoff } => f64::from(material.alpha >= cutoff),
        AlphaMode::Blend => material.alpha.into(),
    }
}

/// The exact result of a ray: the hit and the light that passes.
#[derive(Debug)]
struct Truth {
    /// The first hit of a surface that covers everything; `None` if there is none.
    hit: Option<brute_force::Hit>,
    /// The fraction of light, in [0, 1], that passes between the ends of the ray.
    transmittance: f64,
}

fn truth(scene: &Scene, oracle: &brute_force::Tracer, ray: &RayQuery) -> Truth {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let t_max = f64::from(ray.t_max);
    let mut truth = Truth {
        hit: None,
        transmittance: 1.0,
    };
    let mut start = 0.0;
    while let Some(hit) = oracle.closest(origin + direction * start, direction, t_max - start) {
        let t = start + hit.t;
        let coverage = coverage(scene, hit.instance, hit.triangle);
        truth.transmittance *= 1.0 - coverage;
        if coverage == 1.0 {
            truth.hit = Some(brute_force::Hit { t, ..hit });
            break;
        }
        // Past the surface that was met.
        let at = (origin + direction * t)
            .length()
            .max(direction.length() * t);
        start = t + 1e-11 * at / direction.length();
    }
    truth
}

fn bounds(scene: &Scene) -> (DVec3, DVec3) {
    let mut bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (number, placed) in scene.instances.iter().enumerate() {
        for triangle in 0..scene.meshes[placed.mesh as usize].triangles.len() {
            for p in corners(scene, number as u32, triangle as u32) {
                bounds = (bounds.0.min(p), bounds.1.max(p));
            }
        }
    }
    bounds
}

/// All triangles of the scene as pairs of instance and triangle index.
fn all_triangles(scene: &Scene) -> Vec<(u32, u32)> {
    let mut triangles = Vec::new();
    for (number, placed) in scene.instances.iter().enumerate() {
        let count = scene.meshes[placed.mesh as usize].triangles.len();
        triangles.extend((0..count as u32).map(|t| (number as u32, t)));
    }
    triangles
}

/// Random rays of three kinds, a third each: between random points, nearly along the plane of a triangle, and close to an
/// edge of a triangle (a millionth to a thousandth of the coordinates' magnitude beside it). Every seventh ray has `any`
/// set.
fn rays(scene: &Scene, seed: u64) -> Vec<RayQuery> {
    let mut random = Random(seed);
    let (low, high) = bounds(scene);
    let size = (high - low).max_element();
    let triangles = all_triangles(scene);
    (0..RAYS)
        .map(|ray| {
            let mut anywhere = || {
                let p = DVec3::new(random.unit(), random.unit(), random.unit());
                low + (high - low) * p
            };
            let (mut origin, mut target) = (anywhere(), anywhere());
            let (instance, triangle) = triangles[random.index(triangles.len())];
            let [a, b, c] = corners(scene, instance, triangle);
            match ray % 3 {
                0 => {}
                1 => {
                    let normal = (b - a).cross(c - a).normalize();
                    let along = (b - a).normalize() * (random.unit() - 0.5)
                        + (c - a).normalize() * (random.unit() - 0.5);
                    let (u, v) = (random.unit() * 0.5, random.unit() * 0.5);
                    target = a + (b - a) * u + (c - a) * v;
                    // Shallower, the triangle is so thin a line that it is all edge.
                    let thinnest = 1e-4 * a.length().max(size * 0.3) / (b - a).length();
                    let rise = thinnest.min(0.1).powf(random.unit()) * 0.1_f64.powf(random.unit());
                    origin = target + (along.normalize() + normal * rise) * size * 0.3;
                }
                _ => {
                    let at = random.unit();
                    // Closer than f32 resolves the coordinates, the answer is a matter of rounding.
                    let beside = 10_f64.powf(-3.0 - 3.0 * random.unit());
                    let scale = a.length().max((a - origin).length());
                    let offset = random.direction() * scale * beside;
                    target = a + (b - a) * at + offset;
                }
            }
            let any = ray % 7 == 0;
            let direction = target - origin;
            RayQuery {
                origin: origin.as_vec3(),
                t_max: if any { 0.9 } else { 1e30 },
                direction: (if any {
                    direction
                } else {
                    direction.normalize()
                })
                .as_vec3(),
                any: any.into(),
            }
        })
        .collect()
}

/// The distance of a line from the nearest edge of a triangle, in world units.
fn distance_to_edges(origin: DVec3, direction: DVec3, corners: [DVec3; 3]) -> f64 {
    nearest_edge(origin, direction, corners, |_| 1.0)
}

/// The distance of a line from the nearest edge of a triangle, relative to the coordinates there.
fn edge_distance(origin: DVec3, direction: DVec3, corners: [DVec3; 3]) -> f64 {
    nearest_edge(origin, direction, corners, |at| {
        at.length().max((at - origin).length())
    })
}

/// The smallest distance of a line from an edge of a triangle, divided by `unit` at the point of the edge.
fn nearest_edge(
    origin: DVec3,
    direction: DVec3,
    corners: [DVec3; 3],
    unit: impl Fn(DVec3) -> f64,
) -> f64 {
    let d = direction.normalize();
    (0..3)
        .map(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            // Closest points of the line and the segment, in the plane across the line.
            let across = |v: DVec3| v - d * v.dot(d);
            let (from, edge) = (across(p - origin), across(q - p));
            let s = (-from.dot(edge) / edge.length_squared().max(1e-300)).clamp(0.0, 1.0);
            (from + edge * s).length() / unit(p + (q - p) * s)
        })
        .fold(f64::INFINITY, f64::min)
}

struct Outcome {
    hits: usize,
    /// Number of rays whose result differs near an edge, where rounding excuses it.
    excused: usize,
    /// Descriptions of the rays that differ without an excuse; empty if there are none.
    wrong: Vec<String>,
}

/// Compares a tracer's answers with the oracle. `triangle_of` maps an instance and a primitive to the index of the triangle
/// in its mesh.
fn compare(
    scene: &Scene,
    oracle: &brute_force::Tracer,
    rays: &[RayQuery],
    answers: &[RayHit],
    triangle_of: impl Fn(u32, u32) -> u32,
) -> Outcome {
    let mut outcome = Outcome {
        hits: 0,
        excused: 0,
        wrong: Vec::new(),
    };
    for (ray, answer) in rays.iter().zip(answers) {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let truth = truth(scene, oracle, ray);
        let found = (answer.t >= 0.0).then(|| {
            assert_ne!(answer.instance, NONE);
            (
                answer.instance,
                triangle_of(answer.instance, answer.primitive),
            )
        });
        outcome.hits += usize::from(found.is_some());
        let mut involved = Vec::new();
        let passes_alike =
            (f64::from(answer.transmittance) - truth.transmittance).abs() < 1e-5 || ray.any == 0;
        let agrees = match (&truth.hit, found) {
            (None, None) if passes_alike => true,
            (None, None) => {
                // The triangle that one of both has missed is any.
                involved = all_triangles(scene);
                false
            }
            (Some(_), Some(_)) if ray.any == 1 => passes_alike,
            (Some(t), Some((instance, triangle))) => {
                // The hit as a point of the triangle found, seen from the ray.
                let [a, b, c] = corners(scene, instance, triangle);
                let (u, v) = (f64::from(answer.u), f64::from(answer.v));
                let point = a + (b - a) * u + (c - a) * v;
                let scale = point.length().max((point - origin).length());
                // Across the ray and along it.
                let end = origin + direction * f64::from(answer.t);
                let beside = (end - point).length() / scale;
                involved = vec![(t.instance, t.triangle), (instance, triangle)];
                let gap = (origin + direction * t.t - point).length() / scale;
                beside < 1e-5 && ((t.instance, t.triangle) == (instance, triangle) || gap < 1e-5)
            }
            (Some(t), None) => {
                involved = vec![(t.instance, t.triangle)];
                false
            }
            (None, Some(found)) => {
                involved = vec![found];
                false
            }
        };
        if agrees {
            continue;
        }
        let nearest = involved
            .iter()
            .map(|&(i, t)| edge_distance(origin, direction, corners(scene, i, t)))
            .fold(f64::INFINITY, f64::min);
        if nearest <= NEAR_EDGE {
            outcome.excused += 1;
        } else {
            outcome.wrong.push(format!(
                "{ray:?} {answer:?} truth {truth:?} edge {nearest:e}"
            ));
        }
    }
    outcome
}

/// The answers of a shader variant for the rays, and the driver that traced them; `None` if the scene is too large for the
/// variant.
fn answers(
    scene: &Scene,
    origin: DVec3,
    rays: &[RayQuery],
    variant: Variant,
) -> Option<(Vec<RayHit>, DriverKind)> {
    let (device, _) = support::open_device(Some(variant));
    let uploaded = match GpuScene::new(&device, scene, origin, variant) {
        Err(e) if e.to_string().contains("as texels") => return None,
        uploaded => Arc::new(uploaded.unwrap()),
    };
    let tracer = RayTracer::new(&device, uploaded, rays).unwrap();
    tracer.run().unwrap();
    support::assert_no_messages(&device);
    Some((tracer.answers().unwrap(), device.info.driver_kind))
}

/// A function that maps an instance and a primitive to the index of the triangle in its mesh. The compute BVH stores
/// triangles in the order of its leaves.
fn leaf_order(scene: &Scene, origin: DVec3, tracer: Tracer) -> impl Fn(u32, u32) -> u32 {
    let leaves = Geometry::new(&merge_static(scene, origin), true);
    let meshes: Vec<u32> = scene
        .instances
        .iter()
        .map(|instance| instance.mesh)
        .collect();
    move |instance, primitive| {
        let first = leaves.meshes[meshes[instance as usize] as usize].first_triangle;
        match tracer {
            Tracer::ComputeBvh => leaves.order[(first + primitive) as usize],
            Tracer::RayQuery => primitive,
        }
    }
}

/// Compares both tracers with the oracle. `origin` is the world position that the device uses as its zero, as the renderer
/// does with the camera position.
fn check(name: &str, scene: &Scene, origin: DVec3) {
    let mut near = scene.clone();
    for instance in &mut near.instances {
        instance.object_to_world = DAffine3::from_translation(-origin) * instance.object_to_world;
    }
    let oracle = brute_force::Tracer::new(&near);
    let rays = rays(&near, 7);
    for tracer in [Tracer::ComputeBvh, Tracer::RayQuery] {
        let answers: Vec<Vec<RayHit>> = support::variants(tracer)
            .into_iter()
            .filter_map(|variant| answers(scene, origin, &rays, variant))
            .map(|(answers, _)| answers)
            .collect();
        if answers.is_empty() {
            assert_eq!(tracer, Tracer::RayQuery);
            continue;
        }
        let bits = |a: &[RayHit]| bytemuck::cast_slice::<_, u8>(a).to_vec();
        assert!(
            answers.iter().all(|a| bits(a) == bits(&answers[0])),
            "{name}: the accessors differ"
        );
        let triangle_of = leaf_order(scene, origin, tracer);
        let outcome = compare(&near, &oracle, &rays, &answers[0], triangle_of);
        let fraction = outcome.excused as f64 / RAYS as f64;
        println!(
            "{name} {}: {} hits, {} differ at an edge ({fraction:.1e}), {} elsewhere",
            tracer.name(),
            outcome.hits,
            outcome.excused,
            outcome.wrong.len()
        );
        for text in outcome.wrong.iter().take(5) {
            println!("  {text}");
        }
        assert!(
            outcome.wrong.is_empty(),
            "{name} {}: wrong hits",
            tracer.name()
        );
        assert!(
            outcome.hits > RAYS / 5,
            "{name}: too few hits to mean anything"
        );
        assert!(
            fraction <= 1e-4,
            "{name} {}: {fraction:e} of the rays differ",
            tracer.name()
        );
    }
}

/// The triangles of a closed sphere with bumps.
fn bumpy_sphere(rings: u32, radius: f32) -> Vec<[Vec3; 3]> {
    let at = |i: u32, j: u32| {
        let (theta, phi) = (
            std::f32::consts::PI * i as f32 / rings as f32,
            std::f32::consts::TAU * (j % (2 * rings)) as f32 / (2 * rings) as f32,
        );
        let (i, j) = (if i == 0 || i == rings { 0 } else { i }, j % (2 * rings));
        let bump = 1.0 + 0.1 * ((i * 7 + j * 13) % 5) as f32 / 5.0 * f32::from(i > 0);
        radius
            * bump
            * Vec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            )
    };
    let mut faces = Vec::new();
    for i in 0..rings {
        for j in 0..2 * rings {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            if i + 1 < rings {
                faces.push([a, b, c]);
            }
            if i > 0 {
                faces.push([a, c, d]);
            }
        }
    }
    faces
}

/// A scene with many instances of one mesh: rotated, mirrored, sheared and scaled.
fn placed(offset: DVec3, scale: f64) -> Scene {
    let mut scene = support::scene_of(&[
        (Material::default(), bumpy_sphere(12, 1.0)),
        (
            Material::default(),
            support::quad(
                Vec3::new(-20.0, -3.0, 20.0),
                Vec3::X * 40.0,
                -Vec3::Z * 40.0,
            ),
        ),
    ]);
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.2), DVec3::Z);
    for i in 0..40_u32 {
        let f = f64::from(i);
        let turn = DMat3::from_quat(Quat::from_rotation_y(i as f32 * 0.7).as_dquat());
        let mirror = if i % 3 == 0 { -1.0 } else { 1.0 };
        let size = DMat3::from_diagonal(DVec3::new(mirror, 0.5 + f * 0.02, 1.3));
        let matrix = if i % 4 == 0 {
            shear * turn * size
        } else {
            turn * size
        };
        let position = DVec3::new(
            (f * 2.4).sin() * (3.0 + f * 0.3),
            (f * 1.7).cos() * 2.0,
            (f * 2.4).cos() * (3.0 + f * 0.3),
        );
        scene.instances.push(Instance {
            name: String::new(),
            mesh: 0,
            object_to_world: DAffine3::from_mat3_translation(matrix, position),
        });
    }
    for instance in &mut scene.instances {
        instance.object_to_world = DAffine3::from_translation(offset)
            * DAffine3::from_scale(DVec3::splat(scale))
            * instance.object_to_world;
    }
    scene
}

#[test]
fn instances_turned_mirrored_and_sheared() {
    check("instances", &placed(DVec3::ZERO, 1.0), DVec3::ZERO);
}

/// One of four instances is opaque, one has only holes, and two cover a part of the light. Each surface must weaken a ray
/// once, whether meshes are shared or not.
#[test]
fn surfaces_that_cover_a_part() {
    let mut scene = placed(DVec3::ZERO, 1.0);
    let with = |alpha: f32, alpha_mode: AlphaMode| Material {
        alpha,
        alpha_mode,
        ..Material::default()
    };
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    let covers = [
        with(0.9, mask),
        with(0.3, mask),
        with(0.3, AlphaMode::Blend),
        with(0.75, AlphaMode::Blend),
    ];
    let (first_mesh, first_material) = (scene.meshes.len() as u32, scene.materials.len() as u32);
    for (number, material) in (0..).zip(covers) {
        let mut mesh = scene.meshes[0].clone();
        mesh.parts[0].material = first_material + number;
        scene.meshes.push(mesh);
        scene.materials.push(material);
    }
    for (number, instance) in (0..).zip(&mut scene.instances) {
        // All but the floor.
        if instance.mesh == 0 {
            instance.mesh = first_mesh + number % 4;
        }
    }
    check("alpha", &scene, DVec3::ZERO);
    let copied = unshared(&scene);
    check(
        "alpha, merged",
        &merge_static(&copied, DVec3::ZERO).scene,
        DVec3::ZERO,
    );
}

/// A ray through an edge of a closed mesh, or through a corner of a sheet, must be weakened by exactly one of the triangles
/// there. The mesh is convex, because at a fold or a protruding corner one triangle is as wrong as none or two.
#[test]
fn edges_and_corners_cover_a_part_once() {
    const CELLS: usize = 8;
    let corner = |i: usize| Vec3::new((i % (CELLS + 1)) as f32, (i / (CELLS + 1)) as f32, 3.0);
    let cell = |i: usize| {
        let first = i / CELLS * (CELLS + 1) + i % CELLS;
        let [a, b, c, d] = [0, 1, CELLS + 2, CELLS + 1].map(|step| corner(first + step));
        [[a, b, c], [a, c, d]]
    };
    let sheet: Vec<[Vec3; 3]> = (0..CELLS * CELLS).flat_map(cell).collect();
    // Of the corners at the southern pole each has another rounding error.
    let on_sphere = |p: Vec3| match p.normalize() {
        p if p.y < -0.9999 => Vec3::NEG_Y,
        p => p,
    };
    let sphere: Vec<[Vec3; 3]> = (bumpy_sphere(24, 1.0).into_iter())
        .map(|face| face.map(on_sphere))
        .collect();
    let mut random = Random(5);
    let mut rays_at = |faces: &[[Vec3; 3]], on_edges: bool| -> Vec<RayQuery> {
        let rays = (0..RAYS).map(|_| {
            let (face, origin, along) = if on_edges {
                let face = faces[random.index(faces.len())];
                let origin = (random.direction() * 0.5).as_vec3();
                (face, origin, random.unit() as f32)
            } else {
                // Along an axis, so that nothing is rounded, to a corner inside the sheet.
                let [x, y] = [(); 2].map(|()| 1 + random.index(CELLS - 1));
                let target = corner(y * (CELLS + 1) + x);
                ([target; 3], target.with_z(0.0), 0.0)
            };
            let target = face[0] + (face[1] - face[0]) * along;
            RayQuery {
                origin,
                t_max: 1e30,
                direction: target - origin,
                any: 1,
            }
        });
        rays.collect()
    };
    // As files may have them: every third triangle is turned over.
    let turned = |faces: &Vec<[Vec3; 3]>| {
        let turned = faces
            .iter()
            .enumerate()
            .map(|(index, [a, b, c])| match index % 3 {
                0 => [*a, *c, *b],
                _ => [*a, *b, *c],
            });
        turned.collect::<Vec<_>>()
    };
    for (name, faces, on_edges) in [
        ("edges of a sphere, some turned over", turned(&sphere), true),
        (
            "corners of a sheet, some turned over",
            turned(&sheet),
            false,
        ),
        ("edges of a sphere", sphere, true),
        ("corners of a sheet", sheet, false),
    ] {
        let rays = rays_at(&faces, on_edges);
        let half = Material {
            alpha: 0.5,
            alpha_mode: AlphaMode::Blend,
            ..Material::default()
        };
        let scene = support::scene_of(&[(half, faces)]);
        for tracer in [Tracer::ComputeBvh, Tracer::RayQuery] {
            let variants = support::variants(tracer).into_iter();
            let mut answers = variants.map(|variant| answers(&scene, DVec3::ZERO, &rays, variant));
            let Some(Some((answers, driver))) = answers.next() else {
                continue;
            };
            let once = |a: &&RayHit| a.t < 0.0 && a.transmittance == 0.5;
            let wrong = RAYS - answers.iter().filter(once).count();
            println!("{name}, {}: {wrong} of {RAYS} rays", tracer.name());
            // Lavapipe's own tracer misses some edges, as below, and all of these corners.
            let llvmpipe = matches!(driver, DriverKind::Llvmpipe { .. });
            let allowed = match tracer {
                Tracer::RayQuery if llvmpipe && on_edges => RAYS * 2 / 100,
                Tracer::RayQuery if llvmpipe => RAYS,
                _ => 0,
            };
            assert!(wrong <= allowed, "{name}, {}: {wrong} rays", tracer.name());
        }
    }
}

#[test]
fn a_scene_far_from_the_origin() {
    let far = DVec3::new(3e6, -2e6, 5e6);
    check("far", &placed(far, 1.0), far + DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn a_tiny_and_a_huge_scene() {
    check("tiny", &placed(DVec3::ZERO, 1e-4), DVec3::ZERO);
    check("huge", &placed(DVec3::ZERO, 1e5), DVec3::ZERO);
}

/// A scene with 1.6 MB of positions, of which SwiftShader reads only 1 MiB as texels.
#[test]
fn more_triangles_than_texels_may_reach() {
    let faces = bumpy_sphere(150, 1.0);
    assert!(faces.len() * 36 > 3 << 19);
    let scene = support::scene_of(&[(Material::default(), faces)]);
    check("many", &scene, DVec3::ZERO);
}

/// A ray from inside a closed mesh that aims exactly at an edge or a corner must hit one of the triangles there.
#[test]
fn closed_meshes_are_watertight_at_their_edges_and_corners() {
    for offset in [Vec3::ZERO, Vec3::new(0.3, -0.7, 0.9), Vec3::splat(50.0)] {
        let faces: Vec<[Vec3; 3]> = bumpy_sphere(24, 1.0)
            .into_iter()
            .map(|f| f.map(|p| p + offset))
            .collect();
        let mut random = Random(3);
        let rays: Vec<RayQuery> = (0..RAYS)
            .map(|ray| {
                let face = faces[random.index(faces.len())];
                let at = if ray % 2 == 0 {
                    0.0
                } else {
                    random.unit() as f32
                };
                let origin = offset + (random.direction() * 0.5).as_vec3();
                let target = face[0] + (face[1] - face[0]) * at;
                RayQuery {
                    origin,
                    t_max: 1e30,
                    direction: target - origin,
                    any: 0,
                }
            })
            .collect();
        let scene = support::scene_of(&[(Material::default(), faces)]);
        for tracer in [Tracer::ComputeBvh, Tracer::RayQuery] {
            let variants = support::variants(tracer).into_iter();
            let mut answers = variants.map(|variant| answers(&scene, DVec3::ZERO, &rays, variant));
            let Some(Some((answers, driver))) = answers.next() else {
                continue;
            };
            let misses = answers.iter().filter(|a| a.t < 0.0).count();
            println!(
                "{} at {offset}: {misses} of {RAYS} rays leave",
                tracer.name()
            );
            // Hardware is watertight. Lavapipe's own tracer is not: it loses 0.8 % of these rays.
            let llvmpipe = matches!(driver, DriverKind::Llvmpipe { .. });
            let allowed = match tracer {
                Tracer::RayQuery if llvmpipe => RAYS * 15 / 1000,
                _ => 0,
            };
            assert!(
                misses <= allowed,
                "{misses} of {RAYS} rays leave, at offset {offset}"
            );
        }
    }
}

/// The scene with a separate mesh for every instance, so that all instances are merged.
fn unshared(scene: &Scene) -> Scene {
    let mut copied = scene.clone();
    copied.meshes = scene
        .instances
        .iter()
        .map(|instance| scene.meshes[instance.mesh as usize].clone())
        .collect();
    for (number, instance) in copied.instances.iter_mut().enumerate() {
        instance.mesh = number as u32;
    }
    copied
}

#[test]
fn gathered_meshes() {
    let copied = unshared(&placed(DVec3::ZERO, 1.0));
    check(
        "merged",
        &merge_static(&copied, DVec3::ZERO).scene,
        DVec3::ZERO,
    );
}

/// Merging meshes must move no surface, flip none, and keep the index and the material of each instance.
#[test]
fn gathered_meshes_look_as_they_did() {
    let mut shared = placed(DVec3::new(1e4, 0.0, -2e4), 1.0);
    // An emitter among them, and smooth meshes beside flat ones.
    shared.materials[0].emission = Vec3::new(1.0, 2.0, 3.0);
    let mesh = &mut shared.meshes[0];
    // Its front looks inwards; emitters should shine outwards.
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh.normals = mesh.positions.iter().map(|p| p.normalize()).collect();
    let copied = unshared(&shared);
    let eye = DVec3::new(1e4, 9.0, -2e4 + 18.0);
    let target = DVec3::new(1e4, 0.0, -2e4);
    let view = View {
        camera: support::look_at(eye, target, DVec3::Y, 0.9),
        width: 320,
        height: 240,
        seed: 1,
        bounces: 0,
        jitter: false,
    };
    let [(one, lit_one), (other, lit_other)] = [&shared, &copied].map(|scene| {
        let (device, selection) = support::open_device(None);
        let uploaded = GpuScene::new(&device, scene, eye, selection.variant).unwrap();
        let settings = Settings::default();
        let mut renderer = Renderer::new(&device, Arc::new(uploaded), &view, &settings).unwrap();
        renderer.add_samples(0, 1).unwrap();
        let surfaces = renderer.primary_surfaces().unwrap();
        (surfaces, renderer.sums().unwrap().pixels)
    });
    let pixels = one.len();
    let same = |i: &usize| {
        let (a, b) = (&one[*i], &other[*i]);
        a.instance == b.instance
            && (a.depth - b.depth).abs() <= 1e-4 * a.depth
            && a.normal.distance(b.normal) < 1e-3
            && a.albedo == b.albedo
            && lit_one[*i].sum == lit_other[*i].sum
    };
    let agree = (0..pixels).filter(same).count();
    // Silhouettes may fall on either side of a pixel's centre.
    assert!(pixels - agree <= pixels / 500, "{agree} of {pixels} agree");
    let seen: std::collections::BTreeSet<u32> = one.iter().map(|s| s.instance).collect();
    assert!(seen.len() > 30, "{} instances are seen", seen.len());
    let lit = lit_one.iter().filter(|s| s.sum.x > 0.0).count();
    assert!(lit > pixels / 20, "{lit} pixels show an emitter");
}

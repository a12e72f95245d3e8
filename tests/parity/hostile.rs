//! Differential fuzzing: both tracers and the f64 oracle trace hostile rays through hostile meshes, and their hits are
//! compared. The meshes consist of needles, fans, coplanar and equal triangles, with sizes from 1e-20 to 1e14. Rays aim at
//! edges and corners, run along planes and axes, and begin and end on surfaces.
//!
//! Where rounding decides, two results are right: an intersection close to an edge, or close to an end of the ray, may be
//! found or not. Every other difference is a fault; it is reduced to few triangles and one ray, and printed.
//! `HEADWATER_RAY_SEED` selects other scenes, and `HEADWATER_RAYS` the number of rays.

use super::support::brute_force::{self, Hit};
use super::support::random::Random;
use super::{answers, bumpy_sphere, corners, leaf_order, support, unshared};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use headwater::device_scene::merge_static::merge_static;
use headwater::gpu::DriverKind;
use headwater::scene::{Instance, Material, Scene};
use headwater::shader_interface::{RayHit, RayQuery, Tracer, Variant};
use std::collections::BTreeMap;

const RAYS_PER_SCENE: usize = 4_000;
/// The uncertainty of a position that f32 leaves, relative to the coordinates of ray and triangle there.
const BOUND: f64 = 1e-5;

/// A random power of ten between 10^`low` and 10^`high`, uniform in its exponent.
fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10_f64.powf(low + (high - low) * random.unit())
}

fn within_cube(random: &mut Random) -> DVec3 {
    DVec3::new(random.unit(), random.unit(), random.unit()) * 2.0 - 1.0
}

/// Triangles of one random kind (such as needles or fans), with coordinates up to about 1.
fn faces(random: &mut Random) -> Vec<[DVec3; 3]> {
    let count = 1 + random.index(60);
    let plane = random.direction();
    let kind = random.index(8);
    if kind == 0 {
        let rings = 3 + random.index(10) as u32;
        let sphere = bumpy_sphere(rings, 0.8).into_iter();
        return sphere.map(|face| face.map(|p| p.as_dvec3())).collect();
    }
    let hub = within_cube(random) * 0.3;
    let mut face = |_| {
        let [a, b, c] = [(); 3].map(|()| within_cube(random));
        match kind {
            // Anything, and what meets in one corner.
            1 => [a, b, c],
            2 => [hub, a, a + (b - a) * 0.3],
            // Needles, and slivers whose third corner is on the edge.
            3 => [a, b, a + c * power(random, -7.0, -1.0)],
            4 => [
                a,
                b,
                a + (b - a) * random.unit() + c * power(random, -7.0, -2.0),
            ],
            // In one plane, which is an axis' or is not.
            5 => [a, b, c].map(|p| p - plane * p.dot(plane)),
            6 => [a, b, c].map(|p| p.with_y(0.25)),
            // A small one beside large ones.
            _ => {
                let size = power(random, -4.0, 0.0);
                [a, a + b * size, a + c * size]
            }
        }
    };
    let mut faces: Vec<_> = (0..count).map(&mut face).collect();
    if random.index(4) == 0 {
        // Each once more, turned over.
        faces.extend(faces.clone().into_iter().map(|[a, b, c]| [a, c, b]));
    }
    faces
}

/// A scene of several random meshes with several instances each. The object spaces have sizes of any magnitude.
fn scene(random: &mut Random) -> Scene {
    let scale = power(random, -9.0, 11.0);
    let mut scene = Scene::default();
    for _ in 0..1 + random.index(4) {
        let size = power(random, -20.0, 14.5);
        let faces = faces(random).into_iter();
        let faces: Vec<_> = faces
            .map(|face| face.map(|p| (p * size).as_vec3()))
            .collect();
        support::add(&mut scene, &Material::default(), &faces);
        let mesh = scene.instances.pop().unwrap().mesh;
        // Twice at least, or meshes are merged.
        for _ in 0..2 + random.index(2) {
            let turn = DQuat::from_axis_angle(random.direction(), 6.0 * random.unit());
            let side = if random.index(4) == 0 { -1.0 } else { 1.0 };
            let stretch = DVec3::new(side, power(random, -0.5, 0.5), power(random, -0.5, 0.5));
            let matrix = DMat3::from_quat(turn) * DMat3::from_diagonal(stretch) * (scale / size);
            scene.instances.push(Instance {
                name: String::new(),
                mesh,
                object_to_world: DAffine3::from_mat3_translation(
                    matrix,
                    within_cube(random) * scale,
                ),
            });
        }
    }
    scene
}

/// Random rays that aim at the triangles of a scene.
fn rays(scene: &Scene, random: &mut Random, count: usize) -> Vec<RayQuery> {
    let triangles = super::all_triangles(scene);
    let (low, high) = super::bounds(scene);
    let size = (high - low).max_element();
    let mut ray = |_| {
        let (instance, triangle) = triangles[random.index(triangles.len())];
        let [a, b, c] = corners(scene, instance, triangle);
        let at = |random: &mut Random| {
            let (u, v) = (random.unit(), random.unit());
            match random.index(5) {
                0 => a,
                1 => a + (b - a) * u,
                2 => a + (b - a) * u + random.direction() * size * power(random, -7.0, -3.0),
                _ => a + (b - a) * u * 0.5 + (c - a) * v * 0.5,
            }
        };
        let target = at(random);
        let far = size * power(random, -3.0, 2.0);
        let mut origin = match random.index(6) {
            // From anywhere, along the triangle's plane, along an axis, from a point of a triangle.
            0 => {
                target
                    + ((b - a) * random.unit() + (c - a) * random.unit()).normalize_or(DVec3::X)
                        * far
            }
            1 => target + [DVec3::X, -DVec3::Y, DVec3::Z][random.index(3)] * far,
            2 => at(random),
            _ => target + random.direction() * far,
        };
        // In f32, so that a ray along an axis has zeros.
        let target = target.as_vec3();
        origin = origin.as_vec3().as_dvec3();
        let mut direction = target.as_dvec3() - origin;
        if direction == DVec3::ZERO {
            direction = random.direction() * size;
        }
        // Up to the target, or not quite, or twice as far, or without an end and of any length.
        let t_max = [1.0, 0.999, 2.0, 1e30][random.index(4)];
        if t_max > 2.0 {
            direction *= power(random, -5.0, 5.0) / direction.length();
        }
        RayQuery {
            origin: origin.as_vec3(),
            t_max,
            direction: direction.as_vec3(),
            any: (random.index(5) == 0).into(),
        }
    };
    (0..count).map(&mut ray).collect()
}

/// An intersection of a ray and a triangle, with its uncertainty by rounding.
struct Crossing {
    /// Ray parameter of the intersection, in lengths of the ray's direction.
    t: f64,
    /// The distance from `t`, in the same unit, within which the exact intersection may be.
    slack: f64,
    /// The distance, in world units, by which the point of the triangle may lie beside the ray.
    beside: f64,
    /// The distance of the ray from the nearest edge of the triangle, relative to the coordinates there.
    to_edge: f64,
}

impl Crossing {
    fn of(scene: &Scene, ray: &RayQuery, t: f64, instance: u32, triangle: u32) -> Self {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let corners = corners(scene, instance, triangle);
        let [a, b, c] = corners;
        let size = size_at(origin, direction, t, corners);
        let unit = direction.normalize();
        let sine = (b - a).cross(c - a).normalize_or_zero().dot(unit).abs();
        // Weights of a triangle that the ray sees as a thin line are known to a part that grows with its thinness.
        let beside = (1.0 + 0.1 * aspect_ratio(unit, corners)) * BOUND * size;
        Self {
            t,
            slack: beside / (sine * direction.length()),
            beside,
            to_edge: super::distance_to_edges(origin, direction, corners) / size,
        }
    }

    /// True if every correct tracer must find the intersection.
    fn is_certain(&self, ray: &RayQuery) -> bool {
        self.to_edge > BOUND && self.t > self.slack && self.t + self.slack < f64::from(ray.t_max)
    }
}

/// The magnitude of the coordinates from which an intersection is computed; rounding errors are relative to it.
fn size_at(origin: DVec3, direction: DVec3, t: f64, corners: [DVec3; 3]) -> f64 {
    let way = direction.length() * t;
    let furthest = corners.map(DVec3::length).into_iter().fold(0.0, f64::max);
    origin.length().max(way).max(furthest)
}

/// The longest edge of a triangle, seen along a unit direction, divided by the triangle's height above that edge.
fn aspect_ratio(direction: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let across = |edge: DVec3| edge - direction * edge.dot(direction);
    let edges = [across(b - a), across(c - b), across(a - c)];
    let longest = edges
        .map(DVec3::length_squared)
        .into_iter()
        .fold(0.0, f64::max);
    longest / edges[0].cross(edges[1]).length()
}

/// The first intersection along the ray that every correct tracer must find, with its hit; `None` if there is none.
fn first_certain(
    scene: &Scene,
    oracle: &brute_force::Tracer,
    ray: &RayQuery,
) -> Option<(Crossing, Hit)> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let mut start = 0.0;
    loop {
        let hit = oracle.closest(
            origin + direction * start,
            direction,
            f64::from(ray.t_max) - start,
        )?;
        let t = start + hit.t;
        let crossing = Crossing::of(scene, ray, t, hit.instance, hit.triangle);
        if crossing.is_certain(ray) {
            return Some((crossing, hit));
        }
        // Past it, by what f64 tells apart.
        start = t + 1e-13 * (t + origin.length() / direction.length());
    }
}

/// The result of the comparison of a tracer's hit with the oracle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    /// The same triangle, or a miss in both.
    Same,
    /// A different result that rounding permits: at an edge, at an end of the ray, or between triangles at the same place.
    Rounding,
    /// A fault: an intersection is missed, and rounding does not excuse it.
    Missed,
    /// A fault: the hit is not on the ray, or not on the triangle.
    Elsewhere,
    /// A fault: the hit lies behind a nearer intersection that must be found.
    Behind,
}

impl Class {
    fn is_fault(self) -> bool {
        self > Self::Rounding
    }
}

/// Classifies a tracer's answer for a ray. `triangle` is the hit triangle as (instance, index in the mesh).
fn judge(
    scene: &Scene,
    oracle: &brute_force::Tracer,
    ray: &RayQuery,
    answer: &RayHit,
    triangle: impl Fn(u32, u32) -> u32,
) -> Class {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let certain = first_certain(scene, oracle, ray);
    let closest = || oracle.closest(origin, direction, f64::from(ray.t_max));
    if answer.t < 0.0 {
        return match (certain, closest()) {
            (Some(_), _) => Class::Missed,
            (None, Some(_)) => Class::Rounding,
            (None, None) => Class::Same,
        };
    }
    let number = triangle(answer.instance, answer.primitive);
    let corners = corners(scene, answer.instance, number);
    let [a, b, c] = corners;
    let (u, v) = (f64::from(answer.u), f64::from(answer.v));
    let found = Crossing::of(scene, ray, answer.t.into(), answer.instance, number);
    let unit = direction.normalize();
    // The point of the triangle must be on the ray, and where the ray says.
    let off = a + (b - a) * u + (c - a) * v - origin;
    let along = off.dot(unit);
    let is_inside = u >= -1e-6 && v >= -1e-6 && u + v <= 1.0 + 1e-6;
    let late = (along - found.t * direction.length()).abs();
    let is_there = (off - unit * along).length() <= found.beside
        && late <= found.beside + found.slack * direction.length();
    if !(is_inside && is_there && found.t <= f64::from(ray.t_max)) {
        return Class::Elsewhere;
    }
    match certain {
        Some((first, hit))
            if ray.any == 0 && (hit.instance, hit.triangle) != (answer.instance, number) =>
        {
            if first.t + first.slack < found.t - found.slack {
                Class::Behind
            } else {
                Class::Rounding
            }
        }
        Some(_) => Class::Same,
        None => match closest() {
            Some(hit) if (hit.instance, hit.triangle) == (answer.instance, number) => Class::Same,
            _ => Class::Rounding,
        },
    }
}

/// The class of each ray with a shader variant, and the driver that traced them.
fn classes(scene: &Scene, rays: &[RayQuery], variant: Variant) -> (Vec<Class>, DriverKind) {
    let (answers, driver) = answers(scene, DVec3::ZERO, rays, variant).expect("a small scene");
    let oracle = brute_force::Tracer::new(scene);
    let triangle_of = leaf_order(scene, DVec3::ZERO, variant.tracer);
    let judged = rays.iter().zip(&answers);
    let classes = judged.map(|(ray, answer)| judge(scene, &oracle, ray, answer, &triangle_of));
    (classes.collect(), driver)
}

/// The scene with only the triangles in `kept`, pairs of instance and triangle.
fn part(scene: &Scene, kept: &[(u32, u32)]) -> Scene {
    let mut part = Scene::default();
    for (number, placed) in (0..).zip(&scene.instances) {
        let mesh = &scene.meshes[placed.mesh as usize];
        let of_this = kept.iter().filter(|(instance, _)| *instance == number);
        let faces: Vec<_> = of_this
            .map(|(_, triangle)| {
                mesh.triangles[*triangle as usize].map(|i| mesh.positions[i as usize])
            })
            .collect();
        if faces.is_empty() {
            continue;
        }
        support::add(&mut part, &Material::default(), &faces);
        let mut added = part.instances.pop().unwrap();
        added.object_to_world = placed.object_to_world;
        // Twice in one place, or meshes are merged.
        part.instances.extend([added.clone(), added]);
    }
    part
}

/// A minimal part of a scene in which a ray still gives a fault. Triangles are removed in halves and then in smaller groups,
/// as long as the fault remains.
fn reduced(scene: &Scene, ray: &RayQuery, variant: Variant) -> Scene {
    let fails = |kept: &[(u32, u32)]| {
        !kept.is_empty() && classes(&part(scene, kept), &[*ray], variant).0[0].is_fault()
    };
    let mut kept = super::all_triangles(scene);
    let mut piece = kept.len().div_ceil(2);
    loop {
        let mut start = 0;
        while start < kept.len() {
            let mut rest = kept.clone();
            rest.drain(start..(start + piece).min(kept.len()));
            if fails(&rest) {
                kept = rest;
            } else {
                start += piece;
            }
        }
        if piece == 1 {
            return part(scene, &kept);
        }
        piece = piece.div_ceil(2);
    }
}

/// A scene of plain triangles and a ray as Rust code, to be pasted into a regression test.
fn as_code(scene: &Scene, ray: &RayQuery) -> String {
    let mut text = format!("{ray:?}");
    for placed in scene.instances.iter().step_by(2) {
        let mesh = &scene.meshes[placed.mesh as usize];
        text += &format!("\n    {:?} at {:?}", mesh.positions, placed.object_to_world);
    }
    text
}

/// Traces about `count` rays through random scenes, and panics at a fault of Headwater's own tracer. Faults of drivers'
/// tracers are only counted.
fn fuzz(seed: u64, count: usize) {
    let mut random = Random(seed);
    let mut counts: BTreeMap<(&str, Class), usize> = BTreeMap::new();
    let mut faults = Vec::new();
    for number in 0..count.div_ceil(RAYS_PER_SCENE) {
        let mut scene = scene(&mut random);
        scene.validate().unwrap();
        if random.index(4) == 0 {
            scene = merge_static(&unshared(&scene), DVec3::ZERO)
                .scene
                .into_owned();
        }
        if scene.instances.is_empty() {
            continue;
        }
        let rays = rays(&scene, &mut random, RAYS_PER_SCENE);
        for tracer in [Tracer::ComputeBvh, Tracer::RayQuery] {
            let Some(variant) = support::variants(tracer).first().copied() else {
                continue;
            };
            let (classes, driver) = classes(&scene, &rays, variant);
            for class in &classes {
                *counts.entry((tracer.name(), *class)).or_default() += 1;
            }
            let is_ours =
                tracer == Tracer::ComputeBvh || !matches!(driver, DriverKind::Llvmpipe { .. });
            let fault = classes.iter().position(|class| class.is_fault());
            if let Some(fault) = fault.filter(|_| is_ours && faults.len() < 5) {
                let least = reduced(&scene, &rays[fault], variant);
                faults.push(format!(
                    "scene {number}, {:?}: {}",
                    classes[fault],
                    as_code(&least, &rays[fault])
                ));
            }
        }
    }
    println!("seed {seed}");
    for ((tracer, class), count) in counts {
        println!("{tracer}, {class:?}: {count}");
    }
    assert!(
        faults.is_empty(),
        "hostile rays go wrong:\n{}",
        faults.join("\n")
    );
}

/// A find of the fuzzer: products of coordinates of 1e-20 lost their digits, and rays hit the wrong place. Stored positions
/// have had a separate unit since.
#[test]
fn tiny_meshes_that_are_placed_large_keep_their_positions() {
    let corners = [
        Vec3::new(-1.3877393e-20, 1.1595505e-20, 1.884795e-20),
        Vec3::new(-1.1277861e-20, 6.731282e-21, 1.7354858e-20),
        Vec3::new(1.21996725e-20, -2.2246629e-21, 3.6925056e-21),
    ];
    let mut scene = support::scene_of(&[(Material::default(), vec![corners])]);
    scene.instances[0].object_to_world = DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(
                -4.032252381942375e29,
                1.8068334701428916e29,
                -8.210636000326314e28,
            ),
            DVec3::new(
                -2.6037288113723775e29,
                -2.8187047170365214e29,
                6.584096136014525e29,
            ),
            DVec3::new(
                1.0218545500178055e29,
                3.059215843218683e29,
                1.7137748337096574e29,
            ),
        ),
        translation: DVec3::new(
            -1_110_400_578.658_977_7,
            4_740_092_641.324_363,
            7_440_546_287.100_52,
        ),
    };
    let ray = RayQuery {
        origin: Vec3::new(3_442_154_000.0, 5_768_099_000.0, 16_689_598_000.0),
        t_max: 1.0,
        direction: Vec3::new(-2_227_472_600.0, 619_663_360.0, -2_503_607_300.0),
        any: 0,
    };
    for tracer in [Tracer::ComputeBvh, Tracer::RayQuery] {
        for variant in support::variants(tracer) {
            let (classes, _) = classes(&scene, &[ray], variant);
            assert_eq!(classes, [Class::Same], "{}", tracer.name());
        }
    }
}

#[test]
fn hostile_rays_find_what_the_oracle_finds() {
    let seed = support::number_in("HEADWATER_RAY_SEED").unwrap_or(1);
    let count = support::number_in("HEADWATER_RAYS").unwrap_or(100_000);
    fuzz(seed, count as usize);
}

/// Runs the fuzzer again with a change of the shaders that causes faults of the class `class`, and asserts that they are
/// found and reduced to one triangle.
fn assert_found(change: (&str, &str), class: &str) {
    let fault = ("scene/trace_compute_bvh.glsl", change.0, change.1);
    let test = "hostile::hostile_rays_find_what_the_oracle_finds";
    let output = support::run_with_fault(test, fault, |command| {
        command.env("HEADWATER_RAYS", "20000")
    });
    let said = support::said(&output);
    assert!(
        said.contains("hostile rays go wrong") && said.contains(&format!("{class}: RayQuery")),
        "{said}"
    );
    // One triangle is left.
    let is_triangle = |line: &str| line.contains("[Vec3(") && line.matches(", Vec3(").count() == 2;
    assert!(said.lines().any(is_triangle), "{said}");
}

#[test]
fn edges_that_let_rays_through_are_found_and_reduced() {
    let inside = "bool inside = min(u, min(v, w)) >= 0.0 ||";
    let narrower = "bool inside = min(u, min(v, w)) > 0.01 * abs(u + v + w) ||";
    assert_found((inside, narrower), "Missed");
}

mod thorough {
    use super::*;

    #[test]
    fn shadows_of_nothing_are_found() {
        let meets = "if (meets_triangle(primitive, level, t, front, weights)";
        let too_often = "if ((meets_triangle(primitive, level, t, front, weights) || any_hit)";
        assert_found((meets, too_often), "Elsewhere");
    }

    #[test]
    fn hits_behind_others_are_found() {
        // Of two triangles the one that is met last is taken.
        let nearest = "float t = hit.t;";
        assert_found((nearest, "float t = ray.t_max;"), "Behind");
    }
}

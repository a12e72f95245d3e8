//! Pictures against what is known without the renderer: closed forms, and a path tracer on the CPU
//! that shares no code with it.

mod support;

use glam::{DAffine3, DVec3, Vec3};
use headwater::metrics::statistics::{Estimate, holm, welch_p_value};
use headwater::render::{Settings, View};
use headwater::scene::{Camera, Material, Scene};
use std::f64::consts::PI;
use std::fmt::Write;
use support::brute_force::{Options, Tracer, camera_ray};

/// Chance at which a test of a right renderer alarms, over all the comparisons it makes.
const LEVEL: f64 = 0.001;
/// The widest 99.9 % interval of an image's mean, as a part of it, that still shows something.
const WIDEST: f64 = 0.003;

/// Means and squared standard errors of pixels, from anywhere.
struct Picture {
    mean: Vec<[f64; 3]>,
    error_squared: Vec<[f64; 3]>,
    samples: u64,
}

impl Picture {
    /// Mean over some pixels; their errors are independent.
    fn mean_of(&self, pixels: &[usize], channel: usize) -> Estimate {
        let n = pixels.len() as f64;
        let sum = |values: &[[f64; 3]]| pixels.iter().map(|&p| values[p][channel]).sum::<f64>();
        Estimate {
            mean: sum(&self.mean) / n,
            standard_error: sum(&self.error_squared).sqrt() / n,
            samples: self.samples * pixels.len() as u64,
        }
    }
}

fn exact(mean: f64) -> Estimate {
    Estimate {
        mean,
        standard_error: 0.0,
        samples: 1,
    }
}

/// One comparison: what, and two estimates that should be of the same number.
struct Comparison {
    what: String,
    one: Estimate,
    other: Estimate,
    /// Whether noise that hides a fault is a failure too.
    sharp: bool,
}

/// What fails: means that differ, by Holm over all comparisons, and intervals too wide to tell.
fn failures(comparisons: &[Comparison]) -> String {
    let p_values: Vec<f64> = comparisons
        .iter()
        .map(|c| welch_p_value(&c.one, &c.other))
        .collect();
    let mut text = String::new();
    for (c, p) in comparisons.iter().zip(holm(&p_values)) {
        let (one, other) = (c.one.mean, c.other.mean);
        if p < LEVEL {
            writeln!(text, "{}: {one} is not {other}, p {p:.1e}", c.what).unwrap();
        }
        let half_width = c.one.minus(&c.other).t_interval_half_width(1.0 - LEVEL) / other.abs();
        if c.sharp && half_width.is_nan() | (half_width > WIDEST) {
            writeln!(text, "{}: ±{half_width} is too wide", c.what).unwrap();
        }
    }
    text
}

/// The image's mean and the means of 4 × 4 blocks, each channel by itself.
fn compare_pictures(name: &str, one: &Picture, other: &Picture, width: usize) -> Vec<Comparison> {
    let count = one.mean.len();
    let mut regions = vec![("image".to_owned(), (0..count).collect::<Vec<_>>())];
    for y in (0..count / width).step_by(4) {
        for x in (0..width).step_by(4) {
            let block = (0..16).map(|i| (y + i / 4) * width + x + i % 4);
            regions.push((format!("block at {x}, {y}"), block.collect()));
        }
    }
    let mut comparisons = Vec::new();
    for (region, pixels) in regions {
        for (channel, color) in ["red", "green", "blue"].iter().enumerate() {
            comparisons.push(Comparison {
                what: format!("{name}, {region}, {color}"),
                one: one.mean_of(&pixels, channel),
                other: other.mean_of(&pixels, channel),
                sharp: region == "image",
            });
        }
    }
    comparisons
}

fn on_device(scene: &Scene, view: &View, samples: u32) -> Picture {
    let (device, selection) = support::open_device(None);
    let settings = Settings::default();
    let image = support::render(&device, scene, selection.variant, view, &settings, samples);
    support::assert_no_messages(&device);
    Picture {
        mean: image.mean,
        error_squared: image.error_squared,
        samples: samples.into(),
    }
}

fn by_brute_force(scene: &Scene, camera: &Camera, size: [u32; 2], options: &Options) -> Picture {
    let image = Tracer::new(scene).render(camera, size[0], size[1], options);
    Picture {
        mean: image.mean,
        error_squared: image.error_squared,
        samples: image.groups.into(),
    }
}

/// Light of one colour from a matte quad.
fn lamp(radiance: Vec3, albedo: f32) -> Material {
    Material {
        emission: radiance,
        ..Material::lambert("lamp", Vec3::splat(albedo))
    }
}

/// Irradiance at a point under its normal from a polygon of radiance 1 that is wholly above the
/// horizon, its corners clockwise seen from the point (Lambert 1760; Baum, Rushmeier and Winget,
/// "Improving radiosity solutions through the use of analytically determined form-factors", 1989).
fn polygon_irradiance(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let toward: Vec<DVec3> = corners.iter().map(|c| (*c - point).normalize()).collect();
    let edges = toward.iter().zip(toward.iter().cycle().skip(1));
    let around: DVec3 = edges
        .map(|(a, b)| a.cross(*b).normalize() * a.angle_between(*b))
        .sum();
    0.5 * around.dot(normal).abs()
}

#[test]
fn a_quad_lights_a_plane_as_the_closed_form_says() {
    const SIZE: u32 = 16;
    const SAMPLES: u32 = 2048;
    let albedo = Vec3::new(0.8, 0.5, 0.2);
    let radiance = Vec3::new(3.0, 5.0, 9.0);
    // Tilted, so that no symmetry hides a fault, and above the plane everywhere.
    let (corner, u, v) = (
        Vec3::new(-0.5, 1.0, -0.75),
        Vec3::new(1.25, 0.25, 0.0),
        Vec3::new(0.0, 0.5, 1.5),
    );
    let floor = support::quad(Vec3::new(-8.0, 0.0, 8.0), Vec3::X * 16.0, -Vec3::Z * 16.0);
    let scene = support::scene_of(&[
        (Material::lambert("floor", albedo), floor),
        (lamp(radiance, 0.0), support::quad(corner, u, v)),
    ]);
    let corners = [corner, corner + u, corner + u + v, corner + v].map(|c| c.as_dvec3());
    assert!(u.cross(v).y < 0.0, "the lamp faces down");

    let mut comparisons = Vec::new();
    let points = [
        [0.0, 0.0],
        [1.5, 0.5],
        [-2.0, 1.0],
        [0.25, -3.0],
        [3.0, 3.0],
    ];
    for (number, [x, z]) in points.into_iter().enumerate() {
        let target = DVec3::new(x, 0.0, z);
        // From the side, under the lamp's lowest corner.
        let eye = target + DVec3::new(0.3, 0.5, 0.4);
        let camera = support::look_at(eye, target, DVec3::Y, 0.02);
        let pixels = (0..SIZE * SIZE).map(|p| [p % SIZE, p / SIZE]);
        let irradiance: f64 = pixels
            .map(|pixel| {
                let (origin, direction) = camera_ray(&camera, pixel, [SIZE, SIZE]);
                let point = origin - direction * (origin.y / direction.y);
                polygon_irradiance(point, DVec3::Y, &corners) / f64::from(SIZE * SIZE)
            })
            .sum();
        let view = View {
            camera,
            width: SIZE,
            height: SIZE,
            seed: 7 + number as u32,
            bounces: 1,
            jitter: false,
        };
        let picture = on_device(&scene, &view, SAMPLES);
        let all: Vec<usize> = (0..picture.mean.len()).collect();
        for channel in 0..3 {
            let wanted = f64::from(albedo[channel]) * f64::from(radiance[channel]) / PI;
            comparisons.push(Comparison {
                what: format!("point {x}, {z}, channel {channel}"),
                one: picture.mean_of(&all, channel),
                other: exact(wanted * irradiance),
                sharp: true,
            });
        }
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
}

/// A box that stands on the floor, turned about its axis.
fn standing_box(centre: [f32; 2], size: Vec3, turn: f32) -> Vec<[Vec3; 3]> {
    let (sin, cos) = turn.sin_cos();
    let (x, z) = (
        Vec3::new(cos, 0.0, -sin) * size.x,
        Vec3::new(sin, 0.0, cos) * size.z,
    );
    let y = Vec3::Y * size.y;
    let corner = Vec3::new(centre[0], 0.0, centre[1]) - 0.5 * (x + z);
    [
        support::quad(corner + z, x, y),
        support::quad(corner, y, x),
        support::quad(corner + x, y, z),
        support::quad(corner, z, y),
        support::quad(corner + y, z, x),
    ]
    .concat()
}

const ROOM_SIZE: [u32; 2] = [24, 24];

/// A room after Cornell's, open in front, with a matte, a metal and a dielectric box.
fn room(white: f32) -> (Scene, Camera) {
    let matte = |name, color| Material::lambert(name, color);
    let glossy = |name: &str, color, metallic, roughness| Material {
        name: name.into(),
        base_color: color,
        metallic,
        roughness,
        ..Material::default()
    };
    let (x, y, z) = (Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let low = Vec3::new(-1.0, 0.0, -1.0);
    let scene = support::scene_of(&[
        (
            matte("white", Vec3::splat(white)),
            [
                support::quad(low, z, x),
                support::quad(low + y, x, z),
                support::quad(low, x, y),
            ]
            .concat(),
        ),
        (
            matte("red", Vec3::new(0.6, 0.06, 0.05)),
            support::quad(low, y, z),
        ),
        (
            matte("green", Vec3::new(0.12, 0.45, 0.1)),
            support::quad(low + x, z, y),
        ),
        (
            matte("grey box", Vec3::splat(0.4)),
            standing_box([0.5, -0.55], Vec3::new(0.5, 0.5, 0.5), 0.4),
        ),
        (
            glossy("metal box", Vec3::new(0.9, 0.7, 0.4), 1.0, 0.3),
            standing_box([-0.4, -0.3], Vec3::new(0.6, 1.2, 0.5), 0.3),
        ),
        (
            glossy("dielectric box", Vec3::new(0.2, 0.3, 0.7), 0.0, 0.2),
            standing_box([0.35, 0.4], Vec3::new(0.55, 0.5, 0.5), -0.3),
        ),
        (
            lamp(Vec3::new(9.0, 8.0, 6.0), 0.5),
            support::quad(Vec3::new(-0.4, 1.95, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8),
        ),
    ]);
    // Off the middle, from where the room's edges would run through the pixels' centres.
    let (eye, target) = (DVec3::new(0.07, 1.03, 3.6), DVec3::new(0.01, 0.98, 0.0));
    (scene, support::look_at(eye, target, DVec3::Y, 0.72))
}

#[test]
fn a_room_is_as_the_brute_force_tracer_says() {
    let (scene, camera) = room(0.75);
    let [width, height] = ROOM_SIZE;
    let tracer = Tracer::new(&scene);
    for pixel in 0..width * height {
        // Rounding must not decide what a pixel sees.
        let (origin, direction) = camera_ray(&camera, [pixel % width, pixel / width], ROOM_SIZE);
        if let Some(hit) = tracer.closest(origin, direction, f64::INFINITY) {
            let away = tracer.edge_distance(origin, direction, hit.instance, hit.triangle);
            assert!(away > 1e-5, "pixel {pixel} is on an edge");
        }
    }
    let mut comparisons = Vec::new();
    let mut faulty = Vec::new();
    for (bounces, samples) in [(1, 1024), (5, 6400)] {
        let view = View {
            camera: camera.clone(),
            width,
            height,
            seed: 11,
            bounces,
            jitter: false,
        };
        let options = Options {
            bounces,
            samples,
            seed: 12,
            nee: true,
        };
        let picture = on_device(&scene, &view, samples);
        let truth = by_brute_force(&scene, &camera, ROOM_SIZE, &options);
        let name = format!("{bounces} bounces");
        comparisons.extend(compare_pictures(&name, &picture, &truth, width as usize));
        let options = Options {
            samples: samples / 8,
            ..options
        };
        // The white walls' albedo, 2 % too high.
        let wrong = by_brute_force(&room(0.75 * 1.02).0, &camera, ROOM_SIZE, &options);
        faulty.extend(compare_pictures(&name, &picture, &wrong, width as usize));
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
    let text = failures(&faulty);
    let seen = |line: &str| line.contains("image") && line.contains(" is not ");
    assert!(
        text.lines().any(seen),
        "a planted fault was not seen\n{text}"
    );
}

#[test]
fn the_brute_force_estimators_agree() {
    let (mut scene, camera) = room(0.75);
    // A lamp that chance finds, turned to both sides so that its back counts too.
    let lamp = scene.materials.last_mut().unwrap();
    lamp.double_sided = true;
    let options = Options {
        bounces: 3,
        samples: 1024,
        seed: 3,
        nee: true,
    };
    let one = by_brute_force(&scene, &camera, ROOM_SIZE, &options);
    let options = Options {
        samples: 4096,
        seed: 4,
        nee: false,
        ..options
    };
    let other = by_brute_force(&scene, &camera, ROOM_SIZE, &options);
    let mut comparisons = compare_pictures("room", &one, &other, ROOM_SIZE[0] as usize);
    for comparison in &mut comparisons {
        comparison.sharp = false;
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
}

/// A closed box that glows, seen from inside, with a white box in it.
fn furnace(emission: f32, albedo: f32) -> (Scene, Camera) {
    let mut shell = standing_box([0.0, 0.0], Vec3::splat(4.0), 0.0);
    let corner = Vec3::new(-2.0, 0.0, -2.0);
    shell.extend(support::quad(corner, Vec3::X * 4.0, Vec3::Z * 4.0));
    let glow = Material {
        double_sided: true,
        ..lamp(Vec3::splat(emission), albedo)
    };
    let mut scene = support::scene_of(&[
        (glow, shell),
        (
            Material::lambert("white", Vec3::ONE),
            standing_box([0.0, 0.0], Vec3::ONE, 0.0),
        ),
    ]);
    // Off the floor, mirrored and stretched: the transform must not matter.
    scene.instances[1].object_to_world = DAffine3::from_translation(DVec3::new(0.1, 1.2, -0.2))
        * DAffine3::from_rotation_x(0.5)
        * DAffine3::from_scale(DVec3::new(-1.2, 0.9, 1.1));
    let (eye, target) = (DVec3::new(0.4, 2.2, 1.8), DVec3::new(0.1, 1.7, -0.2));
    (scene, support::look_at(eye, target, DVec3::Y, 1.0))
}

#[test]
fn a_white_furnace_is_one_by_brute_force() {
    let options = Options {
        bounces: 1,
        samples: 64,
        seed: 5,
        nee: false,
    };
    let (scene, camera) = furnace(1.0, 0.0);
    let picture = by_brute_force(&scene, &camera, [16, 16], &options);
    for value in picture.mean.iter().flatten() {
        assert!((value - 1.0).abs() < 1e-12, "{value}");
    }
    // Σ ρⁿ (1 − ρ), with the last of n scattering events missing, where the glow reflects too.
    let (scene, camera) = furnace(0.5, 0.5);
    let all: Vec<usize> = (0..256).collect();
    // What is missing is some 1e-6, from paths that stay in the white box, whose bottom is open; by
    // chance alone the noise is below that.
    let whole = Estimate {
        mean: 1.0,
        standard_error: 1e-5,
        samples: 1 << 40,
    };
    let mut comparisons = Vec::new();
    for nee in [false, true] {
        let options = Options {
            bounces: 40,
            samples: 256,
            nee,
            ..options
        };
        let picture = by_brute_force(&scene, &camera, [16, 16], &options);
        for channel in 0..3 {
            comparisons.push(Comparison {
                what: format!("nee {nee}, channel {channel}"),
                one: picture.mean_of(&all, channel),
                other: whole,
                sharp: true,
            });
        }
    }
    let text = failures(&comparisons);
    assert!(text.is_empty(), "\n{text}");
}

#[test]
fn the_brute_force_tracer_finds_triangles_and_their_edges() {
    let matte = Material::lambert("matte", Vec3::ONE);
    let corner = Vec3::new(0.0, 0.0, -4.0);
    let mut scene = support::scene_of(&[(matte, support::quad(corner, Vec3::X, Vec3::Y))]);
    scene.instances[0].object_to_world = DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.0));
    let tracer = Tracer::new(&scene);
    // A direction of length 2; the second triangle lies above the diagonal.
    let (origin, direction) = (DVec3::new(0.5, 0.75, 0.0), DVec3::Z * -2.0);
    let hit = tracer.closest(origin, direction, 10.0).unwrap();
    assert_eq!((hit.instance, hit.triangle, hit.t), (0, 1, 2.0));
    assert_eq!((hit.u, hit.v), (0.25, 0.5));
    assert!(tracer.closest(origin, direction, 1.9).is_none());
    assert!(tracer.closest(origin, -direction, 10.0).is_none());

    let away = |x: f64, y: f64, triangle: u32| {
        let point = DVec3::new(x, y, -4.0);
        let scale = point.length().max(4.0);
        tracer.edge_distance(point.with_z(0.0), direction, 0, triangle) * scale
    };
    assert!((away(1.75, 0.25, 0) - 0.25).abs() < 1e-12);
    assert!((away(2.5, 0.25, 0) + 0.5).abs() < 1e-12);
    // Beyond a corner the corner is nearest, not a line through it.
    assert!((away(2.3, 1.4, 0) + 0.5).abs() < 1e-12);
    assert!(away(0.5, 0.25, 0).abs() < 1e-12);
    let along = tracer.edge_distance(origin, DVec3::X, 0, 0);
    assert_eq!(along, f64::INFINITY);
}

//! Tests of the brute-force tracer, the path tracer on the CPU, against integrals that are computed without it. They need no
//! device.

mod support;

use glam::{DAffine3, DVec3, Vec3};
use headwater::metrics::statistics::{Estimate, holm, welch_p_value};
use headwater::scene::{Camera, Material, Scene};
use std::f64::consts::PI;
use support::brute_force::{Image, Options, Tracer};

/// The probability with which a correct tracer fails one of the tests of this file.
const LEVEL: f64 = 0.001;
/// A vertical field of view in radians, so narrow that all pixels see the same point.
const NARROW: f64 = 1e-6;

/// A material that emits one colour of light and reflects nothing.
fn emitter(radiance: Vec3, double_sided: bool) -> Material {
    Material {
        emission: radiance,
        double_sided,
        ..Material::lambert("lamp", Vec3::ZERO)
    }
}

/// The mean of a channel over the picture, with its error; the pixels are independent.
fn mean_of(image: &Image, channel: usize) -> Estimate {
    let n = image.mean.len() as f64;
    let sum = |values: &[[f64; 3]]| values.iter().map(|p| p[channel]).sum::<f64>();
    Estimate {
        mean: sum(&image.mean) / n,
        standard_error: sum(&image.error_squared).sqrt() / n,
        samples: u64::from(image.groups) * image.mean.len() as u64,
    }
}

/// The name of a comparison, the estimate, and the exact value.
type Comparison = (String, Estimate, f64);

/// Panics if an estimate differs from its exact value (Holm's correction over all comparisons), or if the half-width of its
/// confidence interval is larger than the fraction `widest` of the value.
fn assert_close(comparisons: &[Comparison], widest: f64) {
    let exact = |mean| Estimate {
        mean,
        standard_error: 0.0,
        samples: 1,
    };
    let p_values: Vec<f64> = comparisons
        .iter()
        .map(|(_, got, wanted)| welch_p_value(got, &exact(*wanted)))
        .collect();
    let mut text = String::new();
    for ((what, got, wanted), p) in comparisons.iter().zip(holm(&p_values)) {
        let half_width = got.t_interval_half_width(1.0 - LEVEL) / wanted;
        println!("{what}: {} ± {half_width:.5}, {wanted}", got.mean);
        if p < LEVEL {
            text += &format!("{what}: {} is not {wanted}, p {p:.1e}\n", got.mean);
        }
        if half_width.is_nan() || half_width > widest {
            text += &format!("{what}: ± {half_width} is too wide\n");
        }
    }
    assert!(text.is_empty(), "\n{text}");
}

fn camera_at(target: DVec3, toward_eye: DVec3, distance: f64) -> Camera {
    let up = toward_eye.any_orthonormal_vector();
    support::look_at(target + toward_eye * distance, target, up, NARROW)
}

#[test]
fn an_emitter_lights_a_plane_as_the_integral_over_it_says() {
    // Tilted and off to a side; it faces the plane.
    let (corner, u, v) = (
        Vec3::new(-0.5, 1.0, -0.75),
        Vec3::new(1.25, 0.25, 0.0),
        Vec3::new(0.0, 0.5, 1.5),
    );
    let albedo = Vec3::new(0.8, 0.5, 0.2);
    let radiance = Vec3::new(3.0, 5.0, 9.0);
    let floor = support::quad(Vec3::new(-8.0, 0.0, 8.0), Vec3::X * 16.0, -Vec3::Z * 16.0);
    let scene = support::scene_of(&[
        (Material::lambert("floor", albedo), floor),
        (emitter(radiance, false), support::quad(corner, u, v)),
    ]);
    let tracer = Tracer::new(&scene);
    let mut comparisons = Vec::new();
    for (number, [x, z]) in [[0.0, 0.0], [1.5, 0.5], [0.25, -3.0]]
        .into_iter()
        .enumerate()
    {
        let point = DVec3::new(x, 0.0, z);
        // ∫ cos cos / r² by the midpoint rule, whose error falls with its cells' number.
        let cells = 400;
        let (corner, u, v) = (corner.as_dvec3(), u.as_dvec3(), v.as_dvec3());
        let normal = u.cross(v) / f64::from(cells * cells);
        let mut irradiance = 0.0;
        for cell in 0..cells * cells {
            let at = [cell % cells, cell / cells].map(|c| (f64::from(c) + 0.5) / f64::from(cells));
            let toward = corner + u * at[0] + v * at[1] - point;
            irradiance += toward.y * -toward.dot(normal) / toward.length_squared().powi(2);
        }
        for (nee, samples) in [(true, 8192), (false, 131_072)] {
            if !nee && number == 2 {
                // Too far for chance to find the emitter often.
                continue;
            }
            let options = Options {
                bounces: 1,
                samples,
                seed: 20 + number as u64,
                nee,
            };
            let toward_eye = DVec3::new(0.3, 0.5, 0.4).normalize();
            let image = tracer.render(&camera_at(point, toward_eye, 0.7), 4, 4, &options);
            for channel in 0..3 {
                let wanted = f64::from(albedo[channel]) * f64::from(radiance[channel]) / PI;
                comparisons.push((
                    format!("{point}, nee {nee}, channel {channel}"),
                    mean_of(&image, channel),
                    wanted * irradiance,
                ));
            }
        }
    }
    assert_close(&comparisons, 0.003);
}

/// The BRDF (RGB, per steradian) of glTF 2.0, appendix B, with KHR_materials_specular and KHR_materials_ior, written a
/// second time. The directions and the normal are unit vectors on one side of the surface.
fn brdf(material: &Material, normal: DVec3, outgoing: DVec3, incoming: DVec3) -> DVec3 {
    let half = (outgoing + incoming).normalize();
    let [n_o, n_i, n_h, o_h] = [
        normal.dot(outgoing),
        normal.dot(incoming),
        normal.dot(half),
        outgoing.dot(half),
    ];
    let alpha2 = f64::from(material.roughness).powi(4);
    let d = alpha2 / (PI * (n_h * n_h * (alpha2 - 1.0) + 1.0).powi(2));
    // Smith's masking and shadowing, correlated by height, as 1 / (1 + Λ(o) + Λ(i)).
    let lambda = |c: f64| 0.5 * ((1.0 + alpha2 * (1.0 / (c * c) - 1.0)).sqrt() - 1.0);
    let specular = d / (1.0 + lambda(n_o) + lambda(n_i)) / (4.0 * n_o * n_i);
    let base = material.base_color.as_dvec3();
    let weight = f64::from(material.specular);
    let ior = f64::from(material.ior);
    let f0 = (material.specular_color.as_dvec3() * ((1.0 - ior) / (1.0 + ior)).powi(2))
        .min(DVec3::ONE)
        * weight;
    let schlick = (1.0 - o_h).powi(5);
    let dielectric_fresnel = f0 + (DVec3::splat(weight) - f0) * schlick;
    let dielectric =
        base / PI * (1.0 - dielectric_fresnel.max_element()) + dielectric_fresnel * specular;
    let metal = (base + (DVec3::ONE - base) * schlick) * specular;
    dielectric.lerp(metal, f64::from(material.metallic))
}

/// The albedo of the plate: the integral of BRDF × cosine over the directions that are above both the shading normal
/// `normal` and the plane z = 0.
fn albedo(material: &Material, normal: DVec3, outgoing: DVec3) -> DVec3 {
    // Enough for the step that the horizon cuts under a tilted normal.
    const CELLS: [u32; 2] = [1500, 3000];
    let (x, y) = normal.any_orthonormal_pair();
    let mut sum = DVec3::ZERO;
    for row in 0..CELLS[0] {
        let (sin, cos) = ((f64::from(row) + 0.5) / f64::from(CELLS[0]) * PI / 2.0).sin_cos();
        for column in 0..CELLS[1] {
            let phi = (f64::from(column) + 0.5) / f64::from(CELLS[1]) * 2.0 * PI;
            let incoming = (x * phi.cos() + y * phi.sin()) * sin + normal * cos;
            if incoming.z > 0.0 {
                sum += brdf(material, normal, outgoing, incoming) * (sin * cos);
            }
        }
    }
    sum * (PI / 2.0 / f64::from(CELLS[0])) * (2.0 * PI / f64::from(CELLS[1]))
}

/// A plate around the origin that faces +Z, alone in a room that glows uniformly.
fn plate(material: Material, shading_normal: Option<Vec3>) -> Scene {
    let r = 1000.0;
    let mut room = Vec::new();
    for axis in 0..3 {
        for side in [-r, r] {
            let corner = Vec3::splat(-r) + Vec3::AXES[axis] * (side + r);
            let (u, v) = (Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3]);
            room.extend(support::quad(corner, u * 2.0 * r, v * 2.0 * r));
        }
    }
    let corner = Vec3::new(-1.0, -1.0, 0.0);
    let front = support::quad(corner, Vec3::X * 2.0, Vec3::Y * 2.0);
    let mut scene =
        support::scene_of(&[(material, front), (emitter(Vec3::splat(2.0), true), room)]);
    if let Some(normal) = shading_normal {
        scene.meshes[0].normals = vec![normal; scene.meshes[0].positions.len()];
    }
    scene
}

fn materials() -> [Material; 4] {
    let base = Material {
        base_color: Vec3::new(1.0, 0.6, 0.2),
        ..Material::default()
    };
    [
        Material {
            name: "metal".into(),
            roughness: 0.4,
            ..base.clone()
        },
        Material {
            name: "rough metal".into(),
            roughness: 1.0,
            ..base.clone()
        },
        Material {
            name: "dielectric".into(),
            roughness: 0.35,
            metallic: 0.0,
            ..base.clone()
        },
        Material {
            name: "mixture".into(),
            roughness: 0.6,
            metallic: 0.3,
            specular: 0.7,
            specular_color: Vec3::new(0.5, 1.0, 2.0),
            ior: 2.2,
            ..base
        },
    ]
}

/// The shading normal by which a plate is shaded for a viewer in the direction `outgoing`: bent until it faces the viewer,
/// and then until the viewer's mirror direction leaves the plate.
fn bent(mut normal: DVec3, outgoing: DVec3) -> DVec3 {
    const LEAST: f64 = 0.01;
    let facing = normal.dot(outgoing);
    if facing < LEAST {
        normal = (normal + (LEAST - facing) * outgoing).normalize();
    }
    let toward_z = |part: f64| normal.lerp(DVec3::Z, part).normalize();
    let leaves = |n: DVec3| 2.0 * n.dot(outgoing) * n.z - outgoing.z >= LEAST.min(outgoing.z);
    if leaves(normal) {
        return normal;
    }
    let [mut low, mut high] = [0.0, 1.0];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if leaves(toward_z(middle)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    toward_z(high)
}

/// Comparisons of the plate's albedo, seen from `outgoing`, with the integral: with and without light sampling.
fn compare_albedo(material: &Material, normal: Option<Vec3>, outgoing: DVec3) -> Vec<Comparison> {
    let tracer = Tracer::new(&plate(material.clone(), normal));
    let shading = normal.map_or(DVec3::Z, |n| bent(n.as_dvec3().normalize(), outgoing));
    let wanted = albedo(material, shading, outgoing) * 2.0;
    let mut comparisons = Vec::new();
    // Off the diagonal, which is an edge.
    let camera = camera_at(DVec3::new(0.3, -0.2, 0.0), outgoing, 0.5);
    for (nee, samples) in [(true, 16384), (false, 4096)] {
        let options = Options {
            bounces: 1,
            samples,
            seed: 31,
            nee,
        };
        let image = tracer.render(&camera, 4, 4, &options);
        for channel in 0..3 {
            comparisons.push((
                format!(
                    "{} from {outgoing:.3}, nee {nee}, channel {channel}",
                    material.name
                ),
                mean_of(&image, channel),
                wanted[channel],
            ));
        }
    }
    comparisons
}

#[test]
fn the_surface_model_reflects_what_its_integral_says() {
    let mut comparisons = Vec::new();
    for material in materials() {
        for cosine in [0.95_f64, 0.5, 0.15] {
            let sine = (1.0 - cosine * cosine).sqrt();
            let outgoing = DVec3::new(0.6 * sine, 0.8 * sine, cosine);
            comparisons.extend(compare_albedo(&material, None, outgoing));
        }
    }
    assert_close(&comparisons, 0.01);
}

#[test]
fn shading_normals_bend_light_but_never_through_the_surface() {
    let normal = Vec3::new(0.5, -0.2, 0.7).normalize();
    let views = [
        // Its mirror direction leaves the plate.
        DVec3::new(0.3, 0.2, 0.9),
        // It goes into the plate.
        DVec3::new(0.1, 0.6, 0.3),
        // The shading normal looks away.
        DVec3::new(-0.9, 0.0, 0.2),
    ]
    .map(DVec3::normalize);
    let steps = views.map(|v| bent(normal.as_dvec3(), v).distance(normal.as_dvec3()));
    assert!(
        steps[0] == 0.0 && steps[1] > 0.05 && steps[2] > 0.5,
        "{steps:?}"
    );
    let mut comparisons = Vec::new();
    for material in materials() {
        for outgoing in views {
            comparisons.extend(compare_albedo(&material, Some(normal), outgoing));
        }
    }
    assert_close(&comparisons, 0.01);
}

#[test]
fn an_emitter_shines_from_its_front_however_it_is_placed() {
    let corner = Vec3::new(-1.0, -1.0, 0.0);
    let quad = support::quad(corner, Vec3::X * 2.0, Vec3::Y * 2.0);
    let mirrored = DAffine3::from_scale(DVec3::new(-1.5, 1.0, 1.0));
    let turned = DAffine3::from_rotation_x(PI);
    for (transform, double_sided, front, back) in [
        (DAffine3::IDENTITY, false, 3.0, 0.0),
        (DAffine3::IDENTITY, true, 3.0, 3.0),
        (mirrored, false, 3.0, 0.0),
        (turned, false, 0.0, 3.0),
        (turned * mirrored, false, 0.0, 3.0),
    ] {
        let mut scene =
            support::scene_of(&[(emitter(Vec3::splat(3.0), double_sided), quad.clone())]);
        scene.instances[0].object_to_world = transform;
        let tracer = Tracer::new(&scene);
        let options = Options {
            bounces: 0,
            samples: 1,
            seed: 1,
            nee: true,
        };
        for (toward_eye, wanted) in [(DVec3::Z, front), (-DVec3::Z, back)] {
            let camera = camera_at(DVec3::new(0.3, -0.2, 0.0), toward_eye, 2.0);
            let image = tracer.render(&camera, 1, 1, &options);
            assert_eq!(image.mean[0], [wanted; 3], "{transform}, {toward_eye}");
        }
    }
}

/// The standard errors that a picture states must match the spread over seeds, although the paths of a group are not
/// independent.
#[test]
fn stated_errors_are_those_that_seeds_show() {
    const SEEDS: u64 = 400;
    let material = Material {
        roughness: 0.5,
        metallic: 0.2,
        ..Material::default()
    };
    let floor = support::quad(Vec3::new(-8.0, 0.0, 8.0), Vec3::X * 16.0, -Vec3::Z * 16.0);
    let above = support::quad(Vec3::new(-1.0, 2.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
    let scene = support::scene_of(&[
        (material, floor),
        (
            Material::lambert("ceiling", Vec3::splat(0.7)),
            above.clone(),
        ),
        (
            emitter(Vec3::ONE, true),
            above.iter().map(|t| t.map(|c| c * 0.5)).collect(),
        ),
    ]);
    let tracer = Tracer::new(&scene);
    let camera = camera_at(DVec3::ZERO, DVec3::new(0.5, 0.6, 0.2).normalize(), 1.0);
    // Of odd numbers, groups have but one path.
    for samples in [512, 45] {
        let (mut means, mut stated) = (Vec::new(), 0.0);
        for seed in 0..SEEDS {
            let options = Options {
                bounces: 3,
                samples,
                seed,
                nee: true,
            };
            let image = tracer.render(&camera, 2, 2, &options);
            let estimate = mean_of(&image, 1);
            means.push(estimate.mean);
            stated += estimate.standard_error.powi(2) / SEEDS as f64;
        }
        let seen = Estimate::of(&means).standard_error.powi(2) * SEEDS as f64;
        // The ratio's own standard error is about √(2/400) = 0.07.
        let ratio = seen / stated;
        println!("{samples} samples: {seen:.3e} seen, {stated:.3e} stated");
        assert!((ratio - 1.0).abs() < 0.3, "{samples} samples: {ratio}");
    }
}

//! Tests of shader functions: the BSDF and its sampling, against the brute-force tracer in f64 and against its own density.

use crate::support::brute_force::{Surface, reflecting_outwards};
use crate::support::random::Random;
use crate::{Function, number, vector};
use glam::{DVec2, DVec3, Vec3};
use headwater::device_scene::gpu_material;
use headwater::metrics::statistics::{chi_square_p_value, holm};
use headwater::scene::Material;
use headwater::shader_interface::GpuMaterial;
use std::f64::consts::TAU;

const INCLUDES: &[&str] = &["bsdf/bsdf.glsl", "scene/geometry.glsl"];

/// Metals and dielectrics from smooth to rough, and one material between metal and dielectric.
fn materials() -> Vec<Material> {
    let mut all = Vec::new();
    for roughness in [0.05, 0.2, 0.5, 1.0] {
        for (metallic, base_color) in [
            (1.0, Vec3::new(0.9, 0.6, 0.3)),
            (0.0, Vec3::new(0.2, 0.7, 0.4)),
            (0.4, Vec3::new(0.8, 0.8, 0.1)),
        ] {
            all.push(Material {
                base_color,
                metallic,
                roughness,
                ..Material::default()
            });
        }
    }
    all.push(Material::lambert("matte", Vec3::splat(0.6)));
    all
}

fn gpu(all: &[Material]) -> Vec<GpuMaterial> {
    all.iter()
        .map(|material| gpu_material(material, 1.0))
        .collect()
}

fn upper(random: &mut Random) -> DVec3 {
    let d = random.direction();
    d.with_z(d.z.abs().max(1e-3)).normalize()
}

fn words(direction: Vec3, last: u32, rest: [u32; 4]) -> [u32; 8] {
    let [x, y, z] = direction.to_array().map(f32::to_bits);
    [x, y, z, last, rest[0], rest[1], rest[2], rest[3]]
}

/// Shading normals that lean as far as possible, seen from all sides and at grazing angles, must reflect the viewer to the
/// front.
#[test]
fn normals_reflect_their_viewer_off_the_surface() {
    let mut random = Random(8);
    let geometric = DVec3::new(0.36, -0.48, 0.8);
    let side_of = |d: DVec3| if d.dot(geometric) < 0.0 { -d } else { d };
    let pairs: Vec<(Vec3, Vec3)> = (0..20_000)
        .map(|_| {
            let mut viewer = side_of(random.direction());
            if random.unit() < 0.3 {
                viewer -= viewer.dot(geometric) * 0.999 * geometric;
            }
            let shading = side_of(random.direction()).as_vec3();
            (shading, -viewer.normalize().as_vec3())
        })
        // `face_viewer` has turned it towards the viewer before.
        .filter(|(shading, direction)| shading.dot(*direction) < -0.01)
        .collect();
    let function = Function {
        includes: &["scene/surface.glsl"],
        body: "x.xyz = floatBitsToUint(reflecting_outwards(uintBitsToFloat(a.xyz), vec3(0.36, -0.48, 0.8), uintBitsToFloat(b.xyz)));",
        ..Function::default()
    };
    let inputs: Vec<_> = (pairs.iter())
        .map(|(shading, direction)| {
            words(
                *shading,
                0,
                words(*direction, 0, [0; 4])[..4].try_into().unwrap(),
            )
        })
        .collect();
    let mut bent = 0;
    for ((shading, direction), output) in pairs.iter().zip(function.run(&inputs)) {
        let (shading, direction) = (shading.as_dvec3(), direction.as_dvec3());
        let expected = reflecting_outwards(shading, geometric, direction);
        let found = vector(&output);
        bent += usize::from(expected != shading);
        // Where the viewer sees the surface from its edge the condition is a small difference.
        assert!(
            (found - expected).length() < 2e-3,
            "{shading} {direction}: {found}, not {expected}"
        );
        let mirrored = direction - 2.0 * direction.dot(found) * found;
        assert!(
            mirrored.dot(geometric) > 0.0,
            "{shading} {direction}: {mirrored}"
        );
    }
    assert!(bent > pairs.len() / 10, "{bent}");
}

#[test]
fn surfaces_reflect_as_their_twins_do() {
    let all = materials();
    let mut random = Random(5);
    let cases: Vec<(usize, Vec3, Vec3)> = (0..20_000)
        .map(|_| {
            let outgoing = upper(&mut random).as_vec3();
            // Half of them near the mirror direction, where narrow lobes are.
            let mut incoming = upper(&mut random).as_vec3();
            if random.unit() < 0.5 {
                incoming = incoming * 0.1 + Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
            }
            (random.index(all.len()), outgoing, incoming.normalize())
        })
        .collect();
    let function = Function {
        includes: INCLUDES,
        body: "vec3 o = uintBitsToFloat(a.xyz); float pdf;
            vec3 f = evaluate_bsdf(make_bsdf(material_at(a.w), NO_LAYERS, o), o, uintBitsToFloat(b.xyz), pdf);
            x = floatBitsToUint(vec4(f, pdf));",
        materials: &gpu(&all),
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = cases
        .iter()
        .map(|(m, o, i)| {
            let [x, y, z] = i.to_array().map(f32::to_bits);
            words(*o, *m as u32, [x, y, z, 0])
        })
        .collect();
    for ((m, o, i), output) in cases.iter().zip(function.run(&inputs)) {
        let twin = Surface::new(&all[*m]).evaluate(o.as_dvec3(), i.as_dvec3());
        let gap = (vector(&output) - twin).abs().max_element();
        // A lobe of α = .0025 turns the directions' last digits into this much.
        assert!(
            gap <= 2e-3 * twin.max_element(),
            "{m} {o} {i}: {output:?} {twin}"
        );
    }
}

/// Draws of a surface's BSDF for one outgoing direction, each with direction, weight and density per solid angle; `None` for
/// a draw without direction.
fn sampled(material: &Material, outgoing: Vec3, count: u32) -> Vec<Option<(DVec3, DVec3, f64)>> {
    let materials = gpu(std::slice::from_ref(material));
    let function = Function {
        includes: &["core/random.glsl", "bsdf/bsdf.glsl", "scene/geometry.glsl"],
        body: "Random random = random_start(b.x, 9u, 4u); vec3 o = uintBitsToFloat(a.xyz);
            BsdfSample s = sample_bsdf(make_bsdf(material_at(0), NO_LAYERS, o), o, to_unit(random_bits(random)));
            x = uvec4(floatBitsToUint(s.direction), s.valid ? 1u : 0u);
            y = floatBitsToUint(vec4(s.weight, s.pdf_solid_angle));",
        materials: &materials,
        ..Function::default()
    };
    let inputs: Vec<[u32; 8]> = (0..count)
        .map(|i| words(outgoing, 0, [i, 0, 0, 0]))
        .collect();
    let draw = |o: [u32; 8]| (o[3] == 1).then(|| (vector(&o), vector(&o[4..]), number(o[7])));
    function.run(&inputs).into_iter().map(draw).collect()
}

#[test]
fn weights_are_reflectance_over_density() {
    const COUNT: u32 = 2000;
    let outgoing = Vec3::new(0.6, -0.2, 0.5).normalize();
    let mut densities_compared = 0;
    for material in materials() {
        let surface = Surface::new(&material);
        let draws: Vec<_> = sampled(&material, outgoing, COUNT)
            .into_iter()
            .flatten()
            .collect();
        // Only a rough lobe loses draws, below the horizon.
        let least = if material.roughness < 0.5 { 0.95 } else { 0.6 };
        assert!(
            draws.len() as f64 > least * f64::from(COUNT),
            "{material:?}: {} draws are valid",
            draws.len()
        );
        // The twin keeps more draws for the lesser lobe; elsewhere the densities are equal.
        let chance = surface.specular_probability(outgoing.as_dvec3());
        let same_density = chance == 0.0 || chance == 1.0 || (0.16..0.84).contains(&chance);
        densities_compared += u32::from(same_density);
        for (direction, weight, pdf) in draws {
            assert!((direction.length() - 1.0).abs() < 1e-5);
            let f = surface.evaluate(outgoing.as_dvec3(), direction);
            let expected = f * (direction.z / pdf);
            let gap = (weight - expected).abs().max_element();
            // In a lobe of α = .0025 the directions' last digits, 6e-8, are 2.4e-5 of its width. In
            // its tail the fourth power of that counts, in the reflectance and in the density, and
            // the half vector is made of two directions.
            assert!(
                gap <= 5e-3 * expected.max_element(),
                "{material:?} {direction}: {weight} {expected}"
            );
            let twin = surface.pdf_solid_angle(outgoing.as_dvec3(), direction);
            assert!(
                !same_density || (pdf - twin).abs() <= 5e-3 * twin,
                "{material:?} {direction}: {pdf} {twin}"
            );
        }
    }
    assert!(densities_compared >= 9, "{densities_compared}");
}

/// A map of incoming directions to the unit square, in which the directions of a lobe fill many bins of a histogram.
enum Chart {
    /// For wide lobes: cosine and azimuth of the direction.
    Hemisphere,
    /// For narrow lobes: the fraction of GGX whose half vectors are nearer to the normal, and the azimuth of the half
    /// vector.
    Lobe { outgoing: DVec3, alpha: f64 },
}

impl Chart {
    /// The fraction of a narrow lobe that lies inside the unit square; the tail lies outside.
    const INSIDE: f64 = 0.99;

    /// The coordinates of a direction in the chart, in [0, 1]; x is larger than 1 in the tail of a lobe.
    fn uv(&self, direction: DVec3) -> DVec2 {
        let azimuth = |d: DVec3| (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        match self {
            Self::Hemisphere => DVec2::new(direction.z, azimuth(direction)),
            Self::Lobe { outgoing, alpha } => {
                let half = *outgoing + direction;
                let slope = half.truncate().length_squared() / (alpha * half.z).powi(2);
                DVec2::new(slope / (1.0 + slope) / Self::INSIDE, azimuth(half))
            }
        }
    }

    /// The direction at a point of the unit square, and the solid angle per unit area of the square there.
    fn direction(&self, uv: DVec2) -> (DVec3, f64) {
        let (sin, cos) = (uv.y * TAU).sin_cos();
        match self {
            Self::Hemisphere => {
                let r = (1.0 - uv.x * uv.x).sqrt();
                (DVec3::new(r * cos, r * sin, uv.x), TAU)
            }
            Self::Lobe { outgoing, alpha } => {
                let fraction = uv.x * Self::INSIDE;
                let slope = alpha * (fraction / (1.0 - fraction)).sqrt();
                let half = DVec3::new(slope * cos, slope * sin, 1.0).normalize();
                let area = TAU * 0.5 * alpha * alpha * Self::INSIDE / (1.0 - fraction).powi(2);
                let along = outgoing.dot(half);
                let direction = half * (2.0 * along) - *outgoing;
                // Slopes to normals, and these to reflected directions.
                (direction, area * half.z.powi(3) * 4.0 * along.max(0.0))
            }
        }
    }
}

/// Sampled directions must be distributed as the density says. The density, and the fractions below the horizon and far from
/// a narrow lobe, must add up to 1.
#[test]
fn directions_are_drawn_by_their_density() {
    const RINGS: usize = 10;
    const SECTORS: usize = 12;
    const FINE: usize = 24;
    const COUNT: u32 = 60_000;
    let mut p_values = Vec::new();
    for material in materials() {
        for outgoing in [Vec3::Z, Vec3::new(0.8, 0.3, 0.3).normalize()] {
            // Narrow lobes would slip between the bins of a hemisphere.
            let chart = if material.roughness < 0.5 {
                Chart::Lobe {
                    outgoing: outgoing.as_dvec3(),
                    alpha: f64::from(material.roughness).powi(2),
                }
            } else {
                Chart::Hemisphere
            };
            let mut observed = vec![0_u64; RINGS * SECTORS + 1];
            for draw in sampled(&material, outgoing, COUNT) {
                let uv = draw.map(|(d, ..)| chart.uv(d)).filter(|p| p.x <= 1.0);
                let bin = uv.map_or(RINGS * SECTORS, |p| {
                    let ring = ((p.x * RINGS as f64) as usize).min(RINGS - 1);
                    ring * SECTORS + ((p.y * SECTORS as f64) as usize).min(SECTORS - 1)
                });
                observed[bin] += 1;
            }
            // The density by the shader, at the middles of many small cells.
            let cells: Vec<(DVec3, f64)> = (0..RINGS * FINE * SECTORS * FINE)
                .map(|cell| {
                    let (i, j) = (cell / (SECTORS * FINE), cell % (SECTORS * FINE));
                    let middle = DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
                    let size = DVec2::new((RINGS * FINE) as f64, (SECTORS * FINE) as f64);
                    chart.direction(middle / size)
                })
                .collect();
            let materials = gpu(std::slice::from_ref(&material));
            let function = Function {
                includes: INCLUDES,
                body: "vec3 o = uintBitsToFloat(a.xyz); float pdf;
                    evaluate_bsdf(make_bsdf(material_at(0), NO_LAYERS, o), o, uintBitsToFloat(b.xyz), pdf);
                    x.x = floatBitsToUint(pdf);",
                materials: &materials,
                ..Function::default()
            };
            let inputs: Vec<[u32; 8]> = cells
                .iter()
                .map(|(d, _)| {
                    let [x, y, z] = d.as_vec3().to_array().map(f32::to_bits);
                    words(outgoing, 0, [x, y, z, 0])
                })
                .collect();
            let mut expected = vec![0.0; RINGS * SECTORS + 1];
            let count_a_cell = f64::from(COUNT) / cells.len() as f64;
            for (cell, output) in function.run(&inputs).iter().enumerate() {
                let (i, j) = (cell / (SECTORS * FINE), cell % (SECTORS * FINE));
                expected[i / FINE * SECTORS + j / FINE] +=
                    number(output[0]) * cells[cell].1 * count_a_cell;
            }
            let inside: f64 = expected.iter().sum();
            let outside = f64::from(COUNT) - inside;
            assert!(
                outside > -2e-3 * f64::from(COUNT),
                "{material:?}: the density sums to {inside}"
            );
            expected[RINGS * SECTORS] = outside.max(0.0);
            if outside < 5.0 {
                // Rounding of the sum; nothing may fall there.
                expected[RINGS * SECTORS] = 1e-9;
            }
            p_values.push(chi_square_p_value(&observed, &expected));
        }
    }
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
}

//! Tests of light that goes through surfaces: the BSDF of glass against the formulas of KHR_materials_transmission and
//! KHR_materials_volume in f64, its energy, reciprocity, and the density of its directions.

use crate::support::random::Random;
use crate::{Function, number, vector};
use glam::{DVec3, Vec3};
use headwater::device_scene::gpu_material;
use headwater::metrics::statistics::{Estimate, chi_square_p_value, holm};
use headwater::scene::Material;
use headwater::shader_interface::{GpuMaterial, Specialisation};
use std::f64::consts::{PI, TAU};

/// A surface of glass, seen from one of its sides.
#[derive(Clone, Copy, Debug)]
struct Glass {
    roughness: f32,
    /// Index of refraction of the substance.
    ior: f32,
    /// Fraction of the light below the specular lobe that goes through.
    transmission: f32,
    /// `None` for a thin sheet; for a volume, true if the viewer is inside.
    inside: Option<bool>,
}

const COLOR: Vec3 = Vec3::new(0.9, 0.7, 0.4);

impl Glass {
    const fn new(roughness: f32, ior: f32, inside: Option<bool>) -> Self {
        Self {
            roughness,
            ior,
            transmission: 1.0,
            inside,
        }
    }

    fn material(&self, color: Vec3) -> GpuMaterial {
        let material = Material {
            base_color: color,
            metallic: 0.0,
            roughness: self.roughness,
            ior: self.ior,
            ..Material::default()
        };
        gpu_material(&material, 1.0)
    }

    /// Index of refraction beyond the surface, relative to the viewer's side; 1 for a sheet.
    fn index(&self) -> f64 {
        let ior = f64::from(self.ior);
        match self.inside {
            None => 1.0,
            Some(false) => ior,
            Some(true) => ior.recip(),
        }
    }

    /// Reflectance at a microfacet: Schlick's for a sheet, as in glTF; Fresnel's for the boundary of a volume.
    fn fresnel(&self, cosine: f64) -> f64 {
        let ior = f64::from(self.ior);
        if self.inside.is_none() {
            let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
            return f0 + (1.0 - f0) * (1.0 - cosine).powi(5);
        }
        // By the angles: Fresnel's equations as sines and tangents of sum and difference.
        let angle = cosine.min(1.0).acos();
        let sine = angle.sin() / self.index();
        if sine >= 1.0 {
            return 1.0;
        }
        let beyond = sine.asin();
        if angle < 1e-4 {
            return ((ior - 1.0) / (ior + 1.0)).powi(2);
        }
        let across = (angle - beyond).sin() / (angle + beyond).sin();
        let along = (angle - beyond).tan() / (angle + beyond).tan();
        0.5 * (across * across + along * along)
    }

    /// f of light that arrives from `i` and leaves towards `o`.
    fn evaluate(&self, o: DVec3, i: DVec3) -> DVec3 {
        let color = COLOR.as_dvec3();
        let alpha = f64::from(self.roughness).powi(2);
        let transmission = f64::from(self.transmission);
        let distribution = |h: DVec3| {
            let cosine2 = h.z * h.z;
            alpha * alpha / (PI * (cosine2 * (alpha * alpha - 1.0) + 1.0).powi(2))
        };
        let lambda = |d: DVec3| {
            let tangent2 = (1.0 - d.z * d.z) / (d.z * d.z);
            0.5 * ((1.0 + alpha * alpha * tangent2).sqrt() - 1.0)
        };
        let masking = 1.0 / (1.0 + lambda(o) + lambda(i));
        if i.z > 0.0 {
            let h = (o + i).normalize();
            let fresnel = self.fresnel(o.dot(h));
            let specular = fresnel * distribution(h) * masking / (4.0 * o.z * i.z);
            return specular + color * ((1.0 - transmission) * (1.0 - fresnel) / PI);
        }
        let index = self.index();
        let mirrored = i.with_z(-i.z);
        let (h, spread) = if index == 1.0 {
            let h = (o + mirrored).normalize();
            (h, 1.0 / (4.0 * o.z * -i.z))
        } else {
            let h = (o + index * i).normalize();
            let h = h * h.z.signum();
            let (along_o, along_i) = (o.dot(h), i.dot(h));
            if along_o <= 0.0 || along_i >= 0.0 {
                return DVec3::ZERO;
            }
            // Walter et al. 2007, equation 21, with the squared index of radiance.
            let spread =
                (along_o * along_i / (o.z * i.z)).abs() / (along_o + index * along_i).powi(2);
            (h, spread)
        };
        let passes = transmission * (1.0 - self.fresnel(o.dot(h)));
        color * (passes * distribution(h) * masking * spread)
    }

    /// A GLSL value of `Layers`.
    fn layers(&self) -> String {
        format!(
            "glass_layers({:?}, {:?}, {}, {})",
            self.transmission,
            self.ior,
            self.inside.is_some(),
            self.inside == Some(true)
        )
    }
}

/// Runs `body` on a glass of one colour: `bsdf` is its BSDF for the outgoing direction `o`, and `u` has random numbers.
fn run(
    glass: Glass,
    color: Vec3,
    inputs: &[[u32; 8]],
    body: &str,
    changes: &[(&str, &str, &str)],
) -> Vec<[u32; 8]> {
    let body = format!(
        "vec3 o = uintBitsToFloat(a.xyz); Bsdf bsdf = make_bsdf(material_at(0), {}, o);
         Random random = random_start(a.w, 7u, 5u); vec4 u = to_unit(random_bits(random)); {body}",
        glass.layers()
    );
    let constants = Specialisation {
        has_transmission: true,
        ..Specialisation::default()
    };
    let function = Function {
        includes: &["core/random.glsl", "bsdf/bsdf.glsl", "scene/geometry.glsl"],
        body: &body,
        globals: "Layers glass_layers(float transmission, float ior, bool has_volume, bool inside) {
            Layers layers = NO_LAYERS;
            layers.transmission = transmission; layers.ior = ior; layers.has_volume = has_volume; layers.inside = inside;
            return layers;
        }",
        materials: &[glass.material(color)],
        changes,
        constants: &constants.words(),
        ..Function::default()
    };
    function.run(inputs)
}

fn words(o: Vec3, number: u32, i: Vec3) -> [u32; 8] {
    let ([a, b, c], [d, e, f]) = (
        o.to_array().map(f32::to_bits),
        i.to_array().map(f32::to_bits),
    );
    [a, b, c, number, d, e, f, 0]
}

/// Sheets and volumes, smooth to rough, from outside and inside; one of them is partly diffuse.
fn all() -> Vec<Glass> {
    let mut all = Vec::new();
    for roughness in [0.1, 0.4, 1.0] {
        for inside in [None, Some(false), Some(true)] {
            all.push(Glass::new(roughness, 1.5, inside));
        }
    }
    all.push(Glass::new(0.3, 2.4, Some(false)));
    all.push(Glass::new(0.3, 1.1, Some(true)));
    all.push(Glass {
        transmission: 0.4,
        ..Glass::new(0.5, 1.33, Some(false))
    });
    all
}

fn upper(random: &mut Random) -> DVec3 {
    let d = random.direction();
    d.with_z(d.z.abs().max(0.02)).normalize()
}

/// The directions that a microfacet with the normal h reflects and refracts `o` into; the second is `None` if the reflection
/// is total.
fn from_facet(o: DVec3, h: DVec3, index: f64) -> (DVec3, Option<DVec3>) {
    let cosine = o.dot(h);
    let sine2 = (1.0 - cosine * cosine) / (index * index);
    let reflected = 2.0 * cosine * h - o;
    let through = (sine2 < 1.0).then(|| (cosine * h - o) / index - (1.0 - sine2).sqrt() * h);
    (reflected, through)
}

/// Pairs of outgoing and incoming directions, many of them near where the lobes are.
fn pairs(glass: &Glass, random: &mut Random, count: usize) -> Vec<(DVec3, DVec3)> {
    let mut found = Vec::new();
    while found.len() < count {
        let o = upper(random);
        let mut i = random.direction();
        if random.unit() < 0.7 {
            let wide = f64::from(glass.roughness);
            let h = (DVec3::Z + wide * random.unit() * random.direction()).normalize();
            let (reflected, through) = from_facet(o, h, glass.index());
            i = if random.unit() < 0.3 {
                reflected
            } else {
                through.unwrap_or(reflected)
            };
            if glass.inside.is_none() && random.unit() < 0.7 {
                i = reflected.with_z(-reflected.z);
            }
        }
        // As the shader gets them.
        let (o, i) = (o.as_vec3().as_dvec3(), i.as_vec3().as_dvec3());
        let index = glass.index();
        let h = match i.z < 0.0 && index != 1.0 {
            true => (o + index * i).normalize(),
            false => DVec3::Z,
        };
        // At the critical angle Fresnel's term turns the last digits of directions into percents.
        if i.z.abs() > 0.02 && i.dot(h).abs() > 0.1 && o.dot(h).abs() > 0.1 {
            found.push((o, i));
        }
    }
    found
}

const EVALUATE: &str = "float pdf; vec3 f = evaluate_bsdf(bsdf, o, uintBitsToFloat(b.xyz), pdf);
    x = floatBitsToUint(vec4(f, pdf));";

#[test]
fn glass_is_seen_as_its_twin() {
    let mut random = Random(21);
    for glass in all() {
        let pairs = pairs(&glass, &mut random, 4000);
        let inputs: Vec<_> = pairs
            .iter()
            .map(|(o, i)| words(o.as_vec3(), 0, i.as_vec3()))
            .collect();
        let mut through = 0;
        for ((o, i), output) in pairs.iter().zip(run(glass, COLOR, &inputs, EVALUATE, &[])) {
            let (twin, found) = (glass.evaluate(*o, *i), vector(&output));
            through += u32::from(i.z < 0.0 && twin.max_element() > 0.0);
            // The lobes of α = 0.01 turn the directions' last digits into this much.
            let gap = (found - twin).abs().max_element();
            assert!(
                gap <= 2e-3 * twin.max_element() + 1e-6,
                "{glass:?} {o} {i}: {found}, not {twin}"
            );
        }
        assert!(through > 500, "{glass:?}: {through}");
    }
}

/// Reflections at the largest index that validation permits equal the twin; with far larger ones, Fresnel's term is 0/0.
#[test]
fn the_largest_index_of_refraction_reflects_as_its_twin() {
    let mut random = Random(27);
    let mut is_right = |ior, inside| {
        let glass = Glass::new(0.5, ior, Some(inside));
        let pairs: Vec<_> = (0..1000)
            .map(|_| (upper(&mut random).as_vec3(), upper(&mut random).as_vec3()))
            .collect();
        let inputs: Vec<_> = pairs.iter().map(|&(o, i)| words(o, 0, i)).collect();
        let found = run(glass, COLOR, &inputs, EVALUATE, &[]);
        pairs.iter().zip(found).all(|((o, i), output)| {
            let twin = glass.evaluate(o.as_dvec3(), i.as_dvec3());
            let gap = (vector(&output) - twin).abs();
            gap.cmple(2e-3 * twin + 1e-6).all()
        })
    };
    for inside in [false, true] {
        assert!(is_right(1e4, inside));
        assert!(!is_right(1e9, inside));
    }
}

/// Light takes the same way back: f times the squared index of the other side is symmetric.
#[test]
fn light_through_glass_takes_the_same_way_back() {
    let mut random = Random(22);
    for glass in all().into_iter().filter(|glass| glass.inside != Some(true)) {
        let pairs: Vec<_> = pairs(&glass, &mut random, 4000)
            .into_iter()
            .filter(|(_, i)| i.z < 0.0)
            .collect();
        let there: Vec<_> = pairs
            .iter()
            .map(|(o, i)| words(o.as_vec3(), 0, i.as_vec3()))
            .collect();
        // Seen from the other side, the surface is turned around.
        let back: Vec<_> = pairs
            .iter()
            .map(|(o, i)| words(-i.as_vec3(), 0, -o.as_vec3()))
            .collect();
        let turned = Glass {
            inside: glass.inside.map(|_| true),
            ..glass
        };
        let (there, back) = (
            run(glass, COLOR, &there, EVALUATE, &[]),
            run(turned, COLOR, &back, EVALUATE, &[]),
        );
        for ((pair, a), b) in pairs.iter().zip(there).zip(back) {
            let (a, b) = (vector(&a) * glass.index().powi(2), vector(&b));
            let gap = (a - b).abs().max_element();
            assert!(
                gap <= 3e-3 * a.max_element() + 1e-6,
                "{glass:?} {pair:?}: {a} {b}"
            );
        }
    }
}

const SAMPLE: &str = "BsdfSample s = sample_bsdf(bsdf, o, u);
    x = uvec4(floatBitsToUint(s.direction), (s.valid ? 1u : 0u) | (s.delta ? 2u : 0u));
    y = floatBitsToUint(vec4(s.weight, s.pdf_solid_angle));";

/// The light that white glass sends to the viewer in a room of uniform light: light that comes through grows with the squared
/// index, which is divided out. Returns mean and standard error.
fn furnace(glass: Glass, outgoing: Vec3, changes: &[(&str, &str, &str)]) -> Estimate {
    let inputs: Vec<_> = (0..1 << 16).map(|n| words(outgoing, n, Vec3::Z)).collect();
    let draws = run(glass, Vec3::ONE, &inputs, SAMPLE, changes);
    let light: Vec<f64> = (draws.iter())
        .map(|o| {
            let through = number(o[2]) < 0.0;
            let weight = if o[3] & 1 == 1 {
                vector(&o[4..]).y
            } else {
                0.0
            };
            weight * if through { glass.index().powi(2) } else { 1.0 }
        })
        .collect();
    Estimate::of(&light)
}

#[test]
fn smooth_glass_keeps_all_light_and_rough_glass_gains_none() {
    let directions = [
        Vec3::Z,
        Vec3::new(0.6, 0.0, 0.8),
        Vec3::new(0.95, 0.0, 0.2).normalize(),
    ];
    for inside in [None, Some(false), Some(true)] {
        for ior in [1.0, 1.5, 2.4] {
            for outgoing in directions {
                let smooth = furnace(Glass::new(0.0, ior, inside), outgoing, &[]);
                let gap = (smooth.mean - 1.0).abs();
                assert!(
                    gap <= 4.0 * smooth.standard_error + 1e-5,
                    "{inside:?} {ior} {outgoing}: {smooth:?}"
                );
                for roughness in [0.1, 0.5, 1.0] {
                    let rough = furnace(Glass::new(roughness, ior, inside), outgoing, &[]);
                    assert!(
                        rough.mean <= 1.0 + 4.0 * rough.standard_error + 1e-5,
                        "{inside:?} {ior} {roughness} {outgoing}: {rough:?}"
                    );
                    // Single scattering loses some at rough surfaces.
                    let least = if roughness < 0.2 { 0.95 } else { 0.25 };
                    let has_most = outgoing.z < 0.5 || rough.mean > least;
                    assert!(
                        has_most,
                        "{inside:?} {ior} {roughness} {outgoing}: {rough:?}"
                    );
                }
            }
        }
    }
}

/// Radiance grows with the squared index of its medium; without it, glass would be too bright from outside.
#[test]
fn a_missing_squared_index_is_found() {
    let changes = [
        (
            "bsdf/transmission.glsl",
            "lobe.color * (below / square(lobe.index))",
            "lobe.color * below",
        ),
        (
            "bsdf/transmission.glsl",
            "squared_index = square(lobe.index)",
            "squared_index = 1.0",
        ),
    ];
    for roughness in [0.0, 0.1] {
        let found = furnace(Glass::new(roughness, 1.5, Some(false)), Vec3::Z, &changes);
        assert!(found.mean > 1.5, "{found:?}");
    }
}

/// Directions must be distributed as the density says, above and below the surface; draws without a direction are the rest.
fn chi_square(glass: Glass, outgoing: Vec3, changes: &[(&str, &str, &str)]) -> f64 {
    const RINGS: usize = 24;
    const SECTORS: usize = 12;
    const FINE: usize = 16;
    const COUNT: u32 = 60_000;
    let bin_of = |d: DVec3| {
        // Rings of equal angle, because lobes are narrow around the normal.
        let ring = ((d.z.clamp(-1.0, 1.0).acos() / PI * RINGS as f64) as usize).min(RINGS - 1);
        let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        ring * SECTORS + ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
    };
    let inputs: Vec<_> = (0..COUNT).map(|n| words(outgoing, n, Vec3::Z)).collect();
    let mut observed = vec![0_u64; RINGS * SECTORS + 1];
    for draw in run(glass, COLOR, &inputs, SAMPLE, changes) {
        let valid = draw[3] & 1 == 1;
        observed[if valid {
            bin_of(vector(&draw))
        } else {
            RINGS * SECTORS
        }] += 1;
    }
    let mut cells = Vec::new();
    for ring in 0..RINGS * FINE {
        for sector in 0..SECTORS * FINE {
            let (r, z) = ((ring as f64 + 0.5) / (RINGS * FINE) as f64 * PI).sin_cos();
            let (sin, cos) = ((sector as f64 + 0.5) / (SECTORS * FINE) as f64 * TAU).sin_cos();
            cells.push((DVec3::new(r * cos, r * sin, z), r * PI * TAU));
        }
    }
    let inputs: Vec<_> = cells
        .iter()
        .map(|(d, _)| words(outgoing, 0, d.as_vec3()))
        .collect();
    let mut expected = vec![0.0; RINGS * SECTORS + 1];
    for ((cell, area), output) in cells
        .iter()
        .zip(run(glass, COLOR, &inputs, EVALUATE, changes))
    {
        expected[bin_of(*cell)] += number(output[3]) * area / cells.len() as f64 * f64::from(COUNT);
    }
    let outside = f64::from(COUNT) - expected.iter().sum::<f64>();
    if outside < -2e-3 * f64::from(COUNT) {
        // The density adds up to more than 1.
        return 0.0;
    }
    expected[RINGS * SECTORS] = if outside < 5.0 { 1e-9 } else { outside };
    chi_square_p_value(&observed, &expected)
}

#[test]
fn directions_through_glass_are_drawn_by_their_density() {
    let mut p_values = Vec::new();
    for glass in all().into_iter().filter(|glass| glass.roughness >= 0.4) {
        for outgoing in [
            Vec3::new(0.0, 0.1, 1.0).normalize(),
            Vec3::new(0.7, 0.3, 0.4).normalize(),
        ] {
            p_values.push(chi_square(glass, outgoing, &[]));
        }
    }
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
    // Without the part of the half vector's Jacobian that belongs to the far side.
    let fault = [(
        "bsdf/transmission.glsl",
        "cosine_out * -cosine_in *",
        "cosine_out *",
    )];
    let glass = Glass::new(0.4, 1.5, Some(false));
    assert!(chi_square(glass, Vec3::new(0.7, 0.3, 0.4).normalize(), &fault) < 1e-6);
}

/// The weights of draws must be f · cosine / density, also where a lobe is narrow.
#[test]
fn weights_through_glass_are_f_over_density() {
    let outgoing = Vec3::new(0.6, -0.2, 0.5).normalize();
    for glass in all() {
        let inputs: Vec<_> = (0..4000).map(|n| words(outgoing, n, Vec3::Z)).collect();
        let draws = run(glass, COLOR, &inputs, SAMPLE, &[]);
        let valid: Vec<_> = draws.iter().filter(|o| o[3] & 1 == 1).collect();
        assert!(valid.len() > 2000, "{glass:?}: {}", valid.len());
        for o in valid {
            let (direction, weight, pdf) = (vector(o), vector(&o[4..]), number(o[7]));
            assert!((direction.length() - 1.0).abs() < 1e-5);
            let expected =
                glass.evaluate(outgoing.as_dvec3(), direction) * (direction.z.abs() / pdf);
            let gap = (weight - expected).abs().max_element();
            assert!(
                gap <= 1e-2 * expected.max_element(),
                "{glass:?} {direction}: {weight} {expected}"
            );
        }
    }
}

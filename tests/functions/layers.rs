//! Tests of the clear coat and of anisotropic lobes: values against the formulas of `KHR_materials_clearcoat` and
//! `KHR_materials_anisotropy` in f64, energy, reciprocity, and samples against their density.

use crate::support::brute_force::Surface;
use crate::support::random::Random;
use crate::{Function, number, vector};
use glam::{DVec2, DVec3, Vec3};
use headwater::device_scene::gpu_material;
use headwater::metrics::statistics::{Estimate, chi_square_p_value, holm};
use headwater::scene::Material;
use headwater::shader_interface::Specialisation;
use std::f64::consts::{PI, TAU};

/// A change of the shaders that plants a fault: (file, text in it, replacement).
type Fault = (&'static str, &'static str, &'static str);

/// A coat that forgets that the surface below receives less light.
const FORGETFUL_COAT: Fault = (
    "bsdf/coat.glsl",
    "return HAS_COAT ? 1.0 - lobe.reflectance : 1.0;",
    "return 1.0;",
);

/// The widths of an anisotropic lobe exchanged in the density of its samples only.
const EXCHANGED_WIDTHS: Fault = (
    "bsdf/specular.glsl",
    "pdf_solid_angle += probability * common_factor / (1.0 + lambda_out);",
    "pdf_solid_angle += probability * ggx_distribution(h, lobe.widths.yx) / (4.0 * outgoing.z)
        / (1.0 + smith_lambda(outgoing, lobe.widths.yx));",
);

/// A surface with layers, and the direction to its viewer in the shading frame.
#[derive(Clone, Debug)]
struct Case {
    material: Material,
    coat: f64,
    coat_roughness: f64,
    coat_normal: DVec3,
    anisotropy: f64,
    compensated: bool,
    outgoing: Vec3,
}

impl Case {
    /// A surface without layers, of the material `material`.
    fn plain(material: Material, outgoing: DVec3) -> Self {
        Self {
            material,
            coat: 0.0,
            coat_roughness: 0.0,
            coat_normal: DVec3::Z,
            anisotropy: 0.0,
            compensated: false,
            outgoing: outgoing.as_vec3(),
        }
    }

    /// Runs the GLSL `body` for each of the vectors `rest`, which are in `b.xyz`; `a.w` is the index of the input, `o` the
    /// outgoing direction, and `bsdf` the BSDF.
    fn run(&self, body: &str, rest: &[Vec3], fault: Option<Fault>) -> Vec<[u32; 8]> {
        let normal = self.coat_normal;
        let body = format!(
            "vec3 o = uintBitsToFloat(a.xyz), i = uintBitsToFloat(b.xyz); Layers layers = NO_LAYERS;
             layers.coat = {:?}; layers.coat_roughness = {:?}; layers.anisotropy = {:?};
             layers.coat_normal = vec3({:?}, {:?}, {:?});
             Bsdf bsdf = make_bsdf(material_at(0), layers, o); {body}",
            self.coat as f32,
            self.coat_roughness as f32,
            self.anisotropy as f32,
            normal.x as f32,
            normal.y as f32,
            normal.z as f32,
        );
        let constants = Specialisation {
            has_coat: true,
            has_normal_maps: true,
            surfaces_named: true,
            has_anisotropy: true,
            energy_compensated: self.compensated,
            ..Specialisation::default()
        };
        let function = Function {
            includes: &["core/random.glsl", "bsdf/bsdf.glsl", "scene/geometry.glsl"],
            body: &body,
            materials: &[gpu_material(&self.material, 1.0)],
            constants: &constants.words(),
            fault,
            ..Function::default()
        };
        let [x, y, z] = self.outgoing.to_array().map(f32::to_bits);
        let inputs: Vec<[u32; 8]> = (0_u32..)
            .zip(rest)
            .map(|(index, direction)| {
                let [u, v, w] = direction.to_array().map(f32::to_bits);
                [x, y, z, index, u, v, w, 0]
            })
            .collect();
        function.run(&inputs)
    }

    /// The BSDF, and the density of sampling, for each incoming direction.
    fn evaluate(&self, incoming: &[Vec3], fault: Option<Fault>) -> Vec<(DVec3, f64)> {
        let body = "float pdf; vec3 f = evaluate_bsdf(bsdf, o, i, pdf);
            x = floatBitsToUint(vec4(f, pdf));";
        let outputs = self.run(body, incoming, fault).into_iter();
        outputs.map(|o| (vector(&o), number(o[3]))).collect()
    }

    /// `count` draws: direction and weight; `None` for a draw without a direction.
    fn sample(&self, count: usize, fault: Option<Fault>) -> Vec<Option<(DVec3, DVec3)>> {
        let body = "Random random = random_start(a.w, 9u, 4u);
            BsdfSample s = sample_bsdf(bsdf, o, to_unit(random_bits(random)));
            x = uvec4(floatBitsToUint(s.direction), s.valid ? 1u : 0u);
            y.xyz = floatBitsToUint(s.weight);";
        let outputs = self.run(body, &vec![Vec3::ZERO; count], fault).into_iter();
        let draw = |o: [u32; 8]| (o[3] == 1).then(|| (vector(&o), vector(&o[4..])));
        outputs.map(draw).collect()
    }

    /// The BSDF by the formulas of the extensions, with the coat's Fresnel term of the cosine N · V.
    fn twin(&self, incoming: DVec3) -> DVec3 {
        let outgoing = self.outgoing.as_dvec3().normalize();
        let base = match self.anisotropy > 0.0 {
            true => self.anisotropic_metal(outgoing, incoming),
            false => Surface::new(&self.material).evaluate(outgoing, incoming),
        };
        let fresnel = self.coat_fresnel(outgoing);
        let normal = self.coat_normal;
        let (out, into) = (outgoing.dot(normal), incoming.dot(normal));
        let half = (outgoing + incoming).normalize();
        let alpha2 = self.coat_roughness.powi(4);
        let d = half.dot(normal).powi(2) * (alpha2 - 1.0) + 1.0;
        let masked = |cosine: f64| (alpha2 + (1.0 - alpha2) * cosine * cosine).sqrt();
        let v = 0.5 / (into * masked(out) + out * masked(into));
        let coat = match into > 0.0 {
            true => alpha2 / (PI * d * d) * v * into / incoming.z,
            false => 0.0,
        };
        base * (1.0 - fresnel) + DVec3::splat(fresnel * coat)
    }

    fn coat_fresnel(&self, outgoing: DVec3) -> f64 {
        let cosine = outgoing.normalize().dot(self.coat_normal);
        self.coat * (0.04 + 0.96 * (1.0 - cosine).powi(5))
    }

    /// Metal with the anisotropic GGX lobe of the extension.
    fn anisotropic_metal(&self, outgoing: DVec3, incoming: DVec3) -> DVec3 {
        let ab = f64::from(self.material.roughness).powi(2);
        let at = ab + (1.0 - ab) * self.anisotropy.powi(2);
        let half = (outgoing + incoming).normalize();
        let a2 = at * ab;
        let f = DVec3::new(ab * half.x, at * half.y, a2 * half.z);
        let w2 = a2 / f.length_squared();
        let d = a2 * w2 * w2 / PI;
        let length = |v: DVec3| DVec3::new(at * v.x, ab * v.y, v.z).length();
        let v = 0.5 / (incoming.z * length(outgoing) + outgoing.z * length(incoming));
        let color = self.material.base_color.as_dvec3();
        let grazing = (1.0 - outgoing.dot(half)).powi(5);
        (color + (1.0 - color) * grazing) * (d * v)
    }
}

fn upper(random: &mut Random) -> DVec3 {
    let direction = random.direction();
    direction.with_z(direction.z.abs().max(0.02)).normalize()
}

fn metal(color: Vec3, roughness: f32) -> Material {
    Material {
        base_color: color,
        roughness,
        ..Material::default()
    }
}

/// Coats of several widths, strengths and normals above several surfaces, and anisotropic metal; with random viewers.
fn cases(random: &mut Random) -> Vec<Case> {
    let gold = Vec3::new(0.9, 0.6, 0.3);
    let paint = Material {
        metallic: 0.0,
        ..metal(Vec3::new(0.5, 0.1, 0.1), 0.5)
    };
    let mut all = Vec::new();
    for (coat, coat_roughness) in [(1.0, 0.2), (0.4, 0.6), (1.0, 1.0)] {
        for material in [&paint, &metal(gold, 0.4), &Material::lambert("", gold)] {
            for tilt in [0.0, 0.5] {
                all.push(Case {
                    coat,
                    coat_roughness,
                    coat_normal: DVec3::new(tilt, -0.3 * tilt, 1.0).normalize(),
                    ..Case::plain(material.clone(), upper(random))
                });
            }
        }
    }
    for (roughness, anisotropy) in [(0.25, 0.3), (0.4, 0.8), (0.7, 0.5), (0.3, 1.0)] {
        for _ in 0..3 {
            all.push(Case {
                anisotropy,
                ..Case::plain(metal(gold, roughness), upper(random))
            });
        }
    }
    // A viewer behind the coat's normal sees no coat; shading normals are bent so that there is none.
    all.retain(|case| case.outgoing.as_dvec3().dot(case.coat_normal) > 0.05);
    assert!(all.len() > 20, "{}", all.len());
    all
}

#[test]
fn coats_and_anisotropic_metal_reflect_as_their_formulas_say() {
    let mut random = Random(6);
    for case in cases(&mut random) {
        let outgoing = case.outgoing;
        let mirrored = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
        let incoming: Vec<Vec3> = (0..500)
            .map(|k| {
                let any = upper(&mut random).as_vec3();
                let near = if k % 2 == 0 { 0.0 } else { 3.0 };
                (any + mirrored * near).normalize()
            })
            .collect();
        for (direction, (f, _)) in incoming.iter().zip(case.evaluate(&incoming, None)) {
            let twin = case.twin(direction.as_dvec3());
            let gap = (f - twin).abs().max_element();
            assert!(
                gap <= 1e-3 * twin.max_element() + 1e-7,
                "{case:?} {direction}: {f}, not {twin}"
            );
        }
    }
}

/// Light and viewer may be exchanged: of anisotropic metal in all, and of a coat up to its Fresnel term, which belongs to the
/// viewer's cosine.
#[test]
fn lobes_are_reciprocal() {
    let mut random = Random(16);
    let black = Material::lambert("", Vec3::ZERO);
    for case in cases(&mut random) {
        let is_coat = case.coat > 0.0;
        let case = match is_coat {
            true => Case {
                material: black.clone(),
                ..case
            },
            false => case,
        };
        let others = (0..40).map(|_| upper(&mut random));
        let others = others.filter(|other| other.dot(case.coat_normal) > 0.05);
        let others: Vec<Vec3> = others.map(|other| other.as_vec3()).collect();
        let body = "float pdf; x.xyz = floatBitsToUint(evaluate_bsdf(bsdf, o, i, pdf));
            y.xyz = floatBitsToUint(evaluate_bsdf(make_bsdf(material_at(0), layers, i), i, o, pdf));";
        // A coat counts light by its own cosine instead of that of the surface.
        let scale = |from: Vec3, to: Vec3| {
            let (from, to) = (from.as_dvec3(), to.as_dvec3());
            match is_coat {
                true => to.z / to.dot(case.coat_normal) / case.coat_fresnel(from),
                false => 1.0,
            }
        };
        for (other, output) in others.iter().zip(case.run(body, &others, None)) {
            let there = vector(&output).x * scale(case.outgoing, *other);
            let back = vector(&output[4..]).x * scale(*other, case.outgoing);
            assert!(
                (there - back).abs() <= 2e-3 * there.max(back) + 1e-7,
                "{case:?} {other}: {there} {back}"
            );
        }
    }
}

/// The albedo of white metal of the roughness 0.3 under coats, and of anisotropic white metal: the mean weight of draws.
fn albedos(fault: Option<Fault>) -> Vec<(Case, Estimate)> {
    let mut all = Vec::new();
    for cosine in [0.1, 0.4, 0.95_f64] {
        let sine = (1.0 - cosine * cosine).sqrt();
        for (coat_roughness, anisotropy) in
            [(0.0, 0.0), (0.1, 0.0), (0.5, 0.0), (1.0, 0.0), (0.0, 0.8)]
        {
            for azimuth in [0.0, 0.25 * TAU] {
                let outgoing = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
                let case = Case {
                    coat: if anisotropy > 0.0 { 0.0 } else { 1.0 },
                    coat_roughness,
                    anisotropy,
                    compensated: true,
                    ..Case::plain(metal(Vec3::ONE, 0.3), outgoing)
                };
                let draws = case.sample(40_000, fault).into_iter();
                let weights: Vec<f64> = draws.map(|d| d.map_or(0.0, |(_, w)| w.x)).collect();
                all.push((case, Estimate::of(&weights)));
            }
        }
    }
    all
}

/// A coated white surface in a uniform room never shines. Under a smooth coat it reflects all light; a rough coat loses what
/// only several scatterings would reflect.
#[test]
fn coats_gain_no_energy() {
    for (case, albedo) in albedos(None) {
        let (mean, error) = (albedo.mean, 4.0 * albedo.standard_error);
        println!(
            "coat roughness {} anisotropy {} to {}: {mean:.4} ± {error:.4}",
            case.coat_roughness, case.anisotropy, case.outgoing
        );
        assert!(error < 0.02, "{case:?}: ± {error}");
        if case.anisotropy > 0.0 {
            // Compensation knows an isotropic lobe of about the same albedo.
            let least = if case.outgoing.z < 0.2 { 0.7 } else { 0.94 };
            assert!((least..1.06).contains(&mean), "{case:?}: {mean}");
            continue;
        }
        assert!(mean <= 1.0 + 0.006 + error, "{case:?}: {mean} ± {error}");
        if case.coat_roughness <= 0.1 {
            assert!(mean >= 1.0 - 0.006 - error, "{case:?}: {mean} ± {error}");
        }
    }
    let gains = albedos(Some(FORGETFUL_COAT)).into_iter();
    let gains = gains.filter(|(case, _)| case.coat > 0.0);
    let found = gains.filter(|(_, albedo)| albedo.mean > 1.006 + 4.0 * albedo.standard_error);
    assert!(found.count() >= 12);
}

/// The probability of a histogram of draws at least as far from the density that the shader states, if both agree.
fn p_value(case: &Case, fault: Option<Fault>) -> f64 {
    const RINGS: usize = 10;
    const SECTORS: usize = 12;
    const FINE: usize = 20;
    const COUNT: usize = 60_000;
    let bin = |cosine: f64, turn: f64| {
        let ring = ((cosine * RINGS as f64) as usize).min(RINGS - 1);
        ring * SECTORS + ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
    };
    let mut observed = vec![0_u64; RINGS * SECTORS + 1];
    for draw in case.sample(COUNT, fault) {
        let place = draw.map(|(d, _)| bin(d.z, (d.y.atan2(d.x) / TAU).rem_euclid(1.0)));
        observed[place.unwrap_or(RINGS * SECTORS)] += 1;
    }
    let (rows, columns) = (RINGS * FINE, SECTORS * FINE);
    let cells: Vec<(DVec2, Vec3)> = (0..rows * columns)
        .map(|cell| {
            let at = DVec2::new(
                ((cell / columns) as f64 + 0.5) / rows as f64,
                ((cell % columns) as f64 + 0.5) / columns as f64,
            );
            let (sin, cos) = (at.y * TAU).sin_cos();
            let r = (1.0 - at.x * at.x).sqrt();
            (at, DVec3::new(r * cos, r * sin, at.x).as_vec3())
        })
        .collect();
    let directions: Vec<Vec3> = cells.iter().map(|(_, direction)| *direction).collect();
    let mut expected = vec![0.0; RINGS * SECTORS + 1];
    let per_cell = COUNT as f64 * TAU / cells.len() as f64;
    for ((at, _), (_, pdf)) in cells.iter().zip(case.evaluate(&directions, fault)) {
        expected[bin(at.x, at.y)] += pdf * per_cell;
    }
    let outside = COUNT as f64 - expected.iter().sum::<f64>();
    expected[RINGS * SECTORS] = if outside < 5.0 { 1e-9 } else { outside };
    chi_square_p_value(&observed, &expected)
}

#[test]
fn layers_are_drawn_by_their_density() {
    let mut random = Random(26);
    // Narrower lobes would slip between the bins.
    let wide: Vec<Case> = cases(&mut random)
        .into_iter()
        .filter(|case| case.coat == 0.0 || case.coat_roughness > 0.5)
        .filter(|case| case.material.roughness >= 0.4)
        .collect();
    assert!(wide.len() >= 10, "{}", wide.len());
    let p_values: Vec<f64> = wide.iter().map(|case| p_value(case, None)).collect();
    assert!(holm(&p_values).iter().all(|p| *p > 1e-4), "{p_values:?}");
    let anisotropic = wide.iter().filter(|case| case.anisotropy > 0.0);
    for case in anisotropic {
        let p = p_value(case, Some(EXCHANGED_WIDTHS));
        assert!(p < 1e-6, "{case:?}: {p}");
    }
}

//! Tests of a surface with two lobes that the renderer does not have: sampling, evaluation and density of its lobes agree.

use crate::support::TOY_LOBES;
use crate::support::random::Random;
use crate::{Function, number, vector};
use glam::{DVec3, Vec3};
use headwater::device_scene::gpu_material;
use headwater::metrics::statistics::Estimate;
use headwater::scene::Material;
use headwater::shader_interface::GpuMaterial;

const COUNT: u32 = 1 << 17;

/// Runs the GLSL `body` for `COUNT` numbers in `b.x`, on a surface with both toy lobes above the lobes of `material`; `o` is
/// the outgoing direction in the shading frame.
fn run(material: GpuMaterial, outgoing: Vec3, body: &str) -> Vec<[u32; 8]> {
    let body = format!(
        "vec3 o = uintBitsToFloat(a.xyz); Bsdf bsdf = make_bsdf(material_at(0), NO_LAYERS, o);
         Random random = random_start(b.x, 7u, 5u); vec4 u = to_unit(random_bits(random)); {body}"
    );
    let function = Function {
        includes: &["core/random.glsl", "bsdf/bsdf.glsl", "scene/geometry.glsl"],
        body: &body,
        materials: &[material],
        changes: &TOY_LOBES,
        ..Function::default()
    };
    let [x, y, z] = outgoing.to_array().map(f32::to_bits);
    let inputs: Vec<[u32; 8]> = (0..COUNT).map(|i| [x, y, z, 0, i, 0, 0, 0]).collect();
    function.run(&inputs)
}

fn assert_within_errors(name: &str, found: &[f64], expected: &[f64]) {
    let (found, expected) = (Estimate::of(found), Estimate::of(expected));
    let error = (found.standard_error.powi(2) + expected.standard_error.powi(2)).sqrt();
    let gap = (found.mean - expected.mean).abs();
    // Four deviations: about one in 16,000 cases by chance, of some twenty.
    assert!(
        gap <= 4.0 * error + 1e-5,
        "{name}: {found:?}, not {expected:?}"
    );
}

#[test]
fn toy_lobes_are_sampled_as_they_are_evaluated() {
    let mut random = Random(4);
    for (name, metallic, roughness) in [
        ("lacquer", 0.0, 0.3),
        ("metal", 1.0, 0.4),
        ("mirror of metal", 1.0, 0.0),
        ("smooth lacquer", 0.0, 0.0),
    ] {
        let material = Material {
            base_color: Vec3::new(0.8, 0.5, 0.2),
            metallic,
            roughness,
            ..Material::default()
        };
        let outgoing = random.direction().with_z(0.6).normalize().as_vec3();
        let material = gpu_material(&material, 1.0);
        let drawn = run(
            material,
            outgoing,
            "BsdfSample s = sample_bsdf(bsdf, o, u);
             x = floatBitsToUint(vec4(s.valid ? s.weight : vec3(0.0), s.pdf_solid_angle));
             y = uvec4(s.delta ? 1u : 0u, s.valid ? 1u : 0u, 0u, 0u);",
        );
        // Uniform directions above the surface, and the delta lobes, which no direction finds.
        let evaluated = run(
            material,
            outgoing,
            "vec3 i = vec3(sqrt(1.0 - u.x * u.x) * on_circle(u.y), u.x); float pdf;
             vec3 f = evaluate_bsdf(bsdf, o, i, pdf) * (i.z * 2.0 * PI);
             x = floatBitsToUint(vec4(f, 2.0 * PI * pdf));
             vec3 sum = vec3(0.0), direction, reflectance; uint lobes = 0u;
             for (uint d = 0u; d < MAX_DELTA_LOBES; d += 1u)
                 if (delta_lobe(bsdf, d, o, direction, reflectance)) { sum += reflectance; lobes += 1u; }
             y = uvec4(floatBitsToUint(sum), lobes);",
        );
        let delta = vector(&evaluated[0][4..]);
        assert_eq!(
            evaluated[0][7],
            if roughness == 0.0 { 2 } else { 0 },
            "{name}"
        );
        for axis in 0..3 {
            let weights: Vec<f64> = drawn.iter().map(|o| vector(o)[axis]).collect();
            let light: Vec<f64> = (evaluated.iter())
                .map(|o| vector(o)[axis] + delta[axis])
                .collect();
            assert_within_errors(&format!("{name}, reflectance"), &weights, &light);
        }
        // Where nothing is lost below the horizon, the density adds up to the probability of lobes that are no delta lobes.
        let wide: Vec<f64> = (drawn.iter())
            .map(|o| f64::from(u32::from(o[4] == 0 && o[5] == 1)))
            .collect();
        let density: Vec<f64> = evaluated.iter().map(|o| number(o[3])).collect();
        assert_within_errors(&format!("{name}, density"), &wide, &density);
        assert!(roughness > 0.0 || delta.cmpgt(DVec3::splat(0.01)).all());
    }
}

/// The rays of delta lobes are those that `delta_lobe` returns; the sampling of a pilot must never return one of them.
#[test]
fn lobes_that_have_rays_of_their_own_are_not_sampled_again() {
    let material = Material {
        roughness: 0.0,
        ..Material::default()
    };
    let outgoing = Vec3::new(0.3, 0.4, 0.8).normalize();
    let drawn = run(
        gpu_material(&material, 1.0),
        outgoing,
        "prefer_narrow_lobes(bsdf); BsdfSample s = sample_bsdf(bsdf, o, u); x = uvec4(s.delta ? 1u : 0u, s.valid ? 1u : 0u, 0u, 0u);",
    );
    assert!(drawn.iter().all(|o| o[0] == 0));
    let valid = drawn.iter().filter(|o| o[1] == 1).count();
    assert!(valid > drawn.len() / 2, "{valid}");
}

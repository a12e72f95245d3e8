//! Tests of shader functions: octahedral words, tangent frames, and the transform of normals for triangles of any size.

use crate::support::random::Random;
use crate::{Function, floats, number, vector};
use glam::DVec3;

/// Random directions, and those along axes and diagonals.
fn directions() -> Vec<DVec3> {
    let mut random = Random(3);
    let mut all: Vec<DVec3> = (0..20_000).map(|_| random.direction()).collect();
    for x in [-1.0, 0.0, 1.0] {
        for y in [-1.0, -1e-20, 0.0, 1.0] {
            for z in [-1.0, -1e-20, 0.0, 1.0] {
                all.extend(DVec3::new(x, y, z).try_normalize());
            }
        }
    }
    all
}

fn inputs(of: &[DVec3]) -> Vec<[u32; 8]> {
    of.iter().map(|d| floats(&d.as_vec3().to_array())).collect()
}

#[test]
fn tangent_frames_are_right_handed_and_orthonormal() {
    let body = "vec3 t, s; tangent_frame(uintBitsToFloat(a.xyz), t, s);
        x.xyz = floatBitsToUint(t); y.xyz = floatBitsToUint(s);";
    let function = Function {
        body,
        ..Function::default()
    };
    let all = directions();
    for (n, output) in all.iter().zip(function.run(&inputs(&all))) {
        let (t, s) = (vector(&output), vector(&output[4..]));
        // Less than twenty roundings, each of them at most 6e-8.
        assert!(
            (t.length() - 1.0).abs() < 1e-6 && (s.length() - 1.0).abs() < 1e-6,
            "{n}"
        );
        assert!((t.cross(s) - *n).length() < 1e-6, "{n}: {t} {s}");
    }
}

#[test]
fn turns_lie_on_the_circle() {
    let body = "vec2 point = on_circle(uintBitsToFloat(a.x));
        x.xyz = floatBitsToUint(vec3(point, turns_of(point)));";
    let function = Function {
        body,
        ..Function::default()
    };
    let eighths = (0..=8).map(|i| i as f32 / 8.0);
    let turns: Vec<f32> = (0..20_000)
        .map(|i| i as f32 / 20_000.0)
        .chain(eighths)
        .chain([f32::MIN_POSITIVE, 1.0 - f32::EPSILON])
        .collect();
    let inputs: Vec<_> = turns.iter().map(|t| floats(&[*t])).collect();
    for (t, output) in turns.iter().zip(function.run(&inputs)) {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(*t)).sin_cos();
        let gap = (vector(&output).truncate() - glam::DVec2::new(cos, sin)).length();
        assert!(gap < 2e-7, "{t}: {gap:e}");
        // 0 and 1 are the same angle.
        let back = (number(output[2]) - f64::from(*t) + 0.5).rem_euclid(1.0) - 0.5;
        assert!(back.abs() < 1e-7, "{t}: {back:e}");
    }
}

#[test]
fn octahedral_words_give_directions_back() {
    let body = "x.xyz = floatBitsToUint(unpack_octahedral(a.x));";
    let function = Function {
        body,
        ..Function::default()
    };
    let all = directions();
    let words: Vec<[u32; 8]> = all
        .iter()
        .map(|d| {
            let word = headwater::device_scene::geometry::pack_octahedral(d.as_vec3());
            [word, 0, 0, 0, 0, 0, 0, 0]
        })
        .collect();
    for (d, output) in all.iter().zip(function.run(&words)) {
        // Half a step of 1/32767 in each coordinate, up to three times as long on the sphere as on
        // the octahedron: 6.5e-5; the rest is for f32.
        assert!(
            (vector(&output) - *d).length() < 7e-5,
            "{d}: {}",
            vector(&output)
        );
    }
}

#[test]
fn normals_across_edges_have_no_favourite_size() {
    let body =
        "x.xyz = floatBitsToUint(unit_cross(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz)));";
    let function = Function {
        body,
        ..Function::default()
    };
    let mut random = Random(4);
    let edges: Vec<(DVec3, DVec3)> = (0..20_000)
        .map(|_| {
            let mut edge = || random.direction() * 10_f64.powf(40.0 * random.unit() - 20.0);
            (edge(), edge())
        })
        .collect();
    let words: Vec<[u32; 8]> = edges
        .iter()
        .map(|(e, f)| {
            let (e, f) = (e.as_vec3(), f.as_vec3());
            floats(&[e.x, e.y, e.z, 0.0, f.x, f.y, f.z])
        })
        .collect();
    for ((e, f), output) in edges.iter().zip(function.run(&words)) {
        let (e, f) = (e.normalize(), f.normalize());
        // Less than twenty roundings, each of them at most 6e-8; what those of the edges cost grows
        // as they become parallel.
        let tolerance = 1e-6 / e.cross(f).length();
        let normal = e.cross(f).normalize();
        assert!((vector(&output) - normal).length() < tolerance, "{e} {f}");
    }
}

/// A mirror turns an error of its normal into twice that error of the reflection, which a narrow field of view magnifies.
#[test]
fn primary_surfaces_keep_their_normals() {
    let function = Function {
        includes: &["restir/sample_data.glsl"],
        body: "Surface surface;
            surface.position = vec3(0.0);
            surface.error = vec3(1e-6);
            surface.geometric_normal = uintBitsToFloat(a.xyz);
            surface.shading_normal = uintBitsToFloat(b.xyz);
            surface.material_index = 0u;
            surface.instance = 7u;
            Ray ray = Ray(surface.geometric_normal, 1e30, -surface.geometric_normal);
            ShadingPoint shading_point = unpack_shading_point(pack_sample_data(surface, no_hit(1.0), ray, vec3(0.0)), ray);
            x.xyz = floatBitsToUint(shading_point.geometric_normal);
            y.xyz = floatBitsToUint(shading_point.shading_normal);",
        materials: &[bytemuck::Zeroable::zeroed()],
        ..Function::default()
    };
    let all = directions();
    let pairs = || all.iter().zip(all.iter().rev());
    let inputs: Vec<[u32; 8]> = pairs()
        .map(|(geometric, shading)| {
            let mut words = floats(&geometric.as_vec3().to_array());
            words[4..].copy_from_slice(&floats(&shading.as_vec3().to_array())[..4]);
            words
        })
        .collect();
    let mut largest = [0.0_f64; 2];
    for ((geometric, shading), output) in pairs().zip(function.run(&inputs)) {
        let error = |kept: DVec3, normal: &DVec3| kept.cross(*normal).length();
        largest[0] = largest[0].max(error(vector(&output), geometric));
        largest[1] = largest[1].max(error(vector(&output[4..]), shading));
    }
    println!("{largest:?} radians");
    assert!(largest.iter().all(|angle| *angle < 2e-6), "{largest:?}");
}

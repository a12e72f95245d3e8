//! Tests of shader functions: the bounds of the rounding errors of surface points.

use crate::support::random::Random;
use crate::{Function, floats, number};
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// The number of points that each test tries.
const POINTS: usize = 20_000;
/// A point through which all planes of the tests pass; `GLSL_POINT` declares it in the shaders.
const POINT: Vec3 = Vec3::new(0.31, -1.7, 2.3);
const GLSL_POINT: &str = "const vec3 POINT = vec3(0.31, -1.7, 2.3);";

fn vector(words: &[u32]) -> DVec3 {
    DVec3::new(number(words[0]), number(words[1]), number(words[2]))
}

/// The number of surface points whose clearance does not lift a ray's origin off the triangle's plane. Rounded barycentrics
/// move a point within the plane by more than its error bound says, so the distance from the plane must count instead.
fn behind_the_plane(fault: Option<(&str, &str, &str)>) -> usize {
    let mut random = Random(7);
    let mut number_in = |low: f64, high: f64| (low + (high - low) * random.unit()) as f32;
    let inputs: Vec<[u32; 8]> = (0..POINTS)
        .map(|_| {
            floats(&[
                // The normal, as angle and height; how far the point slid.
                number_in(0.0, 6.3),
                number_in(-0.95, 0.95),
                number_in(-1e-3, 1e-3),
                number_in(-1e-3, 1e-3),
                // The ray, as angle, cosine and length; the bound's power of ten.
                number_in(0.0, 6.3),
                number_in(0.1, 1.0),
                number_in(0.5, 4.0),
                number_in(-7.0, -4.0),
            ])
        })
        .collect();
    let function = Function {
        includes: &["core/random.glsl", "core/rounding.glsl"],
        globals: GLSL_POINT,
        body: "
            vec4 u = uintBitsToFloat(a), v = uintBitsToFloat(b);
            vec3 normal = vec3(sqrt(1.0 - u.y * u.y) * vec2(cos(u.x), sin(u.x)), u.y), s, t;
            normal = normalize(normal);
            tangent_frame(normal, s, t);
            vec3 direction = -(v.y * normal + sqrt(1.0 - v.y * v.y) * (cos(v.x) * s + sin(v.x) * t));
            direction = normalize(direction);
            vec3 origin = POINT - v.z * direction;
            // What rounds here, and a bound that differs from axis to axis, as those of uneven transforms do.
            vec3 error = vec3(6e-7) + pow(10.0, v.w) * vec3(1.0, 0.03, 0.3);
            vec3 position = POINT + u.z * s + u.w * t;
            float clearance = clearance_of(normal, error);
            refine_by_ray(position, error, clearance, normal, origin, direction);
            x = uvec4(floatBitsToUint(position + clearance * normal), 0u);
            y = uvec4(floatBitsToUint(normal), 0u);",
        fault,
        ..Function::default()
    };
    let outputs = function.run(&inputs);
    (outputs.iter())
        .filter(|words| (vector(&words[..3]) - POINT.as_dvec3()).dot(vector(&words[4..7])) < 0.0)
        .count()
}

#[test]
fn points_that_slid_within_their_plane_stay_before_it() {
    assert_eq!(behind_the_plane(None), 0);
}

#[test]
fn a_point_of_mixed_coordinates_is_found() {
    let fault = (
        "core/rounding.glsl",
        "if (component_sum(refined) < component_sum(error)) {",
        "position = mix(position, origin + depth * direction, lessThan(refined, error));
        error = min(refined, error);
        clearance = clearance_of(normal, error);
        if (false) {",
    );
    assert!(behind_the_plane(Some(fault)) > POINTS / 100);
}

/// For rays that meet a plane at any angle, down to cosines of 1e-3, the number of points that are farther from the exact
/// point than their bound, the number that are farther from the plane than their clearance, and the number of clearances
/// much larger than rounding needs.
fn wrong_bounds(fault: Option<(&str, &str, &str)>) -> [usize; 3] {
    let mut random = Random(11);
    let mut number_in = |low: f64, high: f64| low + (high - low) * random.unit();
    let rays: Vec<(DVec3, DVec3, [u32; 8])> = (0..POINTS)
        .map(|_| {
            let (angle, height) = (number_in(0.0, TAU), number_in(0.05, 1.0));
            let around = f64::sqrt(1.0 - height * height);
            let normal = DVec3::new(around * angle.cos(), around * angle.sin(), height);
            let (s, t) = normal.any_orthonormal_pair();
            let cosine = 10.0_f64.powf(number_in(-3.0, 0.0));
            let (sin, cos) = number_in(0.0, TAU).sin_cos();
            let along = f64::sqrt(1.0 - cosine * cosine) * (cos * s + sin * t);
            let direction = along - cosine * normal;
            let beside = number_in(-1e-3, 1e-3) * s;
            let origin = POINT.as_dvec3() - number_in(0.5, 4.0) * direction + beside;
            let [o, d] = [origin, direction].map(|vector| vector.as_vec3());
            let (x, y) = (normal.x as f32, normal.y as f32);
            (
                o.as_dvec3(),
                d.as_dvec3(),
                floats(&[o.x, o.y, o.z, d.x, d.y, d.z, x, y]),
            )
        })
        .collect();
    let function = Function {
        includes: &["core/rounding.glsl"],
        globals: GLSL_POINT,
        body: "
            vec3 origin = uintBitsToFloat(a.xyz), direction = uintBitsToFloat(uvec3(a.w, b.xy));
            vec3 normal = vec3(uintBitsToFloat(b.zw), 0.0);
            normal.z = sqrt(1.0 - dot(normal, normal));
            float clearance = 0.0;
            float depth = depth_along(origin, direction, POINT, normal, clearance);
            vec3 error = depth_along_error(origin, direction, depth, normal, clearance);
            x = uvec4(floatBitsToUint(origin + depth * direction), floatBitsToUint(clearance));
            y = uvec4(floatBitsToUint(normal), floatBitsToUint(component_sum(error)));",
        fault,
        ..Function::default()
    };
    let inputs: Vec<_> = rays.iter().map(|ray| ray.2).collect();
    let mut wrong = [0; 3];
    for ((origin, direction, _), words) in rays.iter().zip(function.run(&inputs)) {
        let [found, normal] = [&words[..3], &words[4..7]].map(vector);
        let [clearance, error] = [words[3], words[7]].map(number);
        let normal = normal.normalize();
        let above = |point: DVec3| (point - POINT.as_dvec3()).dot(normal);
        let exact = *origin - above(*origin) / direction.dot(normal) * *direction;
        wrong[0] += usize::from(found.distance(exact) > error);
        wrong[1] += usize::from(above(found).abs() > clearance);
        // Four times the bound of `ray_error`, which does not depend on the angle.
        let reach = (origin.abs() + (exact - *origin).abs()).dot(normal.abs());
        wrong[2] += usize::from(clearance > 4.0 * 2.5e-7 * reach);
    }
    wrong
}

#[test]
fn points_on_grazing_rays_keep_their_bounds() {
    assert_eq!(wrong_bounds(None), [0; 3]);
}

/// The fault multiplies the error along a grazing ray axis by axis. The result does not vanish along the normal unless the
/// plane lies along the axes, so the clearance becomes too large.
#[test]
fn a_clearance_that_forgets_the_angle_is_found() {
    let fault = (
        "core/rounding.glsl",
        "    clearance += 2.0 * clearance_of(normal, ray_error(origin, direction, depth));",
        "    vec3 rounding = ray_error(origin, direction, depth);
        float cosine = max(-dot(direction, normal), 1e-6);
        float depth_error = (0.5 * clearance + dot(abs(normal), rounding)) / cosine;
        clearance = clearance_of(normal, rounding + depth_error * abs(direction));",
    );
    let [_, _, large] = wrong_bounds(Some(fault));
    assert!(large > POINTS / 10, "{large}");
}

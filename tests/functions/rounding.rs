//! Tests of shader functions: the rounding errors of surface points.

use crate::support::random::Random;
use crate::{Function, floats, number};
use glam::DVec3;

/// Points that are tried.
const POINTS: usize = 20_000;

/// Barycentrics that are not exact slide a point within its triangle's plane, by more than its bounds say.
/// Whatever is made of it must lie so near the plane that its clearance takes a ray's origin off it.
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
        globals: "const vec3 POINT = vec3(0.31, -1.7, 2.3);",
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
            refine_by_ray(position, error, normal, origin, direction);
            vec3 clear = offset_origin(position, error, normal, normal, LARGEST);
            x = uvec4(floatBitsToUint(clear), 0u);
            y = uvec4(floatBitsToUint(normal), 0u);",
        fault,
        ..Function::default()
    };
    let point = DVec3::new(f64::from(0.31_f32), f64::from(-1.7_f32), f64::from(2.3_f32));
    let outputs = function.run(&inputs);
    let vector = |words: &[u32]| DVec3::new(number(words[0]), number(words[1]), number(words[2]));
    (outputs.iter())
        .filter(|words| (vector(&words[..3]) - point).dot(vector(&words[4..7])) < 0.0)
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
        "if (component_sum(error) < component_sum(position_error)) {",
        "position = mix(position, origin + depth * direction, lessThan(error, position_error));
        position_error = min(error, position_error);
        if (false) {",
    );
    assert!(behind_the_plane(Some(fault)) > POINTS / 100);
}

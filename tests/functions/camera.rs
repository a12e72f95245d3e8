//! Tests of shader functions: rays and projections of all camera models against the same in f64, and rays of the previous frame,
//! which must have the bits that they had then.

use crate::support::random::Random;
use crate::{Function, floats, number, vector};
use glam::{DVec2, Vec2, Vec3};
use headwater::shader_interface::{
    CameraModel, GpuCamera, RestirConstants, Specialisation, ViewConstants,
};

const MODELS: [CameraModel; 3] = [
    CameraModel::Pinhole,
    CameraModel::Orthographic,
    CameraModel::ThinLens,
];
const SIZE: [u32; 2] = [320, 200];
/// The focus distance of the lens.
const FOCUS: f32 = 4.0;

/// A camera that is turned about all axes; `shift` moves and turns it further.
fn camera(shift: f32) -> GpuCamera {
    let forward = Vec3::new(0.3 + shift, -0.4, -0.8).normalize();
    let right = forward.cross(Vec3::new(0.2, 1.0, 0.1)).normalize();
    let radius = 0.25;
    GpuCamera {
        position: Vec3::new(0.5, -1.0 + shift, 2.0),
        right: right * 1.6,
        up: right.cross(forward),
        forward,
        lens_radius: radius,
        lens_slope: radius / FOCUS,
    }
}

fn constants(camera: GpuCamera) -> RestirConstants {
    RestirConstants {
        view: ViewConstants {
            camera,
            width: SIZE[0],
            height: SIZE[1],
            ..ViewConstants::default()
        },
        ..RestirConstants::default()
    }
}

fn words(model: CameraModel) -> Vec<(u32, u32)> {
    Specialisation {
        camera_model: model,
        ..Specialisation::default()
    }
    .words()
}

/// Positions in the picture, in pixels, and points of a lens, in [0, 1)².
fn inputs() -> Vec<[f32; 4]> {
    let mut random = Random(11);
    let mut below = |most: f64| (most * random.unit()) as f32;
    (0..10_000)
        .map(|_| [below(320.0), below(200.0), below(1.0), below(1.0)])
        .collect()
}

/// The largest error of an origin, of a direction, and of the position in pixels at which a point of the ray appears.
fn worst(model: CameraModel, fault: Option<(&str, &str, &str)>) -> [f64; 3] {
    let camera = camera(0.0);
    let function = Function {
        includes: &["restir/frame.glsl"],
        body: "
            vec2 at = uintBitsToFloat(a.xy), disc = on_disc(uintBitsToFloat(a.zw)), seen;
            Ray ray = camera_ray(restir.at.view.camera, at, vec2(picture_size()), disc);
            float depth = 4.0 / dot(ray.direction, restir.at.view.camera.forward);
            vec3 point = ray.origin + depth * ray.direction;
            project(restir.at.view.camera, point - restir.at.view.camera.position, vec2(picture_size()), seen);
            x = uvec4(floatBitsToUint(ray.origin), floatBitsToUint(seen.x));
            y = uvec4(floatBitsToUint(ray.direction), floatBitsToUint(seen.y));",
        restir: constants(camera),
        constants: &words(model),
        fault,
        ..Function::default()
    };
    let [position, right, up, forward] =
        [camera.position, camera.right, camera.up, camera.forward].map(|v| v.as_dvec3());
    let inputs = inputs();
    let bits: Vec<_> = inputs.iter().map(|input| floats(input)).collect();
    let mut worst = [0.0_f64; 3];
    for (input, output) in inputs.iter().zip(function.run(&bits)) {
        let [x, y, u, v] = input.map(f64::from);
        let plane = DVec2::new(2.0 * x / 320.0 - 1.0, 1.0 - 2.0 * y / 200.0);
        let beside = plane.x * right + plane.y * up;
        let (origin, direction) = match model {
            CameraModel::Pinhole => (position, forward + beside),
            CameraModel::Orthographic => (position + beside, forward),
            CameraModel::ThinLens => {
                // The ray from a point of the disc to the point in focus.
                let (sine, cosine) = (std::f64::consts::TAU * v).sin_cos();
                let radius = f64::from(camera.lens_radius) * u.sqrt();
                let on_lens = cosine * right.normalize() + sine * up.normalize();
                let origin = position + radius * on_lens;
                let in_focus = position + f64::from(FOCUS) * (forward + beside);
                (origin, in_focus - origin)
            }
        };
        let seen = DVec2::new(number(output[3]), number(output[7]));
        let errors = [
            (vector(&output) - origin).length(),
            (vector(&output[4..]) - direction.normalize()).length(),
            (seen - DVec2::new(x, y)).length(),
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }
    worst
}

#[test]
fn rays_and_projections_equal_their_twin() {
    for model in MODELS {
        let [origin, direction, seen] = worst(model, None);
        println!("{model:?}: {origin:e} {direction:e} {seen:e}");
        assert!(origin < 1e-6 && direction < 1e-6, "{model:?}");
        // Half a dozen roundings of numbers around 320.
        assert!(seen < 3e-4, "{model:?}: {seen}");
    }
}

#[test]
fn a_lens_that_is_tilted_the_wrong_way_is_found() {
    let file = "scene/camera.glsl";
    let fault = (
        file,
        "direction - camera.lens_slope",
        "direction + camera.lens_slope",
    );
    assert!(worst(CameraModel::ThinLens, Some(fault))[1] > 0.05);
    let fault = (
        file,
        "- plane.y * camera.up, LARGEST",
        "+ plane.y * camera.up, LARGEST",
    );
    assert!(worst(CameraModel::Orthographic, Some(fault))[0] > 0.5);
}

/// The primary rays of some pixels: those of this frame, or of the previous one.
fn rays(
    restir: RestirConstants,
    call: &str,
    model: CameraModel,
    fault: Option<(&str, &str, &str)>,
) -> Vec<[u32; 8]> {
    let body = format!(
        "Ray ray = {call}(a.xy);
        x = uvec4(floatBitsToUint(ray.origin), 0u);
        y = uvec4(floatBitsToUint(ray.direction), 0u);"
    );
    let function = Function {
        includes: &["restir/frame.glsl"],
        body: &body,
        restir,
        constants: &words(model),
        fault,
        ..Function::default()
    };
    let pixels: Vec<_> = (0..SIZE[0] * 20)
        .map(|i| [i % SIZE[0], i / SIZE[0] * 7, 0, 0, 0, 0, 0, 0])
        .collect();
    function.run(&pixels)
}

#[test]
fn the_previous_frame_repeats_its_rays_with_every_bit() {
    let then = RestirConstants {
        jitters: 1,
        jitter: Vec2::new(0.3, 0.9),
        lens_point: Vec2::new(0.8, 0.15),
        ..constants(camera(0.0))
    };
    let now = RestirConstants {
        jitters: 1,
        previous_camera: then.view.camera,
        jitter: Vec2::new(0.6, 0.2),
        previous_jitter: then.jitter,
        lens_point: Vec2::new(0.1, 0.5),
        previous_lens_point: then.lens_point,
        ..constants(camera(0.25))
    };
    let file = "restir/frame.glsl";
    let faults = [
        ("restir.at.previous_lens_point", "restir.at.lens_point"),
        ("restir.at.previous_jitter", "restir.at.jitter"),
        ("restir.at.previous_camera", "restir.at.view.camera"),
    ];
    for model in MODELS {
        let before = rays(then, "primary_ray", model, None);
        let again = rays(now, "previous_primary_ray", model, None);
        assert_eq!(before, again, "{model:?}");
        for (text, planted) in faults {
            let again = rays(
                now,
                "previous_primary_ray",
                model,
                Some((file, text, planted)),
            );
            let matters = model == CameraModel::ThinLens || !text.contains("lens");
            assert_eq!(before != again, matters, "{model:?}: {text}");
        }
    }
}

/// The points of the lens that pixels use are uniform on the disc, and those of adjacent pixels are unrelated.
#[test]
fn points_of_the_lens_cover_it_evenly() {
    let function = Function {
        includes: &["restir/frame.glsl"],
        body: "
            vec2 here = position_on_lens(a.xy, vec2(0.7, 0.4)), right = position_on_lens(a.xy + uvec2(1u, 0u), vec2(0.7, 0.4));
            x = floatBitsToUint(vec4(here, right));",
        constants: &words(CameraModel::ThinLens),
        ..Function::default()
    };
    let pixels: Vec<_> = (0..40_000_u32)
        .map(|i| [i % 200, i / 200, 0, 0, 0, 0, 0, 0])
        .collect();
    let (mut mean, mut square, mut product, mut count) = (DVec2::ZERO, 0.0, 0.0, 0.0);
    for output in function.run(&pixels) {
        let [x, y, right_x, right_y] = [0, 1, 2, 3].map(|i| number(output[i]));
        let (here, right) = (DVec2::new(x, y), DVec2::new(right_x, right_y));
        assert!(here.length() <= 1.0 + 1e-6);
        mean += here;
        square += here.length_squared();
        product += here.dot(right);
        count += 1.0;
    }
    // Five standard deviations; the variances of a coordinate, of r², and of the product are 1/4, 1/12 and 1/8.
    let most = |variance: f64| 5.0 * (variance / count).sqrt();
    assert!((mean / count).abs().max_element() < most(0.25), "{mean}");
    assert!((square / count - 0.5).abs() < most(1.0 / 12.0), "{square}");
    assert!((product / count).abs() < most(0.125), "{product}");
}

/// The sides of cells of space at distances of 1 to 1000 from a camera.
fn sides(model: CameraModel, fault: Option<(&str, &str, &str)>) -> Vec<f64> {
    let function = Function {
        includes: &["restir/frame.glsl", "world_reservoirs/cells.glsl"],
        body: "
            int level;
            vec3 position = restir.at.view.camera.position + uintBitsToFloat(a.x) * restir.at.view.camera.forward;
            x.x = floatBitsToUint(cell_side(restir.at.view.camera, restir.at.view.width, 20.0, position, 0.0, level));",
        restir: constants(camera(0.0)),
        constants: &words(model),
        fault,
        ..Function::default()
    };
    let distances = [1.0, 12.0, 1000.0].map(|distance: f32| floats(&[distance]));
    let outputs = function.run(&distances);
    outputs.iter().map(|output| number(output[0])).collect()
}

#[test]
fn cells_have_the_size_of_pixels() {
    // 20 pixels of 0.01 scene units at the distance 1, rounded down to a power of two.
    assert_eq!(sides(CameraModel::Orthographic, None), [0.125; 3]);
    assert_eq!(sides(CameraModel::Pinhole, None), [0.125, 2.0, 128.0]);
    let scale = "CAMERA_MODEL == CAMERA_MODEL_ORTHOGRAPHIC ? 1.0 : ";
    let fault = ("world_reservoirs/cells.glsl", scale, "");
    assert_ne!(sides(CameraModel::Orthographic, Some(fault)), [0.125; 3]);
}

/// The distance of the eye from which surfaces are compared, for points at three distances.
#[test]
fn the_eye_of_an_orthographic_camera_goes_along() {
    for (model, expected) in [
        (CameraModel::Pinhole, [1.0, 10.0, 1000.0]),
        (CameraModel::Orthographic, [2.0; 3]),
    ] {
        let function = Function {
            includes: &["restir/frame.glsl"],
            body: "
                vec3 point = restir.at.view.camera.position + uintBitsToFloat(a.x) * restir.at.view.camera.forward;
                x.x = floatBitsToUint(distance(point, eye_of(restir.at.view.camera, point)));",
            restir: constants(camera(0.0)),
            constants: &words(model),
            ..Function::default()
        };
        let outputs = function.run(&[1.0, 10.0, 1000.0].map(|distance| floats(&[distance])));
        for (output, expected) in outputs.iter().zip(expected) {
            assert!(
                (number(output[0]) / expected - 1.0).abs() < 1e-5,
                "{model:?}"
            );
        }
    }
}

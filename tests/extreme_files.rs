//! Tests of extreme scene files, loaded and rendered as a user does. Each picture is compared with a closed form, or with
//! the picture of the same file without the emitter that the camera does not see. `near_lights.rs` and `contrast.rs` have
//! many more cases of each kind.

mod support;

use glam::{DAffine3, DVec3, Vec3};
use headwater::metrics::error::median_ratio;
use headwater::render::presets::Preset;
use headwater::render::{Settings, View};
use headwater::scene::{Material, PunctualLight, PunctualShape, Scene};
use headwater::scene_files::export;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;
use std::fs;

fn preset(name: &str) -> Settings {
    Preset::named(name).unwrap().settings().unwrap()
}

/// Name, reflectance and radiance of a material, and the four corners of a quad of this material.
type Quad<'a> = ((&'a str, f64, f64), [[f64; 3]; 4]);

/// Writes an OBJ file of quads, with its MTL file, and loads it.
fn open_obj(quads: &[Quad<'_>]) -> Scene {
    let (mut obj, mut mtl) = ("mtllib scene.mtl\n".to_owned(), String::new());
    for ((name, reflectance, radiance), corners) in quads {
        writeln!(obj, "usemtl {name}").unwrap();
        writeln!(
            mtl,
            "newmtl {name}\nKd {reflectance} {reflectance} {reflectance}"
        )
        .unwrap();
        writeln!(mtl, "Ke {radiance} {radiance} {radiance}").unwrap();
        for [x, y, z] in corners {
            writeln!(obj, "v {x} {y} {z}").unwrap();
        }
        obj += "f -4 -3 -2 -1\n";
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.obj");
    fs::write(&path, obj).unwrap();
    fs::write(folder.path().join("scene.mtl"), mtl).unwrap();
    headwater::scene::Scene::open(path.to_str().unwrap()).unwrap()
}

/// Writes a glTF file with a floor of reflectance 0.5 under a light, and loads it.
fn open_gltf(light: PunctualLight) -> Scene {
    let white = Material {
        base_color: Vec3::splat(0.5),
        metallic: 0.0,
        ..Material::default()
    };
    let floor = support::quad(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    let mut scene = support::scene_of(&[(white, floor)]);
    scene.punctual_lights.push(light);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    export::write_glb(&scene, &path).unwrap();
    headwater::scene::Scene::open(path.to_str().unwrap()).unwrap()
}

/// The camera of a picture (eye, target, vertical field of view in degrees), and the size of the picture in pixels.
struct Shot {
    eye: DVec3,
    target: DVec3,
    degrees: f64,
    width: u32,
    height: u32,
}

impl Shot {
    fn view(&self) -> View {
        View {
            camera: support::look_at(self.eye, self.target, DVec3::Y, self.degrees.to_radians()),
            width: self.width,
            height: self.height,
            seed: 5,
            bounces: 1,
            jitter: false,
        }
    }

    /// The points of the plane y = 0 that the centres of the pixels show, row by row.
    fn points_of_floor(&self) -> Vec<DVec3> {
        let reach = (self.degrees.to_radians() / 2.0).tan();
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        let across = |i: u32| 2.0 * (f64::from(i) + 0.5) - f64::from(self.height);
        let pixels = (0..self.width * self.height).map(|i| (i % self.width, i / self.width));
        pixels
            .map(|(x, y)| {
                let x = 2.0 * (f64::from(x) + 0.5) - f64::from(self.width);
                let way = forward + (x * right - across(y) * up) * reach / f64::from(self.height);
                self.eye - way * (self.eye.y / way.y)
            })
            .collect()
    }

    /// The green channel of each pixel, row by row, in the mean of `samples` samples per pixel.
    fn picture(&self, scene: &Scene, settings: &Settings, samples: u32) -> Vec<f64> {
        let (device, selection) = support::open_device(None);
        let view = self.view();
        let seen = support::render(&device, scene, selection.variant, &view, settings, samples);
        support::assert_no_messages(&device);
        seen.mean.iter().map(|pixel| pixel[1]).collect()
    }

    /// Renders a scene with several presets, and asserts that the relative error of the sum of the compared pixels is below
    /// `most`. `None` in `expected` leaves a pixel out.
    fn assert_shows(&self, scene: &Scene, samples: u32, expected: &[Option<f64>], most: f64) {
        for name in ["path-tracing", "balanced", "accurate"] {
            let seen = self.picture(scene, &preset(name), samples);
            let pairs = || {
                seen.iter()
                    .zip(expected)
                    .filter_map(|(seen, e)| Some((*seen, (*e)?)))
            };
            assert!(pairs().count() > seen.len() / 3);
            let error = pairs().map(|p| p.0).sum::<f64>() / pairs().map(|p| p.1).sum::<f64>() - 1.0;
            println!("{name}: error {:+.3} %", 100.0 * error);
            assert!(error.abs() <= most, "{name}: {error}");
        }
    }
}

/// The irradiance at a floor point from a parallelogram of radiance 1, computed with a fine grid.
fn irradiance(point: DVec3, corner: DVec3, u: DVec3, v: DVec3) -> f64 {
    const STEPS: u32 = 100;
    let coordinate = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    let normal = u.cross(v) / f64::from(STEPS * STEPS);
    let terms = (0..STEPS * STEPS).map(|i| {
        let toward = corner + u * coordinate(i % STEPS) + v * coordinate(i / STEPS) - point;
        toward.y * normal.dot(toward).abs() / toward.length_squared().powi(2)
    });
    terms.sum()
}

const FLOOR: (&str, f64, f64) = ("floor", 0.8, 0.0);

fn floor(reach: f64) -> [[f64; 3]; 4] {
    [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| [reach * x, 0.0, reach * z])
}

#[test]
fn a_spot_of_a_thousandth_of_a_radian_is_a_disc() {
    let scene = open_gltf(PunctualLight {
        name: "spot".into(),
        light_to_world: DAffine3::from_translation(DVec3::Y)
            * DAffine3::from_rotation_x(-FRAC_PI_2),
        shape: PunctualShape::Spot {
            inner: 0.0005,
            outer: 0.001,
        },
        intensity: Vec3::ONE,
        range: None,
    });
    let shot = Shot {
        eye: DVec3::new(0.0, 4.0, 1e-4),
        target: DVec3::ZERO,
        degrees: 0.05,
        width: 15,
        height: 15,
    };
    for name in ["path-tracing", "balanced", "accurate"] {
        let seen = shot.picture(&scene, &preset(name), 4);
        let centre = seen[7 * 15 + 7];
        assert!((centre / 0.15597 - 1.0).abs() < 0.005, "{name}: {centre}");
        for (seen, point) in seen.iter().zip(shot.points_of_floor()) {
            assert!(
                point.length() < 0.00101 || *seen == 0.0,
                "{name}: {seen} at {point}"
            );
            assert!(
                point.length() > 0.00099 || *seen > 0.0,
                "{name}: {seen} at {point}"
            );
        }
    }
}

mod thorough {
    use super::*;

    /// A room that a wall divides, with an emitter in each half. The camera does not see the emitter with the radiance
    /// `unseen`; `None` leaves it out.
    fn room(unseen: Option<f64>) -> Scene {
        let wall = ("wall", 0.5, 0.0);
        let emitter = |x: f64| {
            let corners = [[-0.15, -0.45], [0.15, -0.45], [0.15, -0.15], [-0.15, -0.15]];
            corners.map(|[aside, z]| [x + aside, 0.99, z])
        };
        let plane = |axis: usize, at: f64| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| {
                let mut corner = [a, b, b];
                corner[axis] = at;
                corner[(axis + 1) % 3] = a;
                corner[(axis + 2) % 3] = b;
                corner
            })
        };
        let mut quads = vec![
            (wall, plane(0, -0.01)),
            (wall, plane(0, 0.01)),
            (("seen", 0.0, 1.0), emitter(0.5)),
        ];
        for axis in 0..3 {
            quads.extend([-1.0, 1.0].map(|at| (wall, plane(axis, at))));
        }
        if let Some(radiance) = unseen {
            quads.push((("unseen", 0.0, radiance), emitter(-0.5)));
        }
        open_obj(&quads)
    }

    #[test]
    fn the_emitter_behind_a_wall_hides_nothing() {
        let shot = Shot {
            eye: DVec3::new(0.5, -0.1, 0.95),
            target: DVec3::new(0.4, -0.1, -0.5),
            degrees: 70.0,
            width: 24,
            height: 20,
        };
        let truth = shot.picture(&room(None), &preset("path-tracing"), 4096);
        for radiance in [1e4, 1e6] {
            for name in ["path-tracing", "fast", "balanced", "accurate"] {
                let seen = shot.picture(&room(Some(radiance)), &preset(name), 64);
                let pairs = seen.iter().copied().zip(truth.iter().copied());
                let lit: Vec<_> = pairs.filter(|(_, t)| *t > 0.0 && *t < 0.5).collect();
                let median = median_ratio(lit.iter().copied());
                println!(
                    "{name}, {radiance:e}: median {median:.3} of {} pixels",
                    lit.len()
                );
                assert!(lit.len() > 200);
                assert!(
                    (0.9..1.1).contains(&median),
                    "{name}, {radiance:e}: {median}"
                );
            }
        }
    }

    #[test]
    fn an_emitter_of_tenths_of_a_millimetre_lights_the_floor_ten_metres_away() {
        let low = 1.745_329_252_179_882_4e-4;
        let corners = [[low, -1.0], [2.0 * low, -1.0], [2.0 * low, 1.0], [low, 1.0]];
        let emitter = corners.map(|[y, z]| [-10.0, y, z]);
        let scene = open_obj(&[(FLOOR, floor(50.0)), (("lamp", 0.0, 50.0), emitter)]);
        let shot = Shot {
            eye: DVec3::new(0.0, 2.0, 3.0),
            target: DVec3::ZERO,
            degrees: 40.0,
            width: 12,
            height: 12,
        };
        let corner = DVec3::new(-10.0, low, -1.0);
        let points = shot.points_of_floor().into_iter();
        let expected: Vec<_> = points
            .map(|point| 40.0 / PI * irradiance(point, corner, DVec3::Y * low, DVec3::Z * 2.0))
            .map(Some)
            .collect();
        shot.assert_shows(&scene, 256, &expected, 0.005);
    }

    #[test]
    fn an_emitter_a_millimetre_above_the_floor_is_seen_from_forty_metres() {
        const H: f64 = 0.001;
        let corners = [[-H, -H], [H, -H], [H, H], [-H, H]];
        let emitter = corners.map(|[x, z]| [x, H, z]);
        let scene = open_obj(&[(FLOOR, floor(40.0)), (("lamp", 0.0, 1e4), emitter)]);
        let shot = Shot {
            eye: DVec3::new(0.0, 32.0, 24.0),
            target: DVec3::ZERO,
            degrees: 0.0143,
            width: 15,
            height: 15,
        };
        let corner = DVec3::new(-H, H, -H);
        let of_point = |point: DVec3| {
            // The emitter hides what is behind it.
            let through = point + (shot.eye - point) * (H / shot.eye.y);
            let is_hidden = through.x.abs().max(through.z.abs()) < 1.2 * H;
            let light = irradiance(point, corner, DVec3::X * (2.0 * H), DVec3::Z * (2.0 * H));
            (!is_hidden).then_some(8e3 / PI * light)
        };
        let expected: Vec<_> = shot.points_of_floor().into_iter().map(of_point).collect();
        shot.assert_shows(&scene, 1024, &expected, 0.005);
    }

    #[test]
    fn a_point_light_two_millionths_of_the_distance_above_the_floor_lights_it() {
        const H: f64 = 8e-6;
        let scene = open_gltf(PunctualLight {
            name: "point".into(),
            light_to_world: DAffine3::from_translation(DVec3::Y * H),
            shape: PunctualShape::Point,
            intensity: Vec3::ONE,
            range: None,
        });
        let shot = Shot {
            eye: DVec3::new(0.0, 4.0, 1e-4),
            target: DVec3::ZERO,
            degrees: 20.0,
            width: 15,
            height: 15,
        };
        // The pixel below the light would outshine all others.
        let of_point = |point: DVec3| {
            let distance = point.length();
            (distance > 0.01).then(|| 0.1565 * H / (H * H + distance * distance).powf(1.5))
        };
        let expected: Vec<_> = shot.points_of_floor().into_iter().map(of_point).collect();
        shot.assert_shows(&scene, 4, &expected, 0.05);
    }
}

//! Comparison of the pictures of two renderers: it finds regions that differ by more than noise explains.

use crate::support;
use crate::support::brute_force::{Options, Tracer, camera_ray};
use glam::Vec3;
use headwater::metrics::statistics::{Estimate, holm, welch_p_value};
use headwater::render::{Settings, View};
use headwater::scene::{Camera, Scene};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The probability with which a test of a correct renderer fails, over all comparisons of the test.
const LEVEL: f64 = 0.001;
/// The maximum half-width of the 99.9 % interval of a difference of means, as a fraction of the mean; with a wider one, a
/// sharp comparison would prove nothing.
const MAX_HALF_WIDTH: f64 = 0.003;

/// Name of the region of all pixels that show no emitter. The light of visible emitters has no noise, and would make the
/// mean of this region look more precise than it is.
pub const IMAGE: &str = "image";

/// Means (RGB) and squared standard errors of the pixels of a picture, from either renderer, and the number of samples per
/// pixel.
pub struct Picture {
    pub mean: Vec<[f64; 3]>,
    pub error_squared: Vec<[f64; 3]>,
    pub samples: u64,
}

impl Picture {
    /// The mean of a channel over some pixels, with its error; the errors of pixels are independent.
    pub fn mean_of(&self, pixels: &[usize], channel: usize) -> Estimate {
        let n = pixels.len() as f64;
        let sum = |values: &[[f64; 3]]| pixels.iter().map(|&p| values[p][channel]).sum::<f64>();
        Estimate {
            mean: sum(&self.mean) / n,
            standard_error: sum(&self.error_squared).sqrt() / n,
            samples: self.samples * pixels.len() as u64,
        }
    }
}

pub fn exact(mean: f64) -> Estimate {
    Estimate {
        mean,
        standard_error: 0.0,
        samples: 1,
    }
}

/// The name of a comparison, and two estimates of the same quantity.
pub struct Comparison {
    pub what: String,
    pub one: Estimate,
    pub other: Estimate,
    /// True if the comparison also fails when noise is so large that it could hide a fault.
    pub sharp: bool,
}

/// Descriptions of the failed comparisons; empty if all pass. One fails if its means differ (with Holm's correction over all
/// comparisons), or if `sharp` is true and the interval is too wide.
pub fn failures(comparisons: &[Comparison]) -> String {
    let p_values: Vec<f64> = comparisons
        .iter()
        .map(|c| welch_p_value(&c.one, &c.other))
        .collect();
    let mut text = String::new();
    for (c, p) in comparisons.iter().zip(holm(&p_values)) {
        let (one, other) = (c.one.mean, c.other.mean);
        let half_width = c.one.minus(&c.other).t_interval_half_width(1.0 - LEVEL) / other.abs();
        println!("{}: {one} ± {half_width:.5}, {other}, p {p:.2}", c.what);
        if p < LEVEL {
            writeln!(text, "{}: {one} is not {other}, p {p:.1e}", c.what).unwrap();
        }
        if c.sharp && half_width.is_nan() | (half_width > MAX_HALF_WIDTH) {
            writeln!(text, "{}: ±{half_width} is too wide", c.what).unwrap();
        }
    }
    text
}

/// The regions of a picture by name, each a list of pixel indices: all pixels without emitters, the blocks of a 6 × 6 grid,
/// and the pixels of each instance.
pub fn regions(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    size: [u32; 2],
) -> BTreeMap<String, Vec<usize>> {
    let mut regions = BTreeMap::<_, Vec<_>>::new();
    for at in 0..size[0] * size[1] {
        let pixel = [at % size[0], at / size[0]];
        let [column, row] = [0, 1].map(|axis| pixel[axis] * 6 / size[axis]);
        let mut names = vec![format!("block {column}, {row}")];
        let (origin, direction) = camera_ray(camera, pixel, size);
        if let Some(hit) = tracer.closest(origin, direction, f64::INFINITY) {
            let instance = &scene.instances[hit.instance as usize];
            names.push(instance.name.clone());
            let mesh = &scene.meshes[instance.mesh as usize];
            let mut materials = mesh.parts.iter().map(|p| p.material as usize);
            if materials.all(|m| scene.materials[m].emission == Vec3::ZERO) {
                names.push(IMAGE.to_owned());
            }
        }
        for name in names {
            regions.entry(name).or_default().push(at as usize);
        }
    }
    regions
}

/// One comparison per region and channel of two pictures; the regions in `sharp` must have precise means.
pub fn compare_pictures(
    name: &str,
    one: &Picture,
    other: &Picture,
    regions: &BTreeMap<String, Vec<usize>>,
    sharp: &[&str],
) -> Vec<Comparison> {
    let mut comparisons = Vec::new();
    for (region, pixels) in regions {
        for (channel, color) in ["red", "green", "blue"].iter().enumerate() {
            comparisons.push(Comparison {
                what: format!("{name}, {region}, {color}"),
                one: one.mean_of(pixels, channel),
                other: other.mean_of(pixels, channel),
                sharp: sharp.contains(&region.as_str()),
            });
        }
    }
    comparisons
}

pub fn on_device(scene: &Scene, view: &View, samples: u32) -> Picture {
    let (device, selection) = support::open_device(None);
    let settings = Settings::default();
    let image = support::render(&device, scene, selection.variant, view, &settings, samples);
    support::assert_no_messages(&device);
    Picture {
        mean: image.mean,
        error_squared: image.error_squared,
        samples: samples.into(),
    }
}

pub fn by_brute_force(
    tracer: &Tracer,
    camera: &Camera,
    size: [u32; 2],
    options: &Options,
) -> Picture {
    let image = tracer.render(camera, size[0], size[1], options);
    Picture {
        mean: image.mean,
        error_squared: image.error_squared,
        samples: image.groups.into(),
    }
}

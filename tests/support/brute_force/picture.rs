//! Pictures: many paths through each pixel.

use super::Tracer;
use super::random::Draws;
use glam::DVec3;
use headwater::scene::Camera;
use std::sync::atomic::{AtomicU32, Ordering};

/// How a picture is made.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// 0: emission only; n: up to n scattering events.
    pub bounces: u32,
    /// Paths a pixel, all through its centre; stratified in groups of the largest power of two
    /// that divides them, so powers of two are best.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether lights are sampled too (and weighed against the surface's sampling by the balance
    /// heuristic), or else found by chance alone.
    pub nee: bool,
}

/// Row by row from the top.
pub struct Image {
    /// Mean radiance.
    pub mean: Vec<[f64; 3]>,
    /// Squared standard errors of the means.
    pub error_squared: Vec<[f64; 3]>,
    /// Independent groups of paths that each pixel's error comes from.
    pub groups: u32,
}

/// Origin and unit direction through a pixel's centre.
pub fn camera_ray(camera: &Camera, pixel: [u32; 2], size: [u32; 2]) -> (DVec3, DVec3) {
    let [x, y] = pixel.map(|p| f64::from(p) + 0.5);
    let [width, height] = size.map(f64::from);
    let half = (0.5 * camera.vertical_fov).tan();
    let local = DVec3::new(
        (2.0 * x / width - 1.0) * half * width / height,
        (1.0 - 2.0 * y / height) * half,
        -1.0,
    );
    let to_world = camera.camera_to_world;
    (
        to_world.translation,
        to_world.transform_vector3(local).normalize(),
    )
}

impl Tracer {
    /// The picture that `camera` sees.
    pub fn render(&self, camera: &Camera, width: u32, height: u32, options: &Options) -> Image {
        let count = (width * height) as usize;
        let mut image = Image {
            mean: vec![[0.0; 3]; count],
            error_squared: vec![[0.0; 3]; count],
            groups: options.samples / Draws::group(options.samples),
        };
        let next_row = AtomicU32::new(0);
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        let work = || {
            let mut rows = Vec::new();
            loop {
                let y = next_row.fetch_add(1, Ordering::Relaxed);
                if y >= height {
                    return rows;
                }
                let row = (0..width).map(|x| self.pixel(camera, [x, y], [width, height], options));
                rows.push((y, row.collect::<Vec<_>>()));
            }
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            for worker in workers {
                for (y, row) in worker.join().unwrap() {
                    for (x, (mean, error_squared)) in row.into_iter().enumerate() {
                        let at = y as usize * width as usize + x;
                        image.mean[at] = mean.to_array();
                        image.error_squared[at] = error_squared.to_array();
                    }
                }
            }
        });
        image
    }

    fn pixel(
        &self,
        camera: &Camera,
        [x, y]: [u32; 2],
        [width, height]: [u32; 2],
        options: &Options,
    ) -> (DVec3, DVec3) {
        let (origin, direction) = camera_ray(camera, [x, y], [width, height]);
        let group = Draws::group(options.samples);
        let groups = options.samples / group;
        let mut random = Draws::new(options.seed, u64::from(y * width + x), group);
        // Welford's running mean and sum of squared deviations, over groups: the paths of one are
        // not independent.
        let (mut mean, mut spread) = (DVec3::ZERO, DVec3::ZERO);
        for n in 1..=groups {
            random.deal();
            let mut value = DVec3::ZERO;
            for path in 0..group {
                random.path(path);
                value += self.path(origin, direction, options, &mut random);
            }
            value /= f64::from(group);
            let before = value - mean;
            mean += before / f64::from(n);
            spread += before * (value - mean);
        }
        let n = f64::from(groups);
        (mean, spread / (n * (n - 1.0).max(1.0)))
    }
}

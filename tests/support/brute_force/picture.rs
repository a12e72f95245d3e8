//! Pictures: the mean of many paths through each pixel, with its standard error.

use super::Tracer;
use super::random::Draws;
use glam::DVec3;
use headwater::scene::Camera;
use headwater::scene::camera::Projection;
use std::sync::atomic::{AtomicU32, Ordering};

/// The options of a picture: length and number of paths, seed, and estimator.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Maximum number of scattering events of a path; 0 shows emission only.
    pub bounces: u32,
    /// Number of paths per pixel, all through the pixel's centre. The paths are stratified in groups, whose size is a power
    /// of two that divides this number, so powers of two are best.
    pub samples: u32,
    /// Seed of all random numbers of the picture.
    pub seed: u64,
    /// True: lights are also sampled (next-event estimation), and weighed against BSDF sampling by the balance heuristic.
    /// False: only BSDF rays find emitters.
    pub nee: bool,
}

/// A picture and its errors; the pixels of each list are row by row from the top.
pub struct Image {
    /// Mean radiance (RGB) of each pixel.
    pub mean: Vec<[f64; 3]>,
    /// Squared standard error of the mean, for each pixel and channel.
    pub error_squared: Vec<[f64; 3]>,
    /// Number of independent groups of paths per pixel, from whose spread the error is computed.
    pub groups: u32,
}

/// Origin and unit direction, in world space, of the ray through the centre of a pixel; pixel (0, 0) is at the top left.
pub fn camera_ray(camera: &Camera, pixel: [u32; 2], size: [u32; 2]) -> (DVec3, DVec3) {
    let [x, y] = pixel.map(|p| f64::from(p) + 0.5);
    let [width, height] = size.map(f64::from);
    let half = camera.projection.half_height();
    let beside = DVec3::new(
        (2.0 * x / width - 1.0) * half * width / height,
        (1.0 - 2.0 * y / height) * half,
        0.0,
    );
    let (origin, direction) = match camera.projection {
        Projection::Perspective { lens: None, .. } => (DVec3::ZERO, beside + DVec3::NEG_Z),
        Projection::Perspective { .. } => panic!("a lens has many rays"),
        Projection::Orthographic { .. } => (beside, DVec3::NEG_Z),
    };
    let to_world = camera.camera_to_world;
    (
        to_world.transform_point3(origin),
        to_world.transform_vector3(direction).normalize(),
    )
}

impl Tracer {
    /// The picture of `width` × `height` pixels that `camera` sees, rendered by all cores.
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

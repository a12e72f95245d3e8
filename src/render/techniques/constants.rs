//! The constants of a frame's shaders.

use crate::layouts::{RestirConstants, ReuseConstants, ViewConstants};
use crate::render::scene_bindings::SceneBindings;
use crate::render::settings::{Candidates, Resampling, Search, Settings};
use glam::Vec2;

/// The constants that do not change from frame to frame, for buffers with `slots` places for pixels.
pub fn of_frame(
    view: &ViewConstants,
    bindings: &SceneBindings,
    settings: &Settings,
    slots: u32,
) -> RestirConstants {
    let (direct, indirect) = (&settings.direct, &settings.indirect);
    RestirConstants {
        view: *view,
        previous_camera: view.camera,
        jitter: Vec2::splat(0.5),
        previous_jitter: Vec2::splat(0.5),
        slots,
        frame: 0,
        jacobian_limit: indirect.jacobian_limit,
        min_distance: indirect.min_distance,
        bsdf_samples: if direct.draws_bsdf() {
            direct.bsdf_samples
        } else {
            0
        },
        more_bsdf_samples: direct.more_bsdf_samples,
        mean_light_luminance: bindings.scene.mean_light_luminance,
        reuse: ReuseConstants::default(),
    }
}

impl From<&Resampling> for ReuseConstants {
    fn from(resampling: &Resampling) -> Self {
        let Resampling {
            spatial, similar, ..
        } = resampling;
        Self {
            uniform_candidates: u32::from(resampling.candidates == Candidates::Uniform),
            light_samples: resampling.light_samples,
            temporal_confidence_cap: resampling.temporal.confidence_cap as f32,
            spatial_confidence_cap: spatial.confidence_cap as f32,
            spatial_passes: if resampling.reuse.is_spatial() {
                spatial.passes
            } else {
                0
            },
            tries: match spatial.search {
                Search::Random => spatial.neighbours,
                Search::Greedy => spatial.neighbours * spatial.tries,
            },
            radius: spatial.radius,
            min_normal_cosine: similar.normal.to_radians().cos(),
            depth_tolerance: similar.depth,
            same_material: similar.material.into(),
        }
    }
}

/// A position in the pixel, uniform over frames and seeds (the generator of `random.glsl`).
pub fn jitter(seed: u32, frame: u32) -> Vec2 {
    let mut v = [0x9E37_79B9_u32, frame, seed, 0xFFFF_FFFF]
        .map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    mix(&mut v);
    v.iter_mut().for_each(|x| *x ^= *x >> 16);
    mix(&mut v);
    Vec2::from_array([v[0], v[1]].map(|bits| (bits >> 8) as f32 * 2.0_f32.powi(-24)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge in the picture moves with the mean jitter of the frames that are averaged. Over seeds, that mean must
    /// deviate less than it would with independent positions.
    #[test]
    fn the_mean_jitter_of_some_frames_is_close_to_the_pixel_centre() {
        const SEEDS: u32 = 256;
        for frames in [4, 16, 64, 100] {
            let mean = |seed: u32, first: u32| {
                let sum: Vec2 = (first..first + frames)
                    .map(|frame| jitter(seed, frame))
                    .sum();
                sum / frames as f32 - Vec2::splat(0.5)
            };
            for first in [0, 1000] {
                let square: Vec2 = (0..SEEDS).map(|seed| mean(seed, first).powf(2.0)).sum();
                let deviation = (square / SEEDS as f32).max_element().sqrt();
                let independent = (1.0 / (12.0 * frames as f32)).sqrt();
                let share = deviation / independent;
                println!("{frames} frames from {first}: {share:.3} of independent positions");
                let limit = if frames == 4 { 0.6 } else { 0.25 };
                assert!(share < limit, "{frames} frames from {first}: {share:.3}");
            }
        }
    }

    #[test]
    fn every_position_is_uniform_over_seeds() {
        const SEEDS: u32 = 1 << 14;
        for frame in [0, 1, 5, 123_456, u32::MAX] {
            let mut counts = [0.0_f64; 16];
            for seed in 0..SEEDS {
                let cell = (jitter(seed, frame) * 4.0).as_uvec2();
                counts[(cell.y * 4 + cell.x) as usize] += 1.0;
            }
            let expected = f64::from(SEEDS) / 16.0;
            let chi_square: f64 = (counts.iter().map(|n| (n - expected).powi(2) / expected)).sum();
            // The 1e-5 quantile with 15 degrees of freedom.
            assert!(chi_square < 50.5, "frame {frame}: {chi_square}");
        }
    }
}

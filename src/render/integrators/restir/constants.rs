//! The constants that the shaders of a frame read, among them the jitter and the lens point of the frame, from which shaders
//! compute the position within each pixel, and the point of the lens, through which its primary ray passes.

use crate::render::scene_bindings::SceneBindings;
use crate::render::settings::{
    Candidates, Far, LightBvhSettings, LightChoice, Resampling, Rest, Search, Settings,
};
use crate::shader_interface::{
    GridConstants, RestirConstants, ReuseConstants, ViewConstants, WorldConstants,
};
use glam::Vec2;

/// Makes the constants of shaders, and sets those that stay the same in all frames. The others (the index and the jitter of
/// the frame, and the structures for the hash grid, world reservoirs and reuse) get default values, which the caller
/// replaces. `slots` is the number of slots for pixels in each buffer (the pixels, padded to whole tiles), and `light_nodes`
/// is the number of nodes of the light BVH, 0 without one. If `jitters` is true, primary rays pass through random points of
/// their pixels, otherwise through the centres.
pub fn frame_constants(
    view: &ViewConstants,
    bindings: &SceneBindings,
    settings: &Settings,
    light_nodes: u32,
    slots: u32,
    jitters: bool,
) -> RestirConstants {
    let (direct, indirect) = (&settings.direct, &settings.indirect);
    RestirConstants {
        view: *view,
        previous_camera: view.camera,
        jitters: u32::from(jitters),
        jitter: Vec2::ZERO,
        previous_jitter: Vec2::ZERO,
        lens_point: Vec2::ZERO,
        previous_lens_point: Vec2::ZERO,
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
        mean_light_luminance: bindings.scene.first_lights().mean_luminance,
        light_node_count: light_nodes,
        light_bvh_joins: (settings.light_bvh.far == Far::Joined).into(),
        light_tile: settings.light_bvh.tile,
        light_list: settings.light_bvh.list,
        light_bvh_uniform: (settings.light_bvh.choice == LightChoice::Uniform).into(),
        grid: GridConstants::default(),
        world: WorldConstants::default(),
        reuse: ReuseConstants::default(),
    }
}

/// The constants with which candidates of direct or of indirect light are drawn and reservoirs are reused, computed from the
/// settings of this light. `distant_fraction` is the probability, in [0, 1], that a draw among all lights selects a distant
/// light (at infinite distance). The light BVH contains no distant lights, so the higher this probability is, the fewer
/// candidates are drawn from the light BVH.
pub fn reuse_constants(
    resampling: &Resampling,
    light_bvh: &LightBvhSettings,
    distant_fraction: f32,
) -> ReuseConstants {
    let Resampling {
        spatial, similar, ..
    } = resampling;
    let draws_near = resampling.candidates == Candidates::LightBvh;
    let (near_samples, near_fraction) = match draws_near {
        true => near_samples(resampling.light_samples, light_bvh, distant_fraction),
        false => (0, 0.0),
    };
    let is_uniform = match resampling.candidates {
        Candidates::Uniform => true,
        Candidates::LightBvh => light_bvh.rest == Rest::Uniform,
        Candidates::Power | Candidates::HashGrid | Candidates::Auto => false,
    };
    ReuseConstants {
        uniform_candidates: is_uniform.into(),
        light_samples: resampling.light_samples,
        rare_lights: resampling.rare_lights,
        near_samples,
        near_fraction,
        temporal_confidence_cap: resampling.temporal.confidence_cap as f32,
        spatial_confidence_cap: spatial.confidence_cap as f32,
        neighbours: spatial.neighbours,
        // Pixels that are close together merge many of the same samples, so their noise is correlated. If the merge got
        // its full confidence, this noise would stay for many frames (in `cornell` with `balanced`, the error after eight
        // frames would be 0.0061 instead of 0.0045). So the confidence is limited to that of a merge with only
        // `neighbours` neighbours. It is at least 3, because with 1 the second frame has more noise than the first.
        confidence_without_history: if resampling.most_neighbours() > spatial.neighbours {
            (1 + spatial.neighbours).max(3) as f32
        } else {
            f32::MAX
        },
        tries: match spatial.search {
            Search::Random => 1,
            Search::Greedy => spatial.tries,
        },
        radius: spatial.radius,
        min_normal_cosine: similar.normal.to_radians().cos(),
        depth_tolerance: similar.depth,
        same_material: similar.material.into(),
    }
}

/// Returns how many of `count` light samples are drawn from the light BVH (a tree of lights), and this number as a
/// fraction of `count`. The other samples are drawn among all lights, because the light BVH does not contain lights at
/// infinite distance. `distant_fraction` is the probability, in [0, 1], that a draw among all lights selects such a
/// light; the higher it is, the more samples are drawn among all lights. If `count` is 1, the returned number is 1, and
/// the returned fraction is the probability that this sample is drawn from the light BVH.
fn near_samples(count: u32, settings: &LightBvhSettings, distant_fraction: f32) -> (u32, f32) {
    let rest = settings.uniform_share + (1.0 - settings.uniform_share) * distant_fraction;
    match count {
        1 => (1, 1.0 - rest),
        _ => {
            let rest = ((rest * count as f32).round() as u32).clamp(1, count);
            (count - rest, (count - rest) as f32 / count as f32)
        }
    }
}

/// The position within the first pixel of the picture, in [0, 1)², at which the primary ray of the frame `frame` passes.
/// Each of the other pixels adds its own offset to this position, modulo 1. The position is point `frame` of the
/// two-dimensional Sobol' sequence, Owen-scrambled by `seed` (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020).
/// Positions are uniform over seeds and stratified over successive frames, so the mean of several frames converges faster
/// than with independent positions.
pub fn jitter(seed: u32, frame: u32) -> Vec2 {
    sobol(frame, [hash(seed), hash(seed ^ 0x5555_5555)])
}

/// The point of the thin lens, in [0, 1)², through which primary rays pass in the frame `frame`, before each pixel adds its
/// offset. It is a point of the same sequence as [`jitter`], with another scramble. The order of the points is scrambled too
/// (Burley's padding): otherwise, a lens point would belong to each position in the pixel, and the mean over frames would be
/// wrong.
pub fn lens_point(seed: u32, frame: u32) -> Vec2 {
    let [order, x, y] = [0x3333_3333, 0x0F0F_0F0F, 0x00FF_00FF].map(|mask| hash(seed ^ mask));
    sobol(scrambled_order(frame, order), [x, y])
}

/// Point `index` of the two-dimensional Sobol' sequence, in [0, 1)², Owen-scrambled by a seed for each dimension.
fn sobol(index: u32, seeds: [u32; 2]) -> Vec2 {
    // Both dimensions of a point, as fractions of 2³², from the most significant bit down.
    let x = index.reverse_bits();
    let mut y = 0;
    let mut column = 1 << 31;
    for bit in 0..32 {
        if index >> bit & 1 != 0 {
            y ^= column;
        }
        // The columns of the second generator matrix are Pascal's triangle modulo 2.
        column ^= column >> 1;
    }
    let scrambled = [owen_scramble(x, seeds[0]), owen_scramble(y, seeds[1])];
    Vec2::from_array(scrambled.map(|bits| (bits >> 8) as f32 * 2.0_f32.powi(-24)))
}

/// Returns the Owen scramble of `x`, computed with a hash (Laine and Karras 2011). `x` is one coordinate of a point of
/// the Sobol' sequence, multiplied by 2³². A bit of `x` is flipped or not depending on the bits above it and on `seed`.
/// So the scrambled points are as evenly distributed as those of the sequence.
fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut bits = x.reverse_bits().wrapping_add(seed);
    for factor in [0x6C50_B47C_u32, 0xB82F_1E52, 0xC7AF_E638, 0x8D22_F6E6] {
        bits ^= bits.wrapping_mul(factor);
    }
    bits.reverse_bits()
}

/// An Owen scramble of the number `index`: each bit is flipped or not depending on a hash of the bits above it and of `seed`. So
/// numbers that begin at a multiple of a power of two, and are as many, stay among themselves, in a random order.
/// [`owen_scramble`] would not do: with some seeds its order depends on the block of numbers so little that positions and
/// lens points are visibly correlated after 16,384 frames.
fn scrambled_order(index: u32, seed: u32) -> u32 {
    (0..u32::BITS).fold(0, |order, bit| {
        let above = index >> bit >> 1;
        let flip = hash(above ^ hash(seed ^ bit));
        order | (((index >> bit) ^ flip) & 1) << bit
    })
}

/// A hash of `seed`, in which each bit depends on all bits of `seed`, so that similar seeds give unrelated jitter (Wellons,
/// "Prospecting for Hash Functions", 2018).
fn hash(seed: u32) -> u32 {
    let mut bits = seed ^ seed >> 16;
    bits = bits.wrapping_mul(0x7FEB_352D);
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x846C_A68B);
    bits ^ bits >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If frames are averaged, an edge in the picture is shifted by the mean of their jitters (the positions of primary rays
    /// in their pixels). So this mean must be close to the pixel's centre. Along each axis, the RMS distance of the mean
    /// from the centre, over many seeds, must be less than a quarter of the RMS distance that independent positions give.
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
                let fraction = deviation / independent;
                println!("{frames} frames from {first}: {fraction:.3} of independent positions");
                assert!(
                    fraction < 0.25,
                    "{frames} frames from {first}: {fraction:.3}"
                );
            }
        }
    }

    #[test]
    fn every_position_is_uniform_over_seeds() {
        const SEEDS: u32 = 1 << 14;
        for (frame, of) in [0, 1, 5, 123_456, u32::MAX]
            .into_iter()
            .flat_map(|frame| [jitter, lens_point].map(|of| (frame, of)))
        {
            let mut counts = [0.0_f64; 16];
            for seed in 0..SEEDS {
                let cell = (of(seed, frame) * 4.0).as_uvec2();
                counts[(cell.y * 4 + cell.x) as usize] += 1.0;
            }
            let expected = f64::from(SEEDS) / 16.0;
            let chi_square: f64 = (counts.iter().map(|n| (n - expected).powi(2) / expected)).sum();
            // The 1e-5 quantile with 15 degrees of freedom.
            assert!(chi_square < 50.5, "frame {frame}: {chi_square}");
        }
    }

    /// The mean over frames must contain each position in the pixel with each point of the lens, for every seed.
    #[test]
    fn positions_and_lens_points_are_independent_over_frames() {
        const FRAMES: u32 = 1 << 14;
        for seed in 0..8 {
            let mut counts = [0.0_f64; 256];
            for frame in 0..FRAMES {
                let (at, lens) = (jitter(seed, frame), lens_point(seed, frame));
                let digits = [at.x, at.y, lens.x, lens.y].map(|v| (v * 4.0) as usize);
                counts[digits.iter().fold(0, |cell, digit| 4 * cell + digit)] += 1.0;
            }
            let expected = f64::from(FRAMES) / 256.0;
            let chi_square: f64 = (counts.iter().map(|n| (n - expected).powi(2) / expected)).sum();
            // The 1e-5 quantile with 255 degrees of freedom.
            assert!(chi_square < 362.0, "seed {seed}: {chi_square}");
        }
    }
}

//! What a frame's shaders are told.

use crate::layouts::{FrameConstants, RestirConstants};
use crate::render::offered::Offered;
use crate::render::settings::{Candidates, Resampling, Search, Settings};

/// What view, scene and settings say to all passes; the buffers have `slots` places for pixels.
pub fn of_frame(
    frame: &FrameConstants,
    offered: &Offered,
    settings: &Settings,
    slots: u32,
) -> RestirConstants {
    let (direct, indirect) = (&settings.direct, &settings.indirect);
    RestirConstants {
        camera: frame.camera,
        previous_camera: frame.camera,
        jitter_x: 0.5,
        jitter_y: 0.5,
        previous_jitter_x: 0.5,
        previous_jitter_y: 0.5,
        width: frame.width,
        height: frame.height,
        slots,
        interleave: frame.interleave,
        seed: frame.seed,
        frame: 0,
        lights: frame.lights,
        instance_count: offered.scene.instance_count,
        bounces: frame.bounces,
        roulette_start: frame.roulette_start,
        roulette_floor: frame.roulette_floor,
        jacobian_limit: indirect.jacobian_limit,
        min_distance: indirect.min_distance,
        bsdf_samples: if direct.draws_bsdf() {
            direct.bsdf_samples
        } else {
            0
        },
        more_bsdf_samples: direct.more_bsdf_samples,
        lamp_luminance: offered.scene.lamp_luminance,
        ..RestirConstants::default()
    }
}

/// The same for the passes of one kind of light.
pub fn of_kind(frame: &RestirConstants, kind: &Resampling) -> RestirConstants {
    RestirConstants {
        uniform_candidates: u32::from(kind.candidates == Candidates::Uniform),
        light_samples: kind.light_samples,
        temporal_confidence_cap: kind.temporal.confidence_cap as f32,
        spatial_confidence_cap: kind.spatial.confidence_cap as f32,
        spatial_passes: if kind.reuse.is_spatial() {
            kind.spatial.passes
        } else {
            0
        },
        tries: match kind.spatial.search {
            Search::Random => kind.spatial.neighbours,
            Search::Greedy => kind.spatial.neighbours * kind.spatial.tries,
        },
        radius: kind.spatial.radius,
        least_normal_cosine: kind.similar.normal.to_radians().cos(),
        depth_tolerance: kind.similar.depth,
        same_material: kind.similar.material.into(),
        ..*frame
    }
}

/// A place in the pixel, uniform over frames and seeds (the generator of `random.glsl`).
pub fn jitter(seed: u32, frame: u32) -> [f32; 2] {
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
    [v[0], v[1]].map(|bits| (bits >> 8) as f32 * 2.0_f32.powi(-24))
}

//! What a frame's shaders are told.

use crate::layouts::{
    FrameConstants, MIS_BALANCE, MIS_CONSTANT, MIS_DEFENSIVE, MIS_PAIRWISE, RestirConstants,
    VISIBILITY_FINAL, VISIBILITY_INITIAL, VISIBILITY_NONE, VISIBILITY_WEIGHTS,
};
use crate::render::settings::{Candidates, Direct, Mis, Search, Visibility};

/// What settings, view and scene say; the buffers have `slots` places for pixels.
pub fn of(
    frame: &FrameConstants,
    direct: &Direct,
    slots: u32,
    lamp_luminance: f32,
) -> RestirConstants {
    let tries = match direct.spatial.search {
        Search::Random => direct.spatial.neighbours,
        Search::Greedy => direct.spatial.neighbours * direct.spatial.tries,
    };
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
        uniform_candidates: u32::from(direct.candidates == Candidates::Uniform),
        light_samples: direct.light_samples,
        bsdf_samples: if direct.draws_bsdf() {
            direct.bsdf_samples
        } else {
            0
        },
        more_bsdf_samples: direct.more_bsdf_samples,
        lamp_luminance,
        mis: match direct.mis {
            Mis::Constant => MIS_CONSTANT,
            Mis::Balance => MIS_BALANCE,
            Mis::Pairwise => MIS_PAIRWISE,
            Mis::Defensive => MIS_DEFENSIVE,
        },
        visibility: match direct.visibility {
            Visibility::None => VISIBILITY_NONE,
            Visibility::Final => VISIBILITY_FINAL,
            Visibility::Initial => VISIBILITY_INITIAL,
            Visibility::Weights => VISIBILITY_WEIGHTS,
        },
        temporal_confidence_cap: direct.temporal.confidence_cap as f32,
        spatial_confidence_cap: direct.spatial.confidence_cap as f32,
        spatial_passes: if frame.bounces > 0 && direct.reuse.is_spatial() {
            direct.spatial.passes
        } else {
            0
        },
        neighbours: direct.spatial.neighbours,
        tries,
        radius: direct.spatial.radius,
        least_normal_cosine: direct.similar.normal.to_radians().cos(),
        depth_tolerance: direct.similar.depth,
        same_material: direct.similar.material.into(),
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

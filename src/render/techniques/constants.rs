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

//! The directional albedo of the specular lobe: the fraction of light from one direction that the lobe reflects. From it,
//! shaders compute the energy that a model of single scattering between microfacets loses.

use crate::shader_interface::{ALBEDO_CELLS, MIRROR_ROUGHNESS};
use glam::DVec2;
use rayon::prelude::*;

/// The number of points with which the integral of each entry of the albedo table is computed. Higher: a smaller error, but
/// the table takes longer to make; with this number, the error of an albedo is below 5e-4. The points are those of a
/// low-discrepancy sequence. A regular grid of as many points has ten times the error, because the integrand has a step: it
/// drops to 0 where the reflected direction leaves the hemisphere.
const POINTS: u32 = 4096;

/// Directional albedo of a GGX lobe with height-correlated Smith masking and Schlick's Fresnel term. The first component of
/// the result is the part that F0 scales, and the second is the part that F90 scales, each in [0, 1]. Their sum is the
/// albedo of a lobe whose Fresnel term is 1.
///
/// `cosine` is the cosine between the normal and the outgoing direction, in [0, 1]. `roughness` is the perceptual roughness,
/// in [0, 1]; its square is alpha. The integral is taken over visible normals (Heitz 2018), because the integrand G2/G1 ×
/// Fresnel is then smooth and at most 1.
pub fn specular_albedo(cosine: f64, roughness: f64) -> DVec2 {
    let alpha = (roughness * roughness).max(1e-6);
    let cosine = cosine.clamp(1e-5, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt();
    let lambda = |c: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - c * c) / (c * c)).sqrt() - 1.0);
    let stretched = DVec2::new(alpha * sine, cosine).normalize();
    let mut sum = DVec2::ZERO;
    for point in 0..POINTS {
        // The plastic number's sequence (Roberts 2018), evenly spread in two dimensions.
        let along_sequence = |step: f64| (0.5 + f64::from(point) * step).fract();
        let phi = std::f64::consts::TAU * along_sequence(0.754_877_666_246_692_7);
        let u = along_sequence(0.569_840_290_998_053_2);
        let z = (1.0 - u) * (1.0 + stretched.y) - stretched.y;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (hx, hy, hz) = (
            alpha * (r * phi.cos() + stretched.x),
            alpha * r * phi.sin(),
            (z + stretched.y).max(0.0),
        );
        let length = (hx * hx + hy * hy + hz * hz).sqrt();
        if length == 0.0 {
            continue;
        }
        let along = (hx * sine + hz * cosine) / length;
        let incoming = 2.0 * along * hz / length - cosine;
        if incoming <= 0.0 {
            continue;
        }
        let seen = (1.0 + lambda(cosine)) / (1.0 + lambda(cosine) + lambda(incoming));
        let grazing = (1.0 - along).clamp(0.0, 1.0).powi(5);
        sum += seen * DVec2::new(1.0 - grazing, grazing);
    }
    sum / f64::from(POINTS)
}

/// The table of [`specular_albedo`] that shaders look up with `energy=compensated`. It has (ALBEDO_CELLS + 1)² entries: one
/// row per roughness, and in each row one entry per cosine, both in ascending order. The roughnesses are equally spaced in
/// [0, 1], but those below `MIRROR_ROUGHNESS` are raised to it. The cosines are the squares of equally spaced numbers, so
/// that more of them are at grazing angles, where the slope of the albedo changes most.
pub fn albedo_table() -> Vec<[f32; 2]> {
    let side = ALBEDO_CELLS + 1;
    (0..side * side)
        .into_par_iter()
        .map(|node| {
            let (row, column) = (node / side, node % side);
            let at = |index: u32| f64::from(index) / f64::from(ALBEDO_CELLS);
            let roughness = at(row).max(f64::from(MIRROR_ROUGHNESS));
            let cosine = at(column).powi(2);
            specular_albedo(cosine, roughness).as_vec2().to_array()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_lobe_reflects_all_and_a_rough_one_less() {
        let total = |cosine, roughness| specular_albedo(cosine, roughness).element_sum();
        assert!((total(0.7, 0.02) - 1.0).abs() < 1e-3);
        for cosine in [0.5, 1.0] {
            let albedos: Vec<f64> = [0.2, 0.5, 0.8, 1.0].map(|r| total(cosine, r)).to_vec();
            assert!(albedos.iter().all(|a| *a <= 1.0));
            assert!(
                albedos.windows(2).all(|w| w[1] < w[0]),
                "{cosine}: {albedos:?}"
            );
        }
    }

    #[test]
    fn the_table_interpolates_the_integral() {
        let table = albedo_table();
        let side = ALBEDO_CELLS as usize + 1;
        let mut worst: f64 = 0.0;
        for row in 4..ALBEDO_CELLS as usize {
            // From about half a degree above the horizon.
            for column in 6..ALBEDO_CELLS as usize {
                let corner = |r: usize, c: usize| {
                    let [a, b] = table[(row + r) * side + column + c];
                    f64::from(a) + f64::from(b)
                };
                let middle = (corner(0, 0) + corner(0, 1) + corner(1, 0) + corner(1, 1)) / 4.0;
                let at = |index: usize| (index as f64 + 0.5) / f64::from(ALBEDO_CELLS);
                let exact = specular_albedo(at(column).powi(2), at(row)).element_sum();
                worst = worst.max((middle / exact - 1.0).abs());
            }
        }
        // The furnace may be off by half a per cent.
        assert!(worst < 0.005, "worst relative error {worst}");
    }
}

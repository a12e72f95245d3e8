//! Exhibits: pictures and further numbers of one configuration on one scene, which the page of the scene
//! shows.

use super::comparison::Entry;
use super::pictures::LastFrames;
use super::reference::Reference;
use crate::metrics::relative::{relative_differences, relative_squares};
use crate::metrics::spectrum::Spectrum;
use crate::page::{Exhibit, FrameMap};
use crate::scene::lights::luminance;

/// Makes the exhibit of a configuration from the last frames of one of its runs, of `size` (width, height)
/// pixels. `reference` is the reference of the last frame. `is_steady` is true if all frames show the same
/// time, so that successive frames differ only by noise, and flicker can be measured.
pub fn exhibit(
    entry: &Entry<'_>,
    frames: LastFrames,
    reference: &Reference,
    size: (u32, u32),
    is_steady: bool,
) -> Exhibit {
    let size = (size.0 as usize, size.1 as usize);
    let mut spectrum = Spectrum::default();
    let [first, second] = relative_differences(&frames.last, &reference.halves, |pixel| {
        luminance(pixel.into())
    });
    spectrum.add([&first, &second], size);
    // Two means of frames have most of their frames in common.
    let before = frames.before.as_deref();
    let before = before.filter(|_| is_steady && !entry.configuration.accumulate);
    let errors = entry.row.relmse.iter();
    let passes = entry.cost.milliseconds.iter();
    Exhibit {
        errors: errors.map(|relmse| relmse.max(0.0).sqrt()).collect(),
        runs: entry.row.seeds as u32,
        passes: passes
            .map(|(name, ms)| (name.clone(), entry.frames_of_picture() * ms))
            .collect(),
        flicker: before.map(|before| flicker(&frames.last, before, reference)),
        spectrum: spectrum.bands(),
        low_frequencies: spectrum.low(),
        shared: None,
        picture: frames.last,
    }
}

/// The flicker between two successive frames: per pixel, the root of the squared relative difference, and
/// over the picture its root mean square.
fn flicker(last: &[[f32; 3]], before: &[[f32; 3]], reference: &Reference) -> FrameMap {
    let changes = relative_squares(last, before, &reference.halves);
    let sum: f64 = changes.iter().copied().map(f64::from).sum();
    FrameMap {
        value: (sum / changes.len().max(1) as f64).sqrt(),
        pixels: changes.into_iter().map(f32::sqrt).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flicker_is_the_root_of_the_mean_squared_relative_change() {
        let grey = vec![[1.0; 3]; 4];
        let reference = Reference::known(2, grey.clone(), grey.clone(), 8);
        let mut last = grey.clone();
        last[0] = [1.4; 3];
        let map = flicker(&last, &grey, &reference);
        // A quarter of 0.16 / 1.01.
        let wanted = (0.04_f64 / 1.01).sqrt();
        assert!((map.value - wanted).abs() < 1e-6, "{}", map.value);
        assert!((f64::from(map.pixels[0]) - 2.0 * wanted).abs() < 1e-6);
        assert_eq!(map.pixels[1], 0.0);
    }
}

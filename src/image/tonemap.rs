//! The conversion of radiance to display values: a tone curve, and the sRGB encoding.

use crate::shader_interface::{TONE_DESATURATION, TONE_KNEE};

/// The way in which radiance is shown in a picture with 8 bits per value, such as a PNG file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// The exposure in stops: radiance is multiplied by 2 to this power.
    pub exposure: f32,
    /// The curve that maps radiance to the brightness of the display, after exposure.
    pub curve: ToneCurve,
}

impl From<f32> for Look {
    /// The look with this exposure, in stops, and the default curve.
    fn from(exposure: f32) -> Self {
        Self {
            exposure,
            curve: ToneCurve::default(),
        }
    }
}

/// A curve that maps radiance to the brightness of a display, before the sRGB encoding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// The Khronos PBR neutral tone mapper without its toe: colours up to 0.8 stay, and brighter ones approach white.
    #[default]
    Neutral,
    /// No curve: values above 1 are clamped, channel by channel.
    None,
}

impl ToneCurve {
    /// The brightness of a display in [0, 1] for linear RGB radiance after exposure.
    pub fn map(self, radiance: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Neutral => tone_map(radiance),
            Self::None => radiance.map(|v| if v > 0.0 { v.min(1.0) } else { 0.0 }),
        }
    }
}

/// Maps linear RGB radiance, after exposure, to linear RGB display brightness in [0, 1], by the Khronos PBR
/// neutral tone mapper without its toe.
///
/// A colour whose largest component is at most 0.8 does not change, so that dark and middle tones can be
/// compared with those of other renderers. In a brighter colour, the largest component is mapped by a
/// hyperbola, which begins at 0.8 with slope 1 and tends to 1. The other components keep their ratio to the
/// largest one.
///
/// Then the brighter colour is mixed with the grey of its largest component. The fraction of grey grows with
/// the brightness, because a colour far too bright for a display is seen as white. Neither step changes the
/// hue, and every component rises with exposure.
///
/// The toe, an offset for 4 % of specular reflection, is left out because it changes dark tones. Negative
/// values and NaN become 0.
pub fn tone_map(radiance: [f32; 3]) -> [f32; 3] {
    // Clamped so that the arithmetic below stays finite.
    let colour = radiance.map(|v| if v > 0.0 { v.min(f32::MAX) } else { 0.0 });
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak <= TONE_KNEE {
        return colour;
    }
    let room = 1.0 - TONE_KNEE;
    let mapped = 1.0 - room * (room / (peak - TONE_KNEE + room));
    let white = 1.0 - 1.0 / (TONE_DESATURATION * (peak - mapped) + 1.0);
    colour.map(|v| {
        let scaled = (v / peak) * mapped;
        scaled + (mapped - scaled) * white
    })
}

/// The sRGB encoding (IEC 61966-2-1) of the linear value `value`, for 8-bit pictures. Both are in [0, 1].
fn to_srgb(value: f32) -> f32 {
    if value <= 0.003_130_8 {
        12.92 * value
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value of the sRGB-encoded value `value` (IEC 61966-2-1), for pictures that are read. Both are
/// in [0, 1].
pub(super) fn from_srgb(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// The 8-bit sRGB encoding of a linear value, for PNG files and FLIP. Values outside of [0, 1] are clamped, and NaN becomes
/// 0.
pub(crate) fn to_srgb_byte(value: f32) -> u8 {
    (to_srgb(value.clamp(0.0, 1.0)) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn darks_and_middles_stay_as_they_are() {
        for colour in [[0.0; 3], [1e-30, 0.18, 0.8], [0.5, 0.02, 0.0]] {
            assert_eq!(tone_map(colour), colour);
        }
    }

    #[test]
    fn every_component_rises_with_exposure_and_stays_within_one() {
        for colour in [[1.0, 1.0, 1.0], [1.0, 0.5, 0.0], [0.1, 0.9, 1.0]] {
            let mut before = [0.0; 3];
            for step in -400..400 {
                let now = tone_map(colour.map(|v: f32| v * (step as f32 * 0.1).exp2()));
                for axis in 0..3 {
                    // A ratio in floats may lose its last bit from one step to the next.
                    assert!(now[axis] >= before[axis] - 1e-6, "{colour:?} at {step}");
                    assert!((0.0..=1.0).contains(&now[axis]), "{colour:?} at {step}");
                }
                before = now;
            }
        }
        let greys: Vec<f32> = (0..2000)
            .map(|i| tone_map([i as f32 * 0.01; 3])[0])
            .collect();
        assert!(greys.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn the_hue_stays() {
        // The middle component's place between the least and the largest is the hue.
        let hue = |c: [f32; 3]| (c[1] - c[2]) / (c[0] - c[2]);
        for scale in [0.5, 1.0, 3.0, 50.0] {
            let mapped = tone_map([1.0, 0.4, 0.1].map(|v: f32| v * scale));
            assert!((hue(mapped) - hue([1.0, 0.4, 0.1])).abs() < 1e-3, "{scale}");
        }
    }

    #[test]
    fn without_a_curve_values_are_clamped() {
        let mapped = ToneCurve::None.map([0.9, 4.0, -1.0]);
        assert_eq!(mapped, [0.9, 1.0, 0.0]);
        assert_eq!(ToneCurve::None.map([f32::NAN; 3]), [0.0; 3]);
        assert!(ToneCurve::Neutral.map([0.9, 4.0, 0.0])[0] < 0.9);
    }

    #[test]
    fn what_is_no_colour_is_still_shown() {
        assert_eq!(tone_map([f32::NAN, -1.0, 0.25]), [0.0, 0.0, 0.25]);
        assert_eq!(tone_map([f32::INFINITY; 3]), [1.0; 3]);
        for value in tone_map([f32::INFINITY, 1.0, 0.0]) {
            assert!((0.0..=1.0).contains(&value));
        }
    }

    #[test]
    fn srgb_and_back_is_the_same_byte() {
        for byte in 0..=255 {
            assert_eq!(to_srgb_byte(from_srgb(f32::from(byte) / 255.0)), byte);
        }
        assert_eq!(to_srgb_byte(f32::NAN), 0);
        assert_eq!(to_srgb_byte(7.0), 255);
    }
}

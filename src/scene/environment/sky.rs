//! A generated sky: a clear sky with a sun, above a grey ground.
//!
//! The radiance of the sky is that of Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999.
//! The sun has the irradiance that the Linke turbidity gives (Kasten, "The Linke turbidity factor based on improved values
//! of the integral Rayleigh optical thickness", 1996), tinted by Rayleigh scattering. The ground fills the half below the
//! horizon. It reflects the light of the sky and the sun evenly in all directions.

use super::{Environment, direction};
use crate::base::nearest::nearest;
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The luminance, in kcd/m², that a radiance of 1 in the image of a generated sky stands for. With the value
/// 10, the radiance of most of a clear sky is below 1. A higher value makes the image darker.
const KILOCANDELAS: f64 = 10.0;

/// The angular radius of the sun's disc as seen from the ground, in radians: half of its apparent diameter.
/// Texels that the disc covers get the light of the sun.
const SUN_RADIUS: f64 = 0.2665 * PI / 180.0;

/// The parameters of a generated sky, from which [`Sky::environment`] computes the image of an environment. The user gives
/// them with `--environment sky:KEY=VALUE,KEY=VALUE`; the keys are the names of the fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Elevation of the sun above the horizon in degrees, in [0, 90]; 90 is the zenith.
    pub sun: f64,
    /// Azimuth of the sun in degrees, in [−360, 360]. At 0, the sun is seen along −Z; a higher value moves it clockwise, as
    /// seen from above.
    pub azimuth: f64,
    /// Turbidity, a measure of the haze of the air, in [2, 10]: 2 is very clear, 10 is hazy. A higher value
    /// makes the sun dimmer.
    pub turbidity: f64,
    /// Albedo of the grey ground below the horizon, in [0, 1]: the fraction of light that it reflects. With 0 the ground is
    /// black.
    pub ground: f64,
    /// Width of the environment's image in texels, an integer in [64, 8192]. The height of the image is half of it, rounded
    /// up.
    pub width: f64,
}

const KEYS: [(&str, f64, f64); 5] = [
    ("sun", 0.0, 90.0),
    ("azimuth", -360.0, 360.0),
    ("turbidity", 2.0, 10.0),
    ("ground", 0.0, 1.0),
    ("width", 64.0, 8192.0),
];

/// Parses the parameters of a sky: `KEY=VALUE` pairs that are separated by commas; a colon may come before the first pair.
/// The keys are the names of the fields of [`Sky`]. A missing key has its default:
/// `sun=40,azimuth=30,turbidity=3,ground=0.3,width=1024`.
///
/// # Errors
/// A part is not `KEY=VALUE`, a key is unknown, or a value is not a number or out of range.
pub fn parse(text: &str) -> Result<Sky> {
    let mut values = [40.0, 30.0, 3.0, 0.3, 1024.0];
    for part in text
        .trim_start_matches(':')
        .split(',')
        .filter(|p| !p.is_empty())
    {
        let (key, value) = part.split_once('=').ok_or_else(|| {
            Error::input(format!(
                "sky: '{part}' is not KEY=VALUE; write sky:KEY=VALUE,KEY=VALUE"
            ))
        })?;
        let Some(index) = KEYS.iter().position(|(name, ..)| *name == key) else {
            return Err(Error::input(format!(
                "sky has no parameter '{key}'{}; it has sun, azimuth, turbidity, ground and width",
                nearest(key, KEYS.iter().map(|(name, ..)| *name))
            )));
        };
        let (_, low, high) = KEYS[index];
        values[index] = (value.parse().ok())
            .filter(|number| (low..=high).contains(number))
            .ok_or_else(|| {
                Error::input(format!(
                    "sky: {key}={value} is not valid; it takes {low} to {high}"
                ))
            })?;
    }
    let [sun, azimuth, turbidity, ground, width] = values;
    Ok(Sky {
        sun,
        azimuth,
        turbidity,
        ground,
        width: width.round(),
    })
}

/// The environment with the image of the sky that `parameters` describe, in the syntax of [`parse`].
///
/// # Errors
/// The parameters are invalid, as described at [`parse`].
pub fn generate(parameters: &str) -> Result<Environment> {
    Ok(parse(parameters)?.environment())
}

impl Sky {
    /// Computes the image of the sky, its sun and the ground. The environment has an empty name, no rotation and the
    /// intensity 1. The sun gives the same irradiance at every resolution of the image, also if its disc is smaller than a
    /// texel.
    pub fn environment(&self) -> Environment {
        let width = self.width as u32;
        let mut environment = Environment {
            name: String::new(),
            width,
            height: width.div_ceil(2),
            texels: [].into(),
            rotation: 0.0,
            intensity: 1.0,
        };
        let height = environment.height;
        let texel_angles = |x: u32, y: u32, within: [f64; 2]| {
            let around = TAU * ((f64::from(x) + within[0]) / f64::from(width) - 0.5);
            (around, PI * (f64::from(y) + within[1]) / f64::from(height))
        };
        let sun = direction(self.azimuth.to_radians(), FRAC_PI_2 - self.sun.to_radians());
        let dome = Dome::new(self.sun.to_radians(), self.turbidity);
        let horizon = height / 2;
        let mut texels = vec![DVec3::ZERO; (width * height) as usize];
        // Irradiance of the ground.
        let mut irradiance = DVec3::ZERO;
        // The fraction of each texel that the sun's disc covers, and its solid angle in all.
        let (mut covered, mut disc) = (Vec::new(), 0.0);
        for y in 0..horizon {
            let solid_angle = environment.solid_angle(y);
            for x in 0..width {
                let (around, down) = texel_angles(x, y, [0.5; 2]);
                let toward = direction(around, down);
                let radiance = dome.radiance(down.cos(), toward.dot(sun));
                let index = (y * width + x) as usize;
                texels[index] = radiance;
                irradiance += radiance * (down.cos() * solid_angle);
                // Texels that are as near as the disc and their own diagonal reach.
                let reach = SUN_RADIUS + 1.5 * TAU / f64::from(width);
                if toward.dot(sun) > reach.cos() {
                    let fraction = fraction_of_disc(sun, |within| {
                        let (around, down) = texel_angles(x, y, within);
                        direction(around, down)
                    });
                    covered.push((index, fraction));
                    disc += fraction * solid_angle;
                }
            }
        }
        let direct = sun_irradiance(self.sun, self.turbidity);
        if disc > 0.0 {
            for (index, fraction) in covered {
                texels[index] += direct * (fraction / disc);
            }
            irradiance += direct * self.sun.to_radians().sin();
        }
        let ground = irradiance * (self.ground / PI);
        texels[(horizon * width) as usize..].fill(ground);
        environment.texels = texels.iter().map(|texel| texel.as_vec3()).collect();
        environment
    }
}

/// The fraction of a texel's area that the sun's disc covers, in [0, 1], estimated from a grid of 32 × 32 points. `sun` is
/// the unit direction of the sun. `at` returns the unit direction of a point of the texel from the two coordinates of the
/// point, each in [0, 1].
fn fraction_of_disc(sun: DVec3, at: impl Fn([f64; 2]) -> DVec3) -> f64 {
    const SIDE: u32 = 32;
    let coordinate = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    let points = (0..SIDE * SIDE).map(|i| at([coordinate(i % SIDE), coordinate(i / SIDE)]));
    let inside = points.filter(|point| (*point - sun).length() < 2.0 * (0.5 * SUN_RADIUS).sin());
    inside.count() as f64 / f64::from(SIDE * SIDE)
}

/// The linear RGB irradiance that the sun alone causes on a surface that faces it. Its unit is radiance × sr, where a
/// radiance of 1 stands for [`KILOCANDELAS`]. `elevation` is the sun's elevation in degrees, and `turbidity` the haze of the
/// air as in [`Sky::turbidity`].
fn sun_irradiance(elevation: f64, turbidity: f64) -> DVec3 {
    // Air mass (Kasten and Young 1989), and the optical thickness of clean, dry air.
    let mass = 1.0 / (elevation.to_radians().sin() + 0.50572 * (elevation + 6.07995).powf(-1.6364));
    let thickness =
        1.0 / (6.6296 + mass * (1.7513 + mass * (-0.1202 + mass * (0.0065 - 0.00013 * mass))));
    let watts = 1367.0 * (-0.8662 * turbidity * mass * thickness.max(0.0)).exp();
    // At about 105 lm/W.
    let luminance = watts * 105.0 / 1000.0 / KILOCANDELAS;
    // Rayleigh scattering at 610, 550 and 465 nm.
    let tint = DVec3::new(0.066, 0.1, 0.199) * -mass;
    let tint = DVec3::new(tint.x.exp(), tint.y.exp(), tint.z.exp());
    tint * (luminance / tint.dot(DVec3::new(0.2126, 0.7152, 0.0722)))
}

/// The light of the clear sky without the sun's disc, from which the image of a generated sky is computed. The colour of a
/// direction is given by its luminance Y and its chromaticities x and y (CIE xyY). Each of the three is a factor times the
/// function [`perez`] with its own coefficients.
struct Dome {
    coefficients: [[f64; 5]; 3],
    /// The factors by which the values of [`perez`] for Y (in kcd/m²), x and y are multiplied. Each is the wanted value at
    /// the zenith, divided by the value of [`perez`] at the zenith.
    scale: [f64; 3],
}

impl Dome {
    fn new(sun: f64, t: f64) -> Self {
        let angle = FRAC_PI_2 - sun;
        let coefficients = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * angle);
        let zenith = [
            (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192,
            chromaticity(
                t,
                angle,
                [
                    [0.00166, -0.00375, 0.00209, 0.0],
                    [-0.02903, 0.06377, -0.03202, 0.00394],
                    [0.11693, -0.21196, 0.06052, 0.25886],
                ],
            ),
            chromaticity(
                t,
                angle,
                [
                    [0.00275, -0.00610, 0.00317, 0.0],
                    [-0.04214, 0.08970, -0.04153, 0.00516],
                    [0.15346, -0.26756, 0.06670, 0.26688],
                ],
            ),
        ];
        let scale = std::array::from_fn(|i| zenith[i] / perez(&coefficients[i], 1.0, sun.sin()));
        Self {
            coefficients,
            scale,
        }
    }

    /// The linear RGB radiance of the sky in one direction; a radiance of 1 stands for [`KILOCANDELAS`]. `cosine` is the
    /// cosine of the angle between the direction and the zenith, `sun_cosine` that of the angle between the direction and
    /// the sun.
    fn radiance(&self, cosine: f64, sun_cosine: f64) -> DVec3 {
        let [luminance, x, y] = std::array::from_fn(|i| {
            self.scale[i] * perez(&self.coefficients[i], cosine.max(0.01), sun_cosine)
        });
        let xyz = DVec3::new(x, y, 1.0 - x - y) * (luminance.max(0.0) / y / KILOCANDELAS);
        // From CIE XYZ to linear sRGB (IEC 61966-2-1).
        let to_rgb = DMat3::from_cols(
            DVec3::new(3.2406, -0.9689, 0.0557),
            DVec3::new(-1.5372, 1.8758, -0.2040),
            DVec3::new(-0.4986, 0.0415, 1.0570),
        );
        (to_rgb * xyz).max(DVec3::ZERO)
    }
}

/// The formula of the sky model (Perez et al. 1993) for the luminance of the sky in one direction, or for one of its two
/// chromaticities. The value is relative: [`Dome`] multiplies it by a factor to get the quantity. The numbers `a` to `e` are
/// the coefficients of the formula. `cosine` is the cosine of the angle between the direction and the zenith, `sun_cosine`
/// that of the angle between the direction and the sun.
fn perez([a, b, c, d, e]: &[f64; 5], cosine: f64, sun_cosine: f64) -> f64 {
    let angle = sun_cosine.clamp(-1.0, 1.0).acos();
    (1.0 + a * (b / cosine).exp()) * (1.0 + c * (d * angle).exp() + e * sun_cosine * sun_cosine)
}

fn chromaticity(t: f64, angle: f64, rows: [[f64; 4]; 3]) -> f64 {
    let row = |[a, b, c, d]: [f64; 4]| ((a * angle + b) * angle + c) * angle + d;
    (row(rows[0]) * t + row(rows[1])) * t + row(rows[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_sun_keeps_its_irradiance_at_every_resolution() {
        for (elevation, width) in [(40.0, 1024.0), (40.0, 256.0), (89.0, 512.0), (10.0, 4096.0)] {
            let sky = Sky {
                sun: elevation,
                width,
                ..parse("").unwrap()
            };
            let environment = sky.environment();
            let toward = direction(sky.azimuth.to_radians(), FRAC_PI_2 - elevation.to_radians());
            let dome = Dome::new(elevation.to_radians(), sky.turbidity);
            let mut found = DVec3::ZERO;
            for (index, texel) in environment.texels.iter().enumerate() {
                let (x, y) = (
                    index as u32 % environment.width,
                    index as u32 / environment.width,
                );
                let around = TAU * ((f64::from(x) + 0.5) / width - 0.5);
                let down = PI * (f64::from(y) + 0.5) / f64::from(environment.height);
                let at = direction(around, down);
                if y < environment.height / 2 && at.dot(toward) > 0.9 {
                    let sky_alone = dome.radiance(down.cos(), at.dot(toward));
                    found += (texel.as_dvec3() - sky_alone) * environment.solid_angle(y);
                }
            }
            let wanted = sun_irradiance(elevation, sky.turbidity);
            assert!(
                (found / wanted - 1.0).abs().max_element() < 1e-3,
                "{found} {wanted}"
            );
        }
    }

    #[test]
    fn a_clear_sky_is_as_bright_as_skies_are() {
        let environment = generate("").unwrap();
        let horizontal: f64 = (environment.texels.iter().enumerate())
            .filter(|(index, _)| *index < environment.texels.len() / 2)
            .map(|(index, texel)| {
                let row = index as u32 / environment.width;
                let down = PI * (f64::from(row) + 0.5) / f64::from(environment.height);
                crate::scene::lights::luminance(*texel) * down.cos() * environment.solid_angle(row)
            })
            .sum();
        // In lux. With the sun 40° high, 60 to 90 thousand.
        let lux = horizontal * KILOCANDELAS * 1000.0;
        assert!((5e4..1e5).contains(&lux), "{lux}");
        let zenith = environment.texels[0];
        assert!(
            zenith.z > zenith.x && zenith.min_element() > 0.0,
            "{zenith}"
        );
        assert_eq!(
            environment.texels.last().map(|t| *t == Vec3::ZERO),
            Some(false)
        );
    }

    #[test]
    fn wrong_parameters_are_told_apart() {
        let message = |text: &str| parse(text).unwrap_err().to_string();
        assert!(message("sum=3").contains("sun"));
        assert!(message("sun=91").contains("0 to 90"));
        assert!(message("sun=NaN").contains("sun=NaN"));
        assert!(message("sun").contains("KEY=VALUE"));
        assert_eq!(parse("sun=12,turbidity=4").unwrap().sun, 12.0);
        assert_eq!(parse(":sun=12").unwrap(), parse("sun=12").unwrap());
    }
}

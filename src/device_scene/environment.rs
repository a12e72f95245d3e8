//! The environment (light from infinitely far away) as shaders read it: its texels, and the alias table with which light
//! samples draw a texel at random.

use super::units::Units;
use crate::scene::Environment;
use crate::scene::lights::{AliasTable, luminance};
use glam::{UVec2, Vec2, Vec4};
use std::f64::consts::{PI, TAU};

/// The fraction of light samples of the environment that are uniform over the sphere of directions. The others draw
/// texels in proportion to their mean luminance times their solid angle. Because of the uniform samples, even a dark
/// texel has a probability that 32 random bits can represent, so that light samples miss no part of the environment.
const UNIFORM_FRACTION: f64 = 0.02;

/// The data of the environment (light from infinitely far away) that are uploaded to the device. Shaders read from them how
/// much light comes from a direction, and draw light samples by them. For a scene without an environment, all arrays are
/// empty and the size is 0.
#[derive(Clone, Debug, Default)]
pub struct EnvironmentTexels {
    /// One entry per texel, row by row from the zenith. Red, green and blue are the radiance in the device's unit (the
    /// scene's unit times a power of two). The fourth component is the probability density with which light samples draw
    /// points in the texel, per square radian of longitude × latitude; shaders weight samples by it.
    pub texels: Vec<Vec4>,
    /// The alias table that draws texels, with one entry per texel. A draw picks an entry at random. If 32 random bits are
    /// below the first number of the entry, the entry's own texel is drawn; otherwise the texel whose index is the second
    /// number.
    pub columns: Vec<UVec2>,
    /// The width and the height of the environment in texels, with which shaders find the texel for a direction.
    pub size: UVec2,
    /// The cosine and the sine of the environment's rotation around the upward axis (+Y). Shaders turn a direction in world
    /// space by the opposite angle before they read the texels.
    pub turn: Vec2,
}

impl EnvironmentTexels {
    /// Prepares an environment for the device. Multiplies its radiance by its intensity, converts it to the device's unit of
    /// radiance (the scene's unit times a power of two), and builds the alias table by which light samples draw texels.
    pub fn of(environment: &Environment, units: &Units) -> Self {
        let (width, height) = (environment.width, environment.height);
        let means = environment.means();
        let row = |index: usize| index as u32 / width;
        // Texels are drawn by their mean after interpolation: where the interpolated light is not 0, the
        // texel can be drawn.
        let light = |index: usize| luminance(means[index]) * environment.solid_angle(row(index));
        let total: f64 = (0..means.len()).map(light).sum();
        let weights: Vec<f64> = (0..means.len())
            .map(|index| {
                let uniform = environment.solid_angle(row(index)) / (2.0 * TAU);
                let fraction = if total > 0.0 { UNIFORM_FRACTION } else { 1.0 };
                let own = if total > 0.0 {
                    light(index) / total
                } else {
                    0.0
                };
                (1.0 - fraction) * own + fraction * uniform
            })
            .collect();
        let table = AliasTable::new(&weights, 0.0);
        let cell = TAU / f64::from(width) * PI / f64::from(height);
        let scale = f64::from(environment.intensity) / units.radiance;
        let texels = environment.texels.iter().zip(&table.probabilities);
        let (sine, cosine) = environment.rotation.to_radians().sin_cos();
        Self {
            texels: texels
                .map(|(texel, probability)| {
                    let radiance = (texel.as_dvec3() * scale).as_vec3();
                    radiance.extend((probability / cell) as f32)
                })
                .collect(),
            columns: (table.columns.iter())
                .map(|column| UVec2::new(column.keep_below, column.alias))
                .collect(),
            size: UVec2::new(width, height),
            turn: Vec2::new(cosine as f32, sine as f32),
        }
    }
}

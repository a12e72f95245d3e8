//! Environments: light from infinitely far away, as an image over the sphere of directions. The image is read from a file,
//! or computed by a model of the sky.

mod neutral;
pub mod sky;

use super::lights::luminance;
use super::validate::{BRIGHTEST, is_within};
use crate::{Error, Result};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The maximum number of texels (width × height) of an environment's image; a larger image is refused. An image of this size
/// takes 1.5 GiB on the device: 24 bytes per texel, for its radiance and for its entry in the table that draws texels.
pub(crate) const MAX_TEXELS: u64 = 1 << 26;

/// Light from infinitely far away, which lights a scene from all sides and is its background: an image of radiance over the
/// sphere of directions, by longitude and latitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The name for messages: the path of the file, or the parameters of a generated sky.
    pub name: String,
    /// Width of the image in texels. A row of texels covers the full circle of longitudes.
    pub width: u32,
    /// Height of the image in texels. A column of texels covers the latitudes from the zenith to the nadir.
    pub height: u32,
    /// Linear RGB radiance of each texel, at least 0, row by row; it is multiplied by [`Environment::intensity`]. Row 0 is
    /// at the zenith (+Y). The middle column is seen along −Z, and higher columns are to the right of it, as seen from
    /// within. Look-ups interpolate between the centres of texels.
    pub texels: Arc<[Vec3]>,
    /// Rotation of the image around +Y in degrees, counter-clockwise seen from above: with 90, the middle column is seen
    /// along −X.
    pub rotation: f64,
    /// Factor by which the radiance of all texels is multiplied; 0 switches the environment off.
    pub intensity: f32,
}

impl Environment {
    /// Checks that the number of texels is valid, and puts the radiance of each texel into the range [0, [`BRIGHTEST`]], so
    /// that shaders can compute with the image. In a bad texel, each channel that is NaN or negative becomes 0, and each
    /// channel above the limit becomes [`BRIGHTEST`]. One line about bad texels, with their number and the position of the
    /// first one, is added to `notices`.
    ///
    /// # Errors
    /// The number of texels is 0, above 2²⁶ or not width × height, or all texels are bad.
    pub(crate) fn repair(&mut self, notices: &mut Vec<String>) -> Result<()> {
        let wrong = |fault: String| Err(Error::input(format!("{}: {fault}", self.name)));
        let texels = u64::from(self.width) * u64::from(self.height);
        if texels == 0 || texels > MAX_TEXELS || texels != self.texels.len() as u64 {
            return wrong(format!(
                "has {} × {} texels, an environment 1 to {MAX_TEXELS} in all; scale it",
                self.width, self.height
            ));
        }
        let is_bad = |texel: &Vec3| !is_within(*texel, BRIGHTEST);
        let Some(first) = self.texels.iter().position(is_bad) else {
            return Ok(());
        };
        let bad = self.texels.iter().filter(|texel| is_bad(texel)).count();
        let (x, y) = (first as u32 % self.width, first as u32 / self.width);
        if bad == self.texels.len() {
            return wrong(format!(
                "no texel has a radiance within 0 and {BRIGHTEST:e}; texel {x}, {y} is {}",
                self.texels[first]
            ));
        }
        notices.push(format!(
            "{}: {bad} of {texels} texels have a radiance that is not within 0 and {BRIGHTEST:e}, the first at x = {x}, y = {y}; NaN and negative values become 0, larger ones {BRIGHTEST:e}",
            self.name
        ));
        for texel in Arc::make_mut(&mut self.texels)
            .iter_mut()
            .filter(|texel| is_bad(texel))
        {
            // `max` puts 0 in place of NaN.
            *texel = texel
                .to_array()
                .map(|value| value.max(0.0).clamp(0.0, BRIGHTEST))
                .into();
        }
        Ok(())
    }

    /// The solid angle of each texel in the row with the index `row`, in steradians. It is the weight of such a texel in
    /// integrals over the sphere.
    pub fn solid_angle(&self, row: u32) -> f64 {
        // By the product, because differences of cosines cancel near the poles.
        let (middle, half) = (
            PI * (f64::from(row) + 0.5) / f64::from(self.height),
            0.5 * PI / f64::from(self.height),
        );
        TAU / f64::from(self.width) * 2.0 * middle.sin() * half.sin()
    }

    /// For each texel, the mean of the interpolated RGB radiance over its area, row by row from the zenith. The values are
    /// not multiplied by [`Self::intensity`]. Light samples draw texels in proportion to the luminance of these means, so
    /// they also draw black texels into which the light of a bright neighbour is interpolated.
    pub fn means(&self) -> Vec<Vec3> {
        let (width, height) = (self.width as usize, self.height as usize);
        let across = |row: usize| -> Vec<Vec3> {
            let texels = &self.texels[row * width..(row + 1) * width];
            (0..width)
                .map(|x| {
                    let beside = texels[(x + width - 1) % width] + texels[(x + 1) % width];
                    0.75 * texels[x] + 0.125 * beside
                })
                .collect()
        };
        let mut means = Vec::with_capacity(width * height);
        let (mut above, mut here) = (across(0), across(0));
        for row in 0..height {
            let below = across((row + 1).min(height - 1));
            let beside = above.iter().zip(&below).map(|(a, b)| *a + *b);
            means.extend((here.iter().zip(beside)).map(|(own, sum)| 0.75 * *own + 0.125 * sum));
            above = std::mem::replace(&mut here, below);
        }
        means
    }

    /// Two integrals over the sphere of directions: of the environment's luminance, in radiance × sr, and of the square of
    /// this luminance, in radiance² × sr. Both include [`Self::intensity`]. The first one decides the environment's power as
    /// a light. The second one divided by the first one is the mean luminance of light samples that are drawn in proportion
    /// to luminance.
    pub fn integrals(&self) -> (f64, f64) {
        let (mut integral, mut squares) = (0.0, 0.0);
        for (index, mean) in self.means().into_iter().enumerate() {
            let solid_angle = self.solid_angle(index as u32 / self.width);
            let luminance = luminance(mean) * f64::from(self.intensity);
            integral += luminance * solid_angle;
            squares += luminance * luminance * solid_angle;
        }
        (integral, squares)
    }

    /// The largest radiance in any channel (red, green or blue) of any texel, multiplied by the intensity. The device's unit
    /// of radiance is chosen from it and from other lights, so that the brightest light is near 1.
    pub fn brightest(&self) -> f32 {
        let brightest = self.texels.iter().map(|texel| texel.max_element());
        self.intensity * brightest.fold(0.0, f32::max)
    }

    /// True if the environment emits light: its intensity is above 0, and at least one texel is not black. If it emits none
    /// and the scene has no other light, the user is warned of a black picture.
    pub fn is_lit(&self) -> bool {
        self.brightest() > 0.0
    }
}

/// The unit vector of the direction with two given angles in radians. `around` is the angle from −Z around the vertical
/// axis, clockwise seen from above. `down` is the angle from the zenith (+Y).
pub(crate) fn direction(around: f64, down: f64) -> DVec3 {
    DVec3::new(
        down.sin() * around.sin(),
        down.cos(),
        -down.sin() * around.cos(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(width: u32, height: u32, texel: impl Fn(u32, u32) -> Vec3) -> Environment {
        Environment {
            name: "test".into(),
            width,
            height,
            texels: (0..height)
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| texel(x, y))
                .collect(),
            rotation: 0.0,
            intensity: 1.0,
        }
    }

    #[test]
    fn texels_cover_the_sphere() {
        for (width, height) in [(1, 1), (2, 1), (64, 33), (4096, 2048)] {
            let environment = environment(width, height, |_, _| Vec3::ONE);
            let rows = (0..height).map(|row| environment.solid_angle(row));
            let sum: f64 = rows.sum::<f64>() * f64::from(width);
            assert!((sum / (2.0 * TAU) - 1.0).abs() < 1e-9, "{sum}");
        }
    }

    #[test]
    fn means_reach_as_far_as_the_interpolation_does() {
        let sun = environment(8, 4, |x, y| {
            Vec3::splat(if (x, y) == (0, 0) { 64.0 } else { 0.0 })
        });
        let means = sun.means();
        let at = |x: usize, y: usize| means[8 * y + x].x;
        // The first row is its own neighbour above.
        assert_eq!(
            [at(0, 0), at(1, 0), at(7, 0)],
            [64.0 * 0.75 * 0.875, 7.0, 7.0]
        );
        assert_eq!([at(0, 1), at(1, 1), at(7, 1)], [6.0, 1.0, 1.0]);
        assert_eq!(means.iter().filter(|mean| mean.x > 0.0).count(), 6);
    }

    #[test]
    fn a_constant_environment_has_its_radiance_on_the_whole_sphere() {
        let mut constant = environment(16, 8, |_, _| Vec3::ONE);
        constant.intensity = 3.0;
        let (integral, squares) = constant.integrals();
        assert!((integral / (6.0 * TAU) - 1.0).abs() < 1e-6, "{integral}");
        assert!((squares / (18.0 * TAU) - 1.0).abs() < 1e-6, "{squares}");
    }

    #[test]
    fn radiance_out_of_range_is_replaced_and_counted() {
        for (value, replaced) in [
            (f32::NAN, 0.0),
            (f32::INFINITY, BRIGHTEST),
            (f32::NEG_INFINITY, 0.0),
            (-1.0, 0.0),
            (1e13, BRIGHTEST),
        ] {
            let mut broken = environment(4, 2, |x, y| {
                Vec3::new(1.0, if (x, y) >= (3, 0) { value } else { 0.0 }, -0.0)
            });
            let mut notices = Vec::new();
            broken.repair(&mut notices).unwrap();
            assert_eq!(broken.texels[3], Vec3::new(1.0, replaced, 0.0));
            assert_eq!(broken.texels[7], Vec3::new(1.0, replaced, 0.0));
            assert_eq!(broken.texels[6], Vec3::X);
            let [notice] = notices.as_slice() else {
                panic!("{notices:?}");
            };
            assert!(notice.starts_with("test: 2 of 8 texels "), "{notice}");
            assert!(notice.contains("first at x = 3, y = 0;"), "{notice}");
            broken.repair(&mut notices).unwrap();
            assert_eq!(notices.len(), 1, "a second repair changes nothing");
        }
    }

    #[test]
    fn an_image_of_bad_texels_only_is_refused() {
        let mut broken = environment(4, 2, |_, _| Vec3::NAN);
        let message = broken.repair(&mut Vec::new()).unwrap_err().to_string();
        assert!(
            message.contains("no texel has a radiance within 0 and 1e12"),
            "{message}"
        );
    }
}

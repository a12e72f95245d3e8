//! The power spectrum of the error of a picture. Errors of pixels that are independent of each other have the same power at all
//! spatial frequencies (white noise). Blotches, which are errors that neighbouring pixels share, have more power at low ones.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// The largest number of bands.
const MOST_BANDS: usize = 32;

/// The frequency, in cycles per pixel, below which [`Spectrum::low`] counts: errors with a period of more than eight pixels.
pub const LOW_FREQUENCY: f64 = 0.125;

/// The power of an error by spatial frequency, averaged over all directions and over the errors that were added.
#[derive(Clone, Debug, Default)]
pub struct Spectrum {
    /// The sum of the power in each band. The bands divide the frequencies from 0 to 0.5 cycles per pixel evenly.
    power: Vec<f64>,
    /// The number of coefficients in each band.
    coefficients: Vec<u64>,
    /// The power at low frequencies, and the number of coefficients there.
    low: (f64, u64),
}

impl Spectrum {
    /// Adds the error of a picture with `size` (width, height) pixels, row by row: its difference from each of two references
    /// whose noise is independent. The noise of the references has no part in the product of the two transforms.
    ///
    /// # Panics
    /// A list is shorter than the picture.
    pub fn add(&mut self, differences: [&[f64]; 2], size: (usize, usize)) {
        let (width, height) = size;
        let bands = MOST_BANDS.min(width.min(height) / 4).max(1);
        self.power.resize(bands, 0.0);
        self.coefficients.resize(bands, 0);
        // The two real transforms are the parts of one complex transform.
        let pairs = differences[0].iter().zip(differences[1]);
        let pairs = pairs.take(width * height);
        let pairs = pairs.map(|(re, im)| Complex::new(*re, *im)).collect();
        let transform = transform(pairs, size);
        let at = |x: usize, y: usize| transform[x * height + y];
        for x in 0..width {
            for y in 0..height {
                let frequency = distance(x, width).hypot(distance(y, height));
                if frequency == 0.0 || frequency > 0.5 {
                    continue;
                }
                let opposite = at((width - x) % width, (height - y) % height);
                let power = 0.5 * (at(x, y) * opposite).im;
                let band = (frequency * 2.0 * bands as f64) as usize;
                let band = band.min(bands - 1);
                self.power[band] += power;
                self.coefficients[band] += 1;
                if frequency < LOW_FREQUENCY {
                    self.low = (self.low.0 + power, self.low.1 + 1);
                }
            }
        }
    }

    /// The power in each band, relative to the mean over all of them, which white noise has in each; the bands divide the
    /// frequencies from 0 to 0.5 cycles per pixel evenly. A band without a coefficient, or of an error of 0, has the value 1.
    pub fn bands(&self) -> Vec<f64> {
        let bands = self.power.iter().zip(&self.coefficients);
        bands.map(|(p, n)| self.relative(*p, *n)).collect()
    }

    /// The power below [`LOW_FREQUENCY`], relative to that of white noise: 1 for independent pixels, and larger for blotches.
    pub fn low(&self) -> f64 {
        self.relative(self.low.0, self.low.1)
    }

    fn relative(&self, power: f64, coefficients: u64) -> f64 {
        let total: f64 = self.power.iter().sum();
        let mean = total / self.coefficients.iter().sum::<u64>().max(1) as f64;
        if coefficients == 0 || mean <= 0.0 {
            return 1.0;
        }
        power / coefficients as f64 / mean
    }
}

/// The frequency of a coefficient along one axis, in cycles per pixel.
fn distance(index: usize, length: usize) -> f64 {
    index.min(length - index) as f64 / length as f64
}

/// The Fourier transform of a picture, column by column.
fn transform(mut pixels: Vec<Complex<f64>>, (width, height): (usize, usize)) -> Vec<Complex<f64>> {
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(width).process(&mut pixels);
    let mut columns: Vec<Complex<f64>> = (0..width)
        .flat_map(|x| (0..height).map(move |y| y * width + x))
        .map(|index| pixels[index])
        .collect();
    planner.plan_fft_forward(height).process(&mut columns);
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Random;

    const SIZE: (usize, usize) = (48, 40);

    /// Pictures of independent values with the mean 0, which the seed selects.
    fn noise(seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        (0..SIZE.0 * SIZE.1)
            .map(|_| f64::from(random.unit()) - 0.5)
            .collect()
    }

    fn spectrum(picture: impl Fn(u64) -> [Vec<f64>; 2]) -> Spectrum {
        let mut spectrum = Spectrum::default();
        for seed in 0..40 {
            let [a, b] = picture(3 * seed);
            spectrum.add([&a, &b], SIZE);
        }
        spectrum
    }

    #[test]
    fn white_noise_is_flat() {
        let spectrum = spectrum(|seed| [noise(seed), noise(seed)]);
        let bands = spectrum.bands();
        assert_eq!(bands.len(), 10);
        // The first band has the fewest coefficients.
        assert!(bands.iter().all(|p| (p - 1.0).abs() < 0.3), "{bands:?}");
        assert!((spectrum.low() - 1.0).abs() < 0.1, "{}", spectrum.low());
    }

    #[test]
    fn blotches_have_power_at_low_frequencies() {
        let blurred = |seed| {
            let picture = noise(seed);
            let mean = |i: usize| {
                (0..6)
                    .map(|k| picture[(i + k) % picture.len()])
                    .sum::<f64>()
            };
            (0..picture.len()).map(mean).collect::<Vec<f64>>()
        };
        let spectrum = spectrum(|seed| [blurred(seed), blurred(seed)]);
        assert!(spectrum.low() > 2.0, "{}", spectrum.low());
        assert!(spectrum.bands()[9] < 0.7, "{:?}", spectrum.bands());
    }

    #[test]
    fn noise_of_the_references_does_not_count() {
        let sum = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a + b).collect();
        let wave = |_| {
            let value = |i: usize| (std::f64::consts::PI * (i % SIZE.0) as f64 / 2.0).sin();
            (0..SIZE.0 * SIZE.1).map(value).collect::<Vec<f64>>()
        };
        let spectrum = spectrum(|seed| {
            [
                sum(wave(seed), noise(seed + 1)),
                sum(wave(seed), noise(seed + 2)),
            ]
        });
        // The wave has 0.25 cycles per pixel, which begins the band with the index 5.
        let bands = spectrum.bands();
        let others = (0..10).filter(|i| *i != 5).map(|i| bands[i].abs());
        assert!(others.fold(0.0, f64::max) < 0.02 * bands[5], "{bands:?}");
    }
}

//! The power spectrum of the error of a picture. Errors of pixels that are independent of each other have the
//! same power at all spatial frequencies (white noise). Blotches, which are errors that neighbouring pixels
//! share, have more power at low frequencies.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// The largest number of bands into which a spectrum divides the frequencies from 0 to 0.5 cycles per pixel.
/// A picture with fewer than 128 pixels along an axis gets fewer bands, so that each band has enough
/// coefficients.
const MOST_BANDS: usize = 32;

/// The upper limit of low frequencies, in cycles per pixel. [`Spectrum::low`] contains the errors below it,
/// whose period is longer than eight pixels.
pub const LOW_FREQUENCY: f64 = 0.125;

/// The power of the error of pictures as a function of spatial frequency, averaged over all directions and
/// over the errors that were added. It shows whether the errors of pixels are independent or form blotches.
#[derive(Clone, Debug, Default)]
pub struct Spectrum {
    /// The sum of the power of all coefficients in each band. The bands divide the frequencies from 0 to 0.5
    /// cycles per pixel evenly, in increasing order.
    power: Vec<f64>,
    /// The number of Fourier coefficients that were added to each band of `power`. The mean power of a band
    /// is its sum divided by this number.
    coefficients: Vec<u64>,
    /// The sum of the power of all coefficients below [`LOW_FREQUENCY`], and the number of these
    /// coefficients.
    low: (f64, u64),
}

impl Spectrum {
    /// Adds the error of a picture with `size` (width, height) pixels to the spectrum. `differences` are the
    /// differences of the picture from two references, row by row; the noise of the references must be
    /// independent. The power is computed from the product of the Fourier transforms of the two differences
    /// instead of the square of one, so that the noise of the references cancels on average.
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

    /// The mean power in each band, divided by the mean power of all coefficients: white noise has the value
    /// 1 in each band. The bands divide the frequencies from 0 to 0.5 cycles per pixel evenly, in increasing
    /// order. A band without coefficients has the value 1; if the error is 0, all bands have the value 1.
    pub fn bands(&self) -> Vec<f64> {
        let bands = self.power.iter().zip(&self.coefficients);
        bands.map(|(p, n)| self.relative(*p, *n)).collect()
    }

    /// The mean power below [`LOW_FREQUENCY`], divided by the mean power of all coefficients: 1 if the errors
    /// of pixels are independent (white noise), and larger if they form blotches.
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

/// The magnitude of the frequency of a Fourier coefficient along one axis, in cycles per pixel, in [0, 0.5].
/// `index` is the index of the coefficient, and `length` is the number of pixels along the axis.
fn distance(index: usize, length: usize) -> f64 {
    index.min(length - index) as f64 / length as f64
}

/// The two-dimensional Fourier transform of a picture, which is given row by row. The result is column by
/// column: the coefficient with the index x along the width and y along the height is at x × height + y.
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

    /// A picture of `SIZE` pixels with independent random values in [−0.5, 0.5), which `seed` selects.
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

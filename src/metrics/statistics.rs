//! Estimates with confidence intervals, significance tests, medians and quantiles.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};
use statrs::statistics::{Data, OrderStatistics};

/// The number of degrees of freedom ν from which the normal distribution is used instead of Student's. The
/// quantiles of the two distributions then differ by about the fraction z²/(4ν) of the normal quantile z,
/// which is less than 1e-5 for |z| < 6.
const NORMAL_FROM: f64 = 1e6;

/// The expected count below which a bin is pooled with others before a χ² test (Cochran 1954). With smaller counts, the
/// statistic of the test does not follow the χ² distribution closely enough.
const MIN_EXPECTED: f64 = 5.0;

/// The largest product of the two sample sizes for which the Kolmogorov–Smirnov test is exact. The time of the exact test
/// grows with this product; above it, the limit distribution is used.
const MAX_EXACT: usize = 10_000_000;

/// The median of `values`, in their unit; for an even number of values, the mean of the middle two. NaN if
/// there are no values.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    Data::new(values.collect::<Vec<f64>>()).median()
}

/// The quantile of `values`, in their unit, at the fraction `part` in [0, 1], interpolated between
/// neighbouring values (method R-8 of Hyndman and Fan 1996). NaN if there are no values.
pub fn quantile(values: impl Iterator<Item = f64>, part: f64) -> f64 {
    Data::new(values.collect::<Vec<f64>>()).quantile(part)
}

/// A mean that was estimated from independent samples, such as the mean radiance of a picture from several renders, with the
/// data that confidence intervals and significance tests need.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Estimate {
    /// The estimated mean, in the unit of the samples. It is the centre of confidence intervals.
    pub mean: f64,
    /// The standard error of the mean, at least 0, in the unit of the samples. Confidence intervals are
    /// multiples of it.
    pub standard_error: f64,
    /// Number of samples from which the mean was estimated. Confidence intervals and tests use Student's
    /// distribution, whose degrees of freedom are this number minus 1.
    pub samples: u64,
}

impl Estimate {
    /// The mean of `values` with the standard error s/√n, where s is the standard deviation of the n values. The standard
    /// error of a single value is 0; the mean of no values is NaN.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        Self {
            mean,
            standard_error: (squares / (n - 1.0).max(1.0) / n).sqrt(),
            samples: values.len() as u64,
        }
    }

    /// Half the width of Student's confidence interval, in the unit of the samples. The centre of the interval is the
    /// estimated mean. The interval covers the true mean with probability `confidence` in (0, 1). The result is infinite for
    /// fewer than two samples.
    pub fn t_interval_half_width(&self, confidence: f64) -> f64 {
        if self.samples < 2 {
            return f64::INFINITY;
        }
        self.standard_error * t_quantile(0.5 + 0.5 * confidence, self.samples as f64 - 1.0)
    }

    /// The relative uncertainty of the estimate: half the width of Student's confidence interval, as a fraction of the
    /// magnitude of the mean. The interval covers the true mean with probability `confidence` in (0, 1). The result is
    /// infinite for a mean of 0, and for fewer than two samples.
    pub fn relative_half_width(&self, confidence: f64) -> f64 {
        let half_width = self.t_interval_half_width(confidence);
        if self.mean == 0.0 {
            return f64::INFINITY;
        }
        half_width / self.mean.abs()
    }

    /// The difference `self` − `other` of two independent estimates, with its standard error, both in the unit of the
    /// samples. The formula of Welch and Satterthwaite gives the degrees of freedom of the difference. The field `samples`
    /// of the result is these degrees, rounded down, plus 1, so that [`Self::t_interval_half_width`] calculates with them.
    pub fn minus(&self, other: &Self) -> Self {
        Self {
            mean: self.mean - other.mean,
            standard_error: self.standard_error.hypot(other.standard_error),
            samples: welch_degrees(self, other) as u64 + 1,
        }
    }
}

/// Two-sided p-value of Welch's test that two independent estimates have the same true mean (Welch, "The generalization of
/// 'Student's' problem when several different population variances are involved", 1947). A small p-value is evidence that
/// the true means differ.
///
/// If both standard errors are 0, the result is 1 for equal means and otherwise 0. It is NaN if an estimate is NaN.
pub fn welch_p_value(a: &Estimate, b: &Estimate) -> f64 {
    let difference = (a.mean - b.mean).abs();
    let error = a.standard_error.hypot(b.standard_error);
    if error == 0.0 {
        return match difference {
            0.0 => 1.0,
            d if d.is_nan() => d,
            _ => 0.0,
        };
    }
    2.0 * t_tail(difference / error, welch_degrees(a, b))
}

/// Degrees of freedom of the difference of two independent estimates, by the formula of Welch and
/// Satterthwaite; at least 1. Student's distribution with these degrees of freedom gives the p-value of the
/// difference.
fn welch_degrees(a: &Estimate, b: &Estimate) -> f64 {
    let squares = [a, b].map(|e| e.standard_error * e.standard_error);
    let total = squares[0] + squares[1];
    let spent: f64 = [a, b]
        .iter()
        .zip(squares)
        .filter(|(_, s)| *s > 0.0)
        .map(|(e, s)| (s / total).powi(2) / (e.samples as f64 - 1.0).max(1.0))
        .sum();
    if spent > 0.0 {
        (1.0 / spent).max(1.0)
    } else {
        ((a.samples + b.samples) as f64 - 2.0).max(1.0)
    }
}

fn t_quantile(probability: f64, degrees: f64) -> f64 {
    match StudentsT::new(0.0, 1.0, degrees) {
        Ok(student) if degrees < NORMAL_FROM => student.inverse_cdf(probability),
        _ => Normal::standard().inverse_cdf(probability),
    }
}

/// Probability that a variable with Student's t distribution of `degrees` degrees of freedom exceeds `t`: the one-sided
/// p-value of the statistic `t`. NaN if `t` is NaN.
pub(crate) fn t_tail(t: f64, degrees: f64) -> f64 {
    if t.is_nan() {
        return t;
    }
    match StudentsT::new(0.0, 1.0, degrees) {
        Ok(student) if degrees < NORMAL_FROM => student.sf(t),
        _ => Normal::standard().sf(t),
    }
}

/// Holm's adjusted p-values for tests of several hypotheses. `p_values` has the p-value of each hypothesis, and the result
/// has the same order. If all hypotheses with adjusted values below a level are rejected, the probability of any false
/// rejection is below that level, however the tests depend on each other (Holm, "A simple sequentially rejective multiple
/// test procedure", 1979).
///
/// A p-value of NaN counts as 0, so that a test without a result is reported as significant.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let known = |p: f64| if p.is_nan() { 0.0 } else { p };
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| known(p_values[a]).total_cmp(&known(p_values[b])));
    let mut adjusted = vec![0.0; p_values.len()];
    let mut largest = 0.0_f64;
    for (rank, &index) in order.iter().enumerate() {
        let scaled = known(p_values[index]) * (p_values.len() - rank) as f64;
        largest = largest.max(scaled.min(1.0));
        adjusted[index] = largest;
    }
    adjusted
}

/// P-value of Pearson's χ² test that `observed` counts come from a distribution with the `expected` counts (Pearson 1900).
/// Both slices have one entry per bin, in the same order, and must have the same sum.
///
/// All bins with an expected count below 5 are pooled into one bin. If its expected count is still below 5, it is added to
/// the other bin with the smallest expected count. The result is 0 if a bin has an expected count of 0 but an observed count
/// above 0. It is 1 if fewer than two bins are left.
///
/// # Panics
/// The slices differ in length.
pub fn chi_square_p_value(observed: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    let mut bins: Vec<(f64, f64)> = Vec::new();
    let mut pool = (0.0, 0.0);
    for (&seen, &wanted) in observed.iter().zip(expected) {
        if wanted <= 0.0 && seen > 0 {
            return 0.0;
        }
        if wanted >= MIN_EXPECTED {
            bins.push((seen as f64, wanted));
        } else {
            pool = (pool.0 + seen as f64, pool.1 + wanted);
        }
    }
    if pool.1 >= MIN_EXPECTED {
        bins.push(pool);
    } else if let Some(least) = bins.iter_mut().min_by(|a, b| a.1.total_cmp(&b.1)) {
        *least = (least.0 + pool.0, least.1 + pool.1);
    }
    if bins.len() < 2 {
        return 1.0;
    }
    let statistic: f64 = bins
        .iter()
        .map(|(seen, wanted)| (seen - wanted).powi(2) / wanted)
        .sum();
    ChiSquared::new(bins.len() as f64 - 1.0).map_or(f64::NAN, |d| d.sf(statistic))
}

/// P-value of the two-sided Kolmogorov–Smirnov test that two samples come from the same continuous distribution.
///
/// If the product of the sample sizes is at most 10⁷, the p-value is exact to about 1e-15. It is computed by counting the
/// orders of the pooled values for which the two empirical distribution functions differ less than those of `a` and `b`
/// (Hodges, "The significance probability of the Smirnov two-sample test", 1958). For larger samples, it comes from the
/// limit distribution with Stephens' correction ("Use of the Kolmogorov–Smirnov, Cramér–von Mises and related statistics
/// without extensive tables", 1970). Equal values in the samples make the p-value too large, in both cases. The result is 1
/// if a sample is empty, and NaN if a value is NaN.
pub fn kolmogorov_smirnov_p_value(a: &[f64], b: &[f64]) -> f64 {
    if a.iter().chain(b).any(|v| v.is_nan()) {
        return f64::NAN;
    }
    if a.is_empty() || b.is_empty() {
        return 1.0;
    }
    let [a, b] = [a, b].map(|values| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    });
    // The largest difference of the two empirical distributions, in units of 1/nm.
    let (n, m) = (a.len(), b.len());
    let (mut i, mut j) = (0, 0);
    let mut distance = 0;
    while i < n && j < m {
        let value = a[i].min(b[j]);
        while i < n && a[i] <= value {
            i += 1;
        }
        while j < m && b[j] <= value {
            j += 1;
        }
        distance = distance.max((i * m).abs_diff(j * n));
    }
    if n * m <= MAX_EXACT {
        return smirnov_tail(distance, n, m);
    }
    let size = ((n * m) as f64 / (n + m) as f64).sqrt();
    let statistic = distance as f64 / (n * m) as f64;
    kolmogorov_tail((size + 0.12 + 0.11 / size) * statistic)
}

/// The exact p-value of the Kolmogorov–Smirnov test: the probability that the empirical distribution functions of two
/// samples differ by at least `distance`/(`n` `m`) at some point. `n` and `m` are the sizes of the samples. Both samples are
/// assumed to come from one continuous distribution, so that all orders of the pooled values are equally likely.
fn smirnov_tail(distance: usize, n: usize, m: usize) -> f64 {
    // The fraction of orders of the first i and j values that stay below the distance. The last value
    // is one of the i with probability i/(i + j).
    let mut stayed = vec![0.0; m + 1];
    for i in 0..=n {
        for j in 0..=m {
            let all = (i + j) as f64;
            stayed[j] = if (i * m).abs_diff(j * n) >= distance {
                0.0
            } else if i + j == 0 {
                1.0
            } else {
                let from_a = if i > 0 { stayed[j] } else { 0.0 };
                let from_b = if j > 0 { stayed[j - 1] } else { 0.0 };
                (i as f64 * from_a + j as f64 * from_b) / all
            };
        }
    }
    1.0 - stayed[m]
}

/// Probability that a variable with Kolmogorov's limit distribution exceeds `x`: 2 Σ (−1)ᵏ⁻¹ exp(−2k²x²). It is the p-value
/// of the Kolmogorov–Smirnov test for large samples.
fn kolmogorov_tail(x: f64) -> f64 {
    if x < 0.2 {
        // 1 to within 1e-12; the series converges slowly here.
        return 1.0;
    }
    let mut sum = 0.0;
    let mut sign = 2.0;
    for k in 1..=100 {
        let term = (-2.0 * f64::from(k * k) * x * x).exp();
        sum += sign * term;
        if term < 1e-18 {
            break;
        }
        sign = -sign;
    }
    sum.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(got: f64, wanted: f64, relative: f64) {
        assert!(
            (got - wanted).abs() <= relative * wanted.abs(),
            "{got}, not {wanted}"
        );
    }

    fn estimate(mean: f64, standard_error: f64, samples: u64) -> Estimate {
        Estimate {
            mean,
            standard_error,
            samples,
        }
    }

    #[test]
    fn an_estimate_has_the_sample_mean_and_its_error() {
        let e = Estimate::of(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!((e.mean, e.samples), (2.5, 4));
        near(e.standard_error, (5.0 / 3.0_f64 / 4.0).sqrt(), 1e-15);
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 20.0].into_iter()), 3.0);
        assert_eq!(median([4.0, 1.0, 20.0, 3.0].into_iter()), 3.5);
        assert!(median(std::iter::empty()).is_nan());
    }

    #[test]
    fn intervals_follow_the_tables_of_student() {
        // NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.2.
        for (degrees, confidence, wanted) in [
            (1, 0.95, 12.706),
            (10, 0.95, 2.228),
            (10, 0.998, 4.144),
            (63, 0.99, 2.656),
            (100, 0.998, 3.174),
        ] {
            let e = estimate(7.0, 1.0, degrees + 1);
            near(e.t_interval_half_width(confidence), wanted, 3e-4);
        }
        let normal = estimate(0.0, 1.0, 1_000_000_000).t_interval_half_width(0.999);
        near(normal, 3.290_526_731, 1e-8);
        let below = estimate(0.0, 1.0, NORMAL_FROM as u64).t_interval_half_width(0.999);
        near(below, normal, 1e-5);
        let relative = estimate(-4.0, 1.0, 11).relative_half_width(0.95);
        near(relative, 2.228 / 4.0, 3e-4);
        assert_eq!(
            estimate(0.0, 0.0, 11).relative_half_width(0.95),
            f64::INFINITY
        );
        assert_eq!(
            estimate(0.0, 1.0, 1).t_interval_half_width(0.9),
            f64::INFINITY
        );
    }

    #[test]
    fn welch_agrees_with_worked_examples() {
        // Of equal sizes and errors it is Student's test: t = 2.228139 with 10 degrees.
        let p = welch_p_value(
            &estimate(2.228_138_852 * 2.0_f64.sqrt(), 1.0, 6),
            &estimate(0.0, 1.0, 6),
        );
        near(p, 0.05, 1e-6);
        // An exact side leaves Student's test of the other.
        near(
            welch_p_value(&estimate(4.143_7, 1.0, 11), &estimate(0.0, 0.0, 1)),
            0.002,
            1e-3,
        );
        // The normal limit.
        let p = welch_p_value(
            &estimate(3.0, 1.0, 4_000_000),
            &estimate(0.0, 1e-9, 4_000_000),
        );
        near(p, 0.002_699_796, 1e-6);
        // Unequal: ν = (1 + 4)² / (1/4 + 16/9) = 12.32…
        let difference = estimate(0.0, 1.0, 5).minus(&estimate(0.0, 2.0, 10));
        assert_eq!(difference.samples, 13);
        near(difference.standard_error, 5.0_f64.sqrt(), 1e-15);
        let exact = |m| welch_p_value(&estimate(m, 0.0, 5), &estimate(1.0, 0.0, 5));
        assert_eq!((exact(1.0), exact(1.5)), (1.0, 0.0));
        assert!(exact(f64::NAN).is_nan());
    }

    #[test]
    fn holm_steps_down() {
        assert_eq!(
            holm(&[0.01, 0.04, 0.03, 0.005]),
            vec![0.03, 0.06, 0.06, 0.02]
        );
        assert_eq!(holm(&[0.9, f64::NAN]), vec![0.9, 0.0]);
        assert_eq!(holm(&[0.8, 0.6]), vec![1.0, 1.0]);
        assert!(holm(&[]).is_empty());
    }

    #[test]
    fn chi_square_follows_the_table_and_pools() {
        // A die cast 60 times; 11.070 is the table's 5 % for 5 degrees, here 13.4 gives 1.99 %.
        let p = chi_square_p_value(&[5, 8, 9, 8, 10, 20], &[10.0; 6]);
        near(p, 0.019_905, 1e-4);
        // χ² of 4 with one degree: 4.55 %.
        near(
            chi_square_p_value(&[60, 40], &[50.0, 50.0]),
            0.045_500_264,
            1e-7,
        );
        // Pooled to two bins each time: into their own, or into the least.
        for (observed, expected) in [
            (vec![60, 20, 20], vec![50.0, 50.0, 0.0]),
            (vec![60, 39, 1], vec![50.0, 49.0, 1.0]),
        ] {
            let p = chi_square_p_value(&observed, &expected);
            let wanted = if expected[2] == 0.0 {
                0.0
            } else {
                0.045_500_264
            };
            near(p, wanted, 1e-7);
        }
        let many: Vec<f64> = [50.0].into_iter().chain([2.5; 20]).collect();
        let seen: Vec<u64> = [60].into_iter().chain([2; 20]).collect();
        near(chi_square_p_value(&seen, &many), 0.045_500_264, 1e-7);
        assert_eq!(chi_square_p_value(&[3], &[3.0]), 1.0);
    }
    #[test]
    fn kolmogorov_smirnov_counts_orders() {
        let range = |from: usize, to: usize| (from..to).map(|v| v as f64).collect::<Vec<_>>();
        // Apart: 2 of the C(10, 5) orders are, and 20 have a distance of 4/5 or more.
        let p = kolmogorov_smirnov_p_value(&range(0, 5), &range(5, 10));
        near(p, 2.0 / 252.0, 1e-12);
        let p = kolmogorov_smirnov_p_value(&[0.0, 1.0, 2.0, 3.0, 5.0], &[4.0, 6.0, 7.0, 8.0, 9.0]);
        near(p, 20.0 / 252.0, 1e-12);
        // Of unequal sizes: 2 of C(7, 3), whichever comes first.
        near(
            kolmogorov_smirnov_p_value(&range(0, 3), &range(3, 7)),
            2.0 / 35.0,
            1e-12,
        );
        near(
            kolmogorov_smirnov_p_value(&range(3, 7), &range(0, 3)),
            2.0 / 35.0,
            1e-12,
        );
        // Equal samples, ties and all; nothing; and what is no number.
        near(
            kolmogorov_smirnov_p_value(&[1.0, 1.0, 2.0], &[1.0, 1.0, 2.0]),
            1.0,
            1e-15,
        );
        assert_eq!(kolmogorov_smirnov_p_value(&[], &[1.0]), 1.0);
        assert!(kolmogorov_smirnov_p_value(&[f64::NAN], &[1.0]).is_nan());
    }

    #[test]
    fn kolmogorov_smirnov_tends_to_its_limit() {
        // Smirnov's table (1948): 5 %, 1 % and 0.1 %.
        for (x, wanted) in [(1.358_10, 0.05), (1.627_62, 0.01), (1.949_47, 0.001)] {
            near(kolmogorov_tail(x), wanted, 1e-4);
        }
        near(kolmogorov_tail(0.2), kolmogorov_tail(0.1), 1e-12);
        // Where both can be had, they agree.
        let (n, m) = (2000_usize, 3000_usize);
        let size = ((n * m) as f64 / (n + m) as f64).sqrt();
        for x in [0.8, 1.4, 1.8] {
            let distance = (x / size * (n * m) as f64) as usize;
            near(
                smirnov_tail(distance, n, m),
                kolmogorov_tail((size + 0.12 + 0.11 / size) * x / size),
                0.03,
            );
        }
    }
}

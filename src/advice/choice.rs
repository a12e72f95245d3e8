//! The decision of a race: which measured candidate is recommended, and how certain this recommendation is.

use super::front::{Point, Verdict};
use std::cmp::Ordering;

/// Maximum half-width of the 95 % interval of an error, as a fraction of the error, for a recommendation. If
/// the interval of the best candidate is wider, the verdict is [`Verdict::Undecided`].
const WIDEST_ERROR: f64 = 0.5;

/// Maximum half-width of the 95 % interval of the logarithm of the ratio of two errors at equal time, with
/// which two candidates can count as equal. If the interval is wider, the measurement is too inaccurate to
/// call them equal.
const EQUAL: f64 = 0.1;

/// Compares two measured candidates by their error at equal time; the better one is `Less`. A candidate with
/// an empty picture ([`Point::is_empty`], relative to `path_tracing`) is worse than all others.
pub fn compare(a: &Point, b: &Point, path_tracing: &Point) -> Ordering {
    let empty = |point: &Point| point.is_empty(path_tracing);
    let costs = [a, b].map(Point::log_cost);
    (empty(a).cmp(&empty(b))).then(costs[0].total_cmp(&costs[1]))
}

/// Sorts the measured candidates of the final: the recommended one comes first, its closest competitor
/// second. Returns the result of the comparison of these two. `path_tracing` is the yardstick by which empty
/// pictures are found.
pub fn decide(points: &mut [Point], path_tracing: &Point) -> Verdict {
    points.sort_by(|a, b| compare(a, b, path_tracing));
    let [first, others @ ..] = points else {
        return Verdict::Better;
    };
    let relative = first.error.half_width() / first.error.value;
    if relative.is_nan() || relative > WIDEST_ERROR {
        let factor = (relative / WIDEST_ERROR).powi(2);
        return Verdict::Undecided(if factor.is_finite() { factor } else { 4.0 });
    }
    // The cheapest of those that are as good comes first; the best one stays beside it.
    let is_equal = |point: &Point| {
        let ratio = point.log_error_at_equal_time(first);
        let half_width = ratio.t_interval_half_width(0.95);
        !point.is_empty(path_tracing) && ratio.mean <= half_width && half_width <= EQUAL
    };
    let cheaper = (0..others.len())
        .filter(|i| is_equal(&others[*i]))
        .min_by(|a, b| others[*a].milliseconds.total_cmp(&others[*b].milliseconds));
    match cheaper {
        Some(index) if others[index].milliseconds < first.milliseconds => {
            points[..=index + 1].rotate_right(1);
            return Verdict::Cheaper;
        }
        Some(index) => {
            points[1..=index + 1].rotate_right(1);
            return Verdict::Cheaper;
        }
        None => {}
    }
    let is_clear = |point: &Point| {
        let ratio = point.log_error_at_equal_time(first);
        point.is_empty(path_tracing) || ratio.mean > ratio.t_interval_half_width(0.95)
    };
    match others.iter().position(|point| !is_clear(point)) {
        None => Verdict::Better,
        Some(index) => {
            points[1..=index + 1].rotate_right(1);
            Verdict::Likely
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advice::candidates;
    use crate::advice::chain::{Chain, Purpose};
    use crate::advice::truth::{Observed, Truth};

    /// A candidate with the given relMSE, frame time in milliseconds and median brightness. They come from
    /// eight chains, whose relMSE differs from `relmse` by at most the fraction `scatter`.
    fn point(relmse: f64, milliseconds: f64, median: f64, scatter: f64) -> Point {
        let truth = Truth::new(
            [vec![[1.0; 3]; 4], vec![[1.0; 3]; 4]],
            &[vec![], vec![]],
            64,
        );
        let chains: Vec<Chain> = (0..8)
            .map(|seed| {
                let change = 1.0 + scatter * [-1.0, 1.0, -0.5, 0.5, 0.8, -0.8, 0.2, -0.2][seed];
                Chain {
                    observed: Observed {
                        relmse: relmse * change,
                        median,
                        mean: [1.0; 3],
                    },
                    of_means: Vec::new(),
                    milliseconds,
                }
            })
            .collect();
        let mut candidate = candidates::all(Purpose::Steady).unwrap().remove(1);
        candidate.name = format!("{relmse} {milliseconds}");
        Point::of(&candidate, &chains, &truth)
    }

    fn decided(points: &[Point], path_tracing: &Point) -> (String, Verdict) {
        let mut points = points.to_vec();
        let verdict = decide(&mut points, path_tracing);
        (points[0].candidate.name.clone(), verdict)
    }

    #[test]
    fn the_smaller_error_at_equal_time_wins() {
        let yardstick = point(1.0, 10.0, 1.0, 0.01);
        // In the time of 40 ms path tracing has 0.25.
        let good = point(0.1, 40.0, 1.0, 0.01);
        let points = [yardstick.clone(), good.clone()];
        assert_eq!(
            decided(&points, &yardstick),
            ("0.1 40".into(), Verdict::Better)
        );
        let bad = point(0.5, 40.0, 1.0, 0.01);
        let points = [bad, yardstick.clone()];
        assert_eq!(
            decided(&points, &yardstick),
            ("1 10".into(), Verdict::Better)
        );
    }

    #[test]
    fn of_equal_ones_the_cheaper_is_taken() {
        let yardstick = point(1.0, 10.0, 1.0, 0.01);
        let (cheap, dear) = (point(0.201, 20.0, 1.0, 0.05), point(0.1, 40.0, 1.0, 0.05));
        let points = [dear, yardstick.clone(), cheap];
        assert_eq!(
            decided(&points, &yardstick),
            ("0.201 20".into(), Verdict::Cheaper)
        );
    }

    #[test]
    fn what_may_be_chance_is_not_called_equal() {
        let yardstick = point(1.0, 10.0, 1.0, 0.01);
        let (cheap, dear) = (point(0.24, 20.0, 1.0, 0.6), point(0.1, 40.0, 1.0, 0.6));
        let points = [cheap, dear, yardstick.clone()];
        assert_eq!(
            decided(&points, &yardstick),
            ("0.1 40".into(), Verdict::Likely)
        );
        let points = [point(0.1, 40.0, 1.0, 3.0), yardstick.clone()];
        let (_, verdict) = decided(&points, &yardstick);
        assert!(
            matches!(verdict, Verdict::Undecided(factor) if factor > 1.0),
            "{verdict:?}"
        );
    }

    #[test]
    fn a_clean_and_empty_picture_loses() {
        let yardstick = point(2.0, 10.0, 0.8, 0.01);
        let (empty, good) = (point(0.01, 20.0, 0.1, 0.01), point(0.5, 20.0, 0.9, 0.01));
        let points = [empty, good, yardstick.clone()];
        assert_eq!(
            decided(&points, &yardstick),
            ("0.5 20".into(), Verdict::Better)
        );
    }
}

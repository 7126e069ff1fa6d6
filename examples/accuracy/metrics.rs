//! How far light is off, and which points no other point beats.

/// What a value differs from the truth by, over elements weighted by their area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Metrics {
    /// `√(Σ A (x − r)² / Σ A r²)`, the error of all charts.
    pub(crate) l2: f64,
    /// Root of the mean square, by the mean of the truth.
    pub(crate) rms: f64,
    /// Largest, by the mean of the truth.
    pub(crate) largest: f64,
    /// Relative error that 95 % of the area stays below.
    pub(crate) p95: f64,
    /// The same of 99 %.
    pub(crate) p99: f64,
    /// Mean of the signed error, by the mean of the truth: light gained or lost.
    pub(crate) gain: f64,
    /// Share of the area that is off by more than 5 %.
    pub(crate) off: f64,
}

impl Metrics {
    pub(crate) const NAMES: [&str; 7] = [
        "l2",
        "rms",
        "largest",
        "p95",
        "p99",
        "gain",
        "off_5_percent",
    ];

    pub(crate) fn values(&self) -> [f64; 7] {
        [
            self.l2,
            self.rms,
            self.largest,
            self.p95,
            self.p99,
            self.gain,
            self.off,
        ]
    }

    /// The median of each figure over several runs.
    pub(crate) fn median(runs: &[Self]) -> Self {
        let of = |figure: fn(&Self) -> f64| median(runs.iter().map(figure));
        Self {
            l2: of(|m| m.l2),
            rms: of(|m| m.rms),
            largest: of(|m| m.largest),
            p95: of(|m| m.p95),
            p99: of(|m| m.p99),
            gain: of(|m| m.gain),
            off: of(|m| m.off),
        }
    }
}

/// Relative errors are told by this share of the mean at least: dark corners do not count more.
const DARKEST: f64 = 0.01;

/// Compares values with the truth; each sample is area, value, truth.
pub(crate) fn compare(samples: &[[f64; 3]]) -> Metrics {
    let sum = |term: fn(&[f64; 3]) -> f64| samples.iter().map(term).sum::<f64>();
    let area = sum(|[a, ..]| *a).max(f64::MIN_POSITIVE);
    let mean = (sum(|[a, _, r]| a * r) / area).max(f64::MIN_POSITIVE);
    let squares = sum(|[a, x, r]| a * (x - r).powi(2));
    let of_truth = sum(|[a, _, r]| a * r * r).max(f64::MIN_POSITIVE);
    let mut relative: Vec<(f64, f64)> = (samples.iter())
        .map(|&[a, x, r]| ((x - r).abs() / r.max(DARKEST * mean), a))
        .collect();
    relative.sort_by(|a, b| a.0.total_cmp(&b.0));
    let largest = samples.iter().map(|[_, x, r]| (x - r).abs());
    let off = relative.iter().filter(|e| e.0 > 0.05).map(|e| e.1);
    Metrics {
        l2: (squares / of_truth).sqrt(),
        rms: (squares / area).sqrt() / mean,
        largest: largest.fold(0.0, f64::max) / mean,
        p95: quantile(&relative, 0.95),
        p99: quantile(&relative, 0.99),
        gain: sum(|[a, x, r]| a * (x - r)) / area / mean,
        off: off.sum::<f64>() / area,
    }
}

/// The value that the share `q` of the weight stays below; pairs of value and weight, ascending.
fn quantile(ascending: &[(f64, f64)], q: f64) -> f64 {
    let total: f64 = ascending.iter().map(|e| e.1).sum();
    let mut below = 0.0;
    let reached = ascending.iter().find(|e| {
        below += e.1;
        below >= q * total
    });
    reached.or(ascending.last()).map_or(0.0, |e| e.0)
}

/// The middle value; of an even number the lower of the two.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values
        .get(values.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or(0.0)
}

/// The points that no other beats in both cost and error, by cost.
pub(crate) fn pareto(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|best| point.1 < best.1) {
            front.push(point);
        }
    }
    front
}

/// The least cost at which a method comes below an error, read off its line between points.
///
/// Lines are straight on logarithmic axes. Only a point that was measured below the error counts
/// as having reached it.
pub(crate) fn cost_of(error: f64, points: &[(f64, f64)]) -> Option<f64> {
    let front = pareto(points);
    let below = front.iter().position(|p| p.1 <= error)?;
    let (cost, reached) = front[below];
    let Some(&(cheaper, worse)) = below.checked_sub(1).and_then(|i| front.get(i)) else {
        return Some(cost);
    };
    let part = (worse / error).ln() / (worse / reached.max(f64::MIN_POSITIVE)).ln();
    Some(cheaper * (cost / cheaper).powf(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_two_elements() {
        // Three quarters of the area are right, one quarter is off by 10 %.
        let m = compare(&[[3.0, 2.0, 2.0], [1.0, 2.2, 2.0]]);
        assert!((m.l2 - 0.05).abs() < 1e-12, "√(0.04 / 16)");
        assert!((m.rms - 0.05).abs() < 1e-12);
        assert!((m.largest - 0.1).abs() < 1e-12);
        assert!((m.gain - 0.025).abs() < 1e-12);
        assert_eq!(m.off, 0.25);
        assert!((m.p95 - 0.1).abs() < 1e-12);
    }

    #[test]
    fn dark_elements_are_told_by_the_mean() {
        let m = compare(&[[1.0, 0.001, 0.0], [1.0, 2.0, 2.0]]);
        assert!((m.p99 - 0.1).abs() < 1e-12, "0.001 of 1 % of the mean 1");
        assert_eq!(compare(&[]), Metrics::default());
    }

    #[test]
    fn quantiles_go_by_weight() {
        let errors = [(0.1, 1.0), (0.2, 98.0), (0.9, 1.0)];
        assert_eq!(quantile(&errors, 0.005), 0.1);
        assert_eq!(quantile(&errors, 0.95), 0.2);
        assert_eq!(quantile(&errors, 0.995), 0.9);
    }

    #[test]
    fn medians() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), 2.0);
        assert_eq!(median([]), 0.0);
    }

    #[test]
    fn front_of_points() {
        let points = [(2.0, 5.0), (1.0, 9.0), (3.0, 6.0), (4.0, 1.0), (4.0, 2.0)];
        assert_eq!(pareto(&points), [(1.0, 9.0), (2.0, 5.0), (4.0, 1.0)]);
        assert_eq!(pareto(&[]), []);
    }

    #[test]
    fn cost_is_read_off_the_line() {
        // Error falls as the root of the cost: a tenth of it costs a hundred times as much.
        let points = [(1.0, 0.1), (100.0, 0.01)];
        let cost = cost_of(0.1 / 10_f64.sqrt(), &points);
        assert!((cost.unwrap() - 10.0).abs() < 1e-9);
        assert_eq!(cost_of(0.2, &points), Some(1.0));
        assert_eq!(cost_of(0.005, &points), None);
    }
}

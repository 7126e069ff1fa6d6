//! Quadrature.

use glam::DVec3;

/// Nodes in −1..1 and weights (they sum to 2) of the Gauss–Legendre rule of `n` points, exact for
/// polynomials of degree `2n − 1`.
///
/// The nodes are the zeros of the Legendre polynomial `P_n`, found by Newton's method from
/// `cos(π (i + 3/4) / (n + 1/2))`, which lies nearer to zero `i` than to any other.
pub(super) fn legendre(n: u32) -> Vec<(f64, f64)> {
    let node = |i: u32| {
        let mut x = (std::f64::consts::PI * (f64::from(i) + 0.75) / (f64::from(n) + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (value, below) = polynomials(n, x);
            slope = f64::from(n) * (x * value - below) / (x * x - 1.0);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// `P_n(x)` and `P_{n−1}(x)`.
fn polynomials(n: u32, x: f64) -> (f64, f64) {
    (1..=n).fold((1.0, 0.0), |(value, below), k| {
        let k = f64::from(k);
        let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * below) / k;
        (next, value)
    })
}

/// Points of a convex polygon and their weights, which sum to its area: the Gauss rule in each
/// triangle of a fan, as a square with one side drawn together to a point.
pub(super) fn on_polygon<'a>(
    polygon: &'a [DVec3],
    rule: &'a [(f64, f64)],
) -> impl Iterator<Item = (DVec3, f64)> + 'a {
    let fan = polygon.windows(2).skip(1);
    fan.flat_map(move |far| {
        let (p, u, v) = (polygon[0], far[0] - polygon[0], far[1] - far[0]);
        let doubled = u.cross(v).length();
        let pairs = rule
            .iter()
            .flat_map(move |&s| rule.iter().map(move |&t| (s, t)));
        pairs.map(move |((s, weight_s), (t, weight_t))| {
            let (s, t) = (0.5 + 0.5 * s, 0.5 + 0.5 * t);
            (
                p + (u + v * t) * s,
                0.25 * weight_s * weight_t * doubled * s,
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_integrated_exactly() {
        for n in 1..=16 {
            let rule = legendre(n);
            for power in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                let truth = if power.is_multiple_of(2) {
                    2.0 / f64::from(power + 1)
                } else {
                    0.0
                };
                assert!((sum - truth).abs() < 1e-14, "{n} points, x^{power}: {sum}");
            }
        }
    }

    #[test]
    fn polynomials_over_a_polygon_are_integrated_exactly() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)];
        let square = square.map(|(x, y)| DVec3::new(x, y, 0.0));
        let rule = legendre(4);
        let sum: f64 = on_polygon(&square, &rule)
            .map(|(p, w)| w * p.x.powi(3) * p.y.powi(2))
            .sum();
        assert!((sum - 4.0 / 3.0).abs() < 1e-14, "{sum}");
    }
}

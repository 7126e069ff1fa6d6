use super::{HeightMap, Wrap};

/// Passes of a box that make a Gaussian of it, to 3 % of its height.
const PASSES: usize = 3;

/// What of a map is broader than a Gaussian window of the standard deviation `sigma` in texels: at every
/// texel the plane that fits the heights in the window best, there.
///
/// Where a map repeats, so does the window, and the plane's height is the weighted mean. At other borders
/// the window is cut off; a mean would lean inwards there, which a plane does not (J. Fan,
/// "Design-adaptive nonparametric regression", 1992). With weights `w` and the distance `d` from the
/// texel, each axis for itself,
///
/// ```text
///   m = Σwd / Σw     v = Σwd² / Σw − m²     h̄ = Σwh / Σw     b = (Σwdh / Σw − m h̄) / v
///
///                     ┌──────────────────────────┐
///   height there  =   │   h̄ − m_x b_x − m_y b_y   │
///                     └──────────────────────────┘
/// ```
///
/// because weights that are products of one by column and one by row leave columns and rows uncorrelated.
pub(super) fn low_pass(map: &HeightMap, sigma: f32) -> Vec<f32> {
    let size = map.size().map(|n| n as usize);
    let [across, down] = [0, 1].map(|axis| Axis::new(size[axis], map.wrap()[axis], sigma));
    let heights: Vec<f64> = map.heights().iter().map(|&h| f64::from(h)).collect();
    let tilted = |axis: &Axis, place: fn(usize, usize) -> usize| {
        let moved = |(i, h): (usize, &f64)| axis.position[place(i, size[0])] * h;
        (!axis.repeats).then(|| {
            let moved = heights.iter().enumerate().map(moved).collect();
            blurred(moved, size, [&across, &down])
        })
    };
    let by_x = tilted(&across, |i, width| i % width);
    let by_y = tilted(&down, |i, width| i / width);
    let sum = blurred(heights, size, [&across, &down]);
    let fit = |i: usize| {
        let (x, y) = (i % size[0], i / size[0]);
        let weight = across.weight[x] * down.weight[y];
        let mean = sum[i] / weight;
        let lean = |axis: &Axis, at: usize, moved: &Option<Vec<f64>>| {
            let moved = moved.as_ref().map_or(0.0, |m| m[i] / weight);
            axis.lean(at, mean, moved)
        };
        let fitted = mean - lean(&across, x, &by_x) - lean(&down, y, &by_y);
        fitted.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
    };
    (0..sum.len()).map(fit).collect()
}

/// The window along one axis.
struct Axis {
    repeats: bool,
    radius: usize,
    /// Weight of the texels next to the box, which give it its exact width.
    edge: f64,
    /// Of texels, from the middle.
    position: Vec<f64>,
    /// Σw at each texel.
    weight: Vec<f64>,
    /// m and v at each texel.
    offset: Vec<[f64; 2]>,
}

impl Axis {
    fn new(n: usize, wrap: Wrap, sigma: f32) -> Self {
        // A window wider than the map sees the whole of it either way.
        let variance = f64::from(sigma).min(n as f64).powi(2) / PASSES as f64;
        // P. Gwosdek et al., "Theoretical foundations of Gaussian convolution by extended box filtering",
        // 2011: the box of 2r + 1 texels and two of weight `edge` that has this variance.
        let radius = (0.5 * (12.0 * variance + 1.0).sqrt() - 0.5).floor();
        let edge = (2.0 * radius + 1.0) * (radius * (radius + 1.0) - 3.0 * variance)
            / (6.0 * (variance - (radius + 1.0).powi(2)));
        let middle = 0.5 * (n as f64 - 1.0);
        let mut axis = Self {
            repeats: wrap == Wrap::Repeat,
            radius: radius as usize,
            edge,
            position: (0..n).map(|i| i as f64 - middle).collect(),
            weight: vec![1.0; n],
            offset: vec![[0.0, 1.0]; n],
        };
        let moment = |power: i32| axis.blur(axis.position.iter().map(|p| p.powi(power)).collect());
        let [weight, first, second] = [moment(0), moment(1), moment(2)];
        if !axis.repeats {
            let offset = |i: usize| {
                let mean = first[i] / weight[i];
                [mean - axis.position[i], second[i] / weight[i] - mean * mean]
            };
            axis.offset = (0..n).map(offset).collect();
        }
        axis.weight = weight;
        axis
    }

    /// `m b` at a texel, from the mean there and `Σwph / Σw`, `p` counted from the middle of the axis.
    fn lean(&self, at: usize, mean: f64, moved: f64) -> f64 {
        let [m, v] = self.offset[at];
        // A window of one texel has no slope.
        if self.repeats || v < 1e-6 {
            return 0.0;
        }
        m * (moved - (m + self.position[at]) * mean) / v
    }

    fn blur(&self, mut line: Vec<f64>) -> Vec<f64> {
        for _ in 0..PASSES {
            line = self.box_sums(&line);
        }
        line
    }

    fn box_sums(&self, line: &[f64]) -> Vec<f64> {
        let (n, r) = (line.len() as i64, self.radius as i64);
        let at = |i: i64| match self.repeats {
            true => line[i.rem_euclid(n) as usize],
            false if (0..n).contains(&i) => line[i as usize],
            false => 0.0,
        };
        let mut sum: f64 = (-r..=r).map(at).sum();
        (0..n)
            .map(|i| {
                let whole = sum + self.edge * (at(i - r - 1) + at(i + r + 1));
                sum += at(i + r + 1) - at(i - r);
                whole
            })
            .collect()
    }
}

fn blurred(values: Vec<f64>, size: [usize; 2], [across, down]: [&Axis; 2]) -> Vec<f64> {
    let rows = |values: Vec<f64>, width: usize, axis: &Axis| -> Vec<f64> {
        let rows = values.chunks_exact(width);
        rows.flat_map(|row| axis.blur(row.to_vec())).collect()
    };
    let [width, height] = size;
    let values = transposed(&rows(values, width, across), size);
    transposed(&rows(values, height, down), [height, width])
}

/// Columns for rows; `size` is that of `values`.
pub(super) fn transposed<T: Copy>(values: &[T], [width, height]: [usize; 2]) -> Vec<T> {
    let mut turned = Vec::with_capacity(values.len());
    // By blocks of rows, which stay in the cache.
    for x in 0..width {
        turned.extend((0..height).map(|y| values[y * width + x]));
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::super::test_photos::map;
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn planes_pass_up_to_the_border() {
        let plane = map([40, 30], Wrap::Clamp, |x, y| 3.0 + 0.5 * x - 0.25 * y);
        for sigma in [0.4, 1.0, 3.7, 12.0, 400.0] {
            let found = low_pass(&plane, sigma);
            for (found, expected) in found.iter().zip(plane.heights()) {
                assert!((found - expected).abs() < 1e-4, "{sigma}");
            }
        }
    }

    /// `exp(−σ²ω²/2)` of a wave is left.
    #[test]
    fn waves_fade_as_in_a_gaussian_window() {
        for (n, sigma) in [(64_u32, 2.0_f32), (64, 0.6), (128, 9.3)] {
            let wave = map([n, 8], Wrap::Repeat, |x, _| {
                (TAU as f32 * x / n as f32).sin()
            });
            let omega = TAU / f64::from(n);
            let left = (-0.5 * (f64::from(sigma) * omega).powi(2)).exp();
            let found = low_pass(&wave, sigma);
            for (found, full) in found.iter().zip(wave.heights()) {
                let expected = left * f64::from(*full);
                assert!((f64::from(*found) - expected).abs() < 2e-3, "{sigma}");
            }
        }
    }

    #[test]
    fn a_map_that_repeats_may_begin_anywhere() {
        let noise = |x: f32, y: f32| super::super::test_photos::noise(x as u32, y as u32, 3);
        let whole = map([24, 20], Wrap::Repeat, noise);
        let moved = map([24, 20], Wrap::Repeat, |x, y| {
            noise((x + 7.0) % 24.0, (y + 5.0) % 20.0)
        });
        for sigma in [1.5, 6.0, 90.0] {
            let [whole, moved] = [&whole, &moved].map(|map| low_pass(map, sigma));
            for (i, moved) in moved.iter().enumerate() {
                let (x, y) = ((i % 24 + 7) % 24, (i / 24 + 5) % 20);
                assert!((moved - whole[y * 24 + x]).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn one_texel_is_what_it_is() {
        for wrap in [Wrap::Clamp, Wrap::Repeat] {
            for size in [[1, 1], [5, 1], [1, 5]] {
                let flat = map(size, wrap, |_, _| 0.7);
                for found in low_pass(&flat, 3.0) {
                    assert!((found - 0.7).abs() < 1e-6);
                }
            }
        }
    }
}

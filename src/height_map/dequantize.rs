use super::low_pass::transposed;
use super::{HeightMap, Wrap};

/// Standard deviations in texels of the windows that smooth one after the other.
const WINDOWS: [f64; 6] = [32.0, 16.0, 8.0, 4.0, 2.0, 1.0];

/// Neighbours that differ by more steps than this are an edge, which nothing is smoothed across.
const EDGE: f32 = 3.5;

/// Takes the steps off a map whose heights were rounded, each from somewhere between its `bounds`.
///
/// It becomes as smooth as it can without leaving them: smoothed with a broad window, put back inside, with
/// a narrower one, put back inside, and so on. What leaves the bounds nowhere is kept as it is smoothed, so
/// slopes that took twenty texels for a step come out even. Nothing moves by more than half a step, and an
/// image that holds more than 8 bits could have been rounded to the same numbers.
///
/// A window is cut off at edges (E. Gastal and M. Oliveira, "Domain transform for edge-aware image and
/// video processing", SIGGRAPH 2011), and in it a parabola is fitted instead of a mean, which would lean
/// away from edges and flatten what is round.
pub(super) fn dequantize(map: &HeightMap, bounds: &[[f32; 2]]) -> HeightMap {
    let [width, height] = map.size().map(|n| n as usize);
    let edges = |heights: &[f32], bounds: &[[f32; 2]], width: usize, wrap| -> Vec<Vec<bool>> {
        let lines = heights.chunks_exact(width).zip(bounds.chunks_exact(width));
        lines.map(|(h, b)| links(h, b, wrap)).collect()
    };
    let across = edges(map.heights(), bounds, width, map.wrap()[0]);
    let turned = transposed(map.heights(), [width, height]);
    let turned_bounds = transposed(bounds, [width, height]);
    let down = edges(&turned, &turned_bounds, height, map.wrap()[1]);

    let mut heights = map.heights().to_vec();
    for window in WINDOWS {
        let decay = (-std::f64::consts::SQRT_2 / window).exp();
        smooth_lines(&mut heights, width, &across, decay);
        let mut turned = transposed(&heights, [width, height]);
        smooth_lines(&mut turned, height, &down, decay);
        heights = transposed(&turned, [height, width]);
        for (h, &[low, high]) in heights.iter_mut().zip(bounds) {
            *h = h.clamp(low, high);
        }
    }
    map.with_heights(heights)
}

/// Whether each texel of a line goes on smoothly into the next; the last into the first.
fn links(heights: &[f32], bounds: &[[f32; 2]], wrap: Wrap) -> Vec<bool> {
    let n = heights.len();
    let link = |i: usize| {
        let j = (i + 1) % n;
        let step = |k: usize| bounds[k][1] - bounds[k][0];
        let near = (heights[i] - heights[j]).abs() < EDGE * 0.5 * (step(i) + step(j));
        near && (j > 0 || wrap == Wrap::Repeat)
    };
    (0..n).map(link).collect()
}

fn smooth_lines(heights: &mut [f32], width: usize, links: &[Vec<bool>], decay: f64) {
    for (line, links) in heights.chunks_exact_mut(width).zip(links) {
        let smooth = smooth_line(line, links, decay);
        line.copy_from_slice(&smooth);
    }
}

/// Sums over the texels on one side, by the distance `d` to where they are asked for: `Σw dᵏ` for k of 0
/// to 4, then `Σw dᵏ h` for 0 to 2.
#[derive(Clone, Copy, Debug, Default)]
struct Sums([f64; 8]);

impl Sums {
    /// The same seen from one texel further, where weights are less by `decay`: `(d + 1)ᵏ` for `dᵏ`.
    fn moved(self, decay: f64) -> Self {
        let [a, b, c, d, e, h, dh, ddh] = self.0;
        let sums = [
            a,
            b + a,
            c + 2.0 * b + a,
            d + 3.0 * (c + b) + a,
            e + 4.0 * (d + b) + 6.0 * c + a,
            h,
            dh + h,
            ddh + 2.0 * dh + h,
        ];
        Self(sums.map(|s| decay * s))
    }

    fn with(mut self, height: f32) -> Self {
        self.0[0] += 1.0;
        self.0[5] += f64::from(height);
        self
    }
}

/// One line of texels through the window: at each the parabola that fits the heights around it best.
fn smooth_line(line: &[f32], links: &[bool], decay: f64) -> Vec<f32> {
    let n = line.len();
    // A line that repeats is entered early enough for what lies before it to count.
    let early = match links[n - 1] {
        true => n.min((-25.0 / decay.ln()).ceil() as usize),
        false => 0,
    };
    let side = |forwards: bool| {
        let mut sums = Sums::default();
        let mut all = vec![sums; n];
        for step in 0..n + early {
            let i = (step + n - early % n) % n;
            let (here, link) = match forwards {
                true => (i, (i + n - 1) % n),
                false => (n - 1 - i, n - 1 - i),
            };
            sums = match links[link] {
                true => sums.moved(decay),
                false => Sums::default(),
            };
            all[here] = sums;
            sums = sums.with(line[here]);
        }
        all
    };
    let (before, behind) = (side(true), side(false));
    (0..n).map(|i| fit(before[i], behind[i], line[i])).collect()
}

/// Height at a texel of the parabola through itself and both sides, by polynomials `1`, `p₁ = d − m` and
/// `p₂ = d² − a p₁ − s₂` that are orthogonal under the weights. Where there are too few texels for one, it is
/// left out.
fn fit(before: Sums, behind: Sums, here: f32) -> f32 {
    let both = before.0.iter().zip(behind.with(here).0).enumerate();
    // Distances to one side are negative.
    let both = both.map(|(k, (before, behind))| match k {
        1 | 3 | 6 => behind - before,
        _ => behind + before,
    });
    let mut sums = [0.0; 8];
    sums.iter_mut().zip(both).for_each(|(s, b)| *s = b);
    let [_, m, s2, s3, s4, mean, dh, ddh] = sums.map(|s| s / sums[0]);
    let mut height = mean;
    let v = s2 - m * m;
    if v > 1e-6 {
        let h1 = dh - m * mean;
        height -= m * h1 / v;
        let c = s3 - m * s2;
        let q = s4 - c * c / v - s2 * s2;
        if q > 1e-6 * v * v {
            height += (c / v * m - s2) * (ddh - c / v * h1 - s2 * mean) / q;
        }
    }
    height as f32
}

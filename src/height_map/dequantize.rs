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
/// video processing", SIGGRAPH 2011), and in it a line is fitted instead of a mean, which would lean away
/// from them.
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

/// Sums over the texels on one side: `Σw`, `Σwd`, `Σwd²`, `Σwh`, `Σwdh`, by the distance `d` to where they
/// are asked for.
#[derive(Clone, Copy, Debug, Default)]
struct Sums([f64; 5]);

impl Sums {
    /// The same seen from one texel further, where weights are less by `decay`.
    fn moved(self, decay: f64) -> Self {
        let [w, d, dd, h, dh] = self.0;
        Self([w, d + w, dd + 2.0 * d + w, h, dh + h].map(|s| decay * s))
    }

    fn with(self, height: f32) -> Self {
        let [w, d, dd, h, dh] = self.0;
        Self([w + 1.0, d, dd, h + f64::from(height), dh])
    }
}

/// One line of texels through the window: at each the line that fits the heights around it best.
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
            let (here, from) = match forwards {
                true => (i, (i + n - 1) % n),
                false => (n - 1 - i, n - 1 - i),
            };
            sums = match links[from] {
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

/// Height at a texel of the line through itself and both sides.
fn fit(before: Sums, behind: Sums, here: f32) -> f32 {
    let [w, d, dd, h, dh] = std::array::from_fn(|k| {
        // Distances to one side are negative.
        let sign = if k == 1 || k == 4 { -1.0 } else { 1.0 };
        behind.0[k] + sign * before.0[k]
    });
    let (w, h) = (w + 1.0, h + f64::from(here));
    let (m, mean) = (d / w, h / w);
    let v = dd / w - m * m;
    let slope = if v > 1e-9 {
        (dh / w - m * mean) / v
    } else {
        0.0
    };
    (mean - m * slope) as f32
}

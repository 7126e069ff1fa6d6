use super::low_pass::transposed;
use super::{HeightMap, Warning};

/// Share of the contrast in steps from which on they are told. Smooth relief has none, a checkerboard
/// nothing else.
const TOLD: f64 = 0.45;

/// Texels on either side of a step that it may be blurred over.
const BLUR: usize = 2;

/// A step is so many times as high as both of its sides are uneven.
const EVEN: f64 = 4.0;

/// Lowest step of luminance that counts, by the photo's range.
const LOWEST: f64 = 0.02;

/// Lowest step of chromaticity (red or green by the sum of the three) that counts.
const LOWEST_CHROMATICITY: f64 = 0.03;

/// Whether a photo's contrast is colour or cast shadow rather than relief.
///
/// Light on relief is brighter or darker where the surface leans, and the same again where it is level: a
/// ridge or groove shows as a line, a rounded bump as a gradient. Paint and shadow show as a *step*: two
/// even areas side by side that differ. Looked for along rows and along columns, in luminance and, as light
/// on relief of one material changes no chromaticity, there too:
///
/// ```text
///                      even   blur  even
///   step at i:       |-------|··i··|-------|      |mean right − mean left| > 4 (σ left + σ right)
/// ```
///
/// What counts is the squared difference of neighbours where there are steps, by that of all neighbours.
/// Relief with large flat facets looks the same in a photo, and is told too.
pub(super) fn albedo_edges(luminance: &HeightMap, colours: Option<&[[f32; 3]]>) -> Option<Warning> {
    let size = luminance.size().map(|n| n as usize);
    let window = (size[0].min(size[1]) / 64).clamp(4, 24);
    let signals = signals(luminance, colours);
    let (mut all, mut steps) = (0.0, 0.0);
    let mut sharpest = (0.0, [0; 2]);
    for axis in 0..2 {
        let length = size[axis];
        let lines: Vec<_> = match axis {
            0 => signals.clone(),
            _ => (signals.iter())
                .map(|(values, lowest)| (transposed(values, size), *lowest))
                .collect(),
        };
        for line in 0..size[1 - axis] {
            let parts: Vec<_> = lines
                .iter()
                .map(|(v, lowest)| (Line::new(&v[line * length..][..length]), *lowest))
                .collect();
            for i in window + BLUR..length.saturating_sub(window + BLUR + 1) {
                let light = &parts[0].0;
                let squared = light.difference(i).powi(2);
                all += squared;
                let step = |(line, lowest): &(Line, f64)| line.has_step(i, window, *lowest);
                if squared > 0.0 && parts.iter().any(step) {
                    steps += squared;
                    if squared > sharpest.0 {
                        let place = [i as u32, line as u32];
                        sharpest = (squared, [place[axis], place[1 - axis]]);
                    }
                }
            }
        }
    }
    let share = if all > 0.0 { steps / all } else { 0.0 };
    (share > TOLD).then_some(Warning::AlbedoEdges {
        share,
        at: sharpest.1,
    })
}

/// Luminance and, if there is colour, chromaticities, each with the lowest step that counts.
fn signals(luminance: &HeightMap, colours: Option<&[[f32; 3]]>) -> Vec<(Vec<f32>, f64)> {
    let heights = luminance.heights();
    let low = heights.iter().copied().fold(f32::INFINITY, f32::min);
    let high = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let range = f64::from(high) - f64::from(low);
    let mut signals = vec![(heights.to_vec(), LOWEST * range)];
    for channel in [0, 1] {
        let Some(colours) = colours else { break };
        let share = |c: &[f32; 3]| {
            let sum: f64 = c.iter().map(|&c| f64::from(c)).sum();
            // Black has no chromaticity; that of grey makes no step to grey.
            match sum > 0.02 * range {
                true => (f64::from(c[channel]) / sum) as f32,
                false => 1.0 / 3.0,
            }
        };
        signals.push((colours.iter().map(share).collect(), LOWEST_CHROMATICITY));
    }
    signals
}

/// A line of texels with sums of it and of its squares from the start.
struct Line<'a> {
    values: &'a [f32],
    sums: Vec<[f64; 2]>,
}

impl<'a> Line<'a> {
    fn new(values: &'a [f32]) -> Self {
        let mut sums = vec![[0.0; 2]];
        let mut so_far = [0.0; 2];
        for &value in values {
            let value = f64::from(value);
            so_far = [so_far[0] + value, so_far[1] + value * value];
            sums.push(so_far);
        }
        Self { values, sums }
    }

    fn difference(&self, i: usize) -> f64 {
        f64::from(self.values[i + 1]) - f64::from(self.values[i])
    }

    /// Mean and standard deviation of `n` texels.
    fn even(&self, from: usize, n: usize) -> [f64; 2] {
        let [mean, square] =
            [0, 1].map(|k| (self.sums[from + n][k] - self.sums[from][k]) / n as f64);
        [mean, (square - mean * mean).max(0.0).sqrt()]
    }

    fn has_step(&self, i: usize, window: usize, lowest: f64) -> bool {
        let [left, uneven_left] = self.even(i - BLUR - window + 1, window);
        let [right, uneven_right] = self.even(i + BLUR, window);
        let step = (right - left).abs();
        step > lowest && step > EVEN * (uneven_left + uneven_right)
    }
}

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
/// Relief with large flat facets looks the same in a photo, and is told too. Neighbourhoods with `highlights`,
/// which are told by themselves, do not count.
pub(super) fn albedo_edges(
    luminance: &HeightMap,
    colours: Option<&[[f32; 3]]>,
    highlights: Option<&[bool]>,
) -> Option<Warning> {
    let size = luminance.size().map(|n| n as usize);
    let window = (size[0].min(size[1]) / 64).clamp(4, 24);
    let signals = signals(luminance, colours);
    let glossy: Option<Vec<f32>> =
        highlights.map(|mask| mask.iter().map(|&m| f32::from(m)).collect());
    let mut found = Found::default();
    for axis in 0..2 {
        let turned = |values: &Vec<f32>| match axis {
            0 => values.clone(),
            _ => transposed(values, size),
        };
        let signals = signals.iter().map(|(v, lowest)| (turned(v), *lowest));
        let signals: Vec<_> = signals.collect();
        let glossy = glossy.as_ref().map(turned);
        for line in 0..size[1 - axis] {
            let part = line * size[axis]..(line + 1) * size[axis];
            let signals = signals
                .iter()
                .map(|(v, lowest)| (Line::new(&v[part.clone()]), *lowest));
            let signals: Vec<_> = signals.collect();
            let glossy = glossy.as_ref().map(|g| Line::new(&g[part.clone()]));
            found.add(&signals, glossy.as_ref(), window, [axis, line]);
        }
    }
    let share = found.steps / found.all.max(f64::MIN_POSITIVE);
    (share > TOLD).then_some(Warning::AlbedoEdges {
        share,
        at: found.at,
    })
}

/// Squared differences of neighbours: all, those in steps, and where the largest of these is.
#[derive(Default)]
struct Found {
    all: f64,
    steps: f64,
    sharpest: f64,
    at: [u32; 2],
}

impl Found {
    /// Adds a line of the photo, along `axis`, the first of `signals` being its luminance.
    fn add(
        &mut self,
        signals: &[(Line<'_>, f64)],
        glossy: Option<&Line<'_>>,
        window: usize,
        [axis, line]: [usize; 2],
    ) {
        let [(luminance, _), ..] = signals else {
            return;
        };
        let reach = window + BLUR;
        let is_matte =
            |&i: &usize| glossy.is_none_or(|g| g.even(i + 1 - reach, 2 * reach)[0] == 0.0);
        let length = luminance.values.len();
        for i in (reach..length.saturating_sub(reach + 1)).filter(is_matte) {
            let squared = luminance.difference(i).powi(2);
            self.all += squared;
            let step = |(line, lowest): &(Line<'_>, f64)| line.has_step(i, window, *lowest);
            if squared > 0.0 && signals.iter().any(step) {
                self.steps += squared;
                if squared > self.sharpest {
                    self.sharpest = squared;
                    let place = [i as u32, line as u32];
                    self.at = [place[axis], place[1 - axis]];
                }
            }
        }
    }
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

use glam::Vec3;

use super::face::Sample;
use super::probe::{Ground, Probe};

/// A line across a face where light goes from one level to another, as the edge of a shadow does. One
/// corner is on one side of it, two are on the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Step {
    /// The corner that is alone.
    pub(super) lone: u8,
    /// On the edges from there to the next corner and to the one before: where the light of the lone
    /// corner ends, and where the light of the other begins, as shares of their lengths.
    pub(super) ends: [[f32; 2]; 2],
}

/// Samples are of two levels if the widest gap between them is this share of what they span.
const GAP: f32 = 0.5;

/// Levels differ if the samples span this share of the brightest.
const SPAN: f32 = 0.1;

/// A level reaches as far as light is no farther from it than this share of the step.
const LEVEL: f32 = 0.15;

/// Of the middle of the line, which has to go where its ends do.
const LEVEL_BETWEEN: f32 = 0.25;

/// A step is one if it takes no more than this share of either edge; what is wider, more vertices follow
/// anyway.
const WIDEST: f32 = 0.25;

/// Halvings on the way to where levels meet, so that they are found to a 64th of the edge.
const HALVINGS: usize = 6;

/// Corners are asked about a little inside.
const INSET: f32 = 1e-3;

impl Step {
    /// Looks for the step on a face with the given corners on its triangle, whose samples are `samples`.
    ///
    /// Between corners on either side the place where light is half way is found by bisection; the last
    /// bracket whose ends have the light of the levels is where the step is. A hard edge has it as
    /// narrow as bisection goes, a penumbra as wide as it is.
    pub(super) fn find(
        probe: &Probe,
        ground: &Ground,
        corners: [Vec3; 3],
        samples: &[Sample],
        rays: &mut u64,
    ) -> Option<Self> {
        let middle = between_levels(samples)?;
        let mut light = |points: &[Vec3]| -> Option<Vec<f32>> {
            let told = probe.light(ground, points, rays).into_iter();
            told.map(|light| light.map(|[a, b]| (a + b).element_sum()))
                .collect()
        };
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let corners = corners.map(|corner| corner.lerp(center, INSET));
        let at = light(&corners)?;
        let bright = [0, 1, 2].map(|i| at[i] > middle);
        let lone = (0..3).find(|&i| {
            let [j, k] = [(i + 1) % 3, (i + 2) % 3];
            bright[i] != bright[j] && bright[i] != bright[k]
        })?;
        let others = [(lone + 1) % 3, (lone + 2) % 3];
        let on_edge = |edge: usize, t: f32| corners[lone].lerp(corners[others[edge]], t);
        // The way from the level of the lone corner to that of the other.
        let way = |edge: usize, light: f32| (light - at[lone]) / (at[others[edge]] - at[lone]);
        let mut brackets = [[(0.0_f32, 0.0_f32), (1.0, 1.0)]; 2];
        let mut ends = [[0.0, 1.0]; 2];
        for _ in 0..HALVINGS {
            let halves = brackets.map(|[low, high]| 0.5 * (low.0 + high.0));
            let told = light(&[on_edge(0, halves[0]), on_edge(1, halves[1])])?;
            for (edge, bracket) in brackets.iter_mut().enumerate() {
                let here = (halves[edge], way(edge, told[edge]));
                bracket[usize::from(here.1 > 0.5)] = here;
                let [low, high] = *bracket;
                if low.1 <= LEVEL && high.1 >= 1.0 - LEVEL {
                    ends[edge] = [low.0, high.0];
                }
            }
        }
        if ends.iter().any(|[low, high]| high - low > WIDEST) {
            return None;
        }
        // An edge of shadow that bends between the two is not followed by the line through them.
        let halfway = |end: usize| 0.5 * (on_edge(0, ends[0][end]) + on_edge(1, ends[1][end]));
        let told = light(&[halfway(0), halfway(1)])?;
        let way = |light: f32| 0.5 * (way(0, light) + way(1, light));
        let follows = way(told[0]) <= LEVEL_BETWEEN && way(told[1]) >= 1.0 - LEVEL_BETWEEN;
        let lone = lone as u8;
        follows.then_some(Self { lone, ends })
    }
}

/// The middle of the widest gap between samples, if they are of two levels.
fn between_levels(samples: &[Sample]) -> Option<f32> {
    let light = |s: &Sample| (s.light[0] + s.light[1]).element_sum();
    let mut sorted: Vec<f32> = samples.iter().map(light).collect();
    sorted.sort_by(f32::total_cmp);
    let span = sorted.last()? - sorted.first()?;
    let pairs = sorted
        .windows(2)
        .map(|pair| (pair[1] - pair[0], 0.5 * (pair[0] + pair[1])));
    let (gap, middle) = pairs.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (gap >= GAP * span && span > SPAN * sorted.last()?).then_some(middle)
}

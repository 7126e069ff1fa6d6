use std::ops::Range;

use glam::{Vec3, Vec3A};

use super::eye::Seen;
use super::faces::{Face, Linear};

/// What the search for the end of a run costs, in pixels asked one by one.
const PIXELS_PER_RUN: f32 = 4.0;

/// Which of its points a triangle shows at the pixels of one row.
///
/// Barycentrics are quotients of functions linear in the column, `λ = e/Σe` (see [`Seen`]): exact, in
/// perspective. The triangle is cut into `n²` cells along the lines where some `n λ` is whole, and
/// along a row each `λ` only rises or only falls. So from a pixel within a cell the row stays there
/// until the first `λ` reaches the next whole number `m` on its way,
///
/// ```text
///   n (e₀ + e₁ x) = m (s₀ + s₁ x),    s = Σe
///   ┌──────────────────────────────────────┐
///   │  x = (m s₀ − n e₀) / (n e₁ − m s₁)   │
///   └──────────────────────────────────────┘
/// ```
///
/// and only one pixel of each such run has to ask for its element.
pub(super) struct Places {
    /// `e` in column 0, and its step.
    edges: [Vec3A; 2],
    sums: [f32; 2],
    cells: f32,
    /// 1 where a barycentric rises from left to right, else 0.
    rises: Vec3A,
}

impl Places {
    pub(super) fn new(seen: &Seen, edges: &Linear<Vec3A>, row: usize) -> Self {
        let edges = [edges.at_row(row), edges.column];
        let sums = edges.map(|e| e.x + e.y + e.z);
        // The sign of its derivative, whose denominator is positive.
        let slope = edges[1] * sums[0] - edges[0] * sums[1];
        Self {
            edges,
            sums,
            cells: seen.cells,
            rises: Vec3A::select(slope.cmpgt(Vec3A::ZERO), Vec3A::ONE, Vec3A::ZERO),
        }
    }

    /// Edge functions as they change over a face.
    pub(super) fn edges(seen: &Seen, face: &Face, resolution: usize) -> Linear<Vec3A> {
        face.linear(face.turned(&seen.edges), resolution)
    }

    /// Whether cells are so small that it is quicker to ask at each pixel.
    pub(super) fn change_often(&self, columns: &Range<usize>) -> bool {
        let way = self.barycentrics(columns.end - 1) - self.barycentrics(columns.start);
        let lines = (way * self.cells).abs().element_sum();
        lines * PIXELS_PER_RUN > columns.len() as f32
    }

    /// Weights of the three corners.
    fn barycentrics(&self, column: usize) -> Vec3A {
        let x = column as f32;
        (self.edges[0] + self.edges[1] * x) * (1.0 / (self.sums[0] + self.sums[1] * x))
    }

    /// Weights of the second and third corner.
    pub(super) fn uv(&self, column: usize) -> [f32; 2] {
        let [_, u, v] = self.barycentrics(column).to_array();
        [u, v]
    }

    /// As [`Self::uv`], and the column before which the row does not leave the cell there.
    pub(super) fn run(&self, column: usize) -> ([f32; 2], usize) {
        let at = self.barycentrics(column);
        let next = (at * self.cells).floor() + self.rises;
        let above = next * self.sums[0] - self.edges[0] * self.cells;
        let below = self.edges[1] * self.cells - next * self.sums[1];
        let crossing = above / below;
        // In perspective the next whole number may lie beyond infinity, and come back from behind.
        let ahead = crossing.cmpge(Vec3A::splat(column as f32 - 0.5));
        let crossing = Vec3A::select(ahead, crossing, Vec3A::INFINITY).min_element();
        // On the line itself rounding decides; then it is one pixel.
        let end = (crossing as usize).saturating_add(1).max(column + 1);
        let [_, u, v] = Vec3::from(at).to_array();
        ([u, v], end)
    }
}

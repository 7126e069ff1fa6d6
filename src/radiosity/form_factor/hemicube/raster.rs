use std::ops::Range;

use glam::Vec3A;

use super::eye::Seen;
use super::faces::{Face, Linear};

/// In the item buffer: nothing there.
pub(super) const NOTHING: u32 = u32::MAX;

/// The picture on one face: what is nearest at each pixel.
pub(super) struct Picture {
    resolution: usize,
    /// Inverse depth, 0 for what is infinitely far.
    depths: Vec<f32>,
    items: Vec<u32>,
}

impl Picture {
    pub(super) fn new(resolution: usize) -> Self {
        Self {
            resolution,
            depths: vec![0.0; resolution * resolution],
            items: vec![NOTHING; resolution * resolution],
        }
    }

    pub(super) fn clear(&mut self) {
        self.depths.fill(0.0);
        self.items.fill(NOTHING);
    }

    pub(super) fn row(&self, row: usize) -> &[u32] {
        &self.items[row * self.resolution..(row + 1) * self.resolution]
    }

    /// Draws a triangle as `item` where it is nearer than what was drawn before.
    pub(super) fn draw(&mut self, face: &Face, seen: &Seen, item: u32) {
        self.spans(face, seen, |_, _, depths, items, start, step| {
            let columns = 0..depths.len() as i32;
            // Without a branch: eight pixels at a time.
            for ((depth, drawn), x) in depths.iter_mut().zip(items).zip(columns) {
                let here = start + step * x as f32;
                let nearer = here > *depth;
                *depth = if nearer { here } else { *depth };
                *drawn = if nearer { item } else { *drawn };
            }
        });
    }

    /// As [`Self::draw`], where `stops` says of a row and column that there is something.
    pub(super) fn draw_in_part(
        &mut self,
        face: &Face,
        seen: &Seen,
        item: u32,
        stops: impl Fn(usize, usize) -> bool,
    ) {
        self.spans(face, seen, |row, first, depths, items, start, step| {
            for (x, (depth, drawn)) in depths.iter_mut().zip(items).enumerate() {
                let here = start + step * x as f32;
                if here > *depth && stops(row, first + x) {
                    (*depth, *drawn) = (here, item);
                }
            }
        });
    }

    /// Calls `draw` for the pixels of each row that a triangle covers, with the row, the first
    /// column, the buffers there, the triangle's inverse depth at the first and its step.
    fn spans(
        &mut self,
        face: &Face,
        seen: &Seen,
        mut draw: impl FnMut(usize, usize, &mut [f32], &mut [u32], f32, f32),
    ) {
        let resolution = self.resolution;
        let corners = face.turned(&seen.corners);
        if outside(&corners) {
            return;
        }
        let outline = Outline::new(face.linear(face.turned(&seen.edges), resolution));
        let depth = face.linear(face.turned(&seen.inverse_depth), resolution);
        for row in rows(face, &corners, resolution) {
            let span = outline.span(row, resolution);
            if span.is_empty() {
                continue;
            }
            let start = depth.at_row(row) + depth.column * span.start as f32;
            let pixels = row * resolution + span.start..row * resolution + span.end;
            let depths = &mut self.depths[pixels.clone()];
            draw(
                row,
                span.start,
                depths,
                &mut self.items[pixels],
                start,
                depth.column,
            );
        }
    }
}

/// Whether all corners lie beyond one plane of the pyramid through a face.
fn outside(&[right, up, forward]: &[Vec3A; 3]) -> bool {
    [right, -right, up, -up]
        .into_iter()
        .any(|way| way.cmpgt(forward).all())
}

/// The rows that a triangle may cover, given its corners along the axes of the face.
///
/// The slope `up / forward` of what is in front and between −1 and 1 is greatest at a corner, unless
/// an edge leaves across 1, and so for the least.
fn rows(face: &Face, &[_, up, forward]: &[Vec3A; 3], resolution: usize) -> Range<usize> {
    let slope = up / forward;
    let ahead = forward.cmpgt(Vec3A::ZERO);
    let highest = Vec3A::select(ahead, slope, Vec3A::NEG_ONE);
    let highest = Vec3A::select(up.cmpgt(forward), Vec3A::ONE, highest).max_element();
    let lowest = Vec3A::select(ahead, slope, Vec3A::ONE);
    let lowest = Vec3A::select((-up).cmpgt(forward), Vec3A::NEG_ONE, lowest).min_element();
    // Half a row more on each side: spans decide, and they are exact.
    let first = (face.row_of(lowest, resolution) + 0.5).max(0.0) as usize;
    let end = (face.row_of(highest, resolution) + 1.5).max(0.0) as usize;
    first..end.min(face.rows(resolution))
}

/// Where each row of pixels enters and leaves a triangle.
struct Outline {
    /// Column at which each edge that bounds on the left is crossed in row 0, and by how much more
    /// in the next.
    left: [Vec3A; 2],
    right: [Vec3A; 2],
}

impl Outline {
    /// From edge functions `A x + B y + C`: crossed at `x = −(B y + C)/A`, on the left if `A > 0`.
    fn new(edges: Linear<Vec3A>) -> Self {
        // Far enough away: what a level edge leaves out, it leaves out as a whole.
        let level = edges.column.abs().cmplt(Vec3A::splat(1e-25));
        let column = Vec3A::select(level, Vec3A::splat(1e-25), edges.column);
        let crossing = [-edges.base / column, -edges.row / column];
        let on_left = column.cmpgt(Vec3A::ZERO);
        let nowhere = Vec3A::splat(1e9);
        Self {
            left: [
                Vec3A::select(on_left, crossing[0], -nowhere),
                Vec3A::select(on_left, crossing[1], Vec3A::ZERO),
            ],
            right: [
                Vec3A::select(on_left, nowhere, crossing[0]),
                Vec3A::select(on_left, Vec3A::ZERO, crossing[1]),
            ],
        }
    }

    /// Columns `left ≤ x < right`.
    fn span(&self, row: usize, resolution: usize) -> Range<usize> {
        let y = row as f32;
        let left = (self.left[0] + self.left[1] * y).max_element();
        let right = (self.right[0] + self.right[1] * y).min_element();
        let [left, right] = [left, right].map(|x| x.clamp(0.0, resolution as f32));
        round_up(left)..round_up(right)
    }
}

/// The least whole number that is not below.
fn round_up(x: f32) -> usize {
    let whole = x as i32;
    (whole + i32::from((whole as f32) < x)) as usize
}

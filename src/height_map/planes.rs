use glam::Vec2;

use super::{HeightMap, Kernel};
use crate::parallel::map_chunks;

/// Cells between texels along a side of the smallest blocks.
const CELLS: u32 = 4;

/// Cubics through values may leave their range by a sixth of it on either side, as their Bézier points do; in
/// two directions one after the other by this share.
const OVERSHOOT: f32 = 1.0 / 6.0 + 1.0 / 6.0 * 4.0 / 3.0;

/// What rounding adds, as a share of the heights at hand.
const ROUNDING: f32 = 1e-6;

/// What a map does within blocks of cells, from small blocks to the whole: a plane for each block, and how far
/// heights leave it.
///
/// ```text
///   ┌───────────────────────────────────────────────────────┐
///   │  below ≤ F(x, y) − (mean + slopes · ((x, y) − c)) ≤ above  │      c: middle of the block
///   └───────────────────────────────────────────────────────┘
/// ```
///
/// holds anywhere in a block, between texels too. The minimum and maximum alone would do the same for level
/// relief; with the first moments taken out, slopes do not count as detail. So whoever looks for the place
/// where a map leaves a plane the most can leave out whole blocks and never misses a texel.
///
/// Places are in texels, 0 at the centre of the first. Blocks of level `l` are `4 · 2ˡ` cells wide, those at
/// the right and lower border perhaps less.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanePyramid {
    levels: Vec<Vec<Block>>,
    /// In blocks.
    sizes: Vec<[u32; 2]>,
    cells: [u32; 2],
}

/// What a map does within a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Block {
    /// Height of the plane in the middle.
    pub mean: f32,
    /// By texel.
    pub slopes: Vec2,
    /// Least of what heights are above the plane, mostly negative.
    pub below: f32,
    /// Most of it.
    pub above: f32,
}

impl PlanePyramid {
    /// Of a map whose heights are found with `kernel`.
    pub fn new(map: &HeightMap, kernel: Kernel) -> Self {
        let cells = map.size();
        let size = cells.map(|n| n.div_ceil(CELLS));
        let rows = map_chunks(size[1] as usize, 1, |row| {
            let row = (0..size[0]).map(|x| smallest(map, kernel, [x, row.start as u32]));
            row.collect::<Vec<_>>()
        });
        let mut pyramid = Self {
            levels: vec![rows.concat()],
            sizes: vec![size],
            cells,
        };
        while pyramid.sizes.last() != Some(&[1, 1]) {
            pyramid.add_level();
        }
        pyramid
    }

    /// The level of the block that is the whole map.
    pub fn top(&self) -> usize {
        self.levels.len() - 1
    }

    /// Width and height of a block, in texels.
    pub fn side(level: usize) -> u32 {
        CELLS << level
    }

    /// Columns and rows of blocks on a level.
    pub fn size(&self, level: usize) -> [u32; 2] {
        self.sizes[level]
    }

    /// The block in column `x` and row `y`; nothing beyond the border.
    pub fn block(&self, level: usize, [x, y]: [u32; 2]) -> Option<Block> {
        let [columns, rows] = self.sizes[level];
        (x < columns && y < rows).then(|| self.levels[level][(y * columns + x) as usize])
    }

    /// The lower and the upper corner of a block, in texels.
    pub fn extent(&self, level: usize, [x, y]: [u32; 2]) -> [Vec2; 2] {
        let side = Self::side(level);
        let corner = |x: u32, y: u32| {
            let [width, height] = self.cells;
            Vec2::new((x * side).min(width) as f32, (y * side).min(height) as f32)
        };
        [corner(x, y), corner(x + 1, y + 1)]
    }

    /// The middle of a block's plane, in texels.
    pub fn middle(level: usize, [x, y]: [u32; 2]) -> Vec2 {
        (Vec2::new(x as f32, y as f32) + 0.5) * Self::side(level) as f32
    }

    fn add_level(&mut self) {
        let level = self.levels.len();
        let size = self.sizes[level - 1].map(|n| n.div_ceil(2));
        let blocks = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        let blocks = blocks.map(|at| self.around(level, at)).collect();
        self.sizes.push(size);
        self.levels.push(blocks);
    }

    /// The block of four smaller ones, or what there is of them.
    fn around(&self, level: usize, [x, y]: [u32; 2]) -> Block {
        let child = |dx: u32, dy: u32| self.block(level - 1, [2 * x + dx, 2 * y + dy]);
        let children = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let there = || children.iter().filter_map(|&(dx, dy)| child(dx, dy));
        let count = there().count() as f32;
        let slopes = there().map(|block| block.slopes).sum::<Vec2>() / count;
        let middle = Self::middle(level, [x, y]);
        let mean = children.iter().filter_map(|&(dx, dy)| {
            let to_middle = middle - Self::middle(level - 1, [2 * x + dx, 2 * y + dy]);
            Some(child(dx, dy)?.mean + slopes.dot(to_middle))
        });
        let mut block = Block {
            mean: mean.sum::<f32>() / count,
            slopes,
            below: f32::INFINITY,
            above: f32::NEG_INFINITY,
        };
        for (dx, dy) in children {
            let at = [2 * x + dx, 2 * y + dy];
            if let Some(child) = child(dx, dy) {
                let [low, high] = self.extent(level - 1, at);
                let offset = |p: Vec2| {
                    child.plane(p - Self::middle(level - 1, at)) - block.plane(p - middle)
                };
                let corners = [
                    low,
                    high,
                    Vec2::new(low.x, high.y),
                    Vec2::new(high.x, low.y),
                ];
                for offset in corners.map(offset) {
                    block.below = block.below.min(offset + child.below);
                    block.above = block.above.max(offset + child.above);
                }
            }
        }
        block.widened(0.0)
    }
}

impl Block {
    /// Height of the plane so far from the middle.
    pub fn plane(&self, from_middle: Vec2) -> f32 {
        self.mean + self.slopes.dot(from_middle)
    }

    fn widened(mut self, overshoot: f32) -> Self {
        let range = self.above - self.below;
        let more = overshoot * range + ROUNDING * (self.mean.abs() + range);
        self.below -= more;
        self.above += more;
        self
    }
}

/// Texels along a side of the smallest blocks, with one more on either side.
const PATCH: usize = CELLS as usize + 3;

/// Texels of a block of cells and one more on either side, row by row.
fn patch(map: &HeightMap, [x, y]: [u32; 2]) -> [[f32; PATCH]; PATCH] {
    let first = [x, y].map(|i| i64::from(i * CELLS) - 1);
    let [width, height] = map.size().map(i64::from);
    let inside = |i: i64, n: i64| i >= 0 && i + PATCH as i64 <= n;
    let mut patch = [[0.0; PATCH]; PATCH];
    if inside(first[0], width) && inside(first[1], height) {
        let start = first[1] * width + first[0];
        let rows = map.heights()[start as usize..].chunks(width as usize);
        for (to, from) in patch.iter_mut().zip(rows) {
            to.copy_from_slice(&from[..PATCH]);
        }
        return patch;
    }
    for (j, row) in (0..).zip(&mut patch) {
        for (i, texel) in (0..).zip(row) {
            *texel = map.texel(first[0] + i, first[1] + j);
        }
    }
    patch
}

/// A block of cells: the plane by least squares through the texels around them.
fn smallest(map: &HeightMap, kernel: Kernel, at: [u32; 2]) -> Block {
    let patch = patch(map, at);
    // Texels of the block itself, without those around it.
    const INNER: std::ops::Range<usize> = 1..PATCH - 1;
    let from_middle = |i: usize| i as f32 - 1.0 - 0.5 * CELLS as f32;
    let count = (INNER.len() * INNER.len()) as f32;
    let (mut sum, mut moments, mut spread) = (0.0, Vec2::ZERO, 0.0);
    for j in INNER {
        for i in INNER {
            let at = Vec2::new(from_middle(i), from_middle(j));
            sum += patch[j][i];
            // Places add up to 0, so that the mean need not be taken off before.
            moments += (patch[j][i] - patch[1][1]) * at;
            spread += at.x * at.x;
        }
    }
    let mut block = Block {
        mean: sum / count,
        slopes: moments / spread,
        below: f32::INFINITY,
        above: f32::NEG_INFINITY,
    };
    // Cubics look at a texel more on either side.
    let (looks_at, overshoot) = match kernel {
        Kernel::CatmullRom => (0..PATCH, OVERSHOOT),
        Kernel::BSpline => (0..PATCH, 0.0),
        Kernel::Bilinear | Kernel::Forward | Kernel::Central | Kernel::HalfCentral => (INNER, 0.0),
    };
    for j in looks_at.clone() {
        for i in looks_at.clone() {
            let above = patch[j][i] - block.plane(Vec2::new(from_middle(i), from_middle(j)));
            block.below = block.below.min(above);
            block.above = block.above.max(above);
        }
    }
    block.widened(overshoot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_map::Wrap;
    use crate::height_map::test_photos::noise;

    fn map(size: [u32; 2], wrap: Wrap, height: impl Fn(u32, u32) -> f32) -> HeightMap {
        let heights = (0..size[0] * size[1]).map(|i| height(i % size[0], i / size[0]));
        HeightMap::new(size, heights.collect(), [wrap; 2]).unwrap()
    }

    #[test]
    fn heights_stay_within_the_bounds_of_every_block() {
        for size in [[16, 16], [13, 7], [1, 1], [3, 40]] {
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                // Noise on a slope, one texel far out.
                let map = map(size, wrap, |x, y| {
                    let spike = if (x, y) == (2, 0) { 30.0 } else { 0.0 };
                    noise(x, y, 3) + 2.0 * x as f32 + spike
                });
                for kernel in Kernel::ALL {
                    let pyramid = PlanePyramid::new(&map, kernel);
                    for level in 0..=pyramid.top() {
                        let [columns, rows] = pyramid.sizes[level];
                        for at in (0..columns * rows).map(|i| [i % columns, i / columns]) {
                            check(&map, kernel, &pyramid, level, at);
                        }
                    }
                }
            }
        }
    }

    fn check(map: &HeightMap, kernel: Kernel, pyramid: &PlanePyramid, level: usize, at: [u32; 2]) {
        let block = pyramid.block(level, at).unwrap();
        let [low, high] = pyramid.extent(level, at);
        let [width, height] = map.size().map(|n| n as f32);
        for i in 0..=20 {
            for j in 0..=20 {
                let p = low + (high - low) * Vec2::new(i as f32, j as f32) / 20.0;
                let uv = (p + 0.5) / Vec2::new(width, height);
                let above =
                    map.height(uv, kernel) - block.plane(p - PlanePyramid::middle(level, at));
                assert!(
                    above >= block.below - 1e-4 && above <= block.above + 1e-4,
                    "{kernel:?} {level} {at:?} {p}: {above} of {block:?}"
                );
            }
        }
    }

    #[test]
    fn slopes_are_no_detail() {
        let ramp = map([64, 64], Wrap::Clamp, |x, y| 3.0 * x as f32 - y as f32);
        let pyramid = PlanePyramid::new(&ramp, Kernel::Bilinear);
        // Away from the border, beyond which it is level.
        let block = pyramid.block(2, [1, 1]).unwrap();
        assert!(block.slopes.distance(Vec2::new(3.0, -1.0)) < 1e-4);
        assert!(block.above - block.below < 0.01, "{block:?}");
    }
}

use super::{HeightMap, Level, Pyramid, Wrap};

/// How high and how low the surface of a map goes over blocks of it, for rays that look for the surface and
/// want to pass over what lies wholly below them (A. Tevs, I. Ihrke and H.-P. Seidel, "Maximum mipmaps for
/// fast, accurate, and scalable dynamic height field rendering", I3D 2008).
///
/// The surface is that of graphics cards: straight between the centres of texels. *Patch* `(x, y)` of a level of
/// the [`Pyramid`] lies between the centres of the texels `x` and `x + 1`, `y` and `y + 1`. A block holds
///
/// ```text
///   ┌────────────────────────────────────────────────────────────────────┐
///   │  B_l(x, y) = max( patch (x, y) of level l,  B_{l−1} of its children )  │
///   └────────────────────────────────────────────────────────────────────┘
/// ```
///
/// so that `B_{b+k}` bounds blocks of `2^k` patches a side on *every* level `b` of the pyramid: whoever looks for
/// the surface of smaller means uses the same bounds. Levels have the sizes of the pyramid's. Where a side is
/// odd, the last block takes what is left over.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    levels: Vec<BoundsLevel>,
}

/// One size of [`Bounds`].
#[derive(Clone, Debug, PartialEq)]
pub struct BoundsLevel {
    size: [u32; 2],
    blocks: Vec<[u8; 2]>,
}

impl Bounds {
    /// Bounds of a map's pyramid.
    pub fn new(map: &HeightMap, pyramid: &Pyramid) -> Self {
        let [low, high] = pyramid.range();
        let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
        let mut levels: Vec<BoundsLevel> = Vec::with_capacity(pyramid.levels().len());
        for level in pyramid.levels() {
            let mut own = BoundsLevel::of_patches(level, map.wrap(), |h| (h - low) * scale);
            if let Some(finer) = levels.last() {
                own.include(finer);
            }
            levels.push(own);
        }
        Self { levels }
    }

    /// From the finest to 1 × 1 block.
    pub fn levels(&self) -> &[BoundsLevel] {
        &self.levels
    }
}

impl BoundsLevel {
    /// Width and height in blocks.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Blocks, row after row: how far the highest lies above the map's lowest texel, and how far the lowest lies
    /// below its highest, in 255ths of the map's range, rounded up.
    pub fn blocks(&self) -> &[[u8; 2]] {
        &self.blocks
    }

    fn of_patches(level: &Level, wrap: [Wrap; 2], share: impl Fn(f32) -> f32) -> Self {
        let size = level.size();
        let [width, rows] = size.map(|n| n as usize);
        let next = |i: usize, n: usize, wrap| match wrap {
            _ if i + 1 < n => i + 1,
            Wrap::Repeat => 0,
            Wrap::Clamp => i,
        };
        let shares: Vec<f32> = level.texels().iter().map(|t| share(t.height)).collect();
        let patch = |i: usize| {
            let (x, y) = (i % width, i / width);
            let (right, below) = (next(x, width, wrap[0]), next(y, rows, wrap[1]));
            let corners = [(x, y), (right, y), (x, below), (right, below)];
            let corners = corners.map(|(x, y)| shares[y * width + x]);
            [
                rounded_up(corners.into_iter().fold(0.0, f32::max)),
                rounded_up(1.0 - corners.into_iter().fold(1.0, f32::min)),
            ]
        };
        Self {
            size,
            blocks: (0..width * rows).map(patch).collect(),
        }
    }

    /// Widens blocks to what is in those of the next finer level.
    fn include(&mut self, finer: &Self) {
        let [width, rows] = self.size;
        for (i, found) in (0..).zip(&finer.blocks) {
            let x = (i % finer.size[0] / 2).min(width - 1);
            let y = (i / finer.size[0] / 2).min(rows - 1);
            let own = &mut self.blocks[(y * width + x) as usize];
            *own = [own[0].max(found[0]), own[1].max(found[1])];
        }
    }
}

fn rounded_up(share: f32) -> u8 {
    (share * 255.0).ceil().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_map::test_photos::noise;

    /// Every block against all texels that a patch in it has for corners, on every level of the pyramid below.
    #[test]
    fn blocks_bound_the_surface_of_every_level_below() {
        for (size, wrap) in [
            ([16_u32, 8_u32], [Wrap::Repeat; 2]),
            ([13, 7], [Wrap::Repeat, Wrap::Clamp]),
            ([5, 1], [Wrap::Clamp; 2]),
            ([1, 1], [Wrap::Repeat; 2]),
        ] {
            let heights = (0..size[0] * size[1]).map(|i| 3.0 * noise(i, 7, 2) - 1.0);
            let map = HeightMap::new(size, heights.collect(), wrap).unwrap();
            let pyramid = Pyramid::new(&map);
            let bounds = Bounds::new(&map, &pyramid);
            let [low, high] = pyramid.range();
            for (finer, level) in pyramid.levels().iter().enumerate() {
                let heights = level.texels().iter().map(|t| t.height).collect();
                let means = HeightMap::new(level.size(), heights, wrap).unwrap();
                let [width, rows] = level.size().map(i64::from);
                for (coarser, blocks) in bounds.levels().iter().enumerate().skip(finer) {
                    for (x, y) in (0..rows).flat_map(|y| (0..width).map(move |x| (x, y))) {
                        let block = |i: i64, axis: usize| {
                            (i as u32 >> (coarser - finer)).min(blocks.size()[axis] - 1)
                        };
                        let block = block(y, 1) * blocks.size()[0] + block(x, 0);
                        let [above, below] = blocks.blocks()[block as usize];
                        for (x, y) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
                            let share = (means.texel(x, y) - low) / (high - low).max(1e-9);
                            assert!(share <= f32::from(above) / 255.0 + 1e-6);
                            assert!(1.0 - share <= f32::from(below) / 255.0 + 1e-6 || high == low);
                        }
                    }
                }
            }
        }
    }
}

use crate::height_map::BoundsLevel;

/// All levels of bounds in one picture, for shaders: the finest at the left, the others below each other at its
/// right. Not mips, because llvmpipe reads one size for four pixels, and rays of the four are on different levels.
/// `bounds_at` in `parallax.wgsl` finds its way by the same rule.
pub(super) struct Atlas {
    /// Two blocks a texel, which makes it narrower than the map: what has room for the one has room for the other.
    pub(super) size: [u32; 2],
    /// Four bytes a texel.
    pub(super) texels: Vec<u8>,
}

impl Atlas {
    pub(super) fn new(levels: &[BoundsLevel]) -> Self {
        let finest = levels.first().map_or([1, 1], BoundsLevel::size);
        let width = (finest[0] + (finest[0] / 2).max(1)).next_multiple_of(2);
        let ends = (0..)
            .zip(levels)
            .map(|(i, l)| place(finest, i)[1] + l.size()[1]);
        let rows = ends.max().unwrap_or(1);
        let mut texels = vec![0; 2 * width as usize * rows as usize];
        for (i, level) in (0..).zip(levels) {
            let [x, y] = place(finest, i);
            for (row, blocks) in (y..).zip(level.blocks().chunks(level.size()[0] as usize)) {
                let start = 2 * (row * width + x) as usize;
                texels[start..start + 2 * blocks.len()].copy_from_slice(blocks.as_flattened());
            }
        }
        Self {
            size: [width / 2, rows],
            texels,
        }
    }
}

/// Where the blocks of a level begin. As each level is half as high as the one before, rounded down,
///
/// ```text
///   h₁ + h₂ + … + h_{l−1}  ≤  h₀ − h_{l−1}      with h_l = ⌊h₀ / 2^l⌋,
/// ```
///
/// and levels of one row more than that has follow.
fn place([width, height]: [u32; 2], level: u32) -> [u32; 2] {
    if level == 0 {
        return [0, 0];
    }
    let of_height = height.ilog2() + 2;
    let passed = height.checked_shr(level - 1).unwrap_or(0);
    [width, height - passed + level.saturating_sub(of_height)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_map::{Bounds, HeightMap, Pyramid, Wrap};

    #[test]
    fn levels_lie_apart_and_within() {
        for size in [
            [1, 1],
            [256, 256],
            [37, 21],
            [1, 64],
            [512, 1],
            [300, 7],
            [9, 1000],
        ] {
            let heights = (0..size[0] * size[1]).map(|i| (i * i % 97) as f32);
            let map = HeightMap::new(size, heights.collect(), [Wrap::Repeat; 2]).unwrap();
            let bounds = Bounds::new(&map, &Pyramid::new(&map));
            let atlas = Atlas::new(bounds.levels());
            let [width, rows] = [2 * atlas.size[0], atlas.size[1]];
            assert!(atlas.size[0] <= size[0] && rows <= size[1] + 10, "{size:?}");
            let mut taken = vec![false; (width * rows) as usize];
            for (i, level) in (0..).zip(bounds.levels()) {
                let [x, y] = place(size, i);
                for (k, block) in (0..).zip(level.blocks()) {
                    let (column, row) = (x + k % level.size()[0], y + k / level.size()[0]);
                    assert!(column < width && row < rows, "{size:?}, level {i}");
                    let at = (row * width + column) as usize;
                    assert!(
                        !std::mem::replace(&mut taken[at], true),
                        "{size:?}, level {i}"
                    );
                    assert_eq!(&atlas.texels[2 * at..2 * at + 2], block);
                }
            }
        }
    }
}

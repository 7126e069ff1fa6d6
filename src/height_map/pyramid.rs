use glam::Vec2;

use super::HeightMap;

/// A height map at every size that a renderer asks for: heights, slopes and how much these vary.
///
/// Level 0 has the texels of the map; each further one has half as many a side, rounded down, to 1 × 1.
/// A texel of level `l` holds means over the part of the map that it covers. Slopes have squares beside
/// them, so that what averages away is not lost (M. Olano and D. Baker, "LEAN mapping", I3D 2010):
///
/// ```text
///   ┌──────────────────────────┐
///   │  variance = E[F²] − E[F]² │
///   └──────────────────────────┘
/// ```
///
/// of slopes within a texel, or within whatever footprint means are taken over: both terms are linear in
/// what is stored, so filters of graphics cards do it right.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    levels: Vec<Level>,
}

/// One size of a [`Pyramid`].
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    size: [u32; 2],
    texels: Vec<Moments>,
}

/// Means over a texel, or any other part of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Height.
    pub height: f32,
    /// Slopes `F_u` and `F_v`, the whole map being 1 wide and 1 high.
    pub slopes: Vec2,
    /// Their squares.
    pub squares: Vec2,
}

impl Moments {
    /// Variance of `F_u` and of `F_v`.
    pub fn variance(self) -> Vec2 {
        (self.squares - self.slopes * self.slopes).max(Vec2::ZERO)
    }

    fn weighted(self, weight: f32) -> Self {
        Self {
            height: weight * self.height,
            slopes: weight * self.slopes,
            squares: weight * self.squares,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            height: self.height + other.height,
            slopes: self.slopes + other.slopes,
            squares: self.squares + other.squares,
        }
    }
}

impl Pyramid {
    /// All levels of a map.
    pub fn new(map: &HeightMap) -> Self {
        let mut levels = vec![Level::finest(map)];
        while let Some(coarser) = levels.last().and_then(Level::coarser) {
            levels.push(coarser);
        }
        Self { levels }
    }

    /// From the finest to 1 × 1 texel.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The lowest and the highest texel of the map.
    pub fn range(&self) -> [f32; 2] {
        let texels = self.levels.first().map_or(&[][..], Level::texels);
        let heights = texels.iter().map(|t| t.height);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        [low, high]
    }

    /// The steepest slope of any texel along `u` or `v`; 0 for what is flat.
    pub fn steepest(&self) -> f32 {
        let texels = self.levels.iter().flat_map(|level| &level.texels);
        texels
            .map(|t| {
                t.slopes
                    .abs()
                    .max_element()
                    .max(t.squares.max_element().sqrt())
            })
            .fold(0.0, f32::max)
    }
}

impl Level {
    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Texels, row after row.
    pub fn texels(&self) -> &[Moments] {
        &self.texels
    }

    /// The map's own texels. Between the centres of texels the surface is taken as straight, so that a texel
    /// holds half of the step from the one before and half of the step to the next:
    ///
    /// ```text
    ///   E[F_u] = (f₊ − f₋) / 2      E[F_u²] = ((f₊ − f₀)² + (f₀ − f₋)²) / 2      times width, width²
    /// ```
    fn finest(map: &HeightMap) -> Self {
        let size = map.size();
        let scale = Vec2::new(size[0] as f32, size[1] as f32);
        let moments = |x: i64, y: i64| {
            let height = map.texel(x, y);
            let before = height - Vec2::new(map.texel(x - 1, y), map.texel(x, y - 1));
            let after = Vec2::new(map.texel(x + 1, y), map.texel(x, y + 1)) - height;
            Moments {
                height,
                slopes: 0.5 * scale * (before + after),
                squares: 0.5 * scale * scale * (before * before + after * after),
            }
        };
        let [width, rows] = size.map(i64::from);
        Self {
            size,
            texels: (0..width * rows)
                .map(|i| moments(i % width, i / width))
                .collect(),
        }
    }

    /// Half as many texels a side, or `None` of one texel.
    fn coarser(&self) -> Option<Self> {
        if self.size == [1, 1] {
            return None;
        }
        let size = self.size.map(|n| (n / 2).max(1));
        let [across, down] = [0, 1].map(|axis| shares(self.size[axis], size[axis]));
        let mut texels = Vec::with_capacity((size[0] * size[1]) as usize);
        for (first_row, rows) in &down {
            for (first_column, columns) in &across {
                let mut sum = Moments::default();
                for (row, down) in (*first_row..).zip(rows) {
                    for (column, across) in (*first_column..).zip(columns) {
                        let texel = self.texels[row * self.size[0] as usize + column];
                        sum = sum.plus(texel.weighted(down * across));
                    }
                }
                texels.push(sum);
            }
        }
        Some(Self { size, texels })
    }
}

/// Which of `from` texels each of `to` covers, as the first and the share of each: sizes need not be even.
fn shares(from: u32, to: u32) -> Vec<(usize, Vec<f32>)> {
    let width = f64::from(from) / f64::from(to);
    (0..to)
        .map(|i| {
            let (start, end) = (f64::from(i) * width, f64::from(i + 1) * width);
            let first = start.floor();
            let last = (end - 1e-9).floor();
            let covered = (first as usize..=last as usize)
                .map(|texel| {
                    let (a, b) = (texel as f64, texel as f64 + 1.0);
                    ((b.min(end) - a.max(start)) / width) as f32
                })
                .collect();
            (first as usize, covered)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use super::*;
    use crate::height_map::test_photos::noise;
    use crate::height_map::{Kernel, Wrap};

    fn map(size: [u32; 2], height: impl Fn(u32, u32) -> f32) -> HeightMap {
        let heights = (0..size[0] * size[1]).map(|i| height(i % size[0], i / size[0]));
        HeightMap::new(size, heights.collect(), [Wrap::Repeat; 2]).unwrap()
    }

    #[test]
    fn the_finest_level_has_the_slopes_of_the_map() {
        let map = map([5, 7], |x, y| noise(x, y, 1));
        let pyramid = Pyramid::new(&map);
        for (i, texel) in pyramid.levels()[0].texels().iter().enumerate() {
            let (x, y) = ((i % 5) as f32 + 0.5, (i / 5) as f32 + 0.5);
            let truth = map.at(Vec2::new(x / 5.0, y / 7.0), Kernel::CatmullRom);
            assert!((texel.height - truth.height).abs() < 1e-5);
            assert!(texel.slopes.distance(truth.slopes) < 1e-4);
        }
    }

    /// Means over levels of any size are those over the map.
    #[test]
    fn nothing_is_lost_on_the_way_up() {
        for size in [[8, 8], [7, 5], [13, 1], [1, 1], [16, 3]] {
            let pyramid = Pyramid::new(&map(size, |x, y| noise(x, y, 2)));
            let mean = |level: &Level| {
                let share = 1.0 / level.texels().len() as f32;
                let sum = |sum: Moments, t: &Moments| sum.plus(t.weighted(share));
                level.texels().iter().fold(Moments::default(), sum)
            };
            let whole = mean(&pyramid.levels()[0]);
            assert!(whole.slopes.length() < 1e-4, "what repeats has no slope");
            let last = pyramid.levels().last().unwrap();
            assert_eq!(last.size(), [1, 1]);
            for level in pyramid.levels() {
                let mean = mean(level);
                assert!((mean.height - whole.height).abs() < 1e-5, "{size:?}");
                let off = mean.squares.distance(whole.squares);
                assert!(
                    off < 1e-4 * whole.squares.length().max(1.0),
                    "{size:?}: {off}"
                );
            }
        }
    }

    /// The variance of a sine's slope is half of the square of its steepest.
    #[test]
    fn slopes_that_average_away_are_variance() {
        let wave = |x: u32, _: u32| 0.02 * (TAU * 8.0 * (x as f32 + 0.5) / 256.0).sin();
        let pyramid = Pyramid::new(&map([256, 256], wave));
        let top = pyramid.levels().last().unwrap().texels()[0];
        let truth = 0.5 * (0.02 * TAU * 8.0).powi(2);
        let found = top.variance();
        assert!((found.x / truth - 1.0).abs() < 0.01, "{found} for {truth}");
        assert!(found.y < 1e-6 * truth);
        // No texel lies where it is steepest.
        assert!(pyramid.steepest() > 0.98 * 0.02 * TAU * 8.0);
    }

    #[test]
    fn what_is_flat_has_no_slopes() {
        for size in [[1, 1], [4, 9]] {
            let pyramid = Pyramid::new(&map(size, |_, _| 0.7));
            assert_eq!(pyramid.steepest(), 0.0);
        }
    }
}

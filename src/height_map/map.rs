use thiserror::Error;

/// How a map goes on beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(serde::Serialize, serde::Deserialize))]
pub enum Wrap {
    /// Again and again: what tiles.
    #[default]
    Repeat,
    /// With the texels of the border.
    Clamp,
}

/// Heights at the centres of texels, row after row, the first at `v = 0`.
///
/// Texel `(x, y)` of `w × h` has its centre at `u = (x + ½)/w`, `v = (y + ½)/h`. Heights have any unit and
/// range; what gives them meaning is the scale of the material or displacement that uses the map.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    size: [u32; 2],
    heights: Vec<f32>,
    wrap: [Wrap; 2],
}

/// Why something is no height map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum HeightMapError {
    /// Width or height is nothing.
    #[error("a height map of {0} × {1} texels has none: both must be 1 or more")]
    Empty(u32, u32),
    /// There are more or fewer heights than texels.
    #[error(
        "a height map of {width} × {height} texels has {found} heights: give one for each texel"
    )]
    Count {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Heights that were given.
        found: usize,
    },
    /// A height is infinite or no number.
    #[error("the height of texel ({x}, {y}) is no finite number: mend the image it comes from")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

impl HeightMap {
    /// A map of `size` (width, height) texels.
    ///
    /// # Errors
    ///
    /// If a side is 0, the number of heights is not width × height, or a height is not finite.
    pub fn new(size: [u32; 2], heights: Vec<f32>, wrap: [Wrap; 2]) -> Result<Self, HeightMapError> {
        let [width, height] = size;
        if width == 0 || height == 0 {
            return Err(HeightMapError::Empty(width, height));
        }
        if heights.len() != width as usize * height as usize {
            return Err(HeightMapError::Count {
                width,
                height,
                found: heights.len(),
            });
        }
        if let Some(i) = heights.iter().position(|h| !h.is_finite()) {
            let (x, y) = (i % width as usize, i / width as usize);
            return Err(HeightMapError::NotFinite {
                x: x as u32,
                y: y as u32,
            });
        }
        Ok(Self {
            size,
            heights,
            wrap,
        })
    }

    /// Other heights for the same texels: as many, and finite.
    pub(super) fn with_heights(&self, heights: Vec<f32>) -> Self {
        debug_assert_eq!(heights.len(), self.heights.len());
        debug_assert!(heights.iter().all(|h| h.is_finite()));
        Self { heights, ..*self }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Heights, row after row.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// How it goes on along `u` and along `v`.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Height of a texel, wherever it is.
    pub fn texel(&self, x: i64, y: i64) -> f32 {
        self.heights[self.index(x, y)]
    }

    /// Where in [`heights`](Self::heights) a texel is, wherever it is.
    pub(super) fn index(&self, x: i64, y: i64) -> usize {
        let [x, y] = [self.inside(0, x), self.inside(1, y)];
        y * self.size[0] as usize + x
    }

    /// Where a texel beyond the border is taken from.
    pub(super) fn inside(&self, axis: usize, i: i64) -> usize {
        let n = i64::from(self.size[axis]);
        if (0..n).contains(&i) {
            return i as usize;
        }
        let inside = match self.wrap[axis] {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
        };
        inside as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_map_is_told() {
        let map = |size, heights| HeightMap::new(size, heights, [Wrap::Repeat; 2]);
        assert_eq!(map([0, 3], vec![]), Err(HeightMapError::Empty(0, 3)));
        let error = map([2, 2], vec![0.0; 3]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a height map of 2 × 2 texels has 3 heights: give one for each texel"
        );
        for bad in [f32::NAN, f32::INFINITY] {
            let error = map([3, 2], vec![0.0, 0.0, 0.0, 0.0, bad, 0.0]);
            assert_eq!(error, Err(HeightMapError::NotFinite { x: 1, y: 1 }));
        }
    }

    #[test]
    fn maps_go_on_beyond_their_borders() {
        let heights: Vec<f32> = (0..6).map(|i| i as f32).collect();
        let map = HeightMap::new([3, 2], heights, [Wrap::Repeat, Wrap::Clamp]).unwrap();
        let row: Vec<f32> = (-4..5).map(|x| map.texel(x, 0)).collect();
        assert_eq!(row, [2.0, 0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0]);
        let column: Vec<f32> = (-2..4).map(|y| map.texel(1, y)).collect();
        assert_eq!(column, [1.0, 1.0, 1.0, 4.0, 4.0, 4.0]);
    }
}

use thiserror::Error;

/// The numbers of an image as they stand in its file, row after row, without transparency.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// One channel, 0 to 255.
    Grey8(Vec<u8>),
    /// Red, green, blue, 0 to 255.
    Rgb8(Vec<[u8; 3]>),
    /// One channel, 0 to 65,535.
    Grey16(Vec<u16>),
    /// Red, green, blue, 0 to 65,535.
    Rgb16(Vec<[u16; 3]>),
    /// One channel, any finite number.
    GreyF32(Vec<f32>),
    /// Red, green, blue, any finite numbers.
    RgbF32(Vec<[f32; 3]>),
}

/// How finely an image's numbers are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Precision {
    /// 256 steps.
    Eight,
    /// 65,536 steps.
    Sixteen,
    /// Floating point.
    Float,
}

/// An image whose numbers have no meaning yet.
///
/// What they mean decides how they are read, so there are two ways on: a [`Photo`](super::Photo) says how
/// its light is encoded, and [`prepare_data`](super::prepare_data) takes numbers for heights and decodes
/// nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    size: [u32; 2],
    texels: Texels,
}

/// Why something is no image, or no image of heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum RasterError {
    /// Width or height is nothing.
    #[error("an image of {0} × {1} texels has none: both must be 1 or more")]
    Empty(u32, u32),
    /// There are more or fewer texels than width × height.
    #[error("an image of {width} × {height} texels has {found} of them: give one for each place")]
    Count {
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Texels that were given.
        found: usize,
    },
    /// A number is infinite or none.
    #[error("texel ({x}, {y}) is no finite number: mend the image, or export it again")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// Heights have one channel, and this image has three that differ.
    #[error(
        "texel ({x}, {y}) has a colour, and heights have none: export one channel, or read the image as \
         a photo"
    )]
    Coloured {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Grey8(t) => t.len(),
            Self::Rgb8(t) => t.len(),
            Self::Grey16(t) => t.len(),
            Self::Rgb16(t) => t.len(),
            Self::GreyF32(t) => t.len(),
            Self::RgbF32(t) => t.len(),
        }
    }

    fn is_finite(&self, i: usize) -> bool {
        match self {
            Self::GreyF32(t) => t[i].is_finite(),
            Self::RgbF32(t) => t[i].iter().all(|c| c.is_finite()),
            _ => true,
        }
    }

    /// 16-bit images that were 8-bit ones before have 256 steps still.
    fn narrowed(self) -> Self {
        let stretched = |c: &u16| c.is_multiple_of(257);
        let shifted = |c: &u16| c.is_multiple_of(256);
        let narrow = |c: u16| (c >> 8) as u8;
        match self {
            Self::Grey16(t) if t.iter().all(stretched) || t.iter().all(shifted) => {
                Self::Grey8(t.into_iter().map(narrow).collect())
            }
            Self::Rgb16(t)
                if t.as_flattened().iter().all(stretched)
                    || t.as_flattened().iter().all(shifted) =>
            {
                Self::Rgb8(t.into_iter().map(|c| c.map(narrow)).collect())
            }
            other => other,
        }
    }
}

impl Raster {
    /// An image of `size` (width, height) texels.
    ///
    /// 16 bits that hold 8-bit numbers, stretched or shifted, count as 8 bits.
    ///
    /// # Errors
    ///
    /// If a side is 0, the number of texels is not width × height, or a number is not finite.
    pub fn new(size: [u32; 2], texels: Texels) -> Result<Self, RasterError> {
        let [width, height] = size;
        if width == 0 || height == 0 {
            return Err(RasterError::Empty(width, height));
        }
        if texels.len() != width as usize * height as usize {
            return Err(RasterError::Count {
                width,
                height,
                found: texels.len(),
            });
        }
        let raster = Self {
            size,
            texels: texels.narrowed(),
        };
        match (0..raster.len()).find(|&i| !raster.texels.is_finite(i)) {
            None => Ok(raster),
            Some(i) => {
                let [x, y] = raster.place(i);
                Err(RasterError::NotFinite { x, y })
            }
        }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// How finely its numbers are told apart.
    pub fn precision(&self) -> Precision {
        match self.texels {
            Texels::Grey8(_) | Texels::Rgb8(_) => Precision::Eight,
            Texels::Grey16(_) | Texels::Rgb16(_) => Precision::Sixteen,
            Texels::GreyF32(_) | Texels::RgbF32(_) => Precision::Float,
        }
    }

    /// Whether it has three channels.
    pub fn has_colour(&self) -> bool {
        matches!(
            self.texels,
            Texels::Rgb8(_) | Texels::Rgb16(_) | Texels::RgbF32(_)
        )
    }

    /// The first channel alone.
    pub fn red(self) -> Self {
        let texels = match self.texels {
            Texels::Rgb8(t) => Texels::Grey8(t.into_iter().map(|[red, ..]| red).collect()),
            Texels::Rgb16(t) => Texels::Grey16(t.into_iter().map(|[red, ..]| red).collect()),
            Texels::RgbF32(t) => Texels::GreyF32(t.into_iter().map(|[red, ..]| red).collect()),
            grey => grey,
        };
        Self { texels, ..self }
    }

    /// Number of texels.
    pub(super) fn len(&self) -> usize {
        self.texels.len()
    }

    /// Column and row of a texel.
    pub(super) fn place(&self, i: usize) -> [u32; 2] {
        let width = self.size[0] as usize;
        [(i % width) as u32, (i / width) as u32]
    }

    /// The channels of a texel, whole numbers as 0 to 1, with so many steps added to each of those.
    pub(super) fn channels(&self, i: usize, steps: f64) -> [f64; 3] {
        let of8 = |c: u8| (f64::from(c) + steps) / 255.0;
        let of16 = |c: u16| (f64::from(c) + steps) / 65_535.0;
        match &self.texels {
            Texels::Grey8(t) => [of8(t[i]); 3],
            Texels::Rgb8(t) => t[i].map(of8),
            Texels::Grey16(t) => [of16(t[i]); 3],
            Texels::Rgb16(t) => t[i].map(of16),
            Texels::GreyF32(t) => [f64::from(t[i]); 3],
            Texels::RgbF32(t) => t[i].map(f64::from),
        }
    }

    /// The one channel of every texel, with so many steps added.
    ///
    /// # Errors
    ///
    /// If a texel's channels differ.
    pub(super) fn one_channel(&self, steps: f64) -> Result<Vec<f32>, RasterError> {
        (0..self.len())
            .map(|i| match self.channels(i, steps) {
                [r, g, b] if r == g && g == b => Ok(r as f32),
                _ => {
                    let [x, y] = self.place(i);
                    Err(RasterError::Coloured { x, y })
                }
            })
            .collect()
    }

    /// Shares of texels at the lower and at the upper end of what whole numbers can say: with any channel
    /// at the upper, or all at the lower. Floating point has no ends.
    pub(super) fn clipped(&self) -> [f64; 2] {
        if self.precision() == Precision::Float {
            return [0.0; 2];
        }
        let mut counts = [0_usize; 2];
        for i in 0..self.len() {
            let channels = self.channels(i, 0.0);
            counts[0] += usize::from(channels == [0.0; 3]);
            counts[1] += usize::from(channels.contains(&1.0));
        }
        counts.map(|n| n as f64 / self.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_image_is_told() {
        let grey = |size, n| Raster::new(size, Texels::Grey8(vec![0; n]));
        assert_eq!(grey([0, 3], 0), Err(RasterError::Empty(0, 3)));
        let error = grey([2, 2], 3).unwrap_err().to_string();
        assert_eq!(
            error,
            "an image of 2 × 2 texels has 3 of them: give one for each place"
        );
        let mut texels = vec![[0.0_f32; 3]; 6];
        texels[4][1] = f32::NAN;
        let error = Raster::new([3, 2], Texels::RgbF32(texels));
        assert_eq!(error, Err(RasterError::NotFinite { x: 1, y: 1 }));
    }

    #[test]
    fn sixteen_bits_that_were_eight_are_found_out() {
        let of = |texels| Raster::new([2, 2], Texels::Grey16(texels)).unwrap();
        for texels in [vec![0, 257, 514, 65_535], vec![0, 256, 65_280, 512]] {
            assert_eq!(of(texels).precision(), Precision::Eight);
        }
        let stretched = of(vec![0, 257, 514, 65_535]);
        assert_eq!(stretched.one_channel(0.0).unwrap()[1], 1.0 / 255.0);
        assert_eq!(
            of(vec![0, 257, 515, 65_535]).precision(),
            Precision::Sixteen
        );
    }

    #[test]
    fn heights_have_one_channel() {
        let raster = |texels| Raster::new([2, 1], Texels::Rgb8(texels)).unwrap();
        let grey = raster(vec![[3; 3], [9; 3]]).one_channel(0.0).unwrap();
        assert_eq!(grey, [3.0 / 255.0, 9.0 / 255.0]);
        let colour = raster(vec![[3; 3], [9, 9, 8]]).one_channel(0.0);
        assert_eq!(colour, Err(RasterError::Coloured { x: 1, y: 0 }));
    }

    #[test]
    fn ends_are_counted() {
        let texels = vec![[0, 0, 0], [0, 0, 1], [255, 0, 0], [255; 3]];
        let raster = Raster::new([4, 1], Texels::Rgb8(texels)).unwrap();
        assert_eq!(raster.clipped(), [0.25, 0.5]);
        let float = Raster::new([2, 1], Texels::GreyF32(vec![0.0, 1.0])).unwrap();
        assert_eq!(float.clipped(), [0.0; 2]);
    }
}

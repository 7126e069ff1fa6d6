use super::raster::{Precision, Raster};

/// What the numbers of a photo say of its light.
///
/// There is no default: a decoding too many or too few bends every slope of the relief, and nobody
/// sees it in the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// The curve of IEC 61966-2-1, as in nearly all 8-bit photos.
    Srgb,
    /// Numbers are light, as in raw conversions and in what renderers write.
    Linear,
}

/// Rec. 709 luminance of linear red, green and blue (ITU-R BT.709-6, 3.2).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

impl Encoding {
    /// The light that a number stands for.
    pub fn decode(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Srgb if value <= 0.040_45 => value / 12.92,
            Self::Srgb => ((value + 0.055) / 1.055).powf(2.4),
        }
    }
}

/// An image of light: a raster, and how its light is encoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Photo {
    raster: Raster,
    encoding: Encoding,
}

impl Photo {
    /// A photo whose numbers mean what `encoding` says.
    pub fn new(raster: Raster, encoding: Encoding) -> Self {
        Self { raster, encoding }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.raster.size()
    }

    /// The numbers.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// What they say of light.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Linear red, green and blue of every texel.
    pub fn linear(&self) -> Vec<[f32; 3]> {
        (0..self.raster.len())
            .map(|i| {
                let channels = self.raster.channels(i, 0.0);
                channels.map(|c| self.encoding.decode(c) as f32)
            })
            .collect()
    }

    /// Linear luminance of every texel, 1 where all channels are at their end.
    pub fn luminance(&self) -> Vec<f32> {
        self.luminance_of(0.0)
    }

    /// Between which luminances a texel lies if its numbers were rounded, where that matters: at 8 bits.
    pub(super) fn bounds(&self) -> Option<Vec<[f32; 2]>> {
        if self.raster.precision() != Precision::Eight {
            return None;
        }
        let (low, high) = (self.luminance_of(-0.5), self.luminance_of(0.5));
        Some(low.into_iter().zip(high).map(|(l, h)| [l, h]).collect())
    }

    fn luminance_of(&self, steps: f64) -> Vec<f32> {
        let decode = |c: f64| self.encoding.decode(c);
        (0..self.raster.len())
            .map(|i| {
                let channels = self.raster.channels(i, steps).map(decode);
                let sum: f64 = channels.iter().zip(LUMINANCE).map(|(c, w)| c * w).sum();
                // The weights may add up to a hair more than 1.
                sum.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Texels;
    use super::*;

    fn ramp(texels: Texels, encoding: Encoding) -> Vec<f32> {
        Photo::new(Raster::new([256, 1], texels).unwrap(), encoding).luminance()
    }

    /// Bump test 16: a ramp of light comes back whichever way it was encoded.
    #[test]
    fn light_is_decoded_as_it_was_encoded() {
        let light: Vec<f64> = (0..256).map(|i| f64::from(i) / 255.0).collect();
        // The standard's curve the other way, which the code above has not.
        let encode = |&l: &f64| {
            if l <= 0.003_130_8 {
                12.92 * l
            } else {
                1.055 * l.powf(1.0 / 2.4) - 0.055
            }
        };
        let of8 = |l| (255.0 * encode(l)).round() as u8;
        let of16 = |l| (65_535.0 * encode(l)).round() as u16;
        let encoded: Vec<u8> = light.iter().map(of8).collect();
        let colour = encoded.iter().map(|&c| [c; 3]).collect();
        let fine = light.iter().map(of16).collect();
        let plain: Vec<u8> = (0..=255).collect();
        // Half a step of 8 bits is up to 1.14/255 of light where the curve is steepest, at white: more than
        // 1/255 is lost in the file.
        for (texels, encoding, most) in [
            (Texels::Grey8(encoded), Encoding::Srgb, 1.15),
            (Texels::Rgb8(colour), Encoding::Srgb, 1.15),
            (Texels::Grey16(fine), Encoding::Srgb, 0.01),
            (Texels::Grey8(plain.clone()), Encoding::Linear, 1e-4),
        ] {
            for (found, light) in ramp(texels, encoding).iter().zip(&light) {
                let off = (f64::from(*found) - light).abs();
                assert!(off < most / 255.0, "{encoding:?}, {light}: {off}");
            }
        }
        // A decoding too many is nowhere near that.
        let wrong = ramp(Texels::Grey8(plain), Encoding::Srgb);
        assert!((wrong[128] - 128.0 / 255.0).abs() > 0.25);
    }

    #[test]
    fn luminance_is_rec_709_of_linear_light() {
        let raster = Raster::new(
            [3, 1],
            Texels::Rgb8(vec![[255, 0, 0], [0, 255, 0], [188; 3]]),
        );
        let found = Photo::new(raster.unwrap(), Encoding::Srgb).luminance();
        for (found, expected) in found.into_iter().zip([0.2126, 0.7152, 0.5029]) {
            assert!((found - expected).abs() < 1e-4, "{found}, not {expected}");
        }
    }

    #[test]
    fn bounds_hold_what_rounds_to_the_texel() {
        let raster = Raster::new([2, 1], Texels::Grey8(vec![0, 100])).unwrap();
        let bounds = Photo::new(raster, Encoding::Linear).bounds().unwrap();
        assert!((bounds[1][0] - 99.5 / 255.0).abs() < 1e-7);
        assert!((bounds[1][1] - 100.5 / 255.0).abs() < 1e-7);
        let fine = Raster::new([2, 1], Texels::Grey16(vec![0, 100])).unwrap();
        assert_eq!(Photo::new(fine, Encoding::Linear).bounds(), None);
    }
}

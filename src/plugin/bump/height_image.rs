use std::sync::Arc;

use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use thiserror::Error;

use super::texels::{self, HeightChannel};
use crate::height_map::{HeightMap, HeightMapError, Pyramid, Wrap};

/// A height map as an asset, for [`Bump`](super::Bump)s.
///
/// Loaded from whatever format Bevy reads (`assets.load::<HeightImage>("bricks.png")`): 8 and 16 bits, float,
/// grey or colour. Numbers are taken as they are stored, 0 to 1, and never as sRGB.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct HeightImage {
    map: Arc<HeightMap>,
    pyramid: Arc<Pyramid>,
    anisotropy: u16,
}

/// Why an image is no height map.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum HeightImageError {
    /// Its texels are gone, or fewer than its size says.
    #[error(
        "the image has no texels in the main world: give it `RenderAssetUsages::MAIN_WORLD`, or load it as a \
         `HeightImage`"
    )]
    NoData,
    /// It is a cube, an array or a volume.
    #[error("the image has several layers: a height map is one flat image")]
    NotFlat,
    /// Its format cannot be read, because it is compressed or of integers.
    #[error(
        "heights cannot be read from the format {0:?}: use an image of 8 or 16 bits or of floats that is not \
         compressed"
    )]
    Format(TextureFormat),
    /// Its heights make no map.
    #[error(transparent)]
    Map(#[from] HeightMapError),
}

impl HeightImage {
    /// An asset of a map.
    pub fn new(map: HeightMap) -> Self {
        Self {
            pyramid: Arc::new(Pyramid::new(&map)),
            map: Arc::new(map),
            anisotropy: 1,
        }
    }

    /// A map from an image that is there already.
    ///
    /// # Errors
    ///
    /// If the image has no texels, several layers, a format that cannot be read or heights that are no
    /// numbers.
    pub fn from_image(
        image: &Image,
        channel: HeightChannel,
        wrap: [Wrap; 2],
    ) -> Result<Self, HeightImageError> {
        let (size, heights) = texels::heights(image, channel)?;
        Ok(Self::new(HeightMap::new(size, heights, wrap)?))
    }

    /// With that many samples at most where a surface is seen aslant, 1 to 16: sharper, and slower.
    #[must_use]
    pub fn with_anisotropy(self, samples: u16) -> Self {
        Self {
            anisotropy: samples.clamp(1, 16),
            ..self
        }
    }

    /// The map.
    pub fn map(&self) -> &HeightMap {
        &self.map
    }

    /// The map itself: images that are clones of each other share it, and it never changes.
    pub(in crate::plugin) fn shared_map(&self) -> &Arc<HeightMap> {
        &self.map
    }

    /// The map at every size.
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
    }

    /// Samples at most where a surface is seen aslant.
    pub fn anisotropy(&self) -> u16 {
        self.anisotropy
    }
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;
    use bevy::render::render_resource::{Extent3d, TextureDimension};

    use super::*;

    fn image(size: [u32; 2], format: TextureFormat, data: Vec<u8>) -> Image {
        let extent = Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        };
        let usage = RenderAssetUsages::all();
        Image::new(extent, TextureDimension::D2, data, format, usage)
    }

    fn heights(image: &Image, channel: HeightChannel) -> Result<Vec<f32>, HeightImageError> {
        let found = HeightImage::from_image(image, channel, [Wrap::Repeat; 2])?;
        Ok(found.map().heights().to_vec())
    }

    fn half(values: &[f32]) -> Vec<u8> {
        values
            .iter()
            .flat_map(|v| half::f16::from_f32(*v).to_le_bytes())
            .collect()
    }

    /// Bump test 16: a ramp in every format is the ramp, marked as sRGB or not.
    #[test]
    fn numbers_are_taken_as_they_are_stored() {
        use TextureFormat as F;
        let ramp = [0.0, 0.25, 0.5, 1.0];
        let bytes = |v: f32| (v * 255.0).round() as u8;
        let words = |v: f32| ((v * 65535.0).round() as u16).to_le_bytes();
        let four = |v: f32| [bytes(v), bytes(v), bytes(v), 255];
        let cases: [(F, Vec<u8>, f32); 9] = [
            (F::R8Unorm, ramp.map(bytes).to_vec(), 0.51 / 255.0),
            (F::Rgba8Unorm, ramp.map(four).concat(), 0.51 / 255.0),
            (F::Rgba8UnormSrgb, ramp.map(four).concat(), 0.51 / 255.0),
            (F::Bgra8UnormSrgb, ramp.map(four).concat(), 0.51 / 255.0),
            (F::R16Uint, ramp.map(words).concat(), 1e-5),
            (F::R16Unorm, ramp.map(words).concat(), 1e-5),
            (
                F::Rgba16Unorm,
                ramp.map(|v| [words(v); 4].concat()).concat(),
                1e-5,
            ),
            (F::R16Float, half(&ramp), 1e-3),
            (F::R32Float, ramp.map(f32::to_le_bytes).concat(), 0.0),
        ];
        for (format, data, limit) in cases {
            let found = heights(&image([4, 1], format, data), HeightChannel::Grey).unwrap();
            for (found, truth) in found.iter().zip(ramp) {
                assert!(
                    (found - truth).abs() <= limit,
                    "{format:?}: {found} for {truth}"
                );
            }
        }
    }

    #[test]
    fn channels_are_told_apart() {
        let texel = image(
            [1, 1],
            TextureFormat::Rgba8UnormSrgb,
            vec![51, 102, 153, 204],
        );
        let one = |channel| heights(&texel, channel).unwrap()[0];
        assert_eq!(one(HeightChannel::Red), 0.2);
        assert_eq!(one(HeightChannel::Green), 0.4);
        assert_eq!(one(HeightChannel::Blue), 0.6);
        assert_eq!(one(HeightChannel::Alpha), 0.8);
        let grey = 0.2126 * 0.2 + 0.7152 * 0.4 + 0.0722 * 0.6;
        assert!((one(HeightChannel::Grey) - grey).abs() < 1e-6);
        let swapped = image([1, 1], TextureFormat::Bgra8Unorm, vec![51, 102, 153, 204]);
        assert_eq!(heights(&swapped, HeightChannel::Red).unwrap()[0], 0.6);
    }

    #[test]
    fn what_is_no_height_map_is_told() {
        let nan = image(
            [1, 1],
            TextureFormat::R32Float,
            f32::NAN.to_le_bytes().to_vec(),
        );
        let error = heights(&nan, HeightChannel::Grey).unwrap_err();
        assert_eq!(
            error,
            HeightImageError::Map(HeightMapError::NotFinite { x: 0, y: 0 })
        );
        let mut gone = image([1, 1], TextureFormat::R8Unorm, vec![7]);
        gone.data = None;
        assert_eq!(
            heights(&gone, HeightChannel::Grey),
            Err(HeightImageError::NoData)
        );
        let block = image([4, 4], TextureFormat::Bc4RUnorm, vec![0; 8]);
        let error = heights(&block, HeightChannel::Grey).unwrap_err();
        assert!(error.to_string().contains("Bc4RUnorm"), "{error}");
    }
}

use bevy::image::TextureFormatPixelInfo;
use bevy::prelude::*;
use bevy::render::render_resource::{TextureDimension, TextureFormat};
use serde::{Deserialize, Serialize};

use super::HeightImageError;

/// Which number of a texel is the height.
#[derive(Reflect, Serialize, Deserialize, Debug, Default, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HeightChannel {
    /// Luminance of the numbers as they are stored (Rec. 709 weights): of grey images, the grey.
    #[default]
    Grey,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha: next to the colours of some normal maps.
    Alpha,
}

/// How a number of a texel is stored.
#[derive(Clone, Copy)]
enum Number {
    /// 0 to 255 as 0 to 1.
    U8,
    /// −127 to 127 as −1 to 1.
    I8,
    /// 0 to 65535 as 0 to 1.
    U16,
    I16,
    F16,
    F32,
}

impl Number {
    fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::F32 => 4,
        }
    }

    fn read(self, bytes: &[u8]) -> f32 {
        match (self, bytes) {
            (Self::U8, &[a]) => f32::from(a) / 255.0,
            (Self::I8, &[a]) => (f32::from(a.cast_signed()) / 127.0).max(-1.0),
            (Self::U16, &[a, b]) => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
            (Self::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])) / 32767.0).max(-1.0),
            (Self::F16, &[a, b]) => half::f16::from_le_bytes([a, b]).to_f32(),
            (Self::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            // Slices are as long as `bytes` says.
            _ => f32::NAN,
        }
    }
}

/// Numbers of a format, in the order red, green, blue, alpha, and at which places they are.
fn layout(format: TextureFormat) -> Option<(Number, &'static [usize])> {
    use TextureFormat as F;
    const R: &[usize] = &[0];
    const RG: &[usize] = &[0, 1];
    const RGBA: &[usize] = &[0, 1, 2, 3];
    const BGRA: &[usize] = &[2, 1, 0, 3];
    Some(match format {
        F::R8Unorm | F::R8Uint => (Number::U8, R),
        F::R8Snorm => (Number::I8, R),
        F::Rg8Unorm | F::Rg8Uint => (Number::U8, RG),
        // Heights are no colours: what is stored is what is meant, whatever the format says.
        F::Rgba8Unorm | F::Rgba8UnormSrgb | F::Rgba8Uint => (Number::U8, RGBA),
        F::Bgra8Unorm | F::Bgra8UnormSrgb => (Number::U8, BGRA),
        // Bevy loads 16-bit grey as integers.
        F::R16Uint | F::R16Unorm => (Number::U16, R),
        F::R16Snorm => (Number::I16, R),
        F::R16Float => (Number::F16, R),
        F::Rg16Uint | F::Rg16Unorm => (Number::U16, RG),
        F::Rg16Float => (Number::F16, RG),
        F::Rgba16Uint | F::Rgba16Unorm => (Number::U16, RGBA),
        F::Rgba16Float => (Number::F16, RGBA),
        F::R32Float => (Number::F32, R),
        F::Rg32Float => (Number::F32, RG),
        F::Rgba32Float => (Number::F32, RGBA),
        _ => return None,
    })
}

/// Size and heights of an image, whatever it stores them in.
pub(super) fn heights(
    image: &Image,
    channel: HeightChannel,
) -> Result<([u32; 2], Vec<f32>), HeightImageError> {
    let descriptor = &image.texture_descriptor;
    let [width, height] = [image.width(), image.height()];
    if descriptor.dimension != TextureDimension::D2 || descriptor.size.depth_or_array_layers != 1 {
        return Err(HeightImageError::NotFlat);
    }
    let format = descriptor.format;
    let (Some((number, places)), Ok(texel)) = (layout(format), format.pixel_size()) else {
        return Err(HeightImageError::Format(format));
    };
    let data = image.data.as_ref().ok_or(HeightImageError::NoData)?;
    let count = width as usize * height as usize;
    // Bytes of smaller sizes may follow.
    let texels = (data.get(..count * texel)).ok_or(HeightImageError::NoData)?;
    let at = |texel: &[u8], i: usize| {
        let start = places[i] * number.bytes();
        number.read(&texel[start..start + number.bytes()])
    };
    let height_of = |texel: &[u8]| match (channel, places.len()) {
        (HeightChannel::Alpha, 4) => at(texel, 3),
        (HeightChannel::Alpha, _) => 1.0,
        (HeightChannel::Green, 2..) => at(texel, 1),
        (HeightChannel::Blue, 4) => at(texel, 2),
        (HeightChannel::Grey, 4) => {
            let [r, g, b] = [0, 1, 2].map(|i| at(texel, i));
            // Grey stays what it is to the last bit.
            if r == g && g == b {
                r
            } else {
                0.2126 * r + 0.7152 * g + 0.0722 * b
            }
        }
        _ => at(texel, 0),
    };
    let heights = texels.chunks_exact(texel).map(height_of).collect();
    Ok(([width, height], heights))
}

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::exr_file;
use crate::cli::failure::Failure;
use crate::height_map::{Encoding, Precision, Raster, Texels};

/// An image file, decoded to the numbers that are in it.
#[derive(Debug)]
pub(in crate::cli) struct ImageFile {
    pub(in crate::cli) raster: Raster,
    /// Share of texels that are not opaque: their colours may mean nothing.
    pub(super) transparent: f64,
}

/// Size, numbers, and the share of texels that are not opaque.
pub(super) type Decoded = ([u32; 2], Texels, f64);

/// Reads a PNG, JPEG, OpenEXR or Radiance HDR file.
pub(in crate::cli) fn read(path: &Path) -> Result<ImageFile, Failure> {
    let name = path.display().to_string();
    let bytes =
        fs::read(path).map_err(|error| Failure::Error(format!("cannot read {name}: {error}")))?;
    decode(&name, &bytes)
}

/// The image of that name from its bytes: PNG, JPEG, OpenEXR or Radiance HDR, told apart by content.
pub(in crate::cli) fn decode(name: &str, bytes: &[u8]) -> Result<ImageFile, Failure> {
    let named = |reason: String| Failure::Error(format!("cannot read {name}: {reason}"));
    if bytes.is_empty() {
        return Err(named("the file is empty: export the image again".into()));
    }
    let (size, texels, transparent) = decode_any(bytes).map_err(named)?;
    Ok(ImageFile {
        raster: Raster::new(size, texels).map_err(|error| named(error.to_string()))?,
        transparent,
    })
}

/// What the numbers of a photo mean if nobody says: cameras and painting programs write sRGB; 16 bits of
/// one channel and floating point come from programs that compute.
pub(super) fn usual_encoding(raster: &Raster) -> Encoding {
    match (raster.precision(), raster.has_colour()) {
        (Precision::Eight, _) | (Precision::Sixteen, true) => Encoding::Srgb,
        (Precision::Sixteen, false) | (Precision::Float, _) => Encoding::Linear,
    }
}

fn decode_any(bytes: &[u8]) -> Result<Decoded, String> {
    let kinds = "it must be a PNG, JPEG, OpenEXR or Radiance HDR image";
    match image::guess_format(bytes) {
        Ok(ImageFormat::OpenExr) => exr_file::decode(bytes),
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Hdr)) => {
            decode_as(bytes, format)
        }
        Ok(other) => Err(format!("{kinds}, and is {other:?}: convert it")),
        Err(_) => Err(format!("{kinds}: convert it")),
    }
}

fn decode_as(bytes: &[u8], format: ImageFormat) -> Result<Decoded, String> {
    let broken = |error| format!("{error}: export the image again");
    let mut decoder = ImageReader::with_format(Cursor::new(bytes), format)
        .into_decoder()
        .map_err(broken)?;
    // Phones store photos lying down and say how to turn them.
    let orientation = decoder.orientation().map_err(broken)?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    image.apply_orientation(orientation);
    texels(image)
}

fn texels(image: DynamicImage) -> Result<Decoded, String> {
    let size = [image.width(), image.height()];
    let transparent = match &image {
        DynamicImage::ImageLumaA8(i) => share(i.pixels().map(|p| p.0[1] < u8::MAX)),
        DynamicImage::ImageRgba8(i) => share(i.pixels().map(|p| p.0[3] < u8::MAX)),
        DynamicImage::ImageLumaA16(i) => share(i.pixels().map(|p| p.0[1] < u16::MAX)),
        DynamicImage::ImageRgba16(i) => share(i.pixels().map(|p| p.0[3] < u16::MAX)),
        DynamicImage::ImageRgba32F(i) => share(i.pixels().map(|p| p.0[3] < 1.0)),
        _ => 0.0,
    };
    let texels = match image {
        DynamicImage::ImageLuma8(i) => Texels::Grey8(i.into_raw()),
        DynamicImage::ImageLumaA8(i) => Texels::Grey8(i.pixels().map(|p| p.0[0]).collect()),
        DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) => {
            Texels::Rgb8(image.into_rgb8().pixels().map(|p| p.0).collect())
        }
        DynamicImage::ImageLuma16(i) => Texels::Grey16(i.into_raw()),
        DynamicImage::ImageLumaA16(i) => Texels::Grey16(i.pixels().map(|p| p.0[0]).collect()),
        DynamicImage::ImageRgb16(_) | DynamicImage::ImageRgba16(_) => {
            Texels::Rgb16(image.into_rgb16().pixels().map(|p| p.0).collect())
        }
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Texels::RgbF32(image.into_rgb32f().pixels().map(|p| p.0).collect())
        }
        other => {
            return Err(format!(
                "its colour type {:?} is unknown: convert it",
                other.color()
            ));
        }
    };
    Ok((size, texels, transparent))
}

pub(super) fn share(holds: impl ExactSizeIterator<Item = bool>) -> f64 {
    let all = holds.len().max(1);
    holds.filter(|&h| h).count() as f64 / all as f64
}

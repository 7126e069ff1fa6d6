use std::io;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext, RenderAssetUsages};
use bevy::image::{CompressedImageFormats, ImageSampler, ImageType, TextureError};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{HeightChannel, HeightImage, HeightImageError};
use crate::height_map::Wrap;

/// Loads [`HeightImage`]s from every image format that Bevy was built with.
///
/// It is found by the type asked for, and claims no file extension: images stay images.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct HeightImageLoader;

/// How a [`HeightImage`] is loaded.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_fresco::height_map::Wrap;
/// # use bevy_fresco::plugin::bump::{HeightImage, HeightImageSettings};
/// # fn load(assets: Res<AssetServer>) {
/// let map: Handle<HeightImage> = assets
///     .load_builder()
///     .with_settings(|s: &mut HeightImageSettings| s.wrap = [Wrap::Clamp; 2])
///     .load("relief.png");
/// # }
/// ```
#[derive(Serialize, Deserialize, Debug, Clone, PartialEq)]
#[serde(default)]
pub struct HeightImageSettings {
    /// Which number of a texel is the height.
    pub channel: HeightChannel,
    /// How the map goes on along `u` and `v`.
    pub wrap: [Wrap; 2],
    /// See [`HeightImage::with_anisotropy`].
    pub anisotropy: u16,
}

impl Default for HeightImageSettings {
    fn default() -> Self {
        Self {
            channel: HeightChannel::default(),
            wrap: [Wrap::Repeat; 2],
            anisotropy: 1,
        }
    }
}

/// Why a file is no height map.
#[derive(Debug, Error)]
pub enum HeightImageLoaderError {
    /// It cannot be read.
    #[error("the file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// Its name has no extension to tell its format by.
    #[error("the file has no extension, such as .png, to tell its format by")]
    NoExtension,
    /// It is no image, or of a format that Bevy was not built with.
    #[error("{0} (formats are features of Bevy: `png`, `jpeg`, `exr`, …)")]
    Image(#[from] TextureError),
    /// The image is no height map.
    #[error(transparent)]
    Heights(#[from] HeightImageError),
}

impl AssetLoader for HeightImageLoader {
    type Asset = HeightImage;
    type Settings = HeightImageSettings;
    type Error = HeightImageLoaderError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &HeightImageSettings,
        context: &mut LoadContext<'_>,
    ) -> Result<HeightImage, HeightImageLoaderError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let extension = context.path().path().extension();
        let extension = extension.and_then(|e| e.to_str());
        let extension = extension.ok_or(HeightImageLoaderError::NoExtension)?;
        let image = Image::from_buffer(
            &bytes,
            ImageType::Extension(extension),
            CompressedImageFormats::NONE,
            false,
            ImageSampler::Default,
            RenderAssetUsages::MAIN_WORLD,
        )?;
        let map = HeightImage::from_image(&image, settings.channel, settings.wrap)?;
        Ok(map.with_anisotropy(settings.anisotropy))
    }
}

use std::sync::Arc;

use bevy::color::Srgba;
use bevy::image::{ImageAddressMode, ImageSampler, TextureAccessError};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;

use super::assets::Copy;
use crate::radiosity::{Texture, Wrap};

/// Images as the bake reads them, kept from one bake to the next.
#[derive(Default)]
pub(super) struct Textures {
    known: HashMap<(usize, bool), Known>,
}

struct Known {
    /// Held so that no other image takes its address, which is its name here.
    _image: Arc<Image>,
    texture: Result<Arc<Texture>, String>,
    used: bool,
}

impl Textures {
    /// The image as colours (sRGB encoded) or as plain numbers.
    pub(super) fn get(&mut self, image: &Copy<Image>, color: bool) -> Result<Arc<Texture>, String> {
        let key = (Arc::as_ptr(&image.asset).addr(), color);
        let known = self.known.entry(key).or_insert_with(|| Known {
            texture: texture(&image.asset, color)
                .map(Arc::new)
                .map_err(|e| e.to_string()),
            _image: image.asset.clone(),
            used: true,
        });
        known.used = true;
        known.texture.clone()
    }

    /// Drops what was not asked for since the last call.
    pub(super) fn keep_used(&mut self) {
        self.known.retain(|_, k| std::mem::take(&mut k.used));
    }
}

#[derive(Debug, thiserror::Error)]
enum ImageProblem {
    #[error("its data is not in the main world: load it with `RenderAssetUsages::MAIN_WORLD`")]
    NotInMainWorld,
    #[error("format {0:?} cannot be read: use an uncompressed image, or a PNG or JPEG file")]
    Format(TextureFormat),
    #[error("it is not a two-dimensional image: use one that is")]
    NotFlat,
}

fn texture(image: &Image, color: bool) -> Result<Texture, ImageProblem> {
    let format = image.texture_descriptor.format;
    let data = image.data.as_ref().ok_or(ImageProblem::NotInMainWorld)?;
    let size = image.size();
    let count = size.x as usize * size.y as usize;
    let as_stored = match format {
        TextureFormat::Rgba8UnormSrgb => color,
        TextureFormat::Rgba8Unorm => !color,
        _ => false,
    };
    let texels = if as_stored && data.len() >= 4 * count {
        data.as_chunks::<4>().0[..count].to_vec()
    } else {
        let texel = |i: usize| {
            let read = image.get_color_at(i as u32 % size.x, i as u32 / size.x);
            Ok(encode(read?, color))
        };
        (0..count)
            .map(texel)
            .collect::<Result<_, _>>()
            .map_err(|e| match e {
                TextureAccessError::UnsupportedTextureFormat(f) => ImageProblem::Format(f),
                _ => ImageProblem::NotFlat,
            })?
    };
    Ok(Texture {
        name: String::new(),
        width: size.x,
        height: size.y,
        texels,
        wrap: wrap(&image.sampler),
    })
}

fn encode(color: Color, srgb: bool) -> [u8; 4] {
    let lanes = if srgb {
        Srgba::from(color).to_f32_array()
    } else {
        color.to_linear().to_f32_array()
    };
    lanes.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8)
}

fn wrap(sampler: &ImageSampler) -> [Wrap; 2] {
    let wrap = |mode| match mode {
        ImageAddressMode::Repeat => Wrap::Repeat,
        ImageAddressMode::MirrorRepeat => Wrap::Mirror,
        ImageAddressMode::ClampToEdge | ImageAddressMode::ClampToBorder => Wrap::Clamp,
    };
    match sampler {
        // Bevy's default sampler, unless the application gave `ImagePlugin` another.
        ImageSampler::Default => [Wrap::Clamp; 2],
        ImageSampler::Descriptor(d) => [wrap(d.address_mode_u), wrap(d.address_mode_v)],
    }
}

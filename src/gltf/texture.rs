//! Images and samplers.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

use glam::{Affine2, Vec2};
use gltf::json::Root;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::container;
use super::notes::Notes;
use crate::radiosity::{Texture, TextureId, TextureRef, Wrap};

/// Loads images when a material first needs them.
#[derive(Debug)]
pub(super) struct Textures<'a> {
    path: &'a Path,
    root: &'a Root,
    accessors: Accessors<'a>,
    /// The images that could be read, so far.
    pub(super) loaded: Vec<Texture>,
    by_use: HashMap<(usize, [u8; 2]), Option<TextureId>>,
    by_image: HashMap<usize, Option<TextureId>>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(path: &'a Path, root: &'a Root, accessors: Accessors<'a>) -> Self {
        Self {
            path,
            root,
            accessors,
            loaded: Vec::new(),
            by_use: HashMap::new(),
            by_image: HashMap::new(),
        }
    }

    /// The texture of a material's slot, or nothing if its image cannot be had; a note says so
    /// then. `slot` is what the note calls it.
    pub(super) fn get(&mut self, info: &Info, slot: &str, notes: &mut Notes) -> Option<TextureRef> {
        let texture = self.root.textures.get(info.index.value())?;
        let Some(image) = self.root.images.get(texture.source.value()) else {
            let extensions = texture.extensions.as_ref();
            let names = extensions.map(|all| all.others.keys().cloned().collect::<Vec<_>>());
            notes.add(format!(
                "The {slot} has no PNG or JPEG image (extensions: {}): it is ignored; export with \
                 PNG or JPEG images.",
                names.unwrap_or_default().join(", ")
            ));
            return None;
        };
        let wrap = wrapping(self.root, texture.sampler.map(|sampler| sampler.value()));
        let index = texture.source.value();
        let texture = match self.by_use.get(&(index, wrap.map(|w| w as u8))) {
            Some(known) => *known,
            None => self.load(index, wrap, notes),
        };
        self.by_use.insert((index, wrap.map(|w| w as u8)), texture);
        let Some(texture) = texture else {
            notes.add(format!(
                "The {slot} is ignored, as {} could not be read.",
                image_name(image, index)
            ));
            return None;
        };
        Some(TextureRef {
            texture,
            uv_set: uv_set(info),
            transform: uv_transform(info),
        })
    }

    fn load(&mut self, index: usize, wrap: [Wrap; 2], notes: &mut Notes) -> Option<TextureId> {
        let texture = match self.by_image.get(&index) {
            // The same texels with another wrapping.
            Some(known) => {
                let known = self.loaded.get(known.as_ref()?.0 as usize)?;
                Texture {
                    wrap,
                    ..known.clone()
                }
            }
            None => self.decode(index, wrap, notes)?,
        };
        let id = TextureId(u32::try_from(self.loaded.len()).ok()?);
        self.loaded.push(texture);
        self.by_image.entry(index).or_insert(Some(id));
        Some(id)
    }

    fn decode(&mut self, index: usize, wrap: [Wrap; 2], notes: &mut Notes) -> Option<Texture> {
        let image = self.root.images.get(index)?;
        let name = image_name(image, index);
        let pixels = image_bytes(self.path, self.accessors, image)
            .and_then(|bytes| decode_pixels(&bytes))
            .map_err(|reason| {
                notes.add(format!(
                    "{name} cannot be used ({reason}): put a PNG or JPEG image there."
                ));
                self.by_image.insert(index, None);
            });
        let pixels = pixels.ok()?;
        let (width, height) = pixels.dimensions();
        let (texels, _) = pixels.as_raw().as_chunks::<4>();
        Some(Texture {
            name,
            width,
            height,
            texels: texels.to_vec(),
            wrap,
        })
    }
}

/// The file that an image is.
pub(super) fn image_bytes(
    path: &Path,
    accessors: Accessors<'_>,
    image: &gltf::json::Image,
) -> Result<Vec<u8>, String> {
    match (&image.uri, image.buffer_view) {
        (_, Some(view)) => accessors.view(view.value()).map(<[u8]>::to_vec),
        (Some(uri), None) => container::fetch(path, uri).map_err(|error| error.to_string()),
        (None, None) => Err("it has neither a uri nor a buffer view".to_owned()),
    }
}

/// Decodes PNG or JPEG, told apart by content: files often lie about it.
fn decode_pixels(bytes: &[u8]) -> Result<image::RgbaImage, String> {
    let reader = image::ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let image = reader.map_err(|error| error.to_string())?.decode();
    Ok(image.map_err(|error| error.to_string())?.into_rgba8())
}

pub(super) fn image_name(image: &gltf::json::Image, index: usize) -> String {
    match (&image.name, &image.uri) {
        (Some(name), _) if !name.is_empty() => format!("Image {name}"),
        (_, Some(uri)) if !container::is_data(uri) => format!("Image {uri}"),
        _ => format!("Image {index}"),
    }
}

pub(super) fn wrapping(root: &Root, sampler: Option<usize>) -> [Wrap; 2] {
    let convert = |mode: &Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    let sampler = sampler.and_then(|sampler| root.samplers.get(sampler));
    sampler.map_or_else(Default::default, |s| {
        [convert(&s.wrap_s), convert(&s.wrap_t)]
    })
}

fn transform_of(info: &Info) -> Option<&TextureTransform> {
    info.extensions.as_ref()?.texture_transform.as_ref()
}

/// Which texture coordinates a slot reads.
pub(super) fn uv_set(info: &Info) -> u32 {
    let other = transform_of(info).and_then(|transform| transform.tex_coord);
    other.unwrap_or(info.tex_coord)
}

/// `KHR_texture_transform`: scale, then rotation, then offset. As v points down, its counter-
/// clockwise rotation is by the negative angle.
pub(super) fn uv_transform(info: &Info) -> Affine2 {
    let transform = transform_of(info).map(|t| {
        Affine2::from_scale_angle_translation(
            Vec2::from_array(t.scale.0),
            -t.rotation.0,
            Vec2::from_array(t.offset.0),
        )
    });
    transform
        .filter(Affine2::is_finite)
        .unwrap_or(Affine2::IDENTITY)
}

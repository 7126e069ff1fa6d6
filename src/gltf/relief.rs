//! `KHR_materials_displacement`: height maps of materials.

use std::collections::HashMap;
use std::path::Path;

use glam::Affine2;
use gltf::json::Root;
use gltf::json::texture::Info;
use serde::Deserialize;

use super::accessor::Accessors;
use super::texture::{image_bytes, image_name, uv_set, uv_transform, wrapping};
use crate::radiosity::Wrap;

/// What a draft calls the extension (KhronosGroup/glTF issue 948, written by NVIDIA's micromap tools).
pub(super) const EXTENSION: &str = "KHR_materials_displacement";

/// What a material says of the relief of its surfaces by `KHR_materials_displacement`:
///
/// ```text
///   ┌─────────────────────────────────┐
///   │  height = offset + factor × red  │      along the normals, in units of the mesh
///   └─────────────────────────────────┘
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDisplacement {
    /// Name of the image, for messages.
    pub image: String,
    /// The image as a file, of a kind that its first bytes tell.
    pub bytes: Vec<u8>,
    /// How the image goes on beyond its border.
    pub wrap: [Wrap; 2],
    /// Which texture coordinates lay it on the mesh.
    pub uv_set: u32,
    /// What is done to these first.
    pub uv_transform: Affine2,
    /// Height from black to white.
    pub factor: f32,
    /// Height of black.
    pub offset: f32,
}

/// The extension as it stands in the file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Json {
    displacement_geometry_texture: Option<Info>,
    #[serde(default = "one")]
    displacement_geometry_factor: f32,
    #[serde(default)]
    displacement_geometry_offset: f32,
}

fn one() -> f32 {
    1.0
}

/// The reliefs of a file's materials, each read when a primitive first needs it.
pub(super) struct Reliefs<'a> {
    pub(super) path: &'a Path,
    pub(super) root: &'a Root,
    pub(super) accessors: Accessors<'a>,
    pub(super) found: Vec<Result<MaterialDisplacement, String>>,
    /// By material.
    pub(super) known: HashMap<usize, Option<usize>>,
}

impl Reliefs<'_> {
    /// Which of those found is that of a material.
    pub(super) fn of(&mut self, material: usize) -> Option<usize> {
        if let Some(&known) = self.known.get(&material) {
            return known;
        }
        let found = self.read(material).map_err(|reason| {
            let name = self.root.materials[material].name.as_deref();
            let name = name.unwrap_or("without name");
            format!("material {name} has an {EXTENSION} that cannot be followed: {reason}")
        });
        let index = found.transpose().map(|found| {
            self.found.push(found);
            self.found.len() - 1
        });
        self.known.insert(material, index);
        index
    }

    fn read(&self, material: usize) -> Result<Option<MaterialDisplacement>, String> {
        let extensions = self.root.materials[material].extensions.as_ref();
        let Some(json) = extensions.and_then(|all| all.others.get(EXTENSION)) else {
            return Ok(None);
        };
        let json: Json = serde_json::from_value(json.clone()).map_err(|error| error.to_string())?;
        let info = (json.displacement_geometry_texture).ok_or("it has no texture")?;
        let texture =
            (self.root.textures.get(info.index.value())).ok_or("its texture does not exist")?;
        let index = texture.source.value();
        let image = (self.root.images.get(index)).ok_or("its image is no PNG or JPEG")?;
        let name = image_name(image, index);
        let bytes = image_bytes(self.path, self.accessors, image)
            .map_err(|reason| format!("{name} cannot be read ({reason})"))?;
        Ok(Some(MaterialDisplacement {
            image: name,
            bytes,
            wrap: wrapping(self.root, texture.sampler.map(|sampler| sampler.value())),
            uv_set: uv_set(&info),
            uv_transform: uv_transform(&info),
            factor: json.displacement_geometry_factor,
            offset: json.displacement_geometry_offset,
        }))
    }
}

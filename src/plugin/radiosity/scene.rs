use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::mesh::UvChannel;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::assets::Copy;
use super::mesh_data::{self, MeshData, MeshProblem};
use super::survey::{FoundObject, Survey};
use super::textures::Textures;
use crate::radiosity::{
    AlphaMode, Light, Material, MaterialId, Object, Scene, Texture, TextureId, TextureRef,
};

/// A survey in the terms of the bake, and what is needed to put the result back.
pub(super) struct Extracted {
    pub(super) scene: Scene,
    /// The triangles of each object in the order of its mesh, for carrying attributes over.
    pub(super) triangles: Vec<Vec<[u32; 3]>>,
    /// What could not be read, one sentence each.
    pub(super) notes: Vec<String>,
}

/// Names of a survey's objects and lights, in its order.
pub(super) struct Names {
    pub(super) objects: Vec<String>,
    pub(super) lights: Vec<String>,
}

/// Puts a survey into world space and the bake's units.
///
/// # Errors
///
/// The object whose mesh cannot be read, and why.
pub(super) fn extract(
    survey: &Survey,
    names: &Names,
    emissive_gain: f32,
    decoded: &mut Textures,
) -> Result<Extracted, (Entity, MeshProblem)> {
    let mut materials = Materials {
        list: Vec::new(),
        textures: Vec::new(),
        by_asset: HashMap::default(),
        by_image: HashMap::default(),
        notes: Vec::new(),
        emissive_gain,
        decoded,
    };
    let mut objects = Vec::with_capacity(survey.objects.len());
    let mut triangles = Vec::with_capacity(survey.objects.len());
    for (found, name) in survey.objects.iter().zip(&names.objects) {
        let data = mesh_data::read(&found.mesh.asset).map_err(|e| (found.entity, e))?;
        triangles.push(data.triangles.clone());
        let material = materials.add(found, name);
        objects.push(object(found, name.clone(), data, material));
    }
    let lights = survey.lights.iter().zip(&names.lights);
    let lights = lights.map(|(found, name)| Light {
        name: name.clone(),
        key: found.entity.to_bits(),
        power: found.power,
        kind: found.kind,
        direct: found.direct,
    });
    let lights = lights.collect();
    materials.decoded.keep_used();
    Ok(Extracted {
        scene: Scene {
            objects,
            materials: materials.list,
            textures: materials.textures,
            lights,
            sky: survey.sky,
            ..Scene::default()
        },
        triangles,
        notes: materials.notes,
    })
}

fn object(found: &FoundObject, name: String, data: MeshData, material: MaterialId) -> Object {
    let to_world = found.transform;
    let normals_to_world = to_world.matrix3.inverse().transpose();
    let mut triangles = data.triangles;
    // A mirrored mesh is wound the other way round in the world; its front is where its normals point.
    if mirrored(&to_world) {
        for t in &mut triangles {
            t.swap(1, 2);
        }
    }
    Object {
        name,
        key: found.entity.to_bits(),
        positions: (data.positions.iter())
            .map(|&p| to_world.transform_point3(p))
            .collect(),
        normals: (data.normals.iter())
            .map(|&n| (normals_to_world * n).normalize_or_zero())
            .collect(),
        uvs: data.uvs.into(),
        colors: data.colors,
        triangles,
        material,
        casts: found.effect.casts && !adds_light(found.material.asset.alpha_mode),
        receives: found.effect.receives,
        reflects: found.effect.reflects,
        refine: found.effect.refine,
    }
}

fn mirrored(to_world: &Affine3A) -> bool {
    to_world.matrix3.determinant() < 0.0
}

/// The materials and textures of a scene as it is put together, each once.
struct Materials<'a> {
    list: Vec<Material>,
    textures: Vec<Texture>,
    by_asset: HashMap<*const StandardMaterial, MaterialId>,
    by_image: HashMap<(*const Image, bool), Option<TextureId>>,
    notes: Vec<String>,
    emissive_gain: f32,
    decoded: &'a mut Textures,
}

impl Materials<'_> {
    fn add(&mut self, found: &FoundObject, object: &str) -> MaterialId {
        let key = Arc::as_ptr(&found.material.asset);
        if let Some(&id) = self.by_asset.get(&key) {
            return id;
        }
        let material = self.convert(found, object);
        self.list.push(material);
        let id = MaterialId(self.list.len() as u32 - 1);
        self.by_asset.insert(key, id);
        id
    }

    fn convert(&mut self, found: &FoundObject, object: &str) -> Material {
        let m = &*found.material.asset;
        let images = &found.images;
        // Bevy shows emissive light times `mix(1, exposure, weight)`, and everything else times
        // `exposure`: in cd/m² it is `emissive · mix(1 / exposure, 1, weight)`.
        let weight = m.emissive_exposure_weight;
        let gain = self.emissive_gain * (1.0 - weight) + weight;
        let mut slot = |image: &Option<Copy<Image>>, channel: &UvChannel, color| {
            let texture = self.texture(image.as_ref()?, color, object)?;
            Some(TextureRef {
                texture,
                uv_set: match channel {
                    UvChannel::Uv0 => 0,
                    UvChannel::Uv1 => 1,
                },
                transform: m.uv_transform,
            })
        };
        Material {
            name: format!("material of {object}"),
            base_color: m.base_color.to_linear().to_vec4(),
            base_color_texture: slot(&images.base_color, &m.base_color_channel, true),
            metallic: m.metallic,
            metallic_texture: slot(&images.metallic, &m.metallic_roughness_channel, false),
            emissive: m.emissive.to_vec3() * gain,
            emissive_texture: slot(&images.emissive, &m.emissive_channel, true),
            double_sided: m.double_sided,
            alpha: alpha(m.alpha_mode),
            unlit: m.unlit,
        }
    }

    fn texture(&mut self, image: &Copy<Image>, color: bool, object: &str) -> Option<TextureId> {
        let key = (Arc::as_ptr(&image.asset), color);
        if let Some(&id) = self.by_image.get(&key) {
            return id;
        }
        let id = match self.decoded.get(image, color) {
            Ok(texture) => {
                self.textures.push((*texture).clone());
                Some(TextureId(self.textures.len() as u32 - 1))
            }
            Err(problem) => {
                self.notes.push(format!(
                    "{object}: one of its textures counts as white: {problem}"
                ));
                None
            }
        };
        self.by_image.insert(key, id);
        id
    }
}

/// Glows and tints are drawn over the picture behind them and stop no light.
fn adds_light(mode: bevy::prelude::AlphaMode) -> bool {
    use bevy::prelude::AlphaMode as Bevy;
    matches!(mode, Bevy::Add | Bevy::Multiply)
}

fn alpha(mode: bevy::prelude::AlphaMode) -> AlphaMode {
    use bevy::prelude::AlphaMode as Bevy;
    match mode {
        Bevy::Opaque | Bevy::Add | Bevy::Multiply => AlphaMode::Opaque,
        Bevy::Mask(cutoff) => AlphaMode::Mask(cutoff),
        // Coverage is decided a sample at a time: on average it is the alpha.
        Bevy::Blend | Bevy::Premultiplied | Bevy::AlphaToCoverage => AlphaMode::Blend,
    }
}

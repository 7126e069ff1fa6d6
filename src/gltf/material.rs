//! Materials, made when a primitive first uses them.

use std::collections::HashMap;

use glam::{Vec3, Vec4};
use gltf::json::Root;
use gltf::json::material::{AlphaMode as FileAlpha, Material as FileMaterial};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use serde_json::Value;

use super::notes::Notes;
use super::relief;
use super::texture::{Textures, uv_set};
use crate::radiosity::{AlphaMode, Material, MaterialId, TextureRef};

const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// The materials of a scene.
#[derive(Debug)]
pub(super) struct Materials<'a> {
    root: &'a Root,
    pub(super) textures: Textures<'a>,
    pub(super) made: Vec<Material>,
    /// By index, and how many sets of texture coordinates there are as far as that matters.
    known: HashMap<(Option<usize>, usize), MaterialId>,
}

/// Makes one material: what it reads its slots with.
struct Slots<'s, 'a> {
    textures: &'s mut Textures<'a>,
    notes: &'s mut Notes,
    name: &'s str,
    uv_sets: usize,
}

impl<'a> Materials<'a> {
    pub(super) fn new(root: &'a Root, textures: Textures<'a>) -> Self {
        Self {
            root,
            textures,
            made: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// The material for a primitive with so many sets of texture coordinates. Slots that need
    /// others are without texture.
    pub(super) fn get(
        &mut self,
        index: Option<usize>,
        uv_sets: usize,
        notes: &mut Notes,
    ) -> MaterialId {
        let file = index.and_then(|index| self.root.materials.get(index));
        let relevant = file.map_or(0, |file| uv_sets.min(wanted_sets(file)));
        if let Some(&id) = self.known.get(&(index, relevant)) {
            return id;
        }
        let material = match file {
            Some(file) => {
                let name = material_name(file, index);
                let mut slots = Slots {
                    textures: &mut self.textures,
                    notes,
                    name: &name,
                    uv_sets,
                };
                slots.convert(file)
            }
            None => Material {
                name: "default".to_owned(),
                ..Material::default()
            },
        };
        let id = MaterialId(self.made.len() as u32);
        self.made.push(material);
        self.known.insert((index, relevant), id);
        id
    }
}

fn material_name(file: &FileMaterial, index: Option<usize>) -> String {
    let name = file.name.clone().filter(|name| !name.is_empty());
    name.unwrap_or_else(|| format!("material {}", index.unwrap_or_default()))
}

/// How many sets of texture coordinates make all slots work.
fn wanted_sets(file: &FileMaterial) -> usize {
    let pbr = &file.pbr_metallic_roughness;
    let slots = [
        pbr.base_color_texture.clone(),
        pbr.metallic_roughness_texture.clone(),
        file.emissive_texture.clone(),
        diffuse_texture(file),
    ];
    let sets = slots
        .iter()
        .flatten()
        .map(|info| (uv_set(info) as usize).saturating_add(1));
    sets.max().unwrap_or(0)
}

fn other_extension<'f>(file: &'f FileMaterial, name: &str) -> Option<&'f Value> {
    file.extensions.as_ref()?.others.get(name)
}

fn diffuse_texture(file: &FileMaterial) -> Option<Info> {
    let texture = other_extension(file, SPECULAR_GLOSSINESS)?.get("diffuseTexture")?;
    serde_json::from_value(texture.clone()).ok()
}

impl Slots<'_, '_> {
    fn convert(&mut self, file: &FileMaterial) -> Material {
        let extensions = file.extensions.as_ref();
        let unlit = extensions.is_some_and(|all| all.unlit.is_some());
        let mut material = Material {
            name: self.name.to_owned(),
            double_sided: file.double_sided,
            alpha: self.alpha(file),
            unlit,
            ..Material::default()
        };
        match other_extension(file, SPECULAR_GLOSSINESS) {
            Some(specular) if !unlit => self.read_diffuse(specular, file, &mut material),
            _ => self.read_metallic(file, &mut material),
        }
        // Unlit materials ignore what light does to the others.
        if unlit {
            material.metallic = 0.0;
            material.metallic_texture = None;
        } else {
            self.read_emission(file, &mut material);
        }
        self.note_transmission(file);
        if other_extension(file, relief::EXTENSION).is_some() {
            self.notes.add(format!(
                "Material {} is displaced by a height map, which light does not see: run `fresco displace` \
                 first.",
                self.name
            ));
        }
        material
    }

    fn read_metallic(&mut self, file: &FileMaterial, material: &mut Material) {
        let pbr = &file.pbr_metallic_roughness;
        let color = Vec4::from_array(pbr.base_color_factor.0);
        material.base_color = self.unit(color, "base colour");
        material.base_color_texture =
            self.texture(pbr.base_color_texture.as_ref(), "base colour texture");
        material.metallic = self
            .unit(Vec4::splat(pbr.metallic_factor.0), "metallic factor")
            .x;
        if material.metallic > 0.0 && !material.unlit {
            let info = pbr.metallic_roughness_texture.as_ref();
            material.metallic_texture = self.texture(info, "metallic-roughness texture");
        }
    }

    /// The older model: its diffuse colour is what a dielectric's base colour is.
    fn read_diffuse(&mut self, specular: &Value, file: &FileMaterial, material: &mut Material) {
        let factor = specular.get("diffuseFactor");
        let factor = factor.and_then(|f| serde_json::from_value::<[f32; 4]>(f.clone()).ok());
        let color = Vec4::from_array(factor.unwrap_or([1.0; 4]));
        material.base_color = self.unit(color, "diffuse colour");
        material.base_color_texture =
            self.texture(diffuse_texture(file).as_ref(), "diffuse texture");
    }

    fn read_emission(&mut self, file: &FileMaterial, material: &mut Material) {
        let extensions = file.extensions.as_ref();
        let strength = extensions.and_then(|all| all.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let emissive = Vec3::from_array(file.emissive_factor.0) * strength;
        if !emissive.is_finite() || emissive.min_element() < 0.0 {
            self.notes.add(format!(
                "Material {} has an emission that is negative or no number: it does not emit.",
                self.name
            ));
            return;
        }
        material.emissive = emissive;
        if emissive != Vec3::ZERO {
            let info = file.emissive_texture.as_ref();
            material.emissive_texture = self.texture(info, "emissive texture");
        }
    }

    fn texture(&mut self, info: Option<&Info>, slot: &str) -> Option<TextureRef> {
        let info = info?;
        let set = uv_set(info);
        if set as usize >= self.uv_sets {
            self.notes.add(format!(
                "The {slot} of material {} is ignored on meshes without TEXCOORD_{set}.",
                self.name
            ));
            return None;
        }
        let slot = format!("{slot} of material {}", self.name);
        self.textures.get(info, &slot, self.notes)
    }

    /// Brings a factor to 0..1.
    fn unit(&mut self, value: Vec4, what: &str) -> Vec4 {
        let clamped = value.map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) });
        if clamped != value {
            self.notes.add(format!(
                "The {what} of material {} is not within 0..1: the nearest allowed value is used.",
                self.name
            ));
        }
        clamped
    }

    fn alpha(&mut self, file: &FileMaterial) -> AlphaMode {
        match file.alpha_mode {
            Checked::Valid(FileAlpha::Mask) => {
                let cutoff = file.alpha_cutoff.unwrap_or_default().0;
                AlphaMode::Mask(if cutoff.is_finite() { cutoff } else { 0.5 })
            }
            Checked::Valid(FileAlpha::Blend) => AlphaMode::Blend,
            Checked::Valid(FileAlpha::Opaque) | Checked::Invalid => AlphaMode::Opaque,
        }
    }

    fn note_transmission(&mut self, file: &FileMaterial) {
        let typed = (file.extensions.as_ref()).is_some_and(|e| e.transmission.is_some());
        let diffuse = "KHR_materials_diffuse_transmission";
        for (name, is_there) in [
            ("KHR_materials_transmission", typed),
            (diffuse, other_extension(file, diffuse).is_some()),
        ] {
            if is_there {
                self.notes.add(format!(
                    "Material {} lets light through ({name}), which is not simulated: it is taken \
                     as opaque.",
                    self.name
                ));
            }
        }
    }
}

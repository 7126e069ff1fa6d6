//! Unlit materials for primitives whose vertex colours hold their light.

use std::collections::{HashMap, HashSet};

use serde_json::{Value, json};

use super::{
    glb::{Glb, object_mut},
    instances::Target,
};

const UNLIT: &str = "KHR_materials_unlit";
/// Where a primitive lists its other materials.
const VARIANTS: &str = "/extensions/KHR_materials_variants/mappings";

/// What moves from the material into the vertex colours because unlit materials do not emit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Folded {
    /// Emitted radiance, cd/m².
    pub(super) emission: [f64; 3],
    /// The base colour, which the material loses.
    pub(super) base: [f64; 3],
}

/// Makes materials unlit, those of other primitives in a copy.
pub(super) struct UnlitMaterials {
    /// As they were before the first change.
    originals: Vec<Value>,
    /// Not used by any primitive that is not baked: may be changed in place, once.
    free: HashSet<usize>,
    /// By original and whether its base colour was folded.
    made: HashMap<(Option<usize>, bool), usize>,
}

impl UnlitMaterials {
    pub(super) fn new(glb: &Glb, targets: &[Target]) -> Self {
        let originals = glb.json["materials"]
            .as_array()
            .cloned()
            .unwrap_or_default();
        Self {
            free: free_materials(glb, targets),
            originals,
            made: HashMap::new(),
        }
    }

    /// Gives a primitive an unlit material; `None` if it has one already, whose colours are not to
    /// be touched.
    pub(super) fn assign(&mut self, glb: &mut Glb, target: Target) -> Option<Option<Folded>> {
        let primitive = target.of(&glb.json).clone();
        let material = index_of(&primitive["material"]);
        let original = self.original(material);
        if original["extensions"].get(UNLIT).is_some() {
            return None;
        }
        let folded = folded(&original);
        let unlit = self.unlit(glb, material, folded);
        target.of_mut(&mut glb.json)["material"] = unlit.into();
        let variants = primitive.pointer(VARIANTS).and_then(Value::as_array);
        for (index, variant) in variants.into_iter().flatten().enumerate() {
            let unlit = self.unlit(glb, index_of(&variant["material"]), None);
            let path = format!("{VARIANTS}/{index}/material");
            if let Some(material) = target.of_mut(&mut glb.json).pointer_mut(&path) {
                *material = unlit.into();
            }
        }
        Some(folded)
    }

    fn original(&self, material: Option<usize>) -> Value {
        material
            .and_then(|index| self.originals.get(index).cloned())
            .unwrap_or_else(|| json!({}))
    }

    fn unlit(&mut self, glb: &mut Glb, material: Option<usize>, folded: Option<Folded>) -> usize {
        let key = (material, folded.is_some());
        if let Some(&made) = self.made.get(&key) {
            return made;
        }
        let mut json = self.original(material);
        note_lost_emission(glb, material, &json, folded);
        if let Some(extensions) = object_mut(&mut json, "extensions") {
            extensions.insert(UNLIT.into(), json!({}));
        }
        glb.use_extension(UNLIT);
        if folded.is_some() {
            let alpha = json["pbrMetallicRoughness"]["baseColorFactor"][3].clone();
            let alpha = if alpha.is_null() { 1.into() } else { alpha };
            if let Some(pbr) = object_mut(&mut json, "pbrMetallicRoughness") {
                pbr.insert("baseColorFactor".into(), json!([1, 1, 1, alpha]));
            }
        }
        let made = match material {
            Some(index) if self.free.remove(&index) => {
                glb.json["materials"][index] = json;
                index
            }
            _ => {
                if let Some(name) = json["name"].as_str() {
                    json["name"] = format!("{name}_baked").into();
                }
                glb.push("materials", json)
            }
        };
        self.made.insert(key, made);
        made
    }
}

fn note_lost_emission(
    glb: &mut Glb,
    material: Option<usize>,
    json: &Value,
    folded: Option<Folded>,
) {
    if folded.is_none() && emission(json).is_some() {
        let name = json["name"].as_str().map(str::to_owned);
        let name = name.or(material.map(|index| index.to_string()));
        glb.notes.push(format!(
            "material {} emits light, which vertex colours cannot show together with its textures \
             or variants",
            name.unwrap_or_default()
        ));
    }
}

/// Materials that no primitive but these has: they may be changed in place.
pub(super) fn free_materials(glb: &Glb, targets: &[Target]) -> HashSet<usize> {
    let ours: HashSet<Target> = targets.iter().copied().collect();
    let count = glb.json["materials"].as_array().map_or(0, Vec::len);
    let mut free: HashSet<usize> = (0..count).collect();
    let meshes = glb.json["meshes"].as_array().into_iter().flatten();
    for (mesh, json) in meshes.enumerate() {
        let primitives = json["primitives"].as_array().into_iter().flatten();
        for (primitive, json) in primitives.enumerate() {
            if !ours.contains(&Target { mesh, primitive }) {
                for material in materials_of(json) {
                    free.remove(&material);
                }
            }
        }
    }
    free
}

fn materials_of(primitive: &Value) -> impl Iterator<Item = usize> {
    let variants = primitive.pointer(VARIANTS);
    let variants = variants.and_then(Value::as_array).into_iter().flatten();
    std::iter::once(primitive)
        .chain(variants)
        .filter_map(|owner| index_of(&owner["material"]))
}

fn index_of(json: &Value) -> Option<usize> {
    json.as_u64().and_then(|index| usize::try_from(index).ok())
}

/// What a material emits, in cd/m², if it does.
fn emission(material: &Value) -> Option<[f64; 3]> {
    let strength = material
        .pointer("/extensions/KHR_materials_emissive_strength/emissiveStrength")
        .and_then(Value::as_f64)
        .unwrap_or(1.0);
    let emission = numbers(&material["emissiveFactor"], 0.0).map(|factor| factor * strength);
    emission
        .iter()
        .any(|&value| value > 0.0)
        .then_some(emission)
}

/// What can be moved into vertex colours: all of it, if no texture varies between vertices.
fn folded(material: &Value) -> Option<Folded> {
    let pbr = &material["pbrMetallicRoughness"];
    let emission = emission(material)?;
    let textured =
        pbr.get("baseColorTexture").is_some() || material.get("emissiveTexture").is_some();
    (!textured).then(|| Folded {
        emission,
        base: numbers(&pbr["baseColorFactor"], 1.0),
    })
}

fn numbers(list: &Value, default: f64) -> [f64; 3] {
    [0, 1, 2].map(|index| list[index].as_f64().unwrap_or(default))
}

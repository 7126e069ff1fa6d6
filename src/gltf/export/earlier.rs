//! Light of an earlier bake, whose place in the file new light can take.

use std::collections::HashMap;

use serde_json::{Map, Value};

use super::{
    glb::{Glb, Numbers},
    primitive::{BAKED_LIGHT, BAKED_LIGHT_GRADIENT},
};
use crate::gltf::accessor_json::{ElementKind, whole};

/// Accessors of an earlier bake, so that baking a baked file again does not make it larger.
pub(super) struct EarlierLight {
    /// Accessor → byte range in the binary chunk. Nothing else in the file uses either.
    places: HashMap<usize, std::ops::Range<usize>>,
}

impl EarlierLight {
    /// Call it when no two nodes share a mesh any more.
    pub(super) fn find(glb: &Glb) -> Self {
        let uses = accessor_uses(&glb.json);
        let mut view_uses = HashMap::<usize, usize>::new();
        for accessor in glb.json["accessors"].as_array().into_iter().flatten() {
            if let Ok(Some(view)) = whole(accessor, "bufferView") {
                *view_uses.entry(view).or_default() += 1;
            }
        }
        let places = uses
            .into_iter()
            .filter(|&(_, uses)| uses == Uses { light: 1, other: 0 })
            .filter_map(|(accessor, _)| {
                let (view, range) = place(&glb.json, accessor)?;
                (view_uses.get(&view) == Some(&1)).then_some((accessor, range))
            })
            .collect();
        Self { places }
    }

    /// Writes new light over that of `accessor`; false if it does not fit there.
    pub(super) fn overwrite(&self, glb: &mut Glb, accessor: usize, light: &Numbers) -> bool {
        match self.places.get(&accessor) {
            Some(range) => glb.overwrite(range.clone(), light),
            None => false,
        }
    }
}

/// How often an accessor is used by primitives.
#[derive(Clone, Copy, Default, PartialEq)]
struct Uses {
    light: usize,
    other: usize,
}

fn accessor_uses(json: &Value) -> HashMap<usize, Uses> {
    let mut uses = HashMap::<usize, Uses>::new();
    let meshes = json["meshes"].as_array().into_iter().flatten();
    let primitives = meshes.flat_map(|mesh| mesh["primitives"].as_array().into_iter().flatten());
    for primitive in primitives {
        let targets = primitive["targets"].as_array().into_iter().flatten();
        for attributes in std::iter::once(&primitive["attributes"]).chain(targets) {
            for name in attributes.as_object().into_iter().flat_map(Map::keys) {
                let Ok(Some(accessor)) = whole(attributes, name) else {
                    continue;
                };
                let uses = uses.entry(accessor).or_default();
                match name.as_str() {
                    BAKED_LIGHT | BAKED_LIGHT_GRADIENT => uses.light += 1,
                    _ => uses.other += 1,
                }
            }
        }
    }
    uses
}

/// The view and bytes of an accessor, if they are exactly what this exporter writes.
fn place(json: &Value, accessor: usize) -> Option<(usize, std::ops::Range<usize>)> {
    let accessor = json["accessors"].get(accessor)?.as_object()?;
    let known = ["bufferView", "componentType", "count", "type"];
    let plain = accessor.keys().all(|key| known.contains(&key.as_str()));
    let view = usize::try_from(accessor.get("bufferView")?.as_u64()?).ok()?;
    let floats = accessor.get("componentType")?.as_u64() == Some(5126);
    let vectors = accessor.get("type")? == ElementKind::VEC3.name();
    let json = json["bufferViews"].get(view)?;
    let start = whole(json, "byteOffset").ok()?.unwrap_or(0);
    let length = whole(json, "byteLength").ok()??;
    let count = usize::try_from(accessor.get("count")?.as_u64()?).ok()?;
    let exact = count.checked_mul(12) == Some(length) && json.get("byteStride").is_none();
    (plain && floats && vectors && exact).then_some((view, start..start.checked_add(length)?))
}

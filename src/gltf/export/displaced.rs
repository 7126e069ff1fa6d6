//! Writes displaced meshes in the place of those they were made from.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use serde_json::Value;

use super::{
    Exported,
    glb::Glb,
    images,
    instances::Target,
    materials::free_materials,
    primitive::{Attributes, replace},
    refine::{self, Source},
};
use crate::{
    displacement::{DisplacedPart, raised_tangent},
    gltf::{Document, GltfError, PrimitiveKey, accessor_json::ElementKind, relief::EXTENSION},
};

/// A displaced mesh and the primitive it takes the place of.
#[derive(Clone, Copy, Debug)]
pub struct DisplacedPrimitive<'a> {
    /// Which primitive.
    pub key: PrimitiveKey,
    /// The primitive's triangles as loaded, which the displaced mesh refers to.
    pub triangles: &'a [[u32; 3]],
    /// What they became.
    pub part: &'a DisplacedPart,
}

/// Writes `document` with displaced meshes as a single `.glb`.
///
/// Texture coordinates, colours, skins, morph targets and whatever else vertices have are interpolated, tangents
/// turned to lie in the displaced surface. Light of an earlier bake is left out, since it fits no more, and so is
/// what materials say of displacement, since it is done.
/// Everything else in the document goes through as it came.
///
/// # Errors
///
/// [`GltfError`] if a mesh does not belong to the document, or the result is too large for one file.
pub fn to_displaced_glb(
    document: &Document,
    displaced: &[DisplacedPrimitive<'_>],
) -> Result<Exported, GltfError> {
    let mut glb = Glb::merge(document)?;
    images::embed_images(&mut glb);
    for displaced in displaced {
        write(&mut glb, displaced)?;
    }
    let targets: Vec<Target> = displaced.iter().map(|d| Target::shared(d.key)).collect();
    drop_relief(&mut glb, &targets);
    glb.finish()
}

fn write(glb: &mut Glb, displaced: &DisplacedPrimitive<'_>) -> Result<(), GltfError> {
    let DisplacedPrimitive {
        key,
        triangles,
        part,
    } = *displaced;
    let source = Source {
        key,
        triangles,
        flipped: false,
    };
    refine::rewrite(glb, &source, &part.mesh, |attributes| {
        turn_tangents(attributes, &part.normals);
        for (name, values) in [("POSITION", &part.positions), ("NORMAL", &part.normals)] {
            let values = values.iter().flat_map(|v| v.to_array());
            replace(attributes, name, ElementKind::VEC3, values);
        }
    })
}

/// Takes displacement out of the materials of displaced primitives, in a copy where others have the same.
fn drop_relief(glb: &mut Glb, targets: &[Target]) {
    let mut free = free_materials(glb, targets);
    let mut copies = HashMap::new();
    for target in targets {
        let index = target.of(&glb.json)["material"].as_u64();
        let Some(index) = index.and_then(|index| usize::try_from(index).ok()) else {
            continue;
        };
        let mut material = glb.json["materials"][index].clone();
        let extensions = material["extensions"].as_object_mut();
        if extensions.and_then(|all| all.remove(EXTENSION)).is_none() {
            continue;
        }
        let without = match free.remove(&index) {
            true => {
                glb.json["materials"][index] = material;
                index
            }
            false => (copies.entry(index))
                .or_insert_with(|| glb.push("materials", material))
                .to_owned(),
        };
        target.of_mut(&mut glb.json)["material"] = without.into();
    }
    let materials = glb.json["materials"].as_array();
    let has = |material: &Value| {
        material
            .pointer(&format!("/extensions/{EXTENSION}"))
            .is_some()
    };
    if !materials.is_some_and(|all| all.iter().any(has)) {
        glb.drop_extension(EXTENSION);
    }
}

/// Turns tangents of the base into the surface. Without normals of the base they mean nothing.
fn turn_tangents(attributes: &mut Attributes, normals: &[Vec3]) {
    let read = |name: &str| -> Option<Vec<Vec3>> {
        let (_, data) = attributes.iter().find(|(known, _)| known == name)?;
        let vectors = data.values.chunks_exact(data.kind.width());
        let vector = |v: &[f64]| Some(DVec3::from_slice(v.get(..3)?).as_vec3());
        vectors.map(vector).collect()
    };
    let (Some(base), Some(flat)) = (read("NORMAL"), read("TANGENT")) else {
        return;
    };
    let Some((_, tangents)) = attributes.iter_mut().find(|(name, _)| name == "TANGENT") else {
        return;
    };
    let width = tangents.kind.width();
    let values = tangents.values.chunks_exact_mut(width);
    for ((value, (base, flat)), &normal) in values.zip(base.into_iter().zip(flat)).zip(normals) {
        let turned = raised_tangent(flat, base.normalize_or_zero(), normal);
        for (value, turned) in value.iter_mut().zip(turned.to_array()) {
            *value = f64::from(turned);
        }
    }
}

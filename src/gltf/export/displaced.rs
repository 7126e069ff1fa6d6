//! Writes displaced meshes in the place of those they were made from.

use glam::Vec3;

use super::{
    Exported,
    glb::Glb,
    images,
    instances::Target,
    primitive::{
        Attributes, BAKED_LIGHT, BAKED_LIGHT_GRADIENT, attributes_mut, push_attribute, remove,
        vertex_count,
    },
    refine::{self, Source},
};
use crate::{
    displacement::DisplacedPart,
    gltf::{
        Document, GltfError, PrimitiveKey,
        accessor_json::{AccessorData, ElementKind},
    },
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
/// turned to lie in the displaced surface. Light of an earlier bake is left out, since it fits no more.
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
    glb.finish()
}

fn write(glb: &mut Glb, displaced: &DisplacedPrimitive<'_>) -> Result<(), GltfError> {
    let DisplacedPrimitive {
        key,
        triangles,
        part,
    } = *displaced;
    let target = Target {
        mesh: key.mesh,
        primitive: key.primitive,
    };
    let primitive = target.of(&glb.json).clone();
    let count = vertex_count(glb, &primitive)?;
    let source = Source {
        key,
        triangles,
        flipped: false,
    };
    let mut attributes = refine::refine(glb, target, count, &source, &part.mesh)?;
    for light in [BAKED_LIGHT, BAKED_LIGHT_GRADIENT] {
        if primitive["attributes"].get(light).is_some() {
            glb.notes.push(format!(
                "{key:?} had the light of an earlier bake, which fits no more: bake the result again"
            ));
        }
    }
    remove(glb, target, &[BAKED_LIGHT, BAKED_LIGHT_GRADIENT]);
    turn_tangents(&mut attributes, &part.normals);
    replace(&mut attributes, "POSITION", &part.positions);
    replace(&mut attributes, "NORMAL", &part.normals);
    for (name, data) in attributes {
        let accessor = push_attribute(glb, &name, &data);
        if let Some(attributes) = attributes_mut(glb, target) {
            attributes.insert(name, accessor.into());
        }
    }
    Ok(())
}

fn replace(attributes: &mut Attributes, name: &str, values: &[Vec3]) {
    let data = AccessorData {
        kind: ElementKind::VEC3,
        values: (values.iter().flat_map(|v| v.to_array()))
            .map(f64::from)
            .collect(),
    };
    match attributes.iter_mut().find(|(known, _)| known == name) {
        Some((_, old)) => *old = data,
        None => attributes.push((name.to_owned(), data)),
    }
}

/// Takes what of the tangents points along the normals out of them.
fn turn_tangents(attributes: &mut Attributes, normals: &[Vec3]) {
    let tangents = attributes.iter_mut().find(|(name, _)| name == "TANGENT");
    let Some((_, tangents)) = tangents else {
        return;
    };
    let width = tangents.kind.width();
    for (value, &normal) in tangents.values.chunks_exact_mut(width).zip(normals) {
        let [Some(&x), Some(&y), Some(&z)] = [0, 1, 2].map(|i| value.get(i)) else {
            return;
        };
        let along = Vec3::new(x as f32, y as f32, z as f32).reject_from_normalized(normal);
        let turned = (along.try_normalize()).unwrap_or_else(|| normal.any_orthonormal_vector());
        for (value, turned) in value.iter_mut().zip(turned.to_array()) {
            *value = f64::from(turned);
        }
    }
}

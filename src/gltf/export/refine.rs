//! Rewrites a primitive's geometry as the refined mesh that the bake made of it.

use glam::Vec3;
use serde_json::Value;

use super::{
    glb::{ELEMENT_ARRAY_BUFFER, Glb, Numbers},
    instances::Target,
    interpolate::{Blend, Rule},
    primitive::{
        Attributes, BAKED_LIGHT, BAKED_LIGHT_GRADIENT, attributes_mut, push_attribute,
        source_attributes, vertex_count, write_attributes,
    },
    skin,
};
use crate::{
    gltf::{
        GltfError, PrimitiveKey,
        accessor_json::{AccessorData, ElementKind},
    },
    mesh::RefinedMesh,
};

/// What a refined mesh was made from.
pub(super) struct Source<'a> {
    pub(super) key: PrimitiveKey,
    /// The primitive's triangles as imported.
    pub(super) triangles: &'a [[u32; 3]],
    /// Import turned them around.
    pub(super) flipped: bool,
}

/// Gives a primitive other geometry, with the attributes that `change` leaves. Light of an earlier bake, which fits no
/// more, is left out and told of.
pub(super) fn rewrite(
    glb: &mut Glb,
    source: &Source<'_>,
    mesh: &RefinedMesh,
    change: impl FnOnce(&mut Attributes),
) -> Result<(), GltfError> {
    let key = source.key;
    let target = Target::shared(key);
    let primitive = target.of(&glb.json).clone();
    let count = vertex_count(glb, &primitive)?;
    let mut attributes = refine(glb, target, count, source, mesh)?;
    for light in [BAKED_LIGHT, BAKED_LIGHT_GRADIENT] {
        if primitive["attributes"].get(light).is_some() {
            glb.notes.push(format!(
                "{key:?} had the light of an earlier bake, which fits no more: bake the result again"
            ));
        }
    }
    change(&mut attributes);
    if let Some(before) = attributes_mut(glb, target) {
        before.retain(|name, _| attributes.iter().any(|(known, _)| known == name));
    }
    write_attributes(glb, target, attributes);
    Ok(())
}

/// Writes the triangles and morph targets of `mesh`; returns its attributes, which the caller
/// writes after changing them.
pub(super) fn refine(
    glb: &mut Glb,
    target: Target,
    count: usize,
    source: &Source<'_>,
    mesh: &RefinedMesh,
) -> Result<Attributes, GltfError> {
    let blend = check(glb, source, mesh, count)?;
    let primitive = target.of(&glb.json).clone();
    let attributes = blend_vertices(glb, &primitive["attributes"], &blend)?;
    write_morph_targets(glb, target, &primitive["targets"], &blend)?;
    let indices = write_indices(glb, source, mesh);
    let primitive = target.of_mut(&mut glb.json);
    primitive["indices"] = indices.into();
    // Strips and fans have become separate triangles, the default.
    if primitive.get("mode").is_some() {
        primitive["mode"] = 4.into();
    }
    let extensions = primitive["extensions"].as_object();
    for name in extensions.into_iter().flat_map(|map| map.keys()) {
        if name != "KHR_materials_variants" {
            glb.notes.push(format!(
                "{:?} was cut finer; what the extension {name} says of its vertices or triangles \
                 may no longer fit",
                source.key
            ));
        }
    }
    Ok(attributes)
}

fn blend_vertices(glb: &mut Glb, source: &Value, blend: &Blend) -> Result<Attributes, GltfError> {
    let mut attributes = Attributes::new();
    let mut joints = Attributes::new();
    for (name, accessor) in source_attributes(glb, source)? {
        let data = glb.read(accessor, blend.source_count())?;
        if skin::is_skin(&name) {
            joints.push((name, data));
        } else {
            let data = blend_one(glb, &name, blend, &data, Rule::of(&name))?;
            attributes.push((name, data));
        }
    }
    attributes.extend(skin::blend(&joints, blend).map_err(|reason| glb.invalid(reason))?);
    Ok(attributes)
}

/// Blends one attribute; values that are not numbers become 0, except in positions.
fn blend_one(
    glb: &mut Glb,
    name: &str,
    blend: &Blend,
    data: &AccessorData,
    rule: Rule,
) -> Result<AccessorData, GltfError> {
    let mut data = blend.apply(data, rule);
    let mut bad = 0;
    for value in data.values.iter_mut().filter(|value| !value.is_finite()) {
        *value = 0.0;
        bad += 1;
    }
    if bad > 0 && name == "POSITION" {
        return Err(glb.invalid("a POSITION is not a finite number".to_owned()));
    }
    if bad > 0 {
        glb.notes.push(format!(
            "{bad} values of {name} were not finite numbers and became 0"
        ));
    }
    Ok(data)
}

fn write_morph_targets(
    glb: &mut Glb,
    target: Target,
    morphs: &Value,
    blend: &Blend,
) -> Result<(), GltfError> {
    for (index, morph) in morphs.as_array().into_iter().flatten().enumerate() {
        for (name, accessor) in source_attributes(glb, morph)? {
            let data = glb.read(accessor, blend.source_count())?;
            // Morph targets hold differences: nothing to normalise.
            let data = blend_one(glb, &name, blend, &data, Rule::Linear)?;
            let accessor = push_attribute(glb, &name, &data);
            target.of_mut(&mut glb.json)["targets"][index][&name] = accessor.into();
        }
    }
    Ok(())
}

/// Appends the triangles, wound as the file's own.
fn write_indices(glb: &mut Glb, source: &Source<'_>, mesh: &RefinedMesh) -> usize {
    let indices =
        mesh.triangles.iter().flat_map(
            |&[a, b, c]| {
                if source.flipped { [a, c, b] } else { [a, b, c] }
            },
        );
    // The largest index of each type means "new strip" to some graphics interfaces.
    let numbers = if mesh.vertices.len() <= usize::from(u16::MAX) {
        Numbers::U16(indices.map(|index| index as u16).collect())
    } else {
        Numbers::U32(indices.collect())
    };
    glb.push_accessor(ElementKind::SCALAR, &numbers, ELEMENT_ARRAY_BUFFER, false)
}

/// Everything that is used as an index must be one.
fn check(
    glb: &Glb,
    source: &Source<'_>,
    mesh: &RefinedMesh,
    count: usize,
) -> Result<Blend, GltfError> {
    let triangles = source.triangles;
    let on_source = |triangle: u32| (triangle as usize) < triangles.len();
    let in_source = |corners: &[u32; 3]| corners.iter().all(|&v| (v as usize) < count);
    let in_mesh = |corners: &[u32; 3]| corners.iter().all(|&v| (v as usize) < mesh.vertices.len());
    let fits = triangles.iter().all(in_source)
        && mesh.triangles.iter().all(in_mesh)
        && mesh
            .vertices
            .iter()
            .all(|p| on_source(p.triangle) && sums_to_one(p.barycentrics));
    if fits {
        Ok(Blend::new(mesh, triangles, count))
    } else {
        Err(glb.refuse(format!(
            "the refined mesh of {:?} does not fit it",
            source.key
        )))
    }
}

/// False for NaN and infinity too.
fn sums_to_one(weights: Vec3) -> bool {
    (weights.element_sum() - 1.0).abs() < 1e-3
}

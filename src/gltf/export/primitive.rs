//! Writes the light of one primitive, and its geometry where the bake cut it finer.

use glam::Vec3;
use serde_json::{Map, Value};

use super::{
    BakedPrimitive, Before,
    glb::{ARRAY_BUFFER, Glb, Numbers, object_mut},
    instances::Target,
    refine::{self, Source},
    vertex_colors::Painter,
};
use crate::gltf::{
    GltfError,
    accessor_json::{AccessorData, ElementKind, whole},
};

/// The vertex attribute that carries baked light: irradiance / π, linear RGB.
pub(super) const BAKED_LIGHT: &str = "_BAKED_LIGHT";
/// The one that carries its gradient.
pub(super) const BAKED_LIGHT_GRADIENT: &str = "_BAKED_LIGHT_GRADIENT";
/// The vertex attribute that multiplies the base colour.
const COLOR: &str = "COLOR_0";

/// Vertex attributes by name, in the order of the file.
pub(super) type Attributes = Vec<(String, AccessorData)>;

/// Writes light as an attribute, or as vertex colours if there is a painter.
pub(super) fn write_primitive(
    glb: &mut Glb,
    target: Target,
    baked: &BakedPrimitive<'_>,
    before: &Before,
    painter: Option<&mut Painter>,
) -> Result<(), GltfError> {
    let primitive = target.of(&glb.json).clone();
    let count = vertex_count(glb, &primitive)?;
    check_light(glb, baked, count)?;
    let mut attributes = match &baked.light.mesh {
        // Accessors must not be empty.
        Some(mesh) if mesh.triangles.is_empty() => return Ok(()),
        Some(mesh) => {
            let source = Source {
                key: baked.key,
                triangles: baked.triangles,
                flipped: baked.flipped,
            };
            refine::refine(glb, target, count, &source, mesh)?
        }
        None => Attributes::new(),
    };
    let light = &baked.light.light;
    if let Some(painter) = painter {
        let old = old_colors(glb, &primitive, count, &attributes)?;
        if let Some(colors) = painter.paint(glb, target, old.as_ref(), light) {
            attributes.retain(|(name, _)| name != COLOR);
            attributes.push((COLOR.to_owned(), colors));
        }
        remove(glb, target, &[BAKED_LIGHT, BAKED_LIGHT_GRADIENT]);
    } else {
        write_light(glb, target, before, BAKED_LIGHT, light);
        let gradient = &baked.light.gradient;
        if gradient.is_empty() {
            remove(glb, target, &[BAKED_LIGHT_GRADIENT]);
        } else {
            let gradient = before.nodes.to_mesh(glb, baked.key.node, gradient);
            write_light(glb, target, before, BAKED_LIGHT_GRADIENT, &gradient);
        }
    }
    write_attributes(glb, target, attributes);
    Ok(())
}

/// Writes attributes, each in the place of that of its name.
pub(super) fn write_attributes(glb: &mut Glb, target: Target, attributes: Attributes) {
    for (name, data) in attributes {
        let accessor = push_attribute(glb, &name, &data);
        if let Some(attributes) = attributes_mut(glb, target) {
            attributes.insert(name, accessor.into());
        }
    }
}

/// Puts values in the place of an attribute's, or adds it.
pub(super) fn replace(
    attributes: &mut Attributes,
    name: &str,
    kind: ElementKind,
    values: impl Iterator<Item = f32>,
) {
    let data = AccessorData {
        kind,
        values: values.map(f64::from).collect(),
    };
    match attributes.iter_mut().find(|(known, _)| known == name) {
        Some((_, old)) => *old = data,
        None => attributes.push((name.to_owned(), data)),
    }
}

fn remove(glb: &mut Glb, target: Target, names: &[&str]) {
    if let Some(attributes) = attributes_mut(glb, target) {
        for name in names {
            attributes.shift_remove(*name);
        }
    }
}

/// Writes light or its gradient as an attribute, over that of an earlier bake where it can.
fn write_light(glb: &mut Glb, target: Target, before: &Before, name: &str, light: &[Vec3]) {
    let numbers = light.iter().flat_map(|light| light.to_array()).collect();
    let numbers = Numbers::Float(numbers);
    let old = whole(&target.of(&glb.json)["attributes"], name);
    if let Ok(Some(old)) = old
        && before.earlier.overwrite(glb, old, &numbers)
    {
        return;
    }
    let accessor = glb.push_accessor(ElementKind::VEC3, &numbers, ARRAY_BUFFER, false);
    if let Some(attributes) = attributes_mut(glb, target) {
        attributes.insert(name.to_owned(), accessor.into());
    }
}

/// The accessors of a primitive's attributes, in the order of the file; baked light of an earlier
/// bake is not among them.
pub(super) fn source_attributes(
    glb: &Glb,
    attributes: &Value,
) -> Result<Vec<(String, usize)>, GltfError> {
    let mut list = Vec::new();
    for name in attributes.as_object().into_iter().flat_map(Map::keys) {
        let accessor = whole(attributes, name).map_err(|reason| glb.invalid(reason))?;
        if let Some(accessor) = accessor
            && name != BAKED_LIGHT
            && name != BAKED_LIGHT_GRADIENT
        {
            list.push((name.clone(), accessor));
        }
    }
    Ok(list)
}

/// Appends an attribute as an accessor: joints as `u16`, all else as floats.
pub(super) fn push_attribute(glb: &mut Glb, name: &str, data: &AccessorData) -> usize {
    let numbers = if name.starts_with("JOINTS_") {
        Numbers::U16(data.values.iter().map(|&value| value as u16).collect())
    } else {
        Numbers::Float(data.values.iter().map(|&value| value as f32).collect())
    };
    glb.push_accessor(data.kind, &numbers, ARRAY_BUFFER, name == "POSITION")
}

pub(super) fn vertex_count(glb: &Glb, primitive: &Value) -> Result<usize, GltfError> {
    let position = whole(&primitive["attributes"], "POSITION");
    let position = position.map_err(|reason| glb.invalid(reason))?;
    match position {
        Some(position) => glb.count(position),
        None => Err(glb.invalid("a baked primitive has no POSITION".to_owned())),
    }
}

/// The vertex colours before light is added: the refined ones, else those of the file.
fn old_colors(
    glb: &Glb,
    primitive: &Value,
    count: usize,
    refined: &Attributes,
) -> Result<Option<AccessorData>, GltfError> {
    if let Some((_, colors)) = refined.iter().find(|(name, _)| name == COLOR) {
        return Ok(Some(colors.clone()));
    }
    whole(&primitive["attributes"], COLOR)
        .map_err(|reason| glb.invalid(reason))?
        .map(|accessor| glb.read(accessor, count))
        .transpose()
}

pub(super) fn attributes_mut(glb: &mut Glb, target: Target) -> Option<&mut Map<String, Value>> {
    object_mut(target.of_mut(&mut glb.json), "attributes")
}

/// Light must be finite and belong to the vertices it comes with.
fn check_light(glb: &Glb, baked: &BakedPrimitive<'_>, vertices: usize) -> Result<(), GltfError> {
    let (key, light) = (baked.key, &baked.light.light);
    let expected = match &baked.light.mesh {
        Some(mesh) => mesh.vertices.len(),
        None => vertices,
    };
    if light.len() != expected {
        return Err(glb.refuse(format!(
            "{key:?} has light for {} vertices, not {expected}",
            light.len()
        )));
    }
    let gradient = &baked.light.gradient;
    if !gradient.is_empty() && gradient.len() != expected {
        return Err(glb.refuse(format!(
            "{key:?} has gradients for {} vertices, not {expected}",
            gradient.len()
        )));
    }
    for (what, values) in [("light", light), ("gradient", gradient)] {
        if let Some(vertex) = values.iter().position(|value| !value.is_finite()) {
            return Err(glb.refuse(format!(
                "the {what} of {key:?} at vertex {vertex} is {}",
                values[vertex]
            )));
        }
    }
    Ok(())
}

//! From the raised surface to a mesh with all that the source's vertices have.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use super::skin;
use crate::displacement::{DisplacedPart, raised_tangent};
use crate::plugin::bump::{ATTRIBUTE_U_GRADIENT, ATTRIBUTE_V_GRADIENT, insert_uv_gradients};
use crate::plugin::radiosity::mesh_data::{MeshData, refined};
use crate::plugin::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT};

/// The raised surface as a mesh: attributes interpolated, tangents turned into the surface. Light that the source
/// was loaded with fits no more and is left out.
pub(super) fn displaced_mesh(source: &Mesh, data: &MeshData, part: &DisplacedPart) -> Mesh {
    let mut mesh = refined(source, &data.triangles, &part.mesh);
    mesh.remove_attribute(ATTRIBUTE_BAKED_LIGHT);
    mesh.remove_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT);
    skin::merge(source, &mut mesh, &data.triangles, &part.mesh);
    turn_tangents(&mut mesh, data, part);
    let arrays = |values: &[Vec3]| -> Vec<[f32; 3]> { values.iter().map(Vec3::to_array).collect() };
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, arrays(&part.positions));
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, arrays(&part.normals));
    if source.skinned_mesh_bounds().is_some() && mesh.generate_skinned_mesh_bounds().is_err() {
        mesh.set_skinned_mesh_bounds(None);
    }
    if mesh.contains_attribute(ATTRIBUTE_U_GRADIENT) && insert_uv_gradients(&mut mesh).is_err() {
        mesh.remove_attribute(ATTRIBUTE_U_GRADIENT);
        mesh.remove_attribute(ATTRIBUTE_V_GRADIENT);
    }
    mesh
}

/// Turns tangents of the base into the surface.
fn turn_tangents(mesh: &mut Mesh, data: &MeshData, part: &DisplacedPart) {
    let tangents = mesh.attribute_mut(Mesh::ATTRIBUTE_TANGENT);
    let Some(VertexAttributeValues::Float32x4(tangents)) = tangents else {
        return;
    };
    let base = part.mesh.interpolate(&data.triangles, |[a, b, c], w| {
        let [a, b, c] = [a, b, c].map(|v| data.normals[v as usize]);
        (a * w.x + b * w.y + c * w.z).normalize_or_zero()
    });
    for ((tangent, base), &normal) in tangents.iter_mut().zip(base).zip(&part.normals) {
        let [x, y, z, handedness] = *tangent;
        let turned = raised_tangent(Vec3::new(x, y, z), base, normal);
        // Interpolated ones are one but for roundings.
        *tangent = turned.extend(handedness.signum()).to_array();
    }
}

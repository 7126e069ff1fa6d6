use bevy::mesh::{MeshVertexAttribute, VertexFormat};
use bevy::prelude::*;
use thiserror::Error;

use crate::bump::vertex_uv_gradients;
use crate::plugin::radiosity::mesh_data;

/// Gradient of the texture coordinate `u` (`UV_0`) at a vertex, by unit of the mesh; with
/// [`ATTRIBUTE_V_GRADIENT`], what [`insert_uv_gradients`] inserts.
pub const ATTRIBUTE_U_GRADIENT: MeshVertexAttribute =
    MeshVertexAttribute::new("UGradient", 0xF2E5_C0BC, VertexFormat::Float32x3);

/// Gradient of the texture coordinate `v` (`UV_0`) at a vertex, by unit of the mesh.
pub const ATTRIBUTE_V_GRADIENT: MeshVertexAttribute =
    MeshVertexAttribute::new("VGradient", 0xF2E5_C0BD, VertexFormat::Float32x3);

/// Why a mesh has no gradients of texture coordinates.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum UvGradientsError {
    /// It has no triangles that can be read.
    #[error("no gradients of texture coordinates: {0}")]
    Mesh(String),
    /// It has no normals.
    #[error(
        "no gradients of texture coordinates: the mesh has no normals; compute_normals() makes some"
    )]
    NoNormals,
    /// It has no texture coordinates.
    #[error("no gradients of texture coordinates: the mesh has no UV_0")]
    NoUvs,
    /// A triangle names a vertex that is not there.
    #[error("no gradients of texture coordinates: a triangle has vertex {0}, of {1}")]
    Index(u32, usize),
}

/// Inserts the gradients of `UV_0` into a mesh, so that bumps on it need no derivatives on the screen: exact
/// per triangle where triangles share no vertices ([`Mesh::duplicate_vertices`]), and means by area where they
/// do, which on round surfaces are nearer to the truth than triangles are.
///
/// Costs 24 bytes a vertex. Bumps that lie on `UV_1` still take derivatives. After changes of positions,
/// normals or texture coordinates it must be called again.
///
/// # Errors
///
/// If the mesh has no triangles, normals or texture coordinates in the main world.
pub fn insert_uv_gradients(mesh: &mut Mesh) -> Result<(), UvGradientsError> {
    let data = mesh_data::read(mesh).map_err(|e| UvGradientsError::Mesh(e.to_string()))?;
    let count = data.positions.len();
    if data.normals.is_empty() {
        return Err(UvGradientsError::NoNormals);
    }
    if data.uvs[0].is_empty() {
        return Err(UvGradientsError::NoUvs);
    }
    let mut indices = data.triangles.iter().flatten();
    if let Some(&wrong) = indices.find(|&&i| i as usize >= count) {
        return Err(UvGradientsError::Index(wrong, count));
    }
    let found = vertex_uv_gradients(&data.positions, &data.normals, &data.uvs[0], data.triangles);
    let part = |i: usize| -> Vec<[f32; 3]> { found.iter().map(|g| g[i].to_array()).collect() };
    let insert = |mesh: &mut Mesh, attribute, values: Vec<[f32; 3]>| {
        mesh.try_insert_attribute(attribute, values)
            .map_err(|e| UvGradientsError::Mesh(e.to_string()))
    };
    insert(mesh, ATTRIBUTE_U_GRADIENT, part(0))?;
    insert(mesh, ATTRIBUTE_V_GRADIENT, part(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(mesh: &Mesh, attribute: MeshVertexAttribute) -> Vec<[f32; 3]> {
        let values = mesh.attribute(attribute).and_then(|v| v.as_float3());
        values.unwrap_or_default().to_vec()
    }

    #[test]
    fn a_plane_has_those_of_its_size() {
        let mut mesh = Mesh::from(Plane3d::default().mesh().size(4.0, 2.0));
        insert_uv_gradients(&mut mesh).unwrap();
        for by_u in values(&mesh, ATTRIBUTE_U_GRADIENT) {
            assert!(Vec3::from(by_u).distance(Vec3::X / 4.0) < 1e-6, "{by_u:?}");
        }
        for by_v in values(&mesh, ATTRIBUTE_V_GRADIENT) {
            assert!(Vec3::from(by_v).distance(Vec3::Z / 2.0) < 1e-6, "{by_v:?}");
        }
    }

    #[test]
    fn what_is_missing_is_told() {
        let whole = Mesh::from(Sphere::new(1.0));
        let mut bare = whole.clone();
        bare.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
        assert_eq!(
            insert_uv_gradients(&mut bare),
            Err(UvGradientsError::NoNormals)
        );
        let mut bare = whole.clone();
        bare.remove_attribute(Mesh::ATTRIBUTE_UV_0);
        assert_eq!(insert_uv_gradients(&mut bare), Err(UvGradientsError::NoUvs));
        let mut bare = whole;
        bare.remove_attribute(Mesh::ATTRIBUTE_POSITION);
        assert!(matches!(
            insert_uv_gradients(&mut bare),
            Err(UvGradientsError::Mesh(_))
        ));
    }
}

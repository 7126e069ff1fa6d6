//! Writes the first set of texture coordinates of meshes, whose vertices are cut apart where charts meet.

use serde_json::Value;

use super::{
    Exported,
    glb::Glb,
    images,
    instances::Target,
    primitive::replace,
    refine::{self, Source},
};
use crate::{
    gltf::{Document, GltfError, PrimitiveKey, accessor_json::ElementKind},
    mesh::{RefinedMesh, SurfacePoint, UvMesh},
};

/// Texture coordinates and the primitive they are for.
#[derive(Clone, Copy, Debug)]
pub struct ProjectedPrimitive<'a> {
    /// Which primitive.
    pub key: PrimitiveKey,
    /// The primitive's triangles as loaded.
    pub triangles: &'a [[u32; 3]],
    /// What they became.
    pub mesh: &'a UvMesh,
}

/// Writes `document` with new `TEXCOORD_0` as a single `.glb`.
///
/// Vertices that are part of several charts are there once for each, with all they had. Tangents, which followed other
/// coordinates, are left out: programs make them anew. So is light of an earlier bake, whose vertices these were.
///
/// # Errors
///
/// [`GltfError`] if a mesh does not belong to the document, or the result is too large for one file.
pub fn to_projected_glb(
    document: &Document,
    projected: &[ProjectedPrimitive<'_>],
) -> Result<Exported, GltfError> {
    let mut glb = Glb::merge(document)?;
    images::embed_images(&mut glb);
    for projected in projected {
        write(&mut glb, projected)?;
    }
    glb.finish()
}

fn write(glb: &mut Glb, projected: &ProjectedPrimitive<'_>) -> Result<(), GltfError> {
    let ProjectedPrimitive {
        key,
        triangles,
        mesh,
    } = *projected;
    let source = Source {
        key,
        triangles,
        flipped: false,
    };
    let primitive = Target::shared(key).of_mut(&mut glb.json);
    drop_tangents(&mut primitive["attributes"]);
    for morph in primitive["targets"].as_array_mut().into_iter().flatten() {
        drop_tangents(morph);
    }
    refine::rewrite(glb, &source, &parted(mesh), |attributes| {
        let uvs = mesh.uvs.iter().flat_map(|uv| uv.to_array());
        replace(attributes, "TEXCOORD_0", ElementKind::VEC2, uvs);
    })
}

fn drop_tangents(attributes: &mut Value) {
    if let Some(attributes) = attributes.as_object_mut() {
        attributes.shift_remove("TANGENT");
    }
}

/// The same surface, with the vertices that it has now.
fn parted(mesh: &UvMesh) -> RefinedMesh {
    let mut vertices = vec![SurfacePoint::corner(0, 0); mesh.uvs.len()];
    for (triangle, corners) in (0..).zip(&mesh.triangles) {
        for (corner, &vertex) in corners.iter().enumerate() {
            vertices[vertex as usize] = SurfacePoint::corner(triangle, corner);
        }
    }
    RefinedMesh {
        vertices,
        triangles: mesh.triangles.clone(),
        sources: (0..mesh.triangles.len() as u32).collect(),
    }
}

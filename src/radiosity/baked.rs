use std::sync::Arc;

use glam::Vec3;

use super::quality::VertexQuality;
use super::report::Report;
use crate::mesh::RefinedMesh;

/// The light of a scene, by object and vertex.
#[derive(Clone, Debug, Default)]
pub struct Bake {
    /// One entry for each of [`Scene::objects`](super::Scene::objects), in the same order.
    pub objects: Vec<ObjectLight>,
    /// What was done, what it cost and how good it is.
    pub report: Report,
}

/// Baked light of one object.
#[derive(Clone, Debug, Default)]
pub struct ObjectLight {
    /// The mesh that carries the light; `None` if it is the object's own. From one bake of a
    /// [`Baker`](super::Baker) to the next it is the same `Arc` as long as it is the same mesh.
    pub mesh: Option<Arc<RefinedMesh>>,
    /// Irradiance / π at each vertex of that mesh, linear RGB in cd/m²: multiplied by the
    /// reflectance it is the radiance the eye sees. Empty if the object does not receive light.
    pub light: Vec<Vec3>,
    /// Where light comes from: its gradient by the normal, at each vertex of that mesh, if
    /// [`BakeSettings::directional`](super::BakeSettings::directional) asks for it, else empty.
    ///
    /// A vector in world space, luminance / π in cd/m², at most ten times as long as the luminance of
    /// [`light`](Self::light): [`reshade`](super::reshade) says what it is for. It belongs to the normals
    /// of the mesh, also where light was put on the side that they point away from. Of a single
    /// far lamp it is the irradiance / π of a surface that faces it, times the unit vector towards it.
    pub gradient: Vec<Vec3>,
    /// How sure the light of each vertex of that mesh is, if
    /// [`BakeSettings::vertex_quality`](super::BakeSettings::vertex_quality) asks for it, else empty.
    pub quality: Vec<VertexQuality>,
}

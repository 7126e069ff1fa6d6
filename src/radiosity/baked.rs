use std::sync::Arc;

use glam::Vec3;

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
}

use std::sync::Arc;

use glam::Vec3;

use super::receiver_mesh::{MeshesBefore, ReceiverMeshes};
use super::refine::Refinement;
use super::validate::ValidScene;
use crate::mesh::{Refined, RefinedMesh};

/// The meshes that light is put on.
///
/// Only direct light makes sharp edges, so there are two: a coarse mesh carries what rays gather, and
/// a finer one inside it the light of lights and emitters. Both are the same where vertices are kept
/// as given. The fine one is the result, to which the coarse one's light is carried over.
#[derive(Clone)]
pub(crate) struct Receivers {
    pub(crate) coarse: Arc<ReceiverMeshes>,
    pub(crate) fine: Arc<ReceiverMeshes>,
    /// For each object, how its fine mesh lies on its coarse one; `None` if they are the same.
    pub(crate) steps: Vec<Option<Arc<RefinedMesh>>>,
}

impl Receivers {
    /// One mesh for both kinds of light.
    pub(crate) fn same(meshes: Arc<ReceiverMeshes>) -> Self {
        Self {
            steps: vec![None; meshes.meshes.len()],
            coarse: meshes.clone(),
            fine: meshes,
        }
    }

    /// The meshes given, refined.
    pub(crate) fn new(
        scene: &ValidScene,
        given: &Arc<ReceiverMeshes>,
        refinement: &Refinement,
    ) -> Self {
        Self::on(scene, refined(scene, given, &refinement.coarse), refinement)
    }

    /// The coarse meshes of a refinement, refined further.
    pub(crate) fn on(
        scene: &ValidScene,
        coarse: Arc<ReceiverMeshes>,
        refinement: &Refinement,
    ) -> Self {
        let step = |by: &Option<Arc<Refined>>| Some(Arc::new(by.as_ref()?.mesh.clone()));
        Self {
            fine: refined(scene, &coarse, &refinement.fine),
            steps: refinement.fine.iter().map(step).collect(),
            coarse,
        }
    }

    /// Where a mesh is what it was before, makes it the same one.
    pub(crate) fn share_results(&mut self, old: &Self, object_before: &[Option<usize>]) {
        let before = MeshesBefore {
            meshes: &old.fine,
            same: &[],
            object: object_before,
        };
        before.share_refinements(Arc::make_mut(&mut self.fine));
    }

    /// The coarse triangle that a fine one lies on.
    pub(crate) fn coarse_triangle(&self, object: usize, triangle: usize) -> usize {
        (self.steps[object].as_ref()).map_or(triangle, |s| s.sources[triangle] as usize)
    }

    /// Whether an object has one mesh for both kinds of light.
    pub(crate) fn is_same(&self, object: usize) -> bool {
        self.steps[object].is_none()
    }

    /// Values of the coarse unknowns, interpolated to the fine ones.
    pub(crate) fn carried_over(&self, values: &[Vec3]) -> Vec<Vec3> {
        let mut over = vec![Vec3::ZERO; self.fine.unknowns];
        for ((fine, coarse), step) in (self.fine.meshes.iter())
            .zip(&self.coarse.meshes)
            .zip(&self.steps)
        {
            match step {
                None => {
                    for (&to, &from) in fine.unknown.iter().zip(&coarse.unknown) {
                        over[to as usize] = values[from as usize];
                    }
                }
                Some(step) => {
                    for (&to, point) in fine.unknown.iter().zip(&step.vertices) {
                        let corners = coarse.triangles[point.triangle as usize]
                            .map(|v| values[coarse.unknown[v as usize] as usize]);
                        let b = point.barycentrics;
                        over[to as usize] = corners[0] * b.x + corners[1] * b.y + corners[2] * b.z;
                    }
                }
            }
        }
        over
    }

    pub(crate) fn bytes(&self) -> u64 {
        let fine = if Arc::ptr_eq(&self.coarse, &self.fine) {
            0
        } else {
            self.fine.bytes()
        };
        self.coarse.bytes() + fine
    }
}

/// Meshes refined, where they are; the same if none is.
fn refined(
    scene: &ValidScene,
    meshes: &Arc<ReceiverMeshes>,
    by: &[Option<Arc<Refined>>],
) -> Arc<ReceiverMeshes> {
    if by.iter().all(Option::is_none) {
        meshes.clone()
    } else {
        meshes.refined(scene, by).into()
    }
}

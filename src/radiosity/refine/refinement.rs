use std::sync::Arc;

use crate::mesh::Refined;
use crate::radiosity::kind::ByKind;
use crate::radiosity::receiver_mesh::ReceiverMeshes;

/// How the meshes of a scene are refined, by object; `None` where they are not.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refinement {
    /// Of the meshes given.
    pub(crate) coarse: Vec<Option<Arc<Refined>>>,
    /// Of the coarse meshes.
    pub(crate) fine: Vec<Option<Arc<Refined>>>,
    /// Relative RMSE that the meshes leave.
    pub(crate) error: ByKind<f64>,
    /// Vertices that there might have been, if there are as many.
    pub(crate) full: Option<usize>,
    /// Rays that it took.
    pub(crate) rays: u64,
}

impl Refinement {
    /// Whether the coarse meshes are the very same.
    pub(crate) fn same_coarse(&self, other: &Self) -> bool {
        let same = |(a, b): (&Option<Arc<Refined>>, &Option<Arc<Refined>>)| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.coarse.len() == other.coarse.len() && self.coarse.iter().zip(&other.coarse).all(same)
    }

    /// What of it fits the meshes of another scene, `before` telling which object was which: an object
    /// that only moved keeps its own.
    pub(crate) fn kept(
        &self,
        old: &ReceiverMeshes,
        new: &ReceiverMeshes,
        before: &[Option<usize>],
    ) -> Self {
        let fits = |o: usize, p: usize| {
            let (new, old) = (&new.meshes[o], &old.meshes[p]);
            new.triangles == old.triangles && new.positions.len() == old.positions.len()
        };
        let kept = |by: &[Option<Arc<Refined>>]| -> Vec<Option<Arc<Refined>>> {
            (before.iter().enumerate())
                .map(|(o, p)| by[(*p).filter(|&p| fits(o, p))?].clone())
                .collect()
        };
        Self {
            coarse: kept(&self.coarse),
            fine: kept(&self.fine),
            rays: 0,
            ..*self
        }
    }
}

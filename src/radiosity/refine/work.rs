use std::collections::BTreeSet;
use std::mem;
use std::sync::Arc;
use std::time::Instant;

use super::drive::{Refiner, is_over};
use super::face::FaceLight;
use super::probe::{LEAST_SHADOW_RAYS, Probe, ProbeRays};
use super::refinement::Refinement;
use crate::mesh::{Conforming, Limits, Origin, Part, Refined};
use crate::radiosity::kind::Kind;
use crate::radiosity::occlusion::OFFSET;
use crate::radiosity::parallel::Cancelled;
use crate::radiosity::receiver_mesh::{ReceiverMesh, ReceiverMeshes};
use crate::radiosity::validate::HALF_EXTENT;

/// Halves of edges are no shorter than this, in internal units: the scene is 2048 across.
const MIN_EDGE: f32 = HALF_EXTENT / 16384.0;

/// Rounds at most. A round halves faces, so this many cut any face down to nothing.
const ROUNDS: usize = 60;

/// Rays of either set at a point, gathering ones and those to each light with a penumbra, beside the error
/// that meshes may leave: what noise hides cannot be found, and meshes that look for it follow the noise.
/// So many gathering ones at least: with fewer, a hot spot that one of them meets looks like detail.
const RAYS: f64 = 0.25;
const LEAST_RAYS: u32 = 40;
const MOST_RAYS: u32 = 512;

/// Meshes while they are refined.
pub(super) struct Work<'a> {
    pub(super) refiner: &'a Refiner<'a>,
    pub(super) meshes: &'a [ReceiverMesh],
    pub(super) probe: Probe<'a>,
    /// Relative RMSE that they may leave.
    pub(super) asked: f64,
    /// The object of each part.
    pub(super) objects: Vec<usize>,
    pub(super) conforming: Conforming,
    pub(super) faces: Vec<FaceLight>,
    /// Faces that are to be judged.
    pub(super) stale: BTreeSet<u32>,
    /// Vertices of meshes that are not refined.
    others: usize,
    /// Of each face: its part of the mean square error times the whole area, relative to the level; below 0
    /// by chance.
    pub(super) errors: Vec<f64>,
    pub(super) rays: u64,
}

/// What came of it.
pub(super) struct Outcome {
    pub(super) by: Vec<Option<Arc<Refined>>>,
    /// Relative RMSE that the mesh leaves.
    pub(super) error: f64,
    /// There were as many vertices as there may be, and that was too few.
    pub(super) full: bool,
}

impl Outcome {
    /// What an earlier refinement made for smooth light.
    pub(super) fn kept(earlier: &Refinement) -> Self {
        Self {
            by: earlier.coarse.clone(),
            error: earlier.error.smooth,
            full: false,
        }
    }
}

impl<'a> Work<'a> {
    /// Of meshes that may leave an error `asked`, relative RMSE.
    pub(super) fn new(
        refiner: &'a Refiner,
        meshes: &'a ReceiverMeshes,
        kind: Kind,
        asked: f64,
    ) -> Self {
        let (scene, vertices) = (refiner.gather.scene, meshes.vertex_count());
        let meshes = &*meshes.meshes;
        let refines = |&o: &usize| scene.objects[o].refine && !meshes[o].triangles.is_empty();
        let objects: Vec<usize> = (0..meshes.len()).filter(refines).collect();
        let parts: Vec<Part> = (objects.iter())
            .map(|&o| Part {
                positions: &meshes[o].positions,
                triangles: &meshes[o].triangles,
                refine: true,
            })
            .collect();
        let conforming = Conforming::new(&parts, OFFSET);
        Self {
            faces: vec![FaceLight::default(); conforming.faces() as usize],
            stale: (0..conforming.faces()).collect(),
            others: vertices - conforming.vertex_count(),
            asked,
            probe: Probe::new(
                refiner.gather,
                refiner.shining,
                kind,
                refiner.gather.settings.seed,
                ProbeRays {
                    gathering: ((RAYS / asked) as u32).clamp(LEAST_RAYS, MOST_RAYS),
                    shadow: ((RAYS / asked) as u32).clamp(LEAST_SHADOW_RAYS, MOST_RAYS),
                },
            ),
            refiner,
            meshes,
            objects,
            conforming,
            errors: Vec::new(),
            rays: 0,
        }
    }

    /// Refines the meshes further, until they leave no more than was asked, all of them together have too
    /// many vertices, or it is late.
    pub(super) fn run(
        &mut self,
        max_vertices: usize,
        until: Option<Instant>,
    ) -> Result<Outcome, Cancelled> {
        let limits = Limits {
            max_vertices: max_vertices.saturating_sub(self.others),
            max_faces: usize::MAX,
            min_edge: MIN_EDGE,
        };
        let mut full = !self.cut_long_edges(&limits);
        // Nothing was judged before.
        if self.errors.is_empty() {
            self.scout()?;
        }
        let mut error = 0.0;
        for _ in 0..ROUNDS {
            let stale = mem::take(&mut self.stale).into_iter().collect();
            self.judge(stale)?;
            self.weigh();
            error = self.error();
            let good = error <= self.asked;
            full &= !good;
            if full || good || is_over(until) {
                break;
            }
            full = !self.cut_worst(&limits);
            if self.stale.is_empty() {
                break;
            }
        }
        Ok(Outcome {
            error,
            full,
            by: self.refined(),
        })
    }

    /// The corners of all faces as vertices of all parts, one part's after the other's.
    pub(super) fn corners(&self) -> Vec<[usize; 3]> {
        let first = self.conforming.first_vertices();
        let corners = |f: u32| {
            let first = first[self.conforming.part(f) as usize];
            (self.conforming.vertices(f)).map(|vertex| first + vertex as usize)
        };
        (0..self.conforming.faces()).map(corners).collect()
    }

    /// The meshes as they are now.
    fn refined(&self) -> Vec<Option<Arc<Refined>>> {
        let mut by = vec![None; self.meshes.len()];
        for (&object, refined) in self
            .objects
            .iter()
            .zip(self.conforming.clone().into_parts())
        {
            let is_new = |o: &Origin| matches!(o, Origin::Between(_));
            if refined.origins.iter().any(is_new) {
                by[object] = Some(Arc::new(refined));
            }
        }
        by
    }
}

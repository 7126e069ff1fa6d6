use std::time::Instant;

use super::refinement::Refinement;
use super::work::{Outcome, Work};
use crate::radiosity::gather::Gather;
use crate::radiosity::gathered::Shining;
use crate::radiosity::kind::{ByKind, Kind};
use crate::radiosity::level::Level;
use crate::radiosity::observer::Observer;
use crate::radiosity::parallel::Cancelled;
use crate::radiosity::receiver_mesh::ReceiverMeshes;
use crate::radiosity::validate::ValidScene;

/// Refines the meshes of a scene for one kind of light.
pub(crate) struct Refiner<'a> {
    pub(crate) gather: &'a Gather<'a>,
    pub(crate) shining: &'a Shining<'a>,
    pub(crate) observer: &'a dyn Observer,
    pub(crate) level: Level,
    /// Edges longer than this are cut whatever the light, in internal units.
    pub(crate) max_edge: f32,
    /// When to be done at the latest.
    pub(crate) until: Option<Instant>,
}

/// What is asked of a refinement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// Relative RMSE that the meshes may leave.
    pub(crate) error: ByKind<f64>,
    pub(crate) max_vertices: usize,
}

/// Share of the vertices that the coarse meshes may have at first.
const COARSE: f64 = 0.4;

/// Room for vertices is filled if it is one of so many.
const WORTH_FILLING: usize = 25;

impl Refiner<'_> {
    /// Refines the meshes of a scene: for smooth light, then inside those for light with sharp edges.
    /// What an earlier refinement made of them for smooth light is kept if it is good enough.
    pub(crate) fn refine(
        &self,
        scene: &ValidScene,
        given: &ReceiverMeshes,
        asked: &Asked,
        earlier: Option<&Refinement>,
    ) -> Result<Refinement, Cancelled> {
        let mut coarse_at_most = (COARSE * asked.max_vertices as f64) as usize;
        let earlier = earlier.filter(|e| e.error.smooth <= asked.error.smooth);
        let mut rays = 0;
        let (mut work, mut smooth) = match earlier {
            Some(earlier) => (None, Outcome::kept(earlier)),
            None => {
                let mut work = Work::new(self, given, Kind::Smooth, asked.error.smooth);
                let smooth = work.run(coarse_at_most, self.half_way())?;
                (Some(work), smooth)
            }
        };
        let sharp = loop {
            let coarse = given.refined(scene, &smooth.by);
            let mut finer = Work::new(self, &coarse, Kind::Sharp, asked.error.sharp);
            let sharp = finer.run(asked.max_vertices, self.until)?;
            rays += finer.rays;
            let used = coarse.refined(scene, &sharp.by).vertex_count();
            let room = asked.max_vertices.saturating_sub(used);
            let worth = room * WORTH_FILLING >= asked.max_vertices && !is_over(self.until);
            let Some(work) = work
                .as_mut()
                .filter(|_| smooth.full && !sharp.full && worth)
            else {
                break sharp;
            };
            // Shadows leave room that was kept for them.
            coarse_at_most += room;
            smooth = work.run(coarse_at_most, self.half_way())?;
        };
        Ok(Refinement {
            error: ByKind {
                smooth: smooth.error,
                sharp: sharp.error,
            },
            full: (smooth.full || sharp.full).then_some(asked.max_vertices),
            coarse: smooth.by,
            fine: sharp.by,
            rays: rays + work.map_or(0, |work| work.rays),
        })
    }

    /// When half of the time is over.
    fn half_way(&self) -> Option<Instant> {
        let now = Instant::now();
        self.until
            .map(|until| now + until.saturating_duration_since(now) / 2)
    }
}

pub(super) fn is_over(until: Option<Instant>) -> bool {
    until.is_some_and(|until| Instant::now() > until)
}

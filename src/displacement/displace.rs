use glam::Vec3;

use super::heights::Heights;
use super::raise::raise;
use super::surface::Surface;
use super::uniform::{self, Plan};
use super::{
    Base, Bounds, DisplacementError, DisplacementReport, DisplacementSettings, Tessellation,
    adaptive,
};
use crate::height_map::HeightMap;
use crate::mesh::RefinedMesh;

/// A displaced surface, and what is to be said about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Displaced {
    /// As many as were given, in their order.
    pub parts: Vec<DisplacedPart>,
    /// Of all together.
    pub report: DisplacementReport,
}

/// One displaced mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplacedPart {
    /// Its triangles, and where its vertices lie on the base: all attributes but position and normal are
    /// those of the base, interpolated.
    pub mesh: RefinedMesh,
    /// Of the vertices, in metres.
    pub positions: Vec<Vec3>,
    /// Of the vertices, of length one.
    pub normals: Vec<Vec3>,
    /// What its positions lie in.
    pub bounds: Bounds,
}

/// Somebody who watches the work and may stop it.
pub trait Watch: Sync {
    /// Told what is done and how much of it, 0 to 1; the work ends if this is false.
    fn goes_on(&self, stage: &'static str, done: f32) -> bool;
}

/// Nobody watches.
impl Watch for () {
    fn goes_on(&self, _: &'static str, _: f32) -> bool {
        true
    }
}

/// Raises meshes by a height map. Where vertices of the meshes meet they stay together, to the bit.
///
/// Results are the same on any number of threads.
///
/// # Errors
///
/// If a setting is outside its limits, a mesh is broken or has no texture coordinates, heights are beyond what
/// positions can hold, or `watch` asked to stop.
pub fn displace(
    bases: &[Base],
    map: &HeightMap,
    settings: &DisplacementSettings,
    watch: &dyn Watch,
) -> Result<Displaced, DisplacementError> {
    settings.check()?;
    let heights = Heights::new(map, settings)?;
    let surface = Surface::new(bases, settings)?;
    let budget = settings.budget();
    match settings.tessellation {
        Tessellation::Base => {
            let plan = Plan::new(&surface, |_, _, _| 1.0, budget);
            let tessellated = uniform::tessellate(&surface, &plan);
            raise(&surface, &heights, tessellated, settings, watch)
        }
        Tessellation::Uniform(spacing) => {
            let plan = Plan::new(
                &surface,
                uniform::wanted(&surface, spacing, map.size()),
                budget,
            );
            let tessellated = uniform::tessellate(&surface, &plan);
            let mut displaced = raise(&surface, &heights, tessellated, settings, watch)?;
            displaced.report.density = Some(plan.share);
            displaced.report.stop = plan.stop;
            Ok(displaced)
        }
        Tessellation::Adaptive { tolerance } => {
            let adapted = adaptive::tessellate(&surface, heights, tolerance, budget, watch)?;
            let mut displaced = raise(&surface, &heights, adapted.tessellated, settings, watch)?;
            displaced.report.error = Some(adapted.error);
            displaced.report.stop = adapted.stop;
            Ok(displaced)
        }
    }
}

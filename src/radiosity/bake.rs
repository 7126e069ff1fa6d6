use super::baked::Bake;
use super::element_light::ElementLight;
use super::estimate::estimate_counts;
use super::observer::Observer;
use super::pipeline::{run, run_elements};
use super::settings::{BakeSettings, InvalidSetting};
use super::stages::Start;
use super::validate::{SceneError, ValidScene};
use crate::mesh::{SplitError, fewest_vertices};

/// Why a bake ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The observer asked for it.
    #[error("the bake was cancelled")]
    Cancelled,
    /// A setting lies outside its limits.
    #[error(transparent)]
    Setting(#[from] InvalidSetting),
    /// The scene cannot be baked.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It would need more memory than the settings allow.
    #[error(
        "the bake needs about {:.1} GB of memory and max_memory allows {:.1} GB: lower elements, raise \
         max_edge, use FormFactors::HitList, or raise max_memory",
        *needed as f64 / 1e9, *allowed as f64 / 1e9
    )]
    Memory {
        /// Estimate of the peak, in bytes.
        needed: u64,
        /// [`BakeSettings::max_memory`].
        allowed: u64,
    },
    /// Edges cannot be split as asked.
    #[error(transparent)]
    Split(#[from] SplitError),
}

/// Bakes the diffuse light of a scene into its vertices.
///
/// ```text
///  scene ─► receiving meshes ────────────────────────────────────────┐
///     └───► elements + occluders ─► form factors ─► direct ─► solve ─► gather ─► fit ─► Bake
/// ```
///
/// The result depends on the scene and the settings alone: the same bytes for any number of
/// threads.
///
/// # Errors
///
/// [`BakeError::Cancelled`] if the observer said so, [`BakeError::Memory`] if the bake would need more
/// than it may have, else what is wrong with a setting.
pub fn bake(
    scene: &ValidScene,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<Bake, BakeError> {
    check(scene, settings)?;
    Ok(run(scene, settings, Start::default(), observer)?.0)
}

/// Solves for the light of a scene's elements and stops there: what radiosity programs did before
/// they gathered at vertices, and what the [methods](super::FormFactors) and
/// [solvers](super::Solver) are compared by.
///
/// # Errors
///
/// As [`bake`].
pub fn solve_elements(
    scene: &ValidScene,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<ElementLight, BakeError> {
    check(scene, settings)?;
    run_elements(scene, settings, observer)
}

/// Whether the settings are within their limits and the bake within the memory it may have.
pub(crate) fn check(scene: &ValidScene, settings: &BakeSettings) -> Result<(), BakeError> {
    settings.check()?;
    let (needed, allowed) = (estimate_counts(scene, settings).bytes, settings.max_memory);
    if needed > allowed {
        return Err(BakeError::Memory { needed, allowed });
    }
    // Splitting for the light stops at what is allowed; edges that are too long are cut in any case.
    if let (true, Some(max_edge)) = (settings.refine, settings.max_edge) {
        check_edges(scene, max_edge, settings.max_vertices)?;
    }
    Ok(())
}

fn check_edges(scene: &ValidScene, max_edge: f32, limit: u32) -> Result<(), SplitError> {
    let internal = max_edge / scene.scale;
    let refined = scene.objects.iter().filter(|o| o.refine && o.receives);
    let fewest = refined.map(|o| fewest_vertices(&o.positions, &o.triangles, internal));
    if fewest.sum::<f64>() > f64::from(limit) {
        let limit = limit as usize;
        return Err(SplitError::TooManyVertices { limit, max_edge });
    }
    Ok(())
}

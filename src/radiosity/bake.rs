use super::baked::Bake;
use super::element_light::ElementLight;
use super::observer::Observer;
use super::pipeline::{run, run_elements};
use super::settings::{BakeSettings, InvalidSetting};
use super::stages::Start;
use super::validate::{SceneError, ValidScene};
use crate::mesh::SplitError;

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
/// [`BakeError::Cancelled`] if the observer said so, else what is wrong with a setting.
pub fn bake(
    scene: &ValidScene,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<Bake, BakeError> {
    settings.check()?;
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
    settings.check()?;
    run_elements(scene, settings, observer)
}

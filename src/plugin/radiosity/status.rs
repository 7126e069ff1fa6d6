use std::sync::Arc;

use bevy::prelude::*;

use crate::radiosity::{Report, Stage};

/// What the bake is doing, and what the last one found.
#[derive(Resource, Reflect, Clone, Debug, Default)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct RadiosityStatus {
    /// What is going on now.
    pub state: BakeState,
    /// Bakes that ended with new light or found that nothing had changed.
    pub finished: u64,
    /// Bakes that ended without a result, cancelled ones included.
    pub failed: u64,
    /// What the last finished bake did and how good it is; `None` before the first.
    #[reflect(ignore)]
    pub report: Option<Arc<Report>>,
    /// Why the last bake failed; `None` if it did not.
    pub error: Option<String>,
    /// Bytes that are kept between bakes: what the baker knows, and copies of meshes and images.
    pub bytes: u64,
}

impl RadiosityStatus {
    /// Whether all light is up to date: nothing is running, waiting or failed.
    pub fn is_up_to_date(&self) -> bool {
        self.state == BakeState::UpToDate
    }
}

/// What the bake is doing.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub enum BakeState {
    /// There are no static meshes, or none was looked at yet.
    #[default]
    Idle,
    /// Something changed; a bake starts soon.
    Changed,
    /// Meshes, materials or images are still loading.
    Loading,
    /// A bake is running.
    Baking {
        /// The stage that it is in.
        #[reflect(ignore)]
        stage: Option<Stage>,
        /// How much of the stage is done, 0..=1.
        done: f32,
    },
    /// New light is being put into meshes.
    Applying,
    /// All light is up to date.
    UpToDate,
    /// The last bake failed or was cancelled; the light is that of the one before. A change, or
    /// [`Rebake`](super::Rebake), starts another.
    Stopped,
}

/// A bake has started.
#[derive(Message, Event, Reflect, Clone, Debug)]
pub struct BakeStarted {
    /// Meshes in the scene.
    pub objects: usize,
    /// Lights in the scene.
    pub lights: usize,
}

/// A bake has ended and its light is on the entities.
#[derive(Message, Event, Reflect, Clone, Debug)]
#[reflect(from_reflect = false)]
pub struct BakeFinished {
    /// What it did and how good it is.
    #[reflect(ignore)]
    pub report: Arc<Report>,
    /// Entities whose light changed.
    pub changed: usize,
}

/// A bake has ended without a result. The light stays as it was.
#[derive(Message, Event, Reflect, Clone, Debug)]
pub struct BakeFailed {
    /// Why, and what to do about it.
    pub error: String,
    /// Whether it was asked to stop.
    pub cancelled: bool,
}

/// Starts a bake, also where nothing has changed or changes are not followed: `commands.trigger(Rebake::default())`.
#[derive(Event, Reflect, Clone, Copy, Debug, Default)]
pub struct Rebake {
    /// Forget what earlier bakes found, the meshes they chose included.
    pub from_scratch: bool,
}

/// Stops the bake that is running: `commands.trigger(CancelBake)`.
#[derive(Event, Reflect, Clone, Copy, Debug, Default)]
pub struct CancelBake;

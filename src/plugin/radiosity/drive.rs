use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bevy::prelude::*;
use bevy::time::Real;

use super::assets::{Copies, Sources};
use super::components::{LightBaking, NotBaked};
use super::job::{Failure, Job, Memory, NewLight, Order};
use super::scene::Names;
use super::settings::RadiositySettings;
use super::status::{
    BakeFailed, BakeFinished, BakeStarted, BakeState, CancelBake, RadiosityStatus, Rebake,
};
use super::survey::{StaticWorld, Survey};
use crate::plugin::FrescoView;
use crate::radiosity::{Baker, Report};

/// Where the plugin stands between the world and the bake.
#[derive(Resource, Default)]
pub(super) struct Bakery {
    job: Option<Job>,
    /// What the last bake kept; with the job while one runs.
    memory: Memory,
    /// The world that the light on the entities belongs to, if its bake succeeded.
    reached: Option<Reached>,
    /// The world as it is, since when, and since when it is another than `reached`.
    seen: Option<Seen>,
    asked: Option<Rebake>,
    /// Light that is still to be put into meshes, and the report to give when that is done.
    pub(super) to_apply: VecDeque<NewLight>,
    pub(super) finishing: Option<Finishing>,
}

/// A state of the world that was baked, or that could not be.
#[derive(Clone, Copy, PartialEq)]
struct Reached {
    key: u64,
    failed: bool,
}

#[derive(Clone, Copy)]
struct Seen {
    key: u64,
    since: Duration,
    first_change: Option<Duration>,
}

/// A bake whose light is being put into meshes.
pub(super) struct Finishing {
    report: Arc<Report>,
    changed: usize,
}

/// Takes what a finished job found.
pub(super) fn collect(
    mut commands: Commands,
    mut bakery: ResMut<Bakery>,
    mut status: ResMut<RadiosityStatus>,
    copies: Res<Copies>,
) {
    let Some((key, (memory, result))) = bakery
        .job
        .as_mut()
        .and_then(|job| Some((job.key, job.outcome()?)))
    else {
        return;
    };
    bakery.job = None;
    bakery.memory = memory;
    bakery.reached = Some(Reached {
        key,
        failed: result.is_err(),
    });
    status.bytes = bakery.memory.bytes() + copies.bytes();
    match result {
        Ok(baked) => {
            bakery.finishing = Some(Finishing {
                report: Arc::new(baked.report),
                changed: baked.lights.len(),
            });
            bakery.to_apply = baked.lights.into();
        }
        Err(failure) => fail(&mut commands, &mut status, failure),
    }
}

fn fail(commands: &mut Commands, status: &mut RadiosityStatus, failure: Failure) {
    let event = match failure {
        Failure::Cancelled => BakeFailed {
            error: "the bake was cancelled".into(),
            cancelled: true,
        },
        Failure::Error(error) => BakeFailed {
            error,
            cancelled: false,
        },
    };
    if !event.cancelled {
        warn!("baking light: {}", event.error);
    }
    status.failed += 1;
    status.error = Some(event.error.clone());
    tell(commands, event);
}

/// Ends a bake whose light is all in place.
pub(super) fn finish(
    mut commands: Commands,
    mut bakery: ResMut<Bakery>,
    mut status: ResMut<RadiosityStatus>,
) {
    if !bakery.to_apply.is_empty() {
        return;
    }
    let Some(Finishing { report, changed }) = bakery.finishing.take() else {
        return;
    };
    let known = status.report.as_ref().map_or(&[][..], |r| &r.notes);
    for note in report.notes.iter().filter(|n| !known.contains(n)) {
        warn!("baking light: {note}");
    }
    status.finished += 1;
    status.error = None;
    status.report = Some(report.clone());
    tell(&mut commands, BakeFinished { report, changed });
}

/// To observers at once, and to readers of messages.
fn tell<E>(commands: &mut Commands, event: E)
where
    E: Message + Clone + for<'a> Event<Trigger<'a>: Default>,
{
    commands.write_message(event.clone());
    commands.trigger(event);
}

/// Looks at the world and starts a bake where it is due.
pub(super) fn watch(
    mut commands: Commands,
    mut bakery: ResMut<Bakery>,
    mut status: ResMut<RadiosityStatus>,
    (settings, view): (Res<RadiositySettings>, Res<FrescoView>),
    world: StaticWorld,
    mut sources: Sources,
    time: Res<Time<Real>>,
) {
    let mut settings = settings.clone();
    view.ask(&mut settings.bake);
    let mut survey = world.survey(&mut sources, &settings, *view);
    explain(&mut commands, &world, &mut survey);
    let now = time.elapsed();
    let (loading, empty) = (survey.loading, survey.objects.is_empty());
    bakery.see(survey.key, now);
    if !loading && bakery.is_due(now, empty, &settings) {
        let how = (&settings, *view);
        bakery.start(&mut commands, &mut status, survey, how, &world);
    }
    let state = bakery.state(loading, empty, &settings);
    if status.state != state {
        status.state = state;
    }
}

/// Says on the entities why they take no part.
fn explain(commands: &mut Commands, world: &StaticWorld, survey: &mut Survey) {
    for (entity, reason) in survey.to_tell.drain(..) {
        match reason {
            None => {
                commands.entity(entity).try_remove::<NotBaked>();
            }
            Some(reason) => {
                warn!("{} is not baked: {reason}", world.name(entity));
                commands.entity(entity).try_insert(NotBaked {
                    reason: reason.into_owned(),
                });
            }
        }
    }
}

impl Bakery {
    /// What the last bake kept; not while one runs.
    pub(super) fn baker(&self) -> Option<&Baker> {
        self.memory.baker()
    }

    fn see(&mut self, key: u64, now: Duration) {
        let seen = self.seen.get_or_insert(Seen {
            key,
            since: now,
            first_change: Some(now),
        });
        if seen.key != key {
            *seen = Seen {
                key,
                since: now,
                first_change: seen.first_change.or(Some(now)),
            };
        }
        // Back to what it was: nothing has changed after all.
        if self.reached.is_some_and(|r| r.key == key) {
            seen.first_change = None;
        }
    }

    /// Whether the light is not that of the world.
    fn is_stale(&self) -> bool {
        self.seen.map(|s| s.key) != self.reached.map(|r| r.key)
    }

    fn is_busy(&self) -> bool {
        self.job.is_some() || self.finishing.is_some()
    }

    fn is_due(&self, now: Duration, empty: bool, settings: &RadiositySettings) -> bool {
        if self.is_busy() || (empty && self.reached.is_none()) {
            return false;
        }
        if self.asked.is_some() {
            return true;
        }
        let Some(seen) = self.seen else {
            return false;
        };
        let quiet = now.saturating_sub(seen.since) >= settings.debounce;
        let waited = (seen.first_change)
            .is_some_and(|first| now.saturating_sub(first) >= settings.max_delay);
        settings.automatic && self.is_stale() && (quiet || waited)
    }

    fn start(
        &mut self,
        commands: &mut Commands,
        status: &mut RadiosityStatus,
        survey: Survey,
        (settings, view): (&RadiositySettings, FrescoView),
        world: &StaticWorld,
    ) {
        let started = BakeStarted {
            objects: survey.objects.len(),
            lights: survey.lights.len(),
        };
        let key = survey.key;
        let asked = self.asked.take().unwrap_or_default();
        let order = Order {
            names: Names {
                objects: survey
                    .objects
                    .iter()
                    .map(|o| world.name(o.entity))
                    .collect(),
                lights: survey.lights.iter().map(|l| world.name(l.entity)).collect(),
            },
            settings: settings.clone(),
            view,
            from_scratch: asked.from_scratch,
            survey,
        };
        if let Some(seen) = &mut self.seen {
            seen.first_change = None;
        }
        match Job::start(order, std::mem::take(&mut self.memory)) {
            Ok(job) => {
                self.job = Some(job);
                tell(commands, started);
            }
            Err(error) => {
                self.reached = Some(Reached { key, failed: true });
                fail(commands, status, Failure::Error(error));
            }
        }
    }

    fn state(&self, loading: bool, empty: bool, settings: &RadiositySettings) -> BakeState {
        if let Some(job) = &self.job {
            let (stage, done) = job.progress();
            return BakeState::Baking { stage, done };
        }
        match self.reached {
            _ if self.finishing.is_some() => BakeState::Applying,
            _ if loading => BakeState::Loading,
            None if empty => BakeState::Idle,
            Some(reached) if !self.is_stale() && !reached.failed => BakeState::UpToDate,
            Some(_) if !self.is_stale() => BakeState::Stopped,
            _ if settings.automatic => BakeState::Changed,
            _ => BakeState::Stopped,
        }
    }
}

/// [`Rebake`]: as soon as no other bake is running.
pub(super) fn rebake(asked: On<Rebake>, bakery: Option<ResMut<Bakery>>) {
    if let Some(mut bakery) = bakery {
        bakery.asked = Some(*asked.event());
    }
}

/// [`CancelBake`]: the one that is running, or the one that a change would start.
pub(super) fn cancel(_: On<CancelBake>, bakery: Option<ResMut<Bakery>>) {
    let Some(mut bakery) = bakery else {
        return;
    };
    bakery.asked = None;
    match (&bakery.job, bakery.seen) {
        (Some(job), _) => job.cancel(),
        (None, Some(seen)) if bakery.is_stale() => {
            bakery.reached = Some(Reached {
                key: seen.key,
                failed: true,
            });
        }
        _ => {}
    }
}

/// Without settings nothing runs: what was under way is given up, and to be done if they come back.
pub(super) fn stop(mut bakery: ResMut<Bakery>) {
    if bakery.is_busy() {
        bakery.job = None;
        bakery.to_apply.clear();
        bakery.finishing = None;
        bakery.reached = None;
    }
}

/// Sets Bevy's own switch, which keeps a light's diffuse part off surfaces that have it baked.
pub(super) fn switch_lights(
    points: Query<(&LightBaking, &mut PointLight), Changed<LightBaking>>,
    spots: Query<(&LightBaking, &mut SpotLight), Changed<LightBaking>>,
    suns: Query<(&LightBaking, &mut DirectionalLight), Changed<LightBaking>>,
) {
    for (baking, mut light) in points {
        light.affects_lightmapped_mesh_diffuse = *baking != LightBaking::Full;
    }
    for (baking, mut light) in spots {
        light.affects_lightmapped_mesh_diffuse = *baking != LightBaking::Full;
    }
    for (baking, mut light) in suns {
        light.affects_lightmapped_mesh_diffuse = *baking != LightBaking::Full;
    }
}

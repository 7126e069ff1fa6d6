use std::hash::{BuildHasher, Hash, Hasher};
use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bevy::camera::Exposure;
use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;

use super::assets::mesh_version;
use super::mesh_data::lit_mesh;
use super::scene::{Names, extract};
use super::settings::RadiositySettings;
use super::shown::Shown;
use super::survey::{FoundObject, Survey};
use super::textures::Textures;
use crate::mesh::RefinedMesh;
use crate::plugin::FrescoView;
use crate::radiosity::{BakeError, Baker, ObjectLight, Observer, Report, Stage, local_gradients};

/// What to bake.
pub(super) struct Order {
    pub(super) survey: Survey,
    pub(super) names: Names,
    pub(super) settings: RadiositySettings,
    pub(super) view: FrescoView,
    pub(super) from_scratch: bool,
}

/// What a bake keeps for the next one.
#[derive(Default)]
pub(super) struct Memory {
    baker: Option<Baker>,
    textures: Textures,
    #[cfg(feature = "parallel")]
    threads: Option<(usize, rayon::ThreadPool)>,
}

/// New light for an entity.
pub(super) struct NewLight {
    pub(super) entity: Entity,
    /// The mesh that was lit, as it was.
    pub(super) source: AssetId<Mesh>,
    pub(super) source_version: u64,
    pub(super) mesh: Mesh,
    /// Where the source was split for it, if it was.
    pub(super) refinement: Option<Arc<RefinedMesh>>,
    /// Of the mesh without its light.
    pub(super) lit_version: u64,
    pub(super) fingerprint: u64,
}

/// A finished bake.
pub(super) struct Baked {
    pub(super) report: Report,
    pub(super) lights: Vec<NewLight>,
}

/// Why there is no result.
pub(super) enum Failure {
    Cancelled,
    Error(String),
}

/// A bake on a thread of its own: the pool for asynchronous tasks compiles shaders too, which a
/// bake of seconds would hold up.
pub(super) struct Job {
    thread: Option<JoinHandle<(Memory, Result<Baked, Failure>)>>,
    watch: Arc<Watch>,
    pub(super) key: u64,
}

impl Job {
    /// Starts a bake.
    ///
    /// # Errors
    ///
    /// The platform has no threads.
    pub(super) fn start(order: Order, mut memory: Memory) -> Result<Self, String> {
        let watch = Arc::new(Watch::new(order.settings.time_budget));
        let key = order.survey.key;
        let watched = watch.clone();
        let thread = std::thread::Builder::new()
            .name("fresco bake".into())
            .spawn(move || {
                let result = memory.bake(&order, &watched);
                (memory, result)
            })
            .map_err(|e| {
                format!("no thread to bake on ({e}): on this platform, load baked assets instead")
            })?;
        Ok(Self {
            thread: Some(thread),
            watch,
            key,
        })
    }

    pub(super) fn cancel(&self) {
        self.watch.cancel.store(true, Ordering::Relaxed);
    }

    /// Stage and how much of it is done.
    pub(super) fn progress(&self) -> (Option<Stage>, f32) {
        let stage = self.watch.stage.load(Ordering::Relaxed) as usize;
        let done = f32::from_bits(self.watch.done.load(Ordering::Relaxed));
        (Stage::ALL.get(stage).copied(), done)
    }

    /// The outcome, once there is one.
    pub(super) fn outcome(&mut self) -> Option<(Memory, Result<Baked, Failure>)> {
        if !self.thread.as_ref().is_some_and(JoinHandle::is_finished) {
            return None;
        }
        let ended = self.thread.take()?.join();
        Some(ended.unwrap_or_else(|_| {
            let error = "the bake panicked: this is a bug in bevy_fresco".to_owned();
            (Memory::default(), Err(Failure::Error(error)))
        }))
    }
}

impl Drop for Job {
    /// The thread ends by itself soon after.
    fn drop(&mut self) {
        self.cancel();
    }
}

/// What a running bake and the world tell each other.
struct Watch {
    cancel: AtomicBool,
    deadline: Option<Instant>,
    stage: AtomicU64,
    done: AtomicU32,
}

impl Watch {
    fn new(budget: Option<Duration>) -> Self {
        Self {
            cancel: AtomicBool::new(false),
            deadline: budget.and_then(|b| Instant::now().checked_add(b)),
            stage: AtomicU64::new(u64::MAX),
            done: AtomicU32::new(0),
        }
    }

    fn late(&self) -> bool {
        self.deadline.is_some_and(|d| Instant::now() > d)
    }
}

impl Observer for Watch {
    fn progress(&self, stage: Stage, done: f32) {
        let index = Stage::ALL.iter().position(|&s| s == stage);
        self.stage
            .store(index.map_or(u64::MAX, |i| i as u64), Ordering::Relaxed);
        self.done.store(done.to_bits(), Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.late()
    }
}

impl Memory {
    pub(super) fn baker(&self) -> Option<&Baker> {
        self.baker.as_ref()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.baker.as_ref().map_or(0, Baker::bytes)
    }

    fn bake(&mut self, order: &Order, watch: &Watch) -> Result<Baked, Failure> {
        let extracted = extract(
            &order.survey,
            &order.names,
            order.settings.emissive_gain,
            &mut self.textures,
        );
        let extracted = extracted
            .map_err(|(entity, problem)| Failure::Error(format!("entity {entity}: {problem}")))?;
        let settings = &order.settings.bake;
        let mut baker = (self.baker.take()).unwrap_or_else(|| Baker::new(settings.clone()));
        if baker.settings() != settings {
            baker.set_settings(settings.clone());
        }
        if order.from_scratch {
            baker.forget();
        }
        let scene = extracted.scene;
        let (baker, result) = self.on_threads(order.settings.threads, move || {
            let result = baker.bake(scene, watch);
            (baker, result)
        });
        self.baker = Some(baker);
        let mut bake = result.map_err(|error| match error {
            BakeError::Cancelled if watch.late() => Failure::Error(
                "the bake took longer than `RadiositySettings::time_budget`: raise it, or lower the \
                 settings"
                    .into(),
            ),
            BakeError::Cancelled => Failure::Cancelled,
            other => Failure::Error(other.to_string()),
        })?;
        bake.report.notes.extend(extracted.notes);
        bake.report.notes.extend(too_dark(bake.report.mean_light));
        let elements = (self.baker.as_ref()).filter(|_| order.view == FrescoView::Elements);
        let elements = elements.and_then(Baker::elements);
        let shown = Shown::new(order.view, &bake, settings.error, elements);
        let objects = order.survey.objects.iter().zip(&extracted.triangles);
        let lights = (objects.zip(&bake.objects).enumerate())
            .filter_map(|(o, (object, light))| new_light((o, object), light, &shown, order.view));
        Ok(Baked {
            lights: lights.collect(),
            report: bake.report,
        })
    }

    #[cfg(feature = "parallel")]
    fn on_threads<T: Send>(&mut self, wanted: Option<usize>, work: impl FnOnce() -> T + Send) -> T {
        let count = wanted.unwrap_or_else(all_but_one).max(1);
        if self.threads.as_ref().is_none_or(|(n, _)| *n != count) {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(count)
                .thread_name(|i| format!("fresco bake {i}"));
            // Without a pool of its own the bake uses everyone's.
            self.threads = pool.build().ok().map(|pool| (count, pool));
        }
        match &self.threads {
            Some((_, pool)) => pool.install(work),
            None => work(),
        }
    }

    #[cfg(not(feature = "parallel"))]
    fn on_threads<T>(&mut self, _: Option<usize>, work: impl FnOnce() -> T) -> T {
        work()
    }
}

#[cfg_attr(
    not(feature = "parallel"),
    expect(dead_code, reason = "one thread is all there is")
)]
fn all_but_one() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get) - 1
}

/// Below this share of white, light looks black.
const BLACK: f32 = 0.002;

/// What to say of light that no camera shows.
fn too_dark(mean_light: f32) -> Option<String> {
    let shown = mean_light * Exposure::default().exposure();
    (mean_light > 0.0 && shown < BLACK).then(|| {
        format!(
            "the light is {mean_light:.1e} cd/m² on average, which a camera of Bevy's default \
             exposure shows as black: brighten the lights, or lower the camera's `Exposure::ev100`"
        )
    })
}

/// The lit mesh of an object, unless it carries this very light already.
fn new_light(
    (o, (object, triangles)): (usize, (&FoundObject, &Vec<[u32; 3]>)),
    light: &ObjectLight,
    shown: &Shown,
    view: FrescoView,
) -> Option<NewLight> {
    if !object.effect.receives {
        return None;
    }
    let fingerprint = fingerprint(object, light, view);
    if object.fingerprint == Some(fingerprint) {
        return None;
    }
    let mesh = shown.elements(o, object).unwrap_or_else(|| {
        // A mesh that is flattened to nothing has no gradient, and nothing to see. Other values than light
        // have none.
        let to_world = object.transform.matrix3.as_dmat3();
        let gradient = Some(&light.gradient).filter(|_| !view.replaces_light());
        let gradient = gradient.and_then(|gradient| local_gradients(to_world, gradient));
        lit_mesh(
            &object.mesh.asset,
            triangles,
            light.mesh.as_deref(),
            &shown.values(light),
            &gradient.unwrap_or_default(),
        )
    });
    Some(NewLight {
        entity: object.entity,
        source: object.mesh_id,
        source_version: object.mesh.version,
        lit_version: mesh_version(&mesh),
        mesh,
        refinement: light.mesh.clone(),
        fingerprint,
    })
}

fn fingerprint(object: &FoundObject, light: &ObjectLight, view: FrescoView) -> u64 {
    let mut state = FixedHasher.build_hasher();
    if view.replaces_light() {
        view.hash(&mut state);
    }
    state.write_u64(object.mesh.version);
    state.write_usize(light.mesh.as_ref().map_or(0, |m| m.triangles.len()));
    state.write_usize(light.gradient.len());
    for value in light.light.iter().chain(&light.gradient) {
        for channel in value.to_array() {
            state.write_u32(channel.to_bits());
        }
    }
    state.finish()
}

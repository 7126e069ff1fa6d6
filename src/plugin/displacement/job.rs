use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use bevy::mesh::UvChannel;
use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool};

use super::DisplacementProblem;
use super::attributes::displaced_mesh;
use super::order::Order;
use crate::displacement::{Base, DisplacementReport, Watch, displace};
use crate::plugin::radiosity::mesh_data;

/// A raised mesh, and what is to be said about it.
pub(super) struct Made {
    pub(super) mesh: Mesh,
    pub(super) report: DisplacementReport,
}

/// Work in a task of its own. Dropped, it is given up.
pub(super) struct Job {
    pub(super) order: Order,
    task: Task<Result<Made, DisplacementProblem>>,
    watched: Arc<Watched>,
}

impl Job {
    /// Starts on `mesh`, the content of the order's source.
    pub(super) fn start(order: Order, mesh: Mesh) -> Self {
        let watched = Arc::new(Watched::default());
        let (watch, to_make) = (watched.clone(), order.clone());
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::new);
        let task = pool.spawn(async move {
            catch_unwind(AssertUnwindSafe(|| make(&to_make, &mesh, &*watch)))
                .unwrap_or(Err(DisplacementProblem::Panicked))
        });
        Self {
            order,
            task,
            watched,
        }
    }

    /// What is being done, and how much of it is done.
    pub(super) fn progress(&self) -> (&'static str, f32) {
        let now = self.watched.now.lock();
        *now.unwrap_or_else(PoisonError::into_inner)
    }

    /// The outcome, once there is one.
    pub(super) fn outcome(&mut self) -> Option<Result<Made, DisplacementProblem>> {
        check_ready(&mut self.task)
    }
}

impl Drop for Job {
    /// The task ends by itself soon after.
    fn drop(&mut self) {
        self.watched.given_up.store(true, Ordering::Relaxed);
    }
}

/// What the work and the world tell each other.
struct Watched {
    given_up: AtomicBool,
    now: Mutex<(&'static str, f32)>,
}

impl Default for Watched {
    fn default() -> Self {
        Self {
            given_up: AtomicBool::new(false),
            now: Mutex::new(("start", 0.0)),
        }
    }
}

impl Watch for Watched {
    fn goes_on(&self, stage: &'static str, done: f32) -> bool {
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = (stage, done);
        !self.given_up.load(Ordering::Relaxed)
    }
}

fn make(order: &Order, mesh: &Mesh, watch: &dyn Watch) -> Result<Made, DisplacementProblem> {
    let data = mesh_data::read(mesh)?;
    let displacement = &order.displacement;
    let (uvs, name) = match displacement.uv_channel {
        UvChannel::Uv0 => (&data.uvs[0], "UV_0"),
        UvChannel::Uv1 => (&data.uvs[1], "UV_1"),
    };
    if uvs.is_empty() {
        return Err(DisplacementProblem::NoUvs(name));
    }
    if data.normals.is_empty() {
        return Err(DisplacementProblem::NoNormals);
    }
    let on_map = displacement.uv_transform;
    let uvs: Vec<Vec2> = (uvs.iter())
        .map(|&uv| on_map.transform_point2(uv))
        .collect();
    let base = Base {
        positions: &data.positions,
        normals: &data.normals,
        uvs: &uvs,
        triangles: &data.triangles,
    };
    let displaced = displace(&[base], &order.map, &displacement.settings, watch)?;
    Ok(Made {
        mesh: displaced_mesh(mesh, &data, &displaced.parts[0]),
        report: displaced.report,
    })
}

use std::sync::Arc;

use bevy::ecs::query::QueryData;
use bevy::mesh::morph::MeshMorphWeights;
use bevy::prelude::*;

use super::chain;
use super::job::{Job, Made};
use super::order::{Obstacle, Order, Sources};
use super::{DisplacedMesh, Displacement, DisplacementProblem, DisplacementStatus};
use crate::plugin::radiosity::BakedLighting;

/// The work for an entity.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(super) enum Worker {
    #[default]
    Idle,
    Working(Job),
    /// The order was carried out, or cannot be.
    Ended {
        order: Order,
        failed: bool,
    },
}

/// An entity and all that its mesh is made from.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Link {
    entity: Entity,
    name: Option<&'static Name>,
    displacement: &'static Displacement,
    shown: &'static mut Mesh3d,
    displaced: Option<&'static DisplacedMesh>,
    baked: Option<&'static BakedLighting>,
    morphed: Has<MeshMorphWeights>,
    worker: &'static mut Worker,
    status: &'static mut DisplacementStatus,
}

/// Looks at everything displaced, and starts what is new.
pub(super) fn watch(mut links: Query<Link>, lit: Query<&BakedLighting>, mut sources: Sources) {
    for mut link in &mut links {
        link.drop_light_of_others(&lit);
        let order = match link.morphed {
            true => Err(DisplacementProblem::Morphed.into()),
            false => sources.order(link.source(), link.displacement),
        };
        match order {
            Ok(order) if link.worker.is_at(&order, link.shows_displaced()) => {}
            Ok(order) => {
                if let Some(mesh) = sources.meshes.get(&order.source) {
                    *link.worker = Worker::Working(Job::start(order, mesh.clone()));
                }
            }
            Err(obstacle) => {
                link.worker.rest();
                match obstacle {
                    Obstacle::Loading => link.tell(DisplacementStatus::Loading),
                    Obstacle::Problem(problem) => link.fail(problem),
                }
            }
        }
        if let Worker::Working(job) = &*link.worker {
            let (stage, done) = job.progress();
            link.tell(DisplacementStatus::Working { stage, done });
        }
    }
}

/// Swaps in what was made.
pub(super) fn apply(
    mut commands: Commands,
    mut links: Query<Link>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    for mut link in &mut links {
        let Worker::Working(job) = link.worker.bypass_change_detection() else {
            continue;
        };
        let Some(outcome) = job.outcome() else {
            continue;
        };
        let order = job.order.clone();
        // Else it is for a mesh that the entity has no more, and other work will start.
        if *link.source() != order.source {
            link.worker.rest();
            continue;
        }
        let failed = outcome.is_err();
        match outcome {
            Ok(made) => link.swap(made, &order, &mut commands, &mut meshes),
            Err(problem) => link.fail(problem),
        }
        *link.worker = Worker::Ended { order, failed };
    }
}

/// Puts the source back when a displacement is removed. What is being made is given up.
pub(super) fn restore(
    removed: On<Remove, Displacement>,
    mut commands: Commands,
    mut entities: Query<(&mut Mesh3d, &DisplacedMesh, Option<&BakedLighting>)>,
) {
    if let Ok((mut shown, made, baked)) = entities.get_mut(removed.entity)
        && chain::is_displaced(chain::unlit(&shown, baked), Some(made))
    {
        shown.0 = made.source.clone();
    }
    commands
        .entity(removed.entity)
        .try_remove::<(DisplacedMesh, DisplacementStatus, Worker)>();
}

impl Worker {
    /// Whether the order is being carried out, or was and nobody has undone it.
    fn is_at(&self, order: &Order, is_shown: bool) -> bool {
        match self {
            Self::Idle => false,
            Self::Working(job) => job.order.key == order.key,
            Self::Ended {
                order: last,
                failed,
            } => last.key == order.key && (*failed || is_shown),
        }
    }

    fn rest(&mut self) {
        *self = Self::Idle;
    }
}

impl LinkItem<'_, '_> {
    fn source(&self) -> &Handle<Mesh> {
        chain::source(&self.shown.0, self.displaced, self.baked)
    }

    /// A clone of a lit entity knows what it was raised from, and not what was lit: it would be raised twice.
    fn drop_light_of_others(&mut self, lit: &Query<&BakedLighting>) {
        let Some(made) = self.displaced else {
            return;
        };
        if !self.shows_displaced() {
            let is_it = |b: &BakedLighting| b.lit == self.shown.0 && b.source == made.displaced;
            if lit.iter().any(is_it) {
                self.shown.0 = made.displaced.clone();
            }
        }
    }

    fn shows_displaced(&self) -> bool {
        chain::is_displaced(chain::unlit(&self.shown.0, self.baked), self.displaced)
    }

    fn swap(
        &mut self,
        made: Made,
        order: &Order,
        commands: &mut Commands,
        meshes: &mut Assets<Mesh>,
    ) {
        let displaced = meshes.add(made.mesh);
        self.shown.0 = displaced.clone();
        commands.entity(self.entity).try_insert(DisplacedMesh {
            source: order.source.clone(),
            displaced,
        });
        self.tell(DisplacementStatus::Done(Arc::new(made.report)));
    }

    fn fail(&mut self, problem: DisplacementProblem) {
        if self.status.problem() != Some(&problem) {
            let name =
                (self.name).map_or_else(|| format!("entity {}", self.entity), Name::to_string);
            warn!("{name} is not displaced: {problem}");
            self.tell(DisplacementStatus::Failed(problem));
        }
    }

    fn tell(&mut self, status: DisplacementStatus) {
        self.status.set_if_neq(status);
    }
}

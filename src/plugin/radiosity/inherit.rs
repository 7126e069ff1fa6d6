use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::components::{
    BakedLighting, InEffect, NoStaticLighting, NotBaked, OriginalMaterial, StaticLighting,
};
use crate::plugin::FrescoMaterial;

/// What decides who is static.
#[derive(SystemParam)]
pub(in crate::plugin) struct StaticMarks<'w, 's> {
    marks: Query<
        'w,
        's,
        (
            Option<&'static StaticLighting>,
            Has<NoStaticLighting>,
            Option<&'static ChildOf>,
        ),
    >,
}

impl StaticMarks<'_, '_> {
    /// The mark of the entity itself or of the nearest ancestor that has one.
    pub(in crate::plugin) fn in_effect(&self, entity: Entity) -> Option<StaticLighting> {
        let mut next = Some(entity);
        while let Some(entity) = next {
            let (mark, out, parent) = self.marks.get(entity).ok()?;
            if out {
                return None;
            }
            if let Some(mark) = mark {
                return Some(*mark);
            }
            next = parent.map(ChildOf::parent);
        }
        None
    }
}

/// Finds the [`StaticLighting`] in effect on every mesh, when anything that decides it has changed.
pub(super) fn inherit(
    mut commands: Commands,
    changed: Query<
        (),
        Or<(
            Changed<StaticLighting>,
            Added<NoStaticLighting>,
            Changed<ChildOf>,
            Added<Mesh3d>,
        )>,
    >,
    mut removed: (
        RemovedComponents<StaticLighting>,
        RemovedComponents<NoStaticLighting>,
        RemovedComponents<ChildOf>,
        RemovedComponents<Mesh3d>,
    ),
    meshes: Query<(Entity, Option<&InEffect>), With<Mesh3d>>,
    orphans: Query<Entity, (With<InEffect>, Without<Mesh3d>)>,
    marks: StaticMarks,
) {
    let any_removed = [
        removed.0.read().count(),
        removed.1.read().count(),
        removed.2.read().count(),
        removed.3.read().count(),
    ]
    .iter()
    .any(|&n| n > 0);
    if changed.is_empty() && !any_removed {
        return;
    }
    for entity in &orphans {
        commands.entity(entity).try_remove::<InEffect>();
    }
    for (entity, before) in &meshes {
        let now = marks.in_effect(entity).map(InEffect);
        if now.as_ref() != before {
            match now {
                Some(now) => commands.entity(entity).try_insert(now),
                None => commands.entity(entity).try_remove::<(InEffect, NotBaked)>(),
            };
        }
    }
}

/// Gives entities that are static no more, or receive no more, their own mesh and material back.
pub(super) fn restore(
    mut commands: Commands,
    lit: Query<(Entity, &BakedLighting, Option<&Mesh3d>, Option<&InEffect>)>,
    moved: Query<(
        Entity,
        &OriginalMaterial,
        Option<&MeshMaterial3d<FrescoMaterial>>,
        Option<&InEffect>,
    )>,
) {
    let receives = |effect: Option<&InEffect>| effect.is_some_and(|e| e.0.receives);
    for (entity, baked, mesh, effect) in &lit {
        if receives(effect) {
            continue;
        }
        let mut entity = commands.entity(entity);
        entity.try_remove::<BakedLighting>();
        if mesh.is_some_and(|m| m.0 == baked.lit) {
            entity.try_insert(Mesh3d(baked.source.clone()));
        }
    }
    for (entity, original, shown, effect) in &moved {
        if receives(effect) {
            continue;
        }
        let mut entity = commands.entity(entity);
        entity.try_remove::<OriginalMaterial>();
        if shown.is_some_and(|m| m.id() == original.moved_to) {
            entity
                .try_remove::<MeshMaterial3d<FrescoMaterial>>()
                .try_insert(MeshMaterial3d(original.handle.clone()));
        }
    }
}

use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::components::{InEffect, OriginalMaterial};
use crate::plugin::material::drawn_forward;
use crate::plugin::{FrescoExtension, FrescoMaterial};

/// The materials that were moved, by what they were: entities that shared one share one again.
#[derive(Resource, Default)]
pub(super) struct Moved(HashMap<AssetId<StandardMaterial>, AssetId<FrescoMaterial>>);

/// Moves the materials of receiving entities to the extension that shows baked light.
///
/// A material that is still loading is moved when it is there.
pub(super) fn move_materials(
    mut commands: Commands,
    mut moved: ResMut<Moved>,
    entities: Query<(Entity, &InEffect, &MeshMaterial3d<StandardMaterial>)>,
    originals: Option<Res<Assets<StandardMaterial>>>,
    extended: Option<ResMut<Assets<FrescoMaterial>>>,
) {
    let (Some(originals), Some(mut extended)) = (originals, extended) else {
        return;
    };
    for (entity, effect, material) in &entities {
        if !effect.0.receives {
            continue;
        }
        let Some(base) = originals.get(&material.0) else {
            continue;
        };
        let known = moved.0.get(&material.id());
        let handle = known
            .and_then(|&id| extended.get_strong_handle(id))
            .unwrap_or_else(|| {
                extended.add(FrescoMaterial {
                    base: drawn_forward(base),
                    extension: FrescoExtension::default(),
                })
            });
        moved.0.insert(material.id(), handle.id());
        commands
            .entity(entity)
            .try_remove::<MeshMaterial3d<StandardMaterial>>()
            .try_insert((
                OriginalMaterial {
                    handle: material.0.clone(),
                    moved_to: handle.id(),
                },
                MeshMaterial3d(handle),
            ));
    }
}

/// Carries changes of original materials over.
pub(super) fn follow_originals(
    mut moved: ResMut<Moved>,
    mut changes: MessageReader<AssetEvent<StandardMaterial>>,
    originals: Option<Res<Assets<StandardMaterial>>>,
    extended: Option<ResMut<Assets<FrescoMaterial>>>,
) {
    let (Some(originals), Some(mut extended)) = (originals, extended) else {
        return;
    };
    for event in changes.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let copy = moved.0.get(id).and_then(|&to| extended.get_mut(to));
                if let (Some(mut copy), Some(original)) = (copy, originals.get(*id)) {
                    copy.base = drawn_forward(original);
                }
            }
            AssetEvent::Removed { id } => {
                moved.0.remove(id);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

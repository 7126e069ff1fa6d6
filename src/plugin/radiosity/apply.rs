use std::time::Instant;

use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::assets::{Copies, mesh_version};
use super::components::{BakedLighting, InEffect};
use super::drive::Bakery;
use super::job::NewLight;
use super::settings::RadiositySettings;
use crate::plugin::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT};

type Lit<'w, 's> = Query<
    'w,
    's,
    (
        &'static InEffect,
        &'static mut Mesh3d,
        Option<&'static mut BakedLighting>,
    ),
>;

/// Meshes that were written since Bevy last told of changes: what it then tells of them is no edit.
#[derive(Resource, Default)]
pub(super) struct OwnWrites(HashSet<AssetId<Mesh>>);

/// Puts new light into meshes, as many as the frame's budget allows.
pub(super) fn apply(
    mut commands: Commands,
    mut bakery: ResMut<Bakery>,
    settings: Res<RadiositySettings>,
    copies: Res<Copies>,
    mut own: ResMut<OwnWrites>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut entities: Lit,
) {
    let since = Instant::now();
    while let Some(light) = bakery.to_apply.pop_front() {
        let written = put(light, &mut commands, &copies, &mut meshes, &mut entities);
        own.0.extend(written);
        if since.elapsed() > settings.apply_budget {
            break;
        }
    }
}

/// Gives one entity its light, if it is still there, static and of the same mesh; returns the mesh
/// that was written over.
fn put(
    light: NewLight,
    commands: &mut Commands,
    copies: &Copies,
    meshes: &mut Assets<Mesh>,
    entities: &mut Lit,
) -> Option<AssetId<Mesh>> {
    let (effect, mut mesh, baked) = entities.get_mut(light.entity).ok()?;
    let source = match &baked {
        Some(baked) if baked.lit == mesh.0 => baked.source.id(),
        _ => mesh.id(),
    };
    let same = source == light.source && copies.mesh_version(source) == Some(light.source_version);
    if !effect.0.receives || !same {
        return None;
    }
    match baked {
        Some(mut baked) if baked.lit == mesh.0 => {
            // The entity holds the handle: its place in the assets cannot be gone.
            meshes.insert(baked.lit.id(), light.mesh).ok()?;
            baked.fingerprint = light.fingerprint;
            baked.source_version = light.source_version;
            baked.lit_version = light.lit_version;
            baked.refinement = light.refinement;
            Some(baked.lit.id())
        }
        _ => {
            let lit = meshes.add(light.mesh);
            let source = std::mem::replace(&mut mesh.0, lit.clone());
            commands.entity(light.entity).try_insert(BakedLighting {
                source,
                lit,
                fingerprint: light.fingerprint,
                source_version: light.source_version,
                lit_version: light.lit_version,
                refinement: light.refinement,
            });
            None
        }
    }
}

/// Shows edits of meshes at once, before their light is there.
///
/// An edited source takes the old light along if it still has as many vertices; otherwise it is shown without
/// until its own is baked. An edit of the lit copy itself makes that the new source.
pub(super) fn show_edits(
    mut changes: MessageReader<AssetEvent<Mesh>>,
    mut own: ResMut<OwnWrites>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut entities: Query<(&mut Mesh3d, &mut BakedLighting)>,
) {
    // Of two writes in one frame, one is told of for each.
    let modified: HashSet<AssetId<Mesh>> = (changes.read())
        .filter_map(|event| match event {
            AssetEvent::Modified { id } if !own.0.remove(id) => Some(*id),
            _ => None,
        })
        .collect();
    if modified.is_empty() {
        return;
    }
    for (mut shown, mut baked) in &mut entities {
        if shown.0 != baked.lit {
            continue;
        }
        if modified.contains(&baked.lit.id()) {
            adopt(&mut meshes, &mut baked);
        }
        if modified.contains(&baked.source.id()) {
            show_source(&mut meshes, &mut shown, &mut baked);
        }
    }
}

/// A mesh of the same content as the one that was lit gets its light: nothing that light depends on has changed,
/// so that no bake would bring it.
pub(super) fn keep_light(
    copies: Res<Copies>,
    mut entities: Query<(&mut Mesh3d, &mut BakedLighting)>,
) {
    for (mut shown, mut baked) in &mut entities {
        if shown.0 != baked.lit && copies.mesh_version(shown.id()) == Some(baked.source_version) {
            baked.source = std::mem::replace(&mut shown.0, baked.lit.clone());
        }
    }
}

/// Somebody else wrote to the lit copy: what it is now, less the light, is the source.
fn adopt(meshes: &mut Assets<Mesh>, baked: &mut BakedLighting) {
    let Some(edited) = meshes.get(&baked.lit) else {
        return;
    };
    let version = mesh_version(edited);
    if version == baked.lit_version {
        return;
    }
    let mut source = edited.clone();
    // Fails only if the data is gone, and then there is nothing to take out.
    let _ = source.try_remove_attribute(ATTRIBUTE_BAKED_LIGHT);
    let _ = source.try_remove_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT);
    baked.source = meshes.add(source);
    baked.source_version = version;
    baked.lit_version = version;
    baked.refinement = None;
}

fn show_source(meshes: &mut Assets<Mesh>, shown: &mut Mesh3d, baked: &mut BakedLighting) {
    let (Some(source), Some(lit)) = (meshes.get(&baked.source), meshes.get(&baked.lit)) else {
        return;
    };
    let version = mesh_version(source);
    if version == baked.source_version {
        return;
    }
    let light = lit.try_attribute(ATTRIBUTE_BAKED_LIGHT).ok().cloned();
    let gradient = lit.try_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT).ok();
    let gradient = gradient.cloned();
    match light {
        Some(light) if light.len() == source.count_vertices() => {
            let mut copy = source.clone();
            copy.insert_attribute(ATTRIBUTE_BAKED_LIGHT, light);
            if let Some(gradient) = gradient {
                copy.insert_attribute(ATTRIBUTE_BAKED_LIGHT_GRADIENT, gradient);
            }
            if meshes.insert(baked.lit.id(), copy).is_ok() {
                baked.lit_version = version;
                baked.source_version = version;
                baked.refinement = None;
            }
        }
        _ => shown.0 = baked.source.clone(),
    }
}

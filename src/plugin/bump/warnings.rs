use std::collections::HashSet;

use bevy::asset::{AssetLoadFailedEvent, LoadState};
use bevy::mesh::UvChannel;
use bevy::prelude::*;
use thiserror::Error;

use super::{Bump, HeightImage};
use crate::plugin::FrescoMaterial;

/// Why a bump cannot be seen.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Error)]
pub enum BumpProblem {
    /// The mesh lacks the texture coordinates that the map lies on.
    #[error(
        "its mesh has no {0}: give it texture coordinates, or choose the other set by `uv_channel`"
    )]
    NoUvs(&'static str),
    /// The mesh has no normals to perturb.
    #[error("its mesh has no normals: `compute_normals()` makes some")]
    NoNormals,
    /// The map cannot be loaded.
    #[error("its height map could not be loaded: {0}")]
    NotLoaded(String),
    /// Nobody has the map, or loads it.
    #[error("its height map does not exist: keep the handle that `load` or `add` gave")]
    NoMap,
    /// All heights of the map are the same.
    #[error("its height map is as high everywhere")]
    Constant,
}

/// What was told already.
#[derive(Resource, Debug, Default)]
struct Told(HashSet<(Entity, BumpProblem)>);

pub(super) fn plugin(app: &mut App) {
    let has_assets =
        resource_exists::<Assets<Mesh>>.and_then(resource_exists::<Assets<FrescoMaterial>>);
    app.init_resource::<Told>()
        .add_systems(PostUpdate, warn.run_if(has_assets));
}

/// Entities are looked at when they, their meshes, materials or maps change.
fn warn(
    mut told: ResMut<Told>,
    entities: Query<(
        Entity,
        Option<&Name>,
        Ref<Mesh3d>,
        Ref<MeshMaterial3d<FrescoMaterial>>,
    )>,
    mut changed_meshes: MessageReader<AssetEvent<Mesh>>,
    mut changed_materials: MessageReader<AssetEvent<FrescoMaterial>>,
    mut changed_maps: MessageReader<AssetEvent<HeightImage>>,
    mut failed_maps: MessageReader<AssetLoadFailedEvent<HeightImage>>,
    (meshes, materials, maps): (
        Res<Assets<Mesh>>,
        Res<Assets<FrescoMaterial>>,
        Res<Assets<HeightImage>>,
    ),
    server: Res<AssetServer>,
) {
    let assets_changed = changed_meshes.read().count()
        + changed_materials.read().count()
        + changed_maps.read().count()
        + failed_maps.read().count()
        > 0;
    for (entity, name, mesh, material) in &entities {
        if !assets_changed && !mesh.is_changed() && !material.is_changed() {
            continue;
        }
        let Some(found) = materials.get(&material.0) else {
            continue;
        };
        let extension = &found.extension;
        for bump in [&extension.bump, &extension.detail].into_iter().flatten() {
            let problem = problem(bump, meshes.get(&mesh.0), &maps, &server);
            if let Some(problem) = problem
                && told.0.insert((entity, problem.clone()))
            {
                let name = name.map_or_else(|| entity.to_string(), |n| format!("{n} ({entity})"));
                let material = material
                    .0
                    .path()
                    .map_or_else(|| material.0.id().to_string(), ToString::to_string);
                warn!("{name}, material {material}, is drawn without relief: {problem}");
            }
        }
    }
}

/// What stands against a bump on a mesh; nothing while something is still loading.
fn problem(
    bump: &Bump,
    mesh: Option<&Mesh>,
    maps: &Assets<HeightImage>,
    server: &AssetServer,
) -> Option<BumpProblem> {
    let Some(map) = maps.get(&bump.map) else {
        return match server.get_load_state(&bump.map) {
            Some(LoadState::Failed(error)) => Some(BumpProblem::NotLoaded(error.to_string())),
            Some(_) => None,
            None => Some(BumpProblem::NoMap),
        };
    };
    if map.pyramid().steepest() == 0.0 {
        return Some(BumpProblem::Constant);
    }
    // Vertices that only the renderer has cannot be looked at.
    let lacks = |attribute| mesh?.try_contains_attribute(attribute).ok().map(|has| !has);
    let (uvs, name) = match bump.uv_channel {
        UvChannel::Uv0 => (Mesh::ATTRIBUTE_UV_0, "UV_0"),
        UvChannel::Uv1 => (Mesh::ATTRIBUTE_UV_1, "UV_1"),
    };
    if lacks(uvs) == Some(true) {
        return Some(BumpProblem::NoUvs(name));
    }
    (lacks(Mesh::ATTRIBUTE_NORMAL) == Some(true)).then_some(BumpProblem::NoNormals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_map::{HeightMap, Wrap};

    fn map(heights: &[f32]) -> HeightImage {
        let size = [heights.len() as u32, 1];
        HeightImage::new(HeightMap::new(size, heights.to_vec(), [Wrap::Repeat; 2]).unwrap())
    }

    #[test]
    fn what_is_missing_has_a_name() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default()))
            .init_asset::<HeightImage>();
        let world = app.world_mut();
        let mut maps = world.resource_mut::<Assets<HeightImage>>();
        let good = Bump::new(maps.add(map(&[0.0, 1.0, 0.3])), Default::default());
        let flat = Bump::new(maps.add(map(&[0.4; 3])), Default::default());
        let single = Bump::new(maps.add(map(&[0.4])), Default::default());
        let nowhere = Bump::default();
        let second = Bump {
            uv_channel: UvChannel::Uv1,
            ..good.clone()
        };
        let ball = Mesh::from(Sphere::new(1.0));
        let mut bare = ball.clone();
        bare.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
        let maps = world.resource::<Assets<HeightImage>>();
        let server = world.resource::<AssetServer>();
        let problem = |bump: &Bump, mesh: &Mesh| problem(bump, Some(mesh), maps, server);
        assert_eq!(problem(&good, &ball), None);
        assert_eq!(problem(&flat, &ball), Some(BumpProblem::Constant));
        assert_eq!(problem(&single, &ball), Some(BumpProblem::Constant));
        assert_eq!(problem(&nowhere, &ball), Some(BumpProblem::NoMap));
        assert_eq!(problem(&second, &ball), Some(BumpProblem::NoUvs("UV_1")));
        assert_eq!(problem(&good, &bare), Some(BumpProblem::NoNormals));
    }
}

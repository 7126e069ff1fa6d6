//! What is to be made, and whether it is another than before.

use std::hash::{BuildHasher, Hash, Hasher};
use std::sync::Arc;

use bevy::asset::{AssetServer, LoadState, UntypedAssetId};
use bevy::ecs::system::SystemParam;
use bevy::mesh::UvChannel;
use bevy::platform::collections::HashMap;
use bevy::platform::hash::FixedHasher;
use bevy::prelude::*;

use super::{Displacement, DisplacementProblem, MeshProblem};
use crate::displacement::{Direction, DisplacementSettings, Spacing, Tessellation};
use crate::height_map::HeightMap;
use crate::plugin::bump::HeightImage;
use crate::plugin::radiosity::assets::mesh_version;
use crate::plugin::radiosity::mesh_data;

/// What is to be made of what.
#[derive(Clone)]
pub(super) struct Order {
    pub(super) source: Handle<Mesh>,
    /// Held, so that no other map comes to lie where it lay: the key tells maps by their place.
    pub(super) map: Arc<HeightMap>,
    pub(super) displacement: Displacement,
    /// Tells this order from others.
    pub(super) key: u64,
}

/// Why there is no order.
pub(super) enum Obstacle {
    /// Something is being loaded.
    Loading,
    Problem(DisplacementProblem),
}

impl<P: Into<DisplacementProblem>> From<P> for Obstacle {
    fn from(problem: P) -> Self {
        Self::Problem(problem.into())
    }
}

/// Hashes of the content of source meshes, those that were asked for since they last changed.
#[derive(Resource, Default)]
pub(super) struct MeshVersions(HashMap<AssetId<Mesh>, Result<u64, MeshProblem>>);

impl MeshVersions {
    /// Forgets meshes that changed.
    pub(super) fn follow(mut versions: ResMut<Self>, mut events: MessageReader<AssetEvent<Mesh>>) {
        for event in events.read() {
            if let AssetEvent::Added { id }
            | AssetEvent::Modified { id }
            | AssetEvent::Removed { id } = event
            {
                versions.0.remove(id);
            }
        }
    }
}

/// Where orders come from.
#[derive(SystemParam)]
pub(super) struct Sources<'w> {
    versions: ResMut<'w, MeshVersions>,
    pub(super) meshes: Res<'w, Assets<Mesh>>,
    maps: Res<'w, Assets<HeightImage>>,
    server: Res<'w, AssetServer>,
}

impl Sources<'_> {
    /// What a displacement asks to be made of a mesh.
    pub(super) fn order(
        &mut self,
        source: &Handle<Mesh>,
        displacement: &Displacement,
    ) -> Result<Order, Obstacle> {
        let Some(map) = self.maps.get(&displacement.map) else {
            return Err(self.absent(
                displacement.map.id().untyped(),
                DisplacementProblem::NoMap,
                DisplacementProblem::MapNotLoaded,
            ));
        };
        let Some(mesh) = self.meshes.get(source) else {
            return Err(self.absent(
                source.id().untyped(),
                DisplacementProblem::NoMesh,
                DisplacementProblem::MeshNotLoaded,
            ));
        };
        let known = self.versions.0.entry(source.id());
        let looked_at = || mesh_data::check(mesh).map(|()| mesh_version(mesh));
        let version = (*known.or_insert_with(looked_at))?;
        let map = map.shared_map().clone();
        let mut state = FixedHasher.build_hasher();
        (source.id(), version, Arc::as_ptr(&map)).hash(&mut state);
        hash_displacement(&mut state, displacement);
        Ok(Order {
            source: source.clone(),
            map,
            displacement: displacement.clone(),
            key: state.finish(),
        })
    }

    fn absent(
        &self,
        id: UntypedAssetId,
        missing: DisplacementProblem,
        failed: impl FnOnce(String) -> DisplacementProblem,
    ) -> Obstacle {
        match self.server.get_load_state(id) {
            Some(LoadState::NotLoaded | LoadState::Loading) => Obstacle::Loading,
            Some(LoadState::Failed(error)) => failed(error.to_string()).into(),
            Some(LoadState::Loaded) | None => missing.into(),
        }
    }
}

/// The map is told by itself, not by its handle. By bits, so that what is no number equals itself.
fn hash_displacement(state: &mut impl Hasher, displacement: &Displacement) {
    let Displacement {
        map: _,
        settings,
        uv_channel,
        uv_transform,
    } = displacement;
    hash_settings(state, settings);
    (*uv_channel == UvChannel::Uv1).hash(state);
    hash_floats(state, &uv_transform.to_cols_array());
}

fn hash_settings(state: &mut impl Hasher, settings: &DisplacementSettings) {
    // Named one by one: a setting that is new has to be put here.
    let DisplacementSettings {
        scale,
        mid_level,
        kernel,
        direction,
        tessellation,
        max_triangles,
        max_bytes,
        crease_angle,
        clamp_folds,
    } = *settings;
    hash_floats(state, &[scale, mid_level, crease_angle]);
    std::mem::discriminant(&kernel).hash(state);
    (direction == Direction::FaceNormal, clamp_folds).hash(state);
    (max_triangles, max_bytes).hash(state);
    let (kind, number) = match tessellation {
        Tessellation::Base => (0, 0.0),
        Tessellation::Uniform(Spacing::Texels(texels)) => (1, texels),
        Tessellation::Uniform(Spacing::Metres(metres)) => (2, metres),
        Tessellation::Adaptive { tolerance } => (3, tolerance),
    };
    state.write_u8(kind);
    hash_floats(state, &[number]);
}

fn hash_floats(state: &mut impl Hasher, values: &[f32]) {
    for value in values {
        state.write_u32(value.to_bits());
    }
}

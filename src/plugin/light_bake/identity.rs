use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::plugin::radiosity::mesh_data::MeshData;

/// What an entity is called in a [`LightBake`](super::LightBake), where names do not tell entities apart.
///
/// Any text that no other entity below the same root has.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq, Hash)]
#[reflect(Component, Debug, Clone, PartialEq, Hash)]
pub struct LightBakeId(pub String);

/// How a mesh is found again.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct Identity {
    pub(super) called: Called,
    pub(super) mesh: MeshIdentity,
}

/// How an entity is called.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) enum Called {
    /// By its [`LightBakeId`].
    Id(String),
    /// By names from below the root down to its own, with `/` between them.
    Path(String),
}

impl std::fmt::Display for Called {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Id(id) => write!(f, "the entity with the LightBakeId \"{id}\""),
            Self::Path(path) => write!(f, "the entity \"{path}\""),
        }
    }
}

/// What a mesh looks like to the bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct MeshIdentity {
    pub(super) vertices: u32,
    pub(super) triangles: u32,
    /// CRC-32 of positions and corners.
    pub(super) content: u32,
}

impl MeshIdentity {
    pub(super) fn of(mesh: &MeshData) -> Self {
        let mut content = crc32fast::Hasher::new();
        for position in &mesh.positions {
            for value in position.to_array() {
                content.update(&value.to_le_bytes());
            }
        }
        for corner in mesh.triangles.iter().flatten() {
            content.update(&corner.to_le_bytes());
        }
        Self {
            vertices: mesh.positions.len() as u32,
            triangles: mesh.triangles.len() as u32,
            content: content.finalize(),
        }
    }
}

/// How an entity below `root` is called.
pub(super) fn called(
    entity: Entity,
    root: Entity,
    (ids, names): (&Query<&LightBakeId>, &Query<&Name>),
    parents: &Query<&ChildOf>,
) -> Called {
    if let Ok(LightBakeId(id)) = ids.get(entity) {
        return Called::Id(id.clone());
    }
    let mut path: Vec<&str> = std::iter::once(entity)
        .chain(parents.iter_ancestors(entity))
        .take_while(|&above| above != root)
        .map(|entity| names.get(entity).map_or("", Name::as_str))
        .collect();
    path.reverse();
    Called::Path(path.join("/"))
}

use std::sync::Arc;

use bevy::prelude::*;
use thiserror::Error;

use super::MeshProblem;
use crate::displacement::{DisplacementError, DisplacementReport};

/// What becomes of a [`Displacement`](super::Displacement).
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(opaque)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum DisplacementStatus {
    /// It was not looked at yet, or has no mesh.
    #[default]
    Idle,
    /// The mesh or the map is being loaded.
    Loading,
    /// The raised mesh is being made; the one before is shown.
    Working {
        /// What is being done.
        stage: &'static str,
        /// How much of that is done, 0 to 1.
        done: f32,
    },
    /// The raised mesh is shown.
    Done(Arc<DisplacementReport>),
    /// There is none; what was shown before is shown still. A change of what is the matter starts anew.
    Failed(DisplacementProblem),
}

impl DisplacementStatus {
    /// Whether the mesh is about to become another.
    pub fn is_pending(&self) -> bool {
        matches!(self, Self::Loading | Self::Working { .. })
    }

    /// What was made; `None` unless it is [`Done`](Self::Done).
    pub fn report(&self) -> Option<&DisplacementReport> {
        match self {
            Self::Done(report) => Some(report),
            _ => None,
        }
    }

    /// Why there is nothing; `None` unless it has [`Failed`](Self::Failed).
    pub fn problem(&self) -> Option<&DisplacementProblem> {
        match self {
            Self::Failed(problem) => Some(problem),
            _ => None,
        }
    }
}

/// Why a mesh is not raised.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DisplacementProblem {
    /// The map cannot be loaded.
    #[error("its height map could not be loaded: {0}")]
    MapNotLoaded(String),
    /// Nobody has the map, or loads it.
    #[error("its height map does not exist: keep the handle that `load` or `add` gave")]
    NoMap,
    /// The mesh cannot be loaded.
    #[error("its mesh could not be loaded: {0}")]
    MeshNotLoaded(String),
    /// Nobody has the mesh, or loads it.
    #[error("its mesh does not exist: keep the handle that `load` or `add` gave")]
    NoMesh,
    /// The mesh cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshProblem),
    /// The mesh lacks the texture coordinates that the map lies on.
    #[error(
        "its mesh has no {0}: give it texture coordinates, or choose the other set by `uv_channel`"
    )]
    NoUvs(&'static str),
    /// The mesh has no normals to tell which way is out.
    #[error("its mesh has no normals: `compute_normals()` makes some")]
    NoNormals,
    /// The mesh changes its shape by morph targets, which belong to its own vertices.
    #[error("its mesh has morph targets, which do not fit the vertices of another")]
    Morphed,
    /// A setting is outside its limits, or the mesh is broken.
    #[error(transparent)]
    Displacement(#[from] DisplacementError),
    /// The work broke off.
    #[error("the work panicked: this is a bug in bevy_fresco")]
    Panicked,
}

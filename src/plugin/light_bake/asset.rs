use std::io;
use std::path::Path;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::identity::Identity;
use crate::file;
use crate::mesh::{RefinedMesh, SurfacePoint};

/// What a file begins with: its kind, and the version of what follows.
const HEAD: &[u8; 16] = b"fresco light \0\0\x01";

/// The light of some meshes, to be put onto the same meshes in another run: see [`LitBy`](super::LitBy).
///
/// Its files are called `.light_bake`. They hold, little-endian, 16 bytes that tell the kind and the version, and
/// then what this type does in the format of [`postcard`](https://postcard.jamesmunns.com): for each mesh how it is
/// found again, where it was split, and irradiance / π at each vertex, linear RGB in cd/m².
#[derive(Asset, TypePath, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightBake {
    pub(super) objects: Vec<BakedObject>,
}

/// The light of one mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct BakedObject {
    pub(super) identity: Identity,
    /// Where the mesh was split, if it was.
    refinement: Option<Refinement>,
    pub(super) light: Vec<[f32; 3]>,
    /// In the space of the mesh; empty if it was not asked for.
    pub(super) gradient: Vec<[f32; 3]>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Refinement {
    /// Source triangle and barycentrics of each vertex.
    vertices: Vec<(u32, [f32; 3])>,
    triangles: Vec<[u32; 3]>,
    sources: Vec<u32>,
}

/// Why a file is no [`LightBake`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnreadableLightBake {
    /// It cannot be read at all.
    #[error("the file cannot be read: {0}")]
    Io(#[from] io::Error),
    /// It is something else, or of a later version.
    #[error("the file is no light_bake of this version of bevy_fresco: bake and save it again")]
    Kind,
    /// It ends early or its content is damaged.
    #[error("the file is damaged ({0}): bake and save it again")]
    Damaged(String),
}

impl LightBake {
    /// How many meshes have light in it.
    pub fn len(&self) -> usize {
        self.objects.len()
    }

    /// Whether no mesh has light in it.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    /// The content of a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = HEAD.to_vec();
        // Only types that have no length, or a writer that fails, are errors of it.
        bytes.extend(postcard::to_stdvec(self).expect("plain data can be written to memory"));
        bytes
    }

    /// What a file holds.
    ///
    /// # Errors
    ///
    /// The bytes are something else, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, UnreadableLightBake> {
        let content = bytes.strip_prefix(HEAD).ok_or(UnreadableLightBake::Kind)?;
        let damaged = |problem: &str| UnreadableLightBake::Damaged(problem.to_owned());
        let (bake, rest): (Self, _) =
            postcard::take_from_bytes(content).map_err(|e| damaged(&e.to_string()))?;
        if !rest.is_empty() {
            return Err(damaged("it goes on after its end"));
        }
        match bake.objects.iter().find_map(BakedObject::problem) {
            Some(problem) => Err(damaged(problem)),
            None => Ok(bake),
        }
    }

    /// Writes a file as a whole, or leaves what is there as it was.
    ///
    /// # Errors
    ///
    /// The folder cannot be written to.
    pub fn write(&self, path: impl AsRef<Path>) -> io::Result<()> {
        file::write(path.as_ref(), &self.to_bytes())
    }
}

impl BakedObject {
    pub(super) fn new(
        identity: Identity,
        refinement: Option<&RefinedMesh>,
        light: Vec<[f32; 3]>,
        gradient: Vec<[f32; 3]>,
    ) -> Self {
        let vertex = |v: &SurfacePoint| (v.triangle, v.barycentrics.to_array());
        Self {
            identity,
            refinement: refinement.map(|mesh| Refinement {
                vertices: mesh.vertices.iter().map(vertex).collect(),
                triangles: mesh.triangles.clone(),
                sources: mesh.sources.clone(),
            }),
            light,
            gradient,
        }
    }

    /// Where the mesh was split, if it was.
    pub(super) fn refinement(&self) -> Option<RefinedMesh> {
        let Refinement {
            vertices,
            triangles,
            sources,
        } = self.refinement.as_ref()?;
        let vertex = |&(triangle, barycentrics): &(u32, [f32; 3])| SurfacePoint {
            triangle,
            barycentrics: barycentrics.into(),
        };
        Some(RefinedMesh {
            vertices: vertices.iter().map(vertex).collect(),
            triangles: triangles.clone(),
            sources: sources.clone(),
        })
    }

    /// What is wrong within it.
    fn problem(&self) -> Option<&'static str> {
        let count = self.light.len();
        let all_finite = |values: &[[f32; 3]]| values.iter().flatten().all(|v| v.is_finite());
        if !all_finite(&self.light) || !all_finite(&self.gradient) {
            return Some("light is no number");
        }
        if !self.gradient.is_empty() && self.gradient.len() != count {
            return Some("not every vertex has a gradient");
        }
        let refinement = self.refinement.as_ref()?;
        let triangles = self.identity.mesh.triangles;
        if refinement.vertices.len() != count {
            return Some("not every vertex has light");
        }
        let on_mesh = |v: &(u32, [f32; 3])| v.0 < triangles && all_finite(&[v.1]);
        if !refinement.vertices.iter().all(on_mesh) {
            return Some("a vertex lies on no triangle");
        }
        let corners = refinement.triangles.iter().flatten();
        if { corners }.any(|&corner| corner as usize >= count) {
            return Some("a triangle has no corner");
        }
        (refinement.sources.len() != refinement.triangles.len())
            .then_some("a triangle is cut out of none")
    }
}

/// Loads [`LightBake`]s.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct LightBakeLoader;

impl AssetLoader for LightBakeLoader {
    type Asset = LightBake;
    type Settings = ();
    type Error = UnreadableLightBake;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        _: &mut LoadContext<'_>,
    ) -> Result<LightBake, UnreadableLightBake> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        LightBake::from_bytes(&bytes)
    }

    fn extensions(&self) -> &[&str] {
        &["light_bake"]
    }
}

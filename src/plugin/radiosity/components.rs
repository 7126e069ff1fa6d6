use std::sync::Arc;

use bevy::prelude::*;

use crate::mesh::RefinedMesh;
use crate::plugin::FrescoMaterial;

/// Marks an entity, and all its descendants, as part of the baked scene.
///
/// Put it on a mesh, on the root of a loaded glTF scene or on a level's parent entity. Descendants
/// inherit it, also those that are spawned later; one of their own takes its place for their part of
/// the tree, and [`NoStaticLighting`] takes entities out.
///
/// Meshes with `MeshMaterial3d<StandardMaterial>` that receive light are moved to
/// [`FrescoMaterial`], which shows it; queries for
/// `MeshMaterial3d<StandardMaterial>` do not find them any more. [`OriginalMaterial`] keeps the handle,
/// changes of that material are followed, and it is put back when the entity stops being static.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Debug, Clone, PartialEq, Hash)]
pub struct StaticLighting {
    /// Stops light. What does not is invisible to light: it also reflects and emits none.
    pub casts: bool,
    /// Gets vertex light, and so a mesh of its own.
    pub receives: bool,
    /// Reflects light onto others. What does not is black to them; it still emits.
    pub reflects: bool,
    /// May get more vertices where its light needs them, if
    /// [`BakeSettings::refine`](crate::radiosity::BakeSettings::refine) says so for the scene.
    pub refine: bool,
}

impl Default for StaticLighting {
    /// Casts, receives and reflects, with vertices where the light needs them.
    fn default() -> Self {
        Self {
            casts: true,
            receives: true,
            reflects: true,
            refine: true,
        }
    }
}

/// Takes an entity and its descendants out of the [`StaticLighting`] that they would inherit.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct NoStaticLighting;

/// What is baked of a point, spot, directional or rectangular light.
///
/// Lights without this component follow Bevy's own switch, `affects_lightmapped_mesh_diffuse`: where
/// it is false the light is taken as [`Full`](Self::Full), else as [`Indirect`](Self::Indirect).
/// With it, the switch is set to match.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Debug, Clone, PartialEq, Hash)]
pub enum LightBaking {
    /// Bevy renders the direct light and its shadows in real time; what bounces is baked.
    #[default]
    Indirect,
    /// Direct and bounced light are baked. Lit surfaces keep the light's realtime specular
    /// reflection; entities that are not static are lit in real time.
    ///
    /// Rectangular lights cannot do this in Bevy: they are taken as [`Indirect`](Self::Indirect).
    Full,
    /// The bake does not see the light.
    Excluded,
}

/// The handle that an entity's material had before it was moved to
/// [`FrescoMaterial`]. Change the asset behind it: the move follows.
#[derive(Component, Reflect, Clone, Debug)]
#[reflect(Component, Debug, Clone)]
pub struct OriginalMaterial {
    /// The material as it was.
    pub handle: Handle<StandardMaterial>,
    /// What stands in for it. Another `MeshMaterial3d<FrescoMaterial>` on the entity is somebody's
    /// own and left alone.
    pub moved_to: AssetId<FrescoMaterial>,
}

/// On entities whose mesh carries baked light.
///
/// `Mesh3d` of such an entity is a copy of its own with
/// [`ATTRIBUTE_BAKED_LIGHT`](crate::plugin::ATTRIBUTE_BAKED_LIGHT). To give it another mesh, set
/// `Mesh3d`; to edit it, edit the source. The source is put back when the entity stops being static.
///
/// A clone of the entity does not get this component: it starts anew, with the copy as its source.
#[derive(Component, Reflect, Clone, Debug)]
#[component(clone_behavior = Ignore)]
#[reflect(Component, Debug, Clone)]
pub struct BakedLighting {
    /// The mesh as it was, without light.
    pub source: Handle<Mesh>,
    /// The copy with light.
    pub lit: Handle<Mesh>,
    /// Where the source was split for it, if it was.
    #[reflect(ignore)]
    pub(in crate::plugin) refinement: Option<Arc<RefinedMesh>>,
    /// Tells the light of one bake from that of another.
    pub(super) fingerprint: u64,
    /// The version of the source that the copy was made of.
    pub(super) source_version: u64,
    /// The version of the copy, its light apart.
    pub(super) lit_version: u64,
}

/// On static entities that take no part in the bake, with the reason.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Eq)]
#[reflect(Component, Debug, Clone, PartialEq)]
pub struct NotBaked {
    /// One sentence that names the cause and the cure.
    pub reason: String,
}

/// The [`StaticLighting`] in effect on a mesh, its own or inherited.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct InEffect(pub(super) StaticLighting);

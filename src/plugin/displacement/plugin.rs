use bevy::asset::AssetEventSystems;
use bevy::prelude::*;

use super::drive;
use super::order::MeshVersions;
use super::{DisplacedMesh, Displacement, DisplacementStatus};
use crate::plugin::FrescoMaterialPlugin;
use crate::plugin::radiosity::RadiositySystems;

/// Raises the meshes of entities with a [`Displacement`], and again when something changes.
///
/// Needs Bevy's `AssetPlugin` and `MeshPlugin`; nothing has to be drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct DisplacementPlugin;

/// When the plugin works.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DisplacementSystems {
    /// In `PreUpdate`, before new light: meshes that are finished are swapped in. Bevy computes their bounds in
    /// the same frame.
    Apply,
    /// In `PostUpdate`, after asset events and before baked light looks at meshes: changes are noticed and work
    /// is started.
    Watch,
}

impl Plugin for DisplacementPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FrescoMaterialPlugin>() {
            app.add_plugins(FrescoMaterialPlugin);
        }
        let has_meshes = resource_exists::<Assets<Mesh>>;
        app.register_type::<Displacement>()
            .register_type::<DisplacedMesh>()
            .register_type::<DisplacementStatus>()
            .init_resource::<MeshVersions>()
            .add_observer(drive::restore)
            .add_systems(
                PreUpdate,
                drive::apply
                    .in_set(DisplacementSystems::Apply)
                    .before(RadiositySystems::Apply)
                    .run_if(has_meshes),
            )
            .add_systems(
                PostUpdate,
                (MeshVersions::follow, drive::watch)
                    .chain()
                    .in_set(DisplacementSystems::Watch)
                    .after(AssetEventSystems)
                    .before(RadiositySystems::Watch)
                    .run_if(has_meshes),
            );
    }
}

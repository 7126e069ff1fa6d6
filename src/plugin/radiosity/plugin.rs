use bevy::asset::AssetEventSystems;
use bevy::camera::visibility::{VisibilityPlugin, VisibilitySystems};
use bevy::prelude::*;
use bevy::transform::TransformSystems;

use super::assets::Copies;
use super::components::{
    BakedLighting, LightBaking, NoStaticLighting, NotBaked, OriginalMaterial, StaticLighting,
};
use super::drive::Bakery;
use super::gizmos::RadiosityGizmos;
use super::settings::RadiositySettings;
use super::status::{
    BakeFailed, BakeFinished, BakeStarted, BakeState, CancelBake, RadiosityStatus, Rebake,
};
use super::survey::VisibilityRule;
use super::{apply, diagnostics, drive, gizmos, inherit, material};
use crate::plugin::FrescoMaterialPlugin;

/// Bakes the light of [`StaticLighting`] entities, and again when something changes.
///
/// Needs Bevy's `AssetPlugin`, `MeshPlugin` and `TransformPlugin`; without a renderer the light is baked all
/// the same and lies in the meshes.
#[derive(Clone, Debug, Default)]
pub struct RadiosityPlugin {
    /// What [`RadiositySettings`] starts with, unless the application has inserted one before.
    pub settings: RadiositySettings,
}

/// When the plugin works.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RadiositySystems {
    /// In `PreUpdate`: light of a finished bake is put into meshes.
    Apply,
    /// In `PostUpdate`, after transforms, visibility and asset events: changes are noticed and bakes started.
    Watch,
}

impl Plugin for RadiosityPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<FrescoMaterialPlugin>() {
            app.add_plugins(FrescoMaterialPlugin);
        }
        if !app.world().contains_resource::<RadiositySettings>() {
            app.insert_resource(self.settings.clone());
        }
        app.register_type::<StaticLighting>()
            .register_type::<NoStaticLighting>()
            .register_type::<LightBaking>()
            .register_type::<OriginalMaterial>()
            .register_type::<BakedLighting>()
            .register_type::<NotBaked>()
            .register_type::<RadiositySettings>()
            .register_type::<RadiosityStatus>()
            .register_type::<BakeState>()
            .register_type::<BakeStarted>()
            .register_type::<BakeFinished>()
            .register_type::<BakeFailed>()
            .register_type::<Rebake>()
            .register_type::<CancelBake>()
            .register_type::<RadiosityGizmos>()
            .init_resource::<RadiosityGizmos>()
            .init_resource::<RadiosityStatus>()
            .init_resource::<Bakery>()
            .init_resource::<Copies>()
            .init_resource::<material::Moved>()
            .init_resource::<apply::OwnWrites>()
            .insert_resource(VisibilityRule::Own)
            .add_message::<BakeStarted>()
            .add_message::<BakeFinished>()
            .add_message::<BakeFailed>()
            .add_observer(drive::rebake)
            .add_observer(drive::cancel);
        diagnostics::register(app);
        let wanted = resource_exists::<RadiositySettings>;
        app.add_systems(
            PreUpdate,
            (
                diagnostics::start_clock,
                drive::collect,
                apply::apply,
                drive::finish,
                diagnostics::stop_clock,
            )
                .chain()
                .in_set(RadiositySystems::Apply)
                .run_if(wanted),
        )
        .add_systems(
            PostUpdate,
            (
                diagnostics::start_clock,
                inherit::inherit,
                inherit::restore,
                material::move_materials,
                material::follow_originals,
                drive::switch_lights,
                apply::show_edits,
                Copies::follow,
                apply::keep_light,
                drive::watch,
                diagnostics::stop_clock,
                diagnostics::read_clock,
            )
                .chain()
                .in_set(RadiositySystems::Watch)
                .after(TransformSystems::Propagate)
                .after(VisibilitySystems::VisibilityPropagate)
                .after(AssetEventSystems)
                .run_if(wanted),
        )
        .add_systems(
            Update,
            gizmos::draw.run_if(wanted.and_then(resource_exists::<RadiosityGizmos>)),
        )
        .add_systems(
            Update,
            gizmos::clear.run_if(not(resource_exists::<RadiosityGizmos>)),
        )
        .add_systems(PostUpdate, drive::stop.run_if(not(wanted)));
    }

    fn finish(&self, app: &mut App) {
        if app.is_plugin_added::<VisibilityPlugin>() {
            app.insert_resource(VisibilityRule::Inherited);
        }
    }
}

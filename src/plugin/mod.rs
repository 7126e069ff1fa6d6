//! Everything that knows Bevy.
//!
//! [`FrescoPlugins`] is all of it; add it after `DefaultPlugins`.

mod attribute;
mod baked_scene;
mod bind_group;
pub mod bump;
pub mod displacement;
mod light_bake;
mod material;
pub mod radiosity;
mod shaders;
mod view;

use bevy::app::{PluginGroup, PluginGroupBuilder};

pub use attribute::{ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT};
pub use baked_scene::{BakedScene, BakedScenePlugin};
pub use displacement::DisplacementPlugin;
pub use light_bake::{
    LightBake, LightBakeError, LightBakeId, LightBakeLoader, LitBy, LitByStatus,
    UnreadableLightBake,
};
pub use material::{FrescoExtension, FrescoKey, FrescoMaterial, FrescoMaterialPlugin};
pub use radiosity::RadiosityPlugin;
pub use view::FrescoView;
#[doc(hidden)]
pub use view::ShownInstead;

/// All plugins of this crate.
///
/// | plugin | what it gives |
/// |---|---|
/// | [`FrescoMaterialPlugin`] | the material that shows relief and baked light |
/// | [`BakedScenePlugin`] | light that was baked before, loaded with meshes ([`BakedScene`]) or beside them ([`LitBy`]) |
/// | [`DisplacementPlugin`] | meshes raised by height maps |
/// | [`RadiosityPlugin`] | light baked in the running world |
#[derive(Clone, Copy, Debug, Default)]
pub struct FrescoPlugins;

impl PluginGroup for FrescoPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(FrescoMaterialPlugin)
            .add(BakedScenePlugin)
            .add(DisplacementPlugin)
            .add(RadiosityPlugin::default())
    }
}

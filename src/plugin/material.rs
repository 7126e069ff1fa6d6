//! stub
use bevy::pbr::{ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
/// stub
pub type FrescoMaterial = ExtendedMaterial<StandardMaterial, FrescoExtension>;
/// stub
#[derive(Asset, AsBindGroup, Reflect, Clone, Debug, Default)]
pub struct FrescoExtension {}
impl MaterialExtension for FrescoExtension {}
/// stub
#[derive(Debug)]
pub struct FrescoMaterialPlugin;
impl Plugin for FrescoMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<FrescoMaterial>();
    }
}

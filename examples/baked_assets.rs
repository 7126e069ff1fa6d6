//! Light that was baked before: a glTF file brings it in its vertices, and nothing is baked here.
//!
//! The file was made by `cargo bake assets/scenes/cornell_box.glb -o assets/scenes/cornell_box_baked.glb`.
//! `--screenshot FILE` saves a picture without a window.

mod common;

use bevy::gltf::{GltfAssetLabel, GltfPlugin};
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, BakedScene, BakedScenePlugin};

fn main() -> AppExit {
    // Bevy drops attributes that it is not told of.
    let gltf =
        GltfPlugin::default().add_custom_vertex_attribute("BAKED_LIGHT", ATTRIBUTE_BAKED_LIGHT);
    App::new()
        .add_plugins((
            common::default_plugins("Baked assets").set(gltf),
            BakedScenePlugin,
        ))
        .insert_resource(GlobalAmbientLight::NONE)
        .add_systems(Startup, setup)
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    let room = GltfAssetLabel::Scene(0).from_asset("scenes/cornell_box_baked.glb");
    let scene = BakedScene {
        // The lamp is a surface, and Bevy shows what surfaces emit without the camera's exposure.
        gain: 1.0 / bevy::camera::Exposure::default().exposure(),
        ..default()
    };
    commands.spawn((WorldAssetRoot(assets.load(room)), scene));
}

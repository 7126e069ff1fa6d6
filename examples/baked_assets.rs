//! Light that was baked before: a glTF file brings it in its vertices, or with `--light-bake` another file beside it.
//! Nothing is baked here.
//!
//! The first was made by `cargo bake assets/scenes/cornell_box.glb -o assets/scenes/cornell_box_baked.glb`, the second
//! by the example `your_scene` with `--save assets/scenes/cornell_box.light_bake`. `--screenshot FILE` saves a picture
//! without a window.

mod common;

use bevy::gltf::{GltfAssetLabel, GltfPlugin};
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, BakedScene, BakedScenePlugin, LitBy};

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
    let room = |file| WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset(file)));
    if std::env::args().any(|argument| argument == "--light-bake") {
        // Light that was baked in Bevy is in Bevy's units.
        let light = assets.load("scenes/cornell_box.light_bake");
        commands.spawn((room("scenes/cornell_box.glb"), LitBy(light)));
    } else {
        let scene = BakedScene {
            // The lamp is a surface, and Bevy shows what surfaces emit without the camera's exposure.
            gain: 1.0 / bevy::camera::Exposure::default().exposure(),
            ..default()
        };
        commands.spawn((room("scenes/cornell_box_baked.glb"), scene));
    }
}

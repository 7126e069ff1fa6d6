//! The least there is to do: a glTF file lit by its own bounced light. `--screenshot FILE` saves a picture without a
//! window.

mod common;

use bevy::gltf::GltfAssetLabel;
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;
use bevy_fresco::plugin::{FrescoPlugins, radiosity::StaticLighting};

fn main() -> AppExit {
    App::new()
        // `DefaultPlugins`, with a title.
        .add_plugins((common::default_plugins("Minimal"), FrescoPlugins))
        .add_systems(Startup, setup)
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    // The file brings its lamp and its camera.
    let room = assets.load(GltfAssetLabel::Scene(0).from_asset("scenes/cornell_box.glb"));
    commands.spawn((WorldAssetRoot(room), StaticLighting::default()));
}

//! Any glTF file, lit by its own lights and what bounces, with the panel to change them:
//! `cargo run --features examples,panel --example your_scene -- FILE.glb`.
//!
//! Drag with the left button to turn, with the right one to move, roll the wheel to come nearer; F1 hides the panel.
//! `--screenshot FILE` saves a picture without a window.

#![expect(
    clippy::print_stderr,
    reason = "it says what is wrong with its arguments"
)]

mod common;

use std::path::PathBuf;

use bevy::asset::AssetPlugin;
use bevy::camera::primitives::Aabb;
use bevy::gltf::GltfAssetLabel;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::math::Vec3A;
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;
use bevy_egui::input::egui_wants_any_pointer_input;
use bevy_fresco::panel::FrescoPanelPlugin;
use bevy_fresco::plugin::FrescoPlugins;
use bevy_fresco::plugin::radiosity::{BakedLighting, StaticLighting};

/// Where the camera stands: around a point.
#[derive(Component)]
struct Orbit {
    middle: Vec3,
    distance: f32,
    yaw: f32,
    pitch: f32,
}

/// The name of the file in its folder.
#[derive(Resource)]
struct File(String);

fn main() -> AppExit {
    let mut rest = std::env::args().skip(1);
    let mut file = None;
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--screenshot" => drop(rest.next()),
            _ => file = Some(PathBuf::from(argument)),
        }
    }
    let Some(file) = file else {
        eprintln!("which scene? your_scene FILE.glb");
        return AppExit::error();
    };
    let (Ok(path), Some(name)) = (file.canonicalize(), file.file_name()) else {
        eprintln!("cannot read {}", file.display());
        return AppExit::error();
    };
    let folder = path.parent().map(|folder| folder.display().to_string());
    let assets = AssetPlugin {
        file_path: folder.unwrap_or_default(),
        ..default()
    };
    App::new()
        .add_plugins((
            common::default_plugins("Your scene").set(assets),
            FrescoPlugins,
            FrescoPanelPlugin,
        ))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(File(name.display().to_string()))
        .add_systems(Startup, setup)
        .add_systems(
            Update,
            (
                one_camera,
                look_at_all,
                turn.run_if(not(egui_wants_any_pointer_input)),
            )
                .chain(),
        )
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>, file: Res<File>) {
    let scene = assets.load(GltfAssetLabel::Scene(0).from_asset(file.0.clone()));
    commands.spawn((WorldAssetRoot(scene), StaticLighting::default()));
    let orbit = Orbit {
        middle: Vec3::ZERO,
        distance: 10.0,
        yaw: 0.6,
        pitch: -0.35,
    };
    commands.spawn((Camera3d::default(), orbit));
}

/// Cameras of the file stay off.
fn one_camera(mut cameras: Query<&mut Camera, (Added<Camera>, Without<Orbit>)>) {
    for mut camera in &mut cameras {
        camera.is_active = false;
    }
}

/// Once all of the scene is there, which is when it is lit, the camera sees all of it; from the file's own camera, if
/// it has one.
fn look_at_all(
    lit: Query<(&Aabb, &GlobalTransform), With<BakedLighting>>,
    given: Query<&GlobalTransform, (With<Camera>, Without<Orbit>)>,
    mut orbits: Query<&mut Orbit>,
    mut done: Local<bool>,
) {
    if *done || lit.is_empty() {
        return;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (bounds, place) in &lit {
        for corner in 0..8 {
            let side = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let sides = Vec3::new(side(0), side(1), side(2));
            let corner = bounds.center + bounds.half_extents * Vec3A::from(sides);
            let corner = place.transform_point(corner.into());
            (low, high) = (low.min(corner), high.max(corner));
        }
    }
    let middle = 0.5 * (low + high);
    for mut orbit in &mut orbits {
        orbit.middle = middle;
        orbit.distance = 1.4 * (high - low).length();
        if let Some(camera) = given.iter().next() {
            let from = camera.translation() - middle;
            orbit.distance = from.length().max(0.1);
            let ahead = -from / orbit.distance;
            (orbit.yaw, orbit.pitch) = ((-ahead.x).atan2(-ahead.z), ahead.y.asin());
        }
    }
    *done = true;
}

fn turn(
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    mut cameras: Query<(&mut Transform, &mut Orbit)>,
) {
    for (mut camera, mut orbit) in &mut cameras {
        if buttons.pressed(MouseButton::Left) {
            orbit.yaw -= 0.005 * motion.delta.x;
            orbit.pitch = (orbit.pitch - 0.005 * motion.delta.y).clamp(-1.5, 1.5);
        }
        if buttons.pressed(MouseButton::Right) {
            let step = Vec3::new(-motion.delta.x, motion.delta.y, 0.0);
            let step = camera.rotation * step * (0.0015 * orbit.distance);
            orbit.middle += step;
        }
        orbit.distance *= (-0.1 * scroll.delta.y).exp();
        camera.rotation = Quat::from_euler(EulerRot::YXZ, orbit.yaw, orbit.pitch, 0.0);
        camera.translation = orbit.middle + camera.rotation * Vec3::Z * orbit.distance;
    }
}

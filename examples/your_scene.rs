//! Any glTF file, lit by its own lights and what bounces, with the panel to change them:
//! `cargo run --features examples,panel --example your_scene -- FILE.glb`.
//!
//! Drag with the left button to turn, with the right one to move, roll the wheel to come nearer; F1 hides the panel.
//! Click with the middle button on a surface for what it sees, by form factors.
//!
//! `--baked` bakes nothing and shows the light that `cargo bake` put into the file.
//! `--save FILE.light_bake` bakes without a window and saves the light, for `LitBy`.
//! `--view NAME` begins with one of the panel's views, `--edges` draws the edges of triangles, `--no-panel` hides the
//! panel, and `--screenshot FILE` saves a picture without a window.

#![expect(
    clippy::print_stderr,
    reason = "it says what is wrong with its arguments"
)]

mod common;

use std::path::PathBuf;

use bevy::asset::AssetPlugin;
use bevy::camera::primitives::Aabb;
use bevy::gltf::{GltfAssetLabel, GltfPlugin};
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::math::Vec3A;
use bevy::pbr::wireframe::{WireframeConfig, WireframePlugin};
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;
use bevy_egui::input::egui_wants_any_pointer_input;
use bevy_fresco::panel::{FrescoPanelPlugin, PanelOpen};
use bevy_fresco::plugin::radiosity::{
    BakeState, BakedLighting, RadiosityGizmos, RadiosityStatus, StaticLighting,
};
use bevy_fresco::plugin::{
    ATTRIBUTE_BAKED_LIGHT, BakedScene, FrescoPlugins, FrescoView, LightBake,
};

/// Where the camera stands: around a point.
#[derive(Component)]
struct Orbit {
    middle: Vec3,
    distance: f32,
    yaw: f32,
    pitch: f32,
}

#[derive(Resource)]
struct File {
    /// Its name in its folder.
    name: String,
    /// It brings its light along.
    baked: bool,
}

/// Where its light is to be saved.
#[derive(Resource)]
struct Save(PathBuf);

fn main() -> AppExit {
    let mut rest = std::env::args().skip(1);
    let (mut file, mut view, mut save) = (None, FrescoView::Shaded, None);
    let (mut edges, mut panel, mut baked) = (false, true, false);
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--screenshot" => drop(rest.next()),
            "--view" => match rest.next().as_deref().and_then(named) {
                Some(chosen) => view = chosen,
                None => {
                    let names = FrescoView::ALL.map(|(view, _)| name_of(view));
                    eprintln!("--view needs one of {}", names.join(", "));
                    return AppExit::error();
                }
            },
            "--edges" => edges = true,
            "--no-panel" => panel = false,
            "--baked" => baked = true,
            "--save" => save = rest.next().map(PathBuf::from),
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
    // Bevy drops attributes that it is not told of.
    let gltf =
        GltfPlugin::default().add_custom_vertex_attribute("BAKED_LIGHT", ATTRIBUTE_BAKED_LIGHT);
    let plugins = match save {
        Some(_) => common::without_window(),
        None => common::default_plugins("Your scene"),
    };
    let mut app = App::new();
    if let Some(path) = save {
        app.insert_resource(Save(path))
            .add_systems(Last, save_light);
    }
    app.add_plugins((
        plugins.set(assets).set(gltf),
        FrescoPlugins,
        FrescoPanelPlugin,
        WireframePlugin::default(),
    ))
    .insert_resource(view)
    .insert_resource(PanelOpen(panel))
    .insert_resource(WireframeConfig {
        global: edges,
        ..default()
    })
    .insert_resource(GlobalAmbientLight::NONE)
    .insert_resource(File {
        name: name.display().to_string(),
        baked,
    })
    .add_systems(Startup, setup)
    .add_systems(
        Update,
        (
            one_camera,
            look_at_all,
            turn.run_if(not(egui_wants_any_pointer_input)),
            pick.run_if(not(egui_wants_any_pointer_input)),
        )
            .chain(),
    )
    .run()
}

/// What the command line calls a view.
fn name_of(view: FrescoView) -> String {
    format!("{view:?}").to_lowercase()
}

fn named(name: &str) -> Option<FrescoView> {
    let mut all = FrescoView::ALL.into_iter().map(|(view, _)| view);
    all.find(|view| name_of(*view) == name)
}

fn setup(mut commands: Commands, assets: Res<AssetServer>, file: Res<File>) {
    let scene = assets.load(GltfAssetLabel::Scene(0).from_asset(file.name.clone()));
    let mut root = commands.spawn(WorldAssetRoot(scene));
    match file.baked {
        true => root.insert(BakedScene::default()),
        false => root.insert(StaticLighting::default()),
    };
    let orbit = Orbit {
        middle: Vec3::ZERO,
        distance: 10.0,
        yaw: 0.6,
        pitch: -0.35,
    };
    commands.spawn((Camera3d::default(), orbit));
}

/// Saves the light as soon as it is there.
fn save_light(world: &mut World) {
    let status = world.resource::<RadiosityStatus>();
    let is_over = status.is_up_to_date() || status.state == BakeState::Stopped;
    let mut roots = world.query_filtered::<Entity, With<StaticLighting>>();
    let Ok(root) = roots.single(world) else {
        return;
    };
    if !is_over {
        return;
    }
    let path = world.resource::<Save>().0.clone();
    let saved = LightBake::of(world, root).map_err(|e| e.to_string());
    let exit = match saved.and_then(|bake| bake.write(&path).map_err(|e| e.to_string())) {
        Ok(()) => AppExit::Success,
        Err(problem) => {
            eprintln!("{}: {problem}", path.display());
            AppExit::error()
        }
    };
    world.write_message(exit);
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
    meshes: Query<(&Aabb, &GlobalTransform), With<Mesh3d>>,
    lit: Query<(), With<BakedLighting>>,
    file: Res<File>,
    given: Query<&GlobalTransform, (With<Camera>, Without<Orbit>)>,
    mut orbits: Query<&mut Orbit>,
    mut done: Local<bool>,
) {
    if *done || meshes.is_empty() || (lit.is_empty() && !file.baked) {
        return;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (bounds, place) in &meshes {
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

/// Shows the form factors of what was clicked on.
fn pick(
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window>,
    cameras: Query<(&Camera, &GlobalTransform), With<Orbit>>,
    mut gizmos: ResMut<RadiosityGizmos>,
) {
    if !buttons.just_pressed(MouseButton::Middle) {
        return;
    }
    let cursor = windows.iter().find_map(Window::cursor_position);
    for (camera, place) in &cameras {
        if let Some(ray) = cursor.and_then(|at| camera.viewport_to_world(place, at).ok()) {
            gizmos.form_factors = Some(ray);
        }
    }
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

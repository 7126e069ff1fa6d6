//! All of it in one room: a wall of displaced bricks, a bump-mapped floor and fluted columns, and light that is baked
//! and answers to the relief.
//!
//! R gives the lamps to the engine, with shadow maps and without what bounces, and back; F1 hides the panel.
//! `--screenshot FILE` saves a picture without a window, `--realtime` begins with the engine's lamps, `--compare`
//! times both ways without a window.

#![expect(clippy::print_stdout, reason = "it says what it measured")]

mod common;

use std::f32::consts::{PI, TAU};
use std::time::{Duration, Instant};

use bevy::math::Affine2;
use bevy::prelude::*;
use bevy::render::render_resource::PollType;
use bevy::render::renderer::RenderDevice;
use bevy_fresco::displacement::Tessellation;
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::panel::{FrescoPanelPlugin, PanelOpen};
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage};
use bevy_fresco::plugin::displacement::{Displacement, DisplacementStatus};
use bevy_fresco::plugin::radiosity::{
    LightBaking, RadiositySettings, RadiosityStatus, StaticLighting,
};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial, FrescoPlugins};
use bevy_fresco::radiosity::BakeSettings;

/// Width, height and depth of the room, in metres.
const ROOM: Vec3 = Vec3::new(7.0, 3.4, 6.0);
/// Radius of a column, flutes around it and how deep they are, in metres.
const COLUMN: f32 = 0.28;
const FLUTES: f32 = 16.0;
const FLUTE: f32 = 0.014;
/// How far bricks of the wall and stones of the floor stand out, in metres.
const BRICK: f32 = 0.05;
const STONE: f32 = 0.015;

#[derive(Component)]
struct Lamp;

/// Whether the engine lights the room.
#[derive(Resource, Clone, Copy, PartialEq)]
struct Realtime(bool);

fn main() -> AppExit {
    let flag = |flag: &str| std::env::args().any(|argument| argument == flag);
    let compares = flag("--compare");
    let settings = RadiositySettings {
        bake: BakeSettings {
            directional: true,
            error: 0.04,
            // Room for the wall of bricks beside the rest.
            max_vertices: 120_000,
            ..BakeSettings::DRAFT
        },
        ..default()
    };
    let mut app = App::new();
    app.add_plugins((
        match compares {
            true => common::without_window(),
            false => common::default_plugins("Gallery"),
        },
        FrescoPlugins,
        FrescoPanelPlugin,
    ))
    .insert_resource(PanelOpen(false))
    .insert_resource(settings)
    .insert_resource(GlobalAmbientLight::NONE)
    .insert_resource(ClearColor(Color::BLACK))
    .insert_resource(Realtime(flag("--realtime")))
    .add_systems(Startup, setup)
    .add_systems(Update, (key, light).chain());
    if compares {
        app.add_plugins(common::DrawIntoImage)
            .init_resource::<Times>()
            .add_systems(Last, compare);
    }
    app.run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut maps: ResMut<Assets<HeightImage>>,
    mut materials: ResMut<Assets<FrescoMaterial>>,
) -> Result {
    let bricks: Handle<HeightImage> = assets.load("textures/bricks.png");
    // One flute, round at the bottom.
    let heights = (0..64).map(|i| 1.0 - (PI * (i as f32 + 0.5) / 64.0).sin());
    let flute = HeightMap::new([64, 1], heights.collect(), [Wrap::Repeat; 2])?;
    let flute = maps.add(HeightImage::new(flute));
    let mut matt = |color, uv_scale: Vec2, bump| {
        materials.add(FrescoMaterial {
            base: StandardMaterial {
                base_color: color,
                perceptual_roughness: 0.85,
                uv_transform: Affine2::from_scale(uv_scale),
                ..default()
            },
            extension: FrescoExtension { bump, ..default() },
        })
    };
    let plaster = matt(Color::srgb(0.78, 0.74, 0.68), Vec2::ONE, None);
    let red = matt(Color::srgb(0.72, 0.2, 0.14), Vec2::ONE, None);
    let clay = matt(Color::srgb(0.68, 0.4, 0.3), Vec2::ONE, None);
    let stones = Bump::new(bricks.clone(), BumpHeight::Mesh(STONE));
    let stones = matt(Color::srgb(0.5, 0.49, 0.46), ROOM.xz() / 1.6, Some(stones));
    let fluted = Bump::new(flute, BumpHeight::Mesh(FLUTE));
    let fluted = matt(
        Color::srgb(0.82, 0.8, 0.76),
        Vec2::new(FLUTES, 1.0),
        Some(fluted),
    );
    let glowing = materials.add(FrescoMaterial {
        base: StandardMaterial {
            base_color: Color::BLACK,
            emissive: LinearRgba::rgb(6.0, 4.6, 3.0),
            ..default()
        },
        extension: FrescoExtension::default(),
    });
    let half = 0.5 * ROOM;
    let mut side = |up: Vec3, size: Vec2, material: &Handle<FrescoMaterial>| {
        (
            Mesh3d(meshes.add(Plane3d::new(Vec3::Z, 0.5 * size))),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(-up * half).with_rotation(match up.y == 0.0 {
                // Upright ones keep their up.
                true => Quat::from_rotation_y(up.x.atan2(up.z)),
                false => Quat::from_rotation_x(-PI / 2.0 * up.y),
            }),
        )
    };
    let mut displacement = Displacement {
        uv_transform: Affine2::from_scale(ROOM.xy() / 1.7),
        ..Displacement::new(bricks, BRICK)
    };
    displacement.settings.tessellation = Tessellation::Adaptive { tolerance: 0.008 };
    let across = Vec2::new(ROOM.z, ROOM.y);
    commands.spawn((
        Transform::default(),
        Visibility::default(),
        children![
            side(Vec3::X, across, &red),
            side(Vec3::NEG_X, across, &plaster),
            side(Vec3::Y, ROOM.xz(), &stones),
            side(Vec3::NEG_Y, ROOM.xz(), &plaster),
        ],
    ));
    commands.spawn((side(Vec3::Z, ROOM.xy(), &clay), displacement));
    let column = meshes.add(Cylinder::new(COLUMN, ROOM.y).mesh().resolution(48));
    for (x, z) in [(-1.5, -0.9), (1.5, -0.9), (-2.6, 1.2), (2.6, 1.2)] {
        commands.spawn((
            Mesh3d(column.clone()),
            MeshMaterial3d(fluted.clone()),
            // Bevy's texture coordinates begin at the same place on each.
            Transform::from_xyz(x, 0.0, z).with_rotation(Quat::from_rotation_y(TAU / 32.0)),
        ));
    }
    // Lanterns that only the bake can have as lamps, and one that both can.
    let lantern = meshes.add(Sphere::new(0.13).mesh().ico(3)?);
    for x in [-2.6, 2.6] {
        commands.spawn((
            Mesh3d(lantern.clone()),
            MeshMaterial3d(glowing.clone()),
            Transform::from_xyz(x, 0.2, -1.9),
        ));
    }
    commands.spawn((
        Lamp,
        PointLight {
            intensity: 220_000.0,
            color: Color::srgb(1.0, 0.9, 0.75),
            range: 30.0,
            ..default()
        },
        LightBaking::Full,
        Transform::from_xyz(0.3, 1.2, 0.9),
    ));
    commands.spawn((
        Camera3d::default(),
        Projection::from(PerspectiveProjection {
            fov: 1.15,
            ..default()
        }),
        Transform::from_xyz(1.2, 0.0, 2.85).looking_at(Vec3::new(-0.5, -0.15, -1.0), Vec3::Y),
    ));
    Ok(())
}

fn key(keys: Res<ButtonInput<KeyCode>>, mut realtime: ResMut<Realtime>) {
    if keys.just_pressed(KeyCode::KeyR) {
        realtime.0 = !realtime.0;
    }
}

/// Gives the light to the engine, or takes it back.
fn light(
    mut commands: Commands,
    realtime: Res<Realtime>,
    surfaces: Query<(Entity, Has<Displacement>), With<Mesh3d>>,
    mut lamps: Query<(Entity, &mut PointLight), With<Lamp>>,
) {
    if !realtime.is_changed() {
        return;
    }
    for (surface, is_displaced) in &surfaces {
        match realtime.0 {
            true => commands.entity(surface).remove::<StaticLighting>(),
            false => commands.entity(surface).insert(StaticLighting {
                // Relief has vertices enough for its light.
                refine: !is_displaced,
                ..default()
            }),
        };
    }
    for (entity, mut lamp) in &mut lamps {
        lamp.shadow_maps_enabled = realtime.0;
        commands.entity(entity).insert(match realtime.0 {
            true => LightBaking::Excluded,
            false => LightBaking::Full,
        });
    }
}

/// Frames that are timed in either way, and before them some that are not.
const FRAMES: usize = 30;
const SETTLE: usize = 10;

#[derive(Resource, Default)]
struct Times {
    baked: Vec<Duration>,
    realtime: Vec<Duration>,
    last: Option<Instant>,
}

fn compare(
    mut times: ResMut<Times>,
    mut realtime: ResMut<Realtime>,
    status: Res<RadiosityStatus>,
    raised: Query<&DisplacementStatus>,
    device: Res<RenderDevice>,
    mut exit: MessageWriter<AppExit>,
) {
    // Frames count when they are drawn, not when they are asked for.
    if device.poll(PollType::wait_indefinitely()).is_err() {
        exit.write(AppExit::error());
    }
    let last = times.last.replace(Instant::now());
    let is_raised = raised.iter().all(|status| status.report().is_some());
    let is_ready = is_raised && (realtime.0 || status.is_up_to_date());
    let Some(spent) = last.map(|last| last.elapsed()).filter(|_| is_ready) else {
        return;
    };
    let frames = match realtime.0 {
        true => &mut times.realtime,
        false => &mut times.baked,
    };
    frames.push(spent);
    if frames.len() < SETTLE + FRAMES {
        return;
    }
    if !realtime.0 {
        realtime.0 = true;
        return;
    }
    let median = |frames: &[Duration]| {
        let mut frames = frames[SETTLE..].to_vec();
        frames.sort_unstable();
        frames[FRAMES / 2].as_secs_f64() * 1e3
    };
    let [baked, realtime] = [&times.baked, &times.realtime].map(|frames| median(frames));
    println!("baked light: {baked:.1} ms a frame (median of {FRAMES})");
    println!("one point light with shadow maps: {realtime:.1} ms a frame");
    exit.write(AppExit::Success);
}

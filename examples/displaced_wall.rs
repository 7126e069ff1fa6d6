//! Three ways to show one map of bricks on a round pier: bump mapping, parallax and displacement. In the middle of
//! each they look alike. At the outline only the displaced one has bricks, and only its bricks cast shadows.
//!
//! Up and down make the relief of all three higher and lower: the displaced mesh is made anew in the background.
//! `--screenshot FILE` saves a picture without a window.

mod common;

use std::f32::consts::TAU;

use bevy::math::Affine2;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_fresco::displacement::Tessellation;
use bevy_fresco::height_map::HeightMap;
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage, Parallax};
use bevy_fresco::plugin::displacement::Displacement;
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial, FrescoPlugins};

/// How far bricks stand out of their joints, in metres.
const HEIGHT: f32 = 0.04;
/// How far faces may be from the relief, in metres.
const TOLERANCE: f32 = 0.002;
/// Of a pier, in metres.
const RADIUS: f32 = 0.4;
/// The map goes twice around a pier and twice along it.
const REPEAT: Vec2 = Vec2::splat(2.0);

fn main() -> AppExit {
    App::new()
        .add_plugins((common::default_plugins("Displaced wall"), FrescoPlugins))
        .insert_resource(ClearColor(Color::srgb(0.55, 0.62, 0.7)))
        .insert_resource(GlobalAmbientLight {
            brightness: 250.0,
            ..default()
        })
        .add_systems(Startup, setup)
        .add_systems(Update, (paint, common::change_height(HEIGHT), change_scale))
        .run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<FrescoMaterial>>,
) {
    let map = assets.load("textures/bricks.png");
    let uv_transform = Affine2::from_scale(REPEAT);
    let bump = Bump::new(map.clone(), BumpHeight::Mesh(HEIGHT));
    let parallax = Bump {
        parallax: Some(Parallax::default()),
        ..bump.clone()
    };
    let mut displacement = Displacement {
        uv_transform,
        ..Displacement::new(map, HEIGHT)
    };
    displacement.settings.tessellation = Tessellation::Adaptive {
        tolerance: TOLERANCE,
    };
    // As high as it is around: the map is square.
    let pier = Cylinder::new(RADIUS, TAU * RADIUS).mesh();
    let pier = meshes.add(pier.resolution(96).without_caps());
    for (x, bump, displacement) in [
        (-1.15, Some(bump), None),
        (0.0, Some(parallax), None),
        (1.15, None, Some(displacement)),
    ] {
        let material = materials.add(FrescoMaterial {
            base: StandardMaterial {
                perceptual_roughness: 0.9,
                uv_transform,
                ..default()
            },
            extension: FrescoExtension { bump, ..default() },
        });
        let mut pier = commands.spawn((
            Mesh3d(pier.clone()),
            MeshMaterial3d(material),
            Transform::from_xyz(x, 0.0, 0.0),
        ));
        if let Some(displacement) = displacement {
            pier.insert(displacement);
        }
    }
    commands.spawn((
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-3.0, 3.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 0.5, 4.2).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Paints the bricks when their map is there.
fn paint(
    mut loaded: MessageReader<AssetEvent<HeightImage>>,
    maps: Res<Assets<HeightImage>>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<FrescoMaterial>>,
) {
    for event in loaded.read() {
        let AssetEvent::Added { id } = *event else {
            continue;
        };
        let paint = maps.get(id).map(|map| images.add(painted(map.map())));
        for (_, material) in materials.iter_mut() {
            material.base.base_color_texture.clone_from(&paint);
        }
    }
}

/// Mortar below and clay above.
fn painted(map: &HeightMap) -> Image {
    let texels = map.heights().iter().map(|&height| {
        let color = Vec3::new(0.5, 0.48, 0.45).lerp(Vec3::new(0.66, 0.33, 0.22), height);
        let [r, g, b] = color.to_array().map(|c| (c * 255.0).round() as u8);
        [r, g, b, 255]
    });
    common::picture(map.size(), texels, TextureFormat::Rgba8UnormSrgb)
}

/// What the bumps do, for the displaced mesh.
fn change_scale(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut displaced: Query<&mut Displacement>,
) {
    let direction = common::up_or_down(&keys);
    if direction != 0.0 {
        for mut displacement in &mut displaced {
            displacement.settings.scale += direction * HEIGHT * time.delta_secs();
        }
    }
}

//! What a bump map does: a painted ball, a grey ball with swirls in relief, and the painted ball with both.
//! All three are the same smooth mesh.
//!
//! Up and down make the relief higher and lower, space moves and stops the lamp. `--screenshot FILE` saves a picture
//! without a window.

mod common;

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial, FrescoPlugins};

/// How far swirls stand out of a ball of radius 1.
const HEIGHT: f32 = 0.04;
/// Texels around and from pole to pole.
const SIZE: [u32; 2] = [2048, 1024];

fn main() -> AppExit {
    App::new()
        .add_plugins((common::default_plugins("Bump sphere"), FrescoPlugins))
        .insert_resource(ClearColor(Color::srgb(0.05, 0.055, 0.07)))
        .insert_resource(GlobalAmbientLight {
            brightness: 60.0,
            ..default()
        })
        .add_systems(Startup, setup)
        .add_systems(Update, (swing, common::change_height(HEIGHT)))
        .run()
}

#[derive(Component)]
struct Lamp;

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
    mut maps: ResMut<Assets<HeightImage>>,
    mut materials: ResMut<Assets<FrescoMaterial>>,
) -> Result {
    let ball = meshes.add(Sphere::new(1.0).mesh().uv(128, 64));
    let paint = images.add(painted());
    let heights = over_sphere(|at| swirls(at, 0.0)).collect();
    let map = HeightMap::new(SIZE, heights, [Wrap::Repeat, Wrap::Clamp])?;
    let bump = Bump::new(maps.add(HeightImage::new(map)), BumpHeight::Mesh(HEIGHT));
    for (x, is_painted, has_bump) in [(-2.15, true, false), (0.0, false, true), (2.15, true, true)]
    {
        let material = materials.add(FrescoMaterial {
            base: StandardMaterial {
                base_color: if is_painted {
                    Color::WHITE
                } else {
                    Color::srgb(0.6, 0.6, 0.6)
                },
                base_color_texture: is_painted.then(|| paint.clone()),
                perceptual_roughness: 0.4,
                ..default()
            },
            extension: FrescoExtension {
                bump: has_bump.then(|| bump.clone()),
                ..default()
            },
        });
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(material),
            // Bevy's balls have their poles at front and back.
            Transform::from_xyz(x, 0.0, 0.0).with_rotation(Quat::from_rotation_x(-FRAC_PI_2)),
        ));
    }
    let above_left = Transform::from_xyz(-3.0, 3.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((Lamp, DirectionalLight::default(), above_left));
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 8.2)));
    Ok(())
}

/// A value for each texel of a map around a sphere, as Bevy lays texture coordinates on it: at the direction
/// that the texel shows, so that there is no seam and nothing is squeezed at the poles.
fn over_sphere<T>(value: impl Fn(Vec3) -> T) -> impl Iterator<Item = T> {
    let [width, rows] = SIZE;
    (0..width * rows).map(move |i| {
        let around = TAU * ((i % width) as f32 + 0.5) / width as f32;
        let down = PI * ((i / width) as f32 + 0.5) / rows as f32;
        let (ring, up) = down.sin_cos();
        value(Vec3::new(ring * around.cos(), ring * around.sin(), up))
    })
}

/// Waves that bend waves that bend waves, from 0 to 1.
fn swirls(direction: Vec3, phase: f32) -> f32 {
    let mut at = direction * 2.2 + phase;
    for (turn, strength) in [(1.3, 0.9), (2.1, 0.6), (3.7, 0.35)] {
        at += strength * (turn * at.yzx() + Vec3::new(0.3, 1.7, 2.9)).map(f32::sin);
    }
    0.5 + 0.5 * (6.0 * at.x + 2.0 * at.y).sin()
}

/// Two colours that run into each other.
fn painted() -> Image {
    let colors = [Vec3::new(0.85, 0.32, 0.12), Vec3::new(0.95, 0.75, 0.35)];
    let texels = over_sphere(|at| {
        let color = colors[0].lerp(colors[1], swirls(at.yzx() * 0.6, 4.0));
        let [r, g, b] = color.to_array().map(|c| (c * 255.0).round() as u8);
        [r, g, b, 255]
    });
    Image::new(
        Extent3d {
            width: SIZE[0],
            height: SIZE[1],
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels.flatten().collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    )
}

fn swing(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut moves: Local<bool>,
    mut lamp: Single<&mut Transform, With<Lamp>>,
) {
    *moves ^= keys.just_pressed(KeyCode::Space);
    if *moves {
        lamp.rotate_around(Vec3::ZERO, Quat::from_rotation_y(0.3 * time.delta_secs()));
    }
}

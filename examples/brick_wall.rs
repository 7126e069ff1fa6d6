//! Relief under light that is all baked: bricks that are one flat quad, lit by a glowing tube and by what
//! bounces. No lamp of the engine shines here.
//!
//! P shows the bricks flat and from the side again (`Bump::parallax`), space has the baked light forget where it
//! comes from and remember it again (`BakeSettings::directional`), up and down make the relief higher and lower.
//! `--screenshot FILE` saves a picture without a window, `--flat` begins without parallax.

mod common;

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::math::Affine2;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::height_map::{HeightMap, Wrap};
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage, Parallax};
use bevy_fresco::plugin::radiosity::{RadiositySettings, StaticLighting};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial, FrescoPlugins};

/// How far bricks stand out of their joints, in metres.
const HEIGHT: f32 = 0.02;
/// Texels of the pattern, which is a brick wide and two rows high and repeats.
const TEXELS: UVec2 = UVec2::new(256, 128);
/// Width and height of the pattern, in metres.
const PATTERN: Vec2 = Vec2::new(0.5, 0.4);
/// Half of the width of a joint, and of the edge that slopes down to it, in metres.
const JOINT: f32 = 0.008;
const EDGE: f32 = 0.016;

fn main() -> AppExit {
    let mut settings = RadiositySettings::default();
    settings.bake.directional = true;
    App::new()
        .add_plugins((common::default_plugins("Brick wall"), FrescoPlugins))
        .insert_resource(settings)
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, setup)
        .add_systems(
            Update,
            (
                toggle_direction,
                common::toggle_parallax,
                common::change_height(HEIGHT),
            ),
        )
        .run()
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
    mut maps: ResMut<Assets<HeightImage>>,
    mut materials: ResMut<Assets<FrescoMaterial>>,
) -> Result {
    let heights = texels().map(|at| brick(at).0).collect();
    let map = HeightMap::new(TEXELS.to_array(), heights, [Wrap::Repeat; 2])?;
    let is_flat = std::env::args().any(|argument| argument == "--flat");
    let bump = Bump {
        parallax: (!is_flat).then(Parallax::default),
        ..Bump::new(maps.add(HeightImage::new(map)), BumpHeight::Mesh(HEIGHT))
    };
    let paint = images.add(painted());
    let mut bricks = |size: Vec2| {
        materials.add(FrescoMaterial {
            base: StandardMaterial {
                base_color_texture: Some(paint.clone()),
                perceptual_roughness: 0.9,
                uv_transform: Affine2::from_scale(size / PATTERN),
                ..default()
            },
            extension: FrescoExtension {
                bump: Some(bump.clone()),
                ..default()
            },
        })
    };
    let (width, height, depth) = (4.0, 2.8, 4.0);
    let wall = (
        Mesh3d(meshes.add(Plane3d::new(Vec3::Z, 0.5 * Vec2::new(width, height)))),
        MeshMaterial3d(bricks(Vec2::new(width, height))),
        Transform::from_xyz(0.0, 0.5 * height, 0.0),
    );
    let side = (
        Mesh3d(meshes.add(Plane3d::new(Vec3::Z, 0.5 * Vec2::new(depth, height)))),
        MeshMaterial3d(bricks(Vec2::new(depth, height))),
        Transform::from_xyz(0.5 * width, 0.5 * height, 0.5 * depth)
            .with_rotation(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2)),
    );
    let floor = (
        Mesh3d(meshes.add(Plane3d::new(Vec3::Y, 0.5 * Vec2::new(width, depth)))),
        MeshMaterial3d(materials.add(FrescoMaterial {
            base: StandardMaterial::from_color(Color::srgb(0.55, 0.5, 0.45)),
            extension: FrescoExtension::default(),
        })),
        Transform::from_xyz(0.0, 0.0, 0.5 * depth),
    );
    let tube = (
        Mesh3d(meshes.add(Cuboid::new(0.08, 1.6, 0.08))),
        MeshMaterial3d(materials.add(FrescoMaterial {
            base: StandardMaterial {
                base_color: Color::BLACK,
                emissive: LinearRgba::rgb(45.0, 34.0, 21.0),
                ..default()
            },
            extension: FrescoExtension::default(),
        })),
        Transform::from_xyz(-1.0, 1.3, 0.5),
    );
    commands.spawn((
        StaticLighting::default(),
        Transform::default(),
        Visibility::default(),
        children![wall, side, floor, tube],
    ));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(1.2, 1.5, 1.5).looking_at(Vec3::new(-0.3, 1.2, 0.0), Vec3::Y),
    ));
    Ok(())
}

/// Places of the pattern's texels, in metres.
fn texels() -> impl Iterator<Item = Vec2> {
    (0..TEXELS.element_product()).map(|i| {
        let texel = UVec2::new(i % TEXELS.x, i / TEXELS.x);
        (texel.as_vec2() + 0.5) / TEXELS.as_vec2() * PATTERN
    })
}

/// Height from 0 to 1 at a place of the pattern, and which brick it is on: two rows, the second half a brick
/// farther.
fn brick(at: Vec2) -> (f32, u32) {
    let size = PATTERN / Vec2::new(1.0, 2.0);
    let row = (at.y / size.y) as u32;
    let within = Vec2::new((at.x + 0.5 * size.x * row as f32) % size.x, at.y % size.y);
    let from_joint = within.min(size - within).min_element() - JOINT;
    let edge = (from_joint / EDGE).clamp(0.0, 1.0);
    let rough: f32 = [(3.0, 2.0, 0.3), (7.0, 5.0, 1.1), (13.0, 11.0, 2.3)]
        .map(|(x, y, phase)| {
            let turns = at / PATTERN * std::f32::consts::TAU;
            (x * turns.x + phase).sin() * (y * turns.y + 2.0 * phase).sin()
        })
        .iter()
        .sum();
    let rounded = edge * edge * (3.0 - 2.0 * edge);
    (rounded * (0.93 + 0.02 * rough), row)
}

fn painted() -> Image {
    let colors = texels().map(|at| {
        let (height, row) = brick(at);
        let clay = [Vec3::new(0.6, 0.29, 0.2), Vec3::new(0.66, 0.36, 0.24)][row as usize % 2];
        let color = Vec3::splat(0.62).lerp(clay, height.clamp(0.0, 1.0));
        let [r, g, b] = color.to_array().map(|c| (c * 255.0).round() as u8);
        [r, g, b, 255]
    });
    let mut image = Image::new(
        Extent3d {
            width: TEXELS.x,
            height: TEXELS.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        colors.flatten().collect(),
        TextureFormat::Rgba8UnormSrgb,
        // The bake reads it.
        RenderAssetUsages::all(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

fn toggle_direction(keys: Res<ButtonInput<KeyCode>>, mut settings: ResMut<RadiositySettings>) {
    if keys.just_pressed(KeyCode::Space) {
        settings.bake.directional ^= true;
    }
}

//! The same relief twice under the same light: on the left as the height map of a [`Bump`], on the right as a normal
//! map of Bevy's, made from the same map. Below, how far the normals of each are off, where white is 0° and red 2° and
//! more: the relief is a formula, so they are known.
//!
//! What the pictures show is also told in numbers. Space moves and stops the lamp, up and down make the relief of
//! the bump higher and lower. `--screenshot FILE` saves a picture without a window.

mod common;

use std::f32::consts::TAU;

use bevy::camera::ScalingMode;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy_fresco::height_map::{
    Green, HeightMap, Kernel, NormalMapSettings, Wrap, encode_normal, normal_map,
};
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage};
use bevy_fresco::plugin::{FrescoExtension, FrescoMaterial, FrescoPlugins};

/// Texels of both maps on a side: few, so that each is many pixels.
const TEXELS: u32 = 32;
/// Side of a panel, and how far relief of 1 stands out of it, in metres.
const SIDE: f32 = 2.0;
const HEIGHT: f32 = 0.2;
/// Pixels of the pictures of errors.
const PIXELS: u32 = 512;

fn main() -> AppExit {
    App::new()
        .add_plugins((
            common::default_plugins("Bump and normal map"),
            FrescoPlugins,
        ))
        .insert_resource(ClearColor(Color::srgb(0.05, 0.055, 0.07)))
        .insert_resource(GlobalAmbientLight {
            brightness: 40.0,
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
    mut ours: ResMut<Assets<FrescoMaterial>>,
    mut bevys: ResMut<Assets<StandardMaterial>>,
) -> Result {
    let heights = places(TEXELS).map(|uv| relief(uv).0).collect();
    let map = HeightMap::new([TEXELS; 2], heights, [Wrap::Repeat; 2])?;
    let normals = normal_map(
        &map,
        &NormalMapSettings {
            kernel: Kernel::CatmullRom,
            height: HEIGHT,
            extent: Vec2::splat(SIDE),
            green: Green::Up,
        },
    );
    let texels: Vec<[u8; 3]> = normals.into_iter().map(encode_normal).collect();
    let of_bump = |uv| normal(map.at(uv, Kernel::CatmullRom).slopes);
    let of_normal_map = |uv| filtered(&texels, uv);
    let base = StandardMaterial {
        base_color: Color::srgb(0.7, 0.66, 0.6),
        perceptual_roughness: 0.25,
        ..default()
    };
    // Bevy's normal maps need tangents.
    let panel = Mesh::from(Rectangle::new(SIDE, SIDE)).with_generated_tangents()?;
    let panel = meshes.add(panel);
    let bump = ours.add(FrescoMaterial {
        base: base.clone(),
        extension: FrescoExtension {
            bump: Some(Bump::new(
                maps.add(HeightImage::new(map.clone())),
                BumpHeight::Mesh(HEIGHT),
            )),
            ..default()
        },
    });
    let mapped = bevys.add(StandardMaterial {
        normal_map_texture: Some(images.add(common::picture(
            [TEXELS; 2],
            texels.iter().map(|&[r, g, b]| [r, g, b, 255]),
            TextureFormat::Rgba8Unorm,
        ))),
        ..base
    });
    let at = |column: f32, row: f32| Transform::from_xyz(1.08 * column, 1.08 * row, 0.0);
    commands.spawn((Mesh3d(panel.clone()), MeshMaterial3d(bump), at(-1.0, 1.0)));
    commands.spawn((Mesh3d(panel.clone()), MeshMaterial3d(mapped), at(1.0, 1.0)));
    let mut show_errors = |name: &str, column: f32, found: &dyn Fn(Vec2) -> Vec3| {
        let errors: Vec<f32> = places(PIXELS)
            .map(|uv| degrees(found(uv), truth(uv)))
            .collect();
        let squares: f64 = errors.iter().map(|e| f64::from(e * e)).sum();
        let most = errors.iter().copied().fold(0.0, f32::max);
        let mean = (squares / errors.len() as f64).sqrt();
        info!("{name}: normals are {mean:.2}° off (RMS), {most:.2}° at most");
        let colors = errors.iter().map(|error| {
            let rest = ((1.0 - error / 2.0).clamp(0.0, 1.0) * 255.0) as u8;
            [255, rest, rest, 255]
        });
        let shown = bevys.add(StandardMaterial {
            unlit: true,
            base_color_texture: Some(images.add(common::picture(
                [PIXELS; 2],
                colors,
                TextureFormat::Rgba8UnormSrgb,
            ))),
            ..default()
        });
        commands.spawn((
            Mesh3d(panel.clone()),
            MeshMaterial3d(shown),
            at(column, -1.0),
        ));
    };
    show_errors("bump", -1.0, &of_bump);
    show_errors("normal map", 1.0, &of_normal_map);
    let light = DirectionalLight {
        illuminance: 5000.0,
        ..default()
    };
    let above_left = Transform::from_xyz(-3.0, 2.0, 2.2).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((Lamp, light, above_left));
    // Parallel rays, so that both are seen from the same side. Errors are shown in the colours they have.
    let projection = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical {
            viewport_height: 4.5,
        },
        ..OrthographicProjection::default_3d()
    };
    commands.spawn((
        Camera3d::default(),
        Projection::from(projection),
        Tonemapping::None,
        Transform::from_xyz(0.0, 0.0, 5.0),
    ));
    Ok(())
}

/// Texture coordinates of the middles of `n × n` texels.
fn places(n: u32) -> impl Iterator<Item = Vec2> {
    (0..n * n).map(move |i| (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32)
}

/// Rings that run into each other: height about 0 to 1, and slopes by texture coordinate.
fn relief(uv: Vec2) -> (f32, Vec2) {
    let waves = [
        (Vec2::new(1.0, 2.0), 0.3, 0.2),
        (Vec2::new(3.0, -1.0), 1.9, 0.16),
        (Vec2::new(-2.0, 3.0), 4.0, 0.14),
    ];
    let (mut height, mut slopes) = (0.5, Vec2::ZERO);
    for (along, phase, share) in waves {
        let (sin, cos) = (TAU * along.dot(uv) + phase).sin_cos();
        height += share * sin;
        slopes += share * TAU * cos * along;
    }
    (height, slopes)
}

/// Normal in the plane of the panel, `v` down.
fn normal(slopes: Vec2) -> Vec3 {
    let slopes = slopes * HEIGHT / SIDE;
    Vec3::new(-slopes.x, slopes.y, 1.0).normalize()
}

fn truth(uv: Vec2) -> Vec3 {
    normal(relief(uv).1)
}

/// The normal that a graphics card's filter makes of four texels.
fn filtered(texels: &[[u8; 3]], uv: Vec2) -> Vec3 {
    let place = uv * TEXELS as f32 - 0.5;
    let (first, t) = (place.floor().as_ivec2(), place - place.floor());
    let texel = |x: i32, y: i32| {
        let [x, y] = [first.x + x, first.y + y].map(|i| i.rem_euclid(TEXELS as i32) as u32);
        let [r, g, b] = texels[(y * TEXELS + x) as usize];
        Vec3::new(r.into(), g.into(), b.into()) / 127.5 - 1.0
    };
    let row = |y: i32| texel(0, y).lerp(texel(1, y), t.x);
    row(0).lerp(row(1), t.y).normalize()
}

fn degrees(a: Vec3, b: Vec3) -> f32 {
    let [a, b] = [a, b].map(DVec3::from);
    a.cross(b).length().atan2(a.dot(b)).to_degrees() as f32
}

fn swing(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut moves: Local<bool>,
    mut lamp: Single<&mut Transform, With<Lamp>>,
) {
    *moves ^= keys.just_pressed(KeyCode::Space);
    if *moves {
        lamp.rotate_around(Vec3::ZERO, Quat::from_rotation_z(0.3 * time.delta_secs()));
    }
}

//! Bump test 11: relief finer than pixels makes a surface rougher, and does not flicker.

use std::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::math::Affine2;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{Bump, BumpHeight};

use super::{bump, error, relief, show};
use crate::picture::Picture;
use crate::scenery::{add, grid};
use crate::stage::on_stage;

/// Texels a groove, grooves of the map, and how often it lies on the 64 pixels of the picture.
const TEXELS: f32 = 16.0;
const GROOVES: f32 = 16.0;
const REPEATS: f32 = 9.0;
/// How steep grooves are.
const SLOPE: f32 = 0.4;
const SMOOTH: f32 = 0.2;

fn grooves(world: &mut World) -> Bump {
    let size = (TEXELS * GROOVES) as u32;
    let map = relief([size, 4], Wrap::Repeat, |u, _| (TAU * GROOVES * u).sin());
    // The grid is 2 m wide.
    let height = SLOPE * 2.0 / (TAU * GROOVES * REPEATS);
    let mut bump = bump(world, map, BumpHeight::World(height));
    bump.uv_transform = Affine2::from_scale(Vec2::new(REPEATS, 1.0));
    bump
}

#[test]
fn lost_slopes_are_roughness() {
    let picture = on_stage(|stage| {
        stage.show_normals(true);
        stage.shoot(
            |_| (),
            |world| {
                let grooves = grooves(world);
                let base = StandardMaterial {
                    perceptual_roughness: SMOOTH,
                    ..default()
                };
                show(world, grid(), base, Some(grooves), default());
            },
        )
    });
    let (most, _) = error(&picture, |_| Some(Vec3::Z));
    // A sine's mean square slope.
    let truth = 0.5 * SLOPE * SLOPE;
    let rougher = picture.pixels.iter().map(|p| p[3].powi(4) - SMOOTH.powi(4));
    let worst = rougher
        .map(|variance| (variance / truth - 1.0).abs())
        .fold(0.0, f32::max);
    println!("normals {most:.3}° off, α² {:.1} % off", 100.0 * worst);
    assert!(most < 0.5, "{most}°");
    assert!(worst < 0.1, "{worst}");
}

/// The same grooves as a normal map of Bevy's, which has one size.
fn as_normal_map(world: &mut World) -> Handle<Image> {
    let size = (TEXELS * GROOVES) as u32;
    let texel = |x: u32| {
        let u = (x as f32 + 0.5) / size as f32;
        let slope = SLOPE * (TAU * GROOVES * u).cos();
        let n = Vec3::new(-slope, 0.0, 1.0).normalize() * 0.5 + 0.5;
        [n.x, n.y, n.z, 1.0]
    };
    let floats = (0..4).flat_map(|_| (0..size).flat_map(texel));
    let mut image = Image::new(
        Extent3d {
            width: size,
            height: 4,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        floats.flat_map(f32::to_le_bytes).collect(),
        TextureFormat::Rgba32Float,
        RenderAssetUsages::all(),
    );
    image.sampler = bevy::image::ImageSampler::Descriptor(bevy::image::ImageSamplerDescriptor {
        address_mode_u: bevy::image::ImageAddressMode::Repeat,
        address_mode_v: bevy::image::ImageAddressMode::Repeat,
        ..bevy::image::ImageSamplerDescriptor::linear()
    });
    add(world, image)
}

/// Variance of a pixel's brightness over eight cameras, an eighth of a pixel apart, over the mean's square.
fn flicker(filtered: bool) -> f64 {
    let pictures: Vec<Picture> = (0..8)
        .map(|step| {
            on_stage(move |stage| {
                stage.shoot(
                    |camera| {
                        // A pixel is 2 m / 64 wide.
                        let aside = step as f32 / 8.0 * 2.0 / 64.0;
                        camera.insert(Transform::from_xyz(aside, 0.0, 3.0));
                    },
                    |world| {
                        let light =
                            Transform::from_xyz(1.0, 0.4, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
                        world.spawn((DirectionalLight::default(), light));
                        let mut base = StandardMaterial {
                            perceptual_roughness: SMOOTH,
                            uv_transform: Affine2::from_scale(Vec2::new(REPEATS, 1.0)),
                            ..default()
                        };
                        let at = Transform::from_scale(Vec3::splat(1.2));
                        let mesh = grid().with_generated_tangents().unwrap();
                        if filtered {
                            let mut grooves = grooves(world);
                            grooves.uv_transform = Affine2::IDENTITY;
                            show(world, mesh, base, Some(grooves), at);
                        } else {
                            base.normal_map_texture = Some(as_normal_map(world));
                            show(world, mesh, base, None, at);
                        }
                    },
                )
            })
        })
        .collect();
    let pixels = pictures[0].pixels.len();
    let (mut variance, mut square) = (0.0, 0.0);
    for pixel in 0..pixels {
        let seen = pictures.iter().map(|p| f64::from(p.pixels[pixel][1]));
        let mean = seen.clone().sum::<f64>() / 8.0;
        variance += seen.map(|v| (v - mean).powi(2)).sum::<f64>() / 8.0;
        square += mean * mean;
    }
    variance / square
}

#[test]
fn fine_relief_does_not_flicker() {
    let (unfiltered, filtered) = (flicker(false), flicker(true));
    println!("flicker {filtered:.2e}, of a normal map of one size {unfiltered:.2e}");
    assert!(unfiltered > 1e-3, "nothing to be filtered: {unfiltered}");
    assert!(filtered < 0.25 * unfiltered);
}

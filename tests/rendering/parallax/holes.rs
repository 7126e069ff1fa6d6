//! Surfaces that are cut out by the alpha of a texture have their holes where the relief is seen, in all passes.

use bevy::asset::RenderAssetUsages;
use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{Bump, BumpHeight, HeightImage, Parallax};

use super::{View, Wall};
use crate::bumps::{bump, relief, show, waves_map};
use crate::picture::{Picture, assert_same};
use crate::scenery::{add, grid, show_bevy};
use crate::stage::on_stage;

/// A white and opaque stripe, and one that is not there, `count` times along u.
fn stripes(count: usize) -> Image {
    let mut image = Image::new(
        Extent3d {
            width: 2 * count as u32,
            height: 1,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        [[255; 4], [0; 4]].concat().repeat(count),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::all(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::nearest()
    });
    image
}

fn cut_out(world: &mut World, count: usize) -> StandardMaterial {
    StandardMaterial {
        base_color_texture: Some(add(world, stripes(count))),
        alpha_mode: AlphaMode::Mask(0.5),
        unlit: true,
        double_sided: true,
        cull_mode: None,
        ..default()
    }
}

type Camera = fn(&mut EntityWorldMut);

/// Before a wall behind it that shows through.
fn shoot(camera: Camera, has_parallax: bool) -> Picture {
    on_stage(move |stage| {
        stage.shoot(
            |eye| {
                View::front(0.5).set(eye);
                camera(eye);
            },
            |world| {
                let mut wall = Wall::new(waves_map([256; 2]), BumpHeight::World(0.1));
                wall.at.rotation = Quat::from_rotation_x(-0.9) * Quat::from_rotation_z(0.4);
                let base = cut_out(world, 16);
                let mut bump = wall.bump(world);
                if !has_parallax {
                    bump.parallax = None;
                }
                show(world, wall.mesh(), base, Some(bump), wall.at);
                let red = StandardMaterial {
                    base_color: Color::linear_rgb(1.0, 0.2, 0.1),
                    unlit: true,
                    ..default()
                };
                let behind = Transform::from_xyz(0.0, 0.0, -2.0).with_scale(Vec3::splat(3.0));
                show_bevy(world, grid(), red, behind);
            },
        )
    })
}

/// Were depth drawn where the mesh has no holes, nothing would show through those of the relief.
#[test]
fn holes_are_where_the_relief_is_seen() {
    let multisampled: Camera = |c| {
        c.insert(Msaa::Sample4);
    };
    let (forward, multisampled) = (shoot(|_| (), true), shoot(multisampled, true));
    let apart = forward.distance(&shoot(|_| (), false));
    println!("parallax moves colours by {:.1} %", 100.0 * apart);
    assert!(apart > 0.1, "{apart}");
    // With a prepass, and the picture without it.
    let cases: [(&str, Camera, &Picture); 4] = [
        (
            "depth",
            |c| {
                c.insert(DepthPrepass);
            },
            &forward,
        ),
        (
            "motion vectors",
            |c| {
                c.insert((DepthPrepass, MotionVectorPrepass));
            },
            &forward,
        ),
        (
            "normals",
            |c| {
                c.insert((DepthPrepass, NormalPrepass));
            },
            &forward,
        ),
        (
            "multisampled",
            |c| {
                c.insert((DepthPrepass, Msaa::Sample4));
            },
            &multisampled,
        ),
    ];
    for (name, camera, without) in cases {
        // Single pixels lie on one side of a stripe's edge or the other: the mask's size is chosen by what
        // texture coordinates change by, before it is moved and after.
        assert_same(
            &format!("holes, {name}"),
            &shoot(camera, true),
            without,
            0.02,
        );
    }
}

/// All of it lies so deep, in metres, but for its border.
const DEPTH: f32 = 0.5;

fn sunken() -> HeightImage {
    let is_border = |x: f32| !(0.05..0.95).contains(&x);
    relief([64; 2], Wrap::Clamp, move |u, v| {
        f32::from(u8::from(is_border(u) || is_border(v)))
    })
}

/// What a lamp draws on a wall through another before it: through the sunken stripes of that, or through those of a
/// mesh that is itself sunk by so many metres.
fn shadows(is_sunken: bool, sunk: f32, lamp: fn(&mut World, Transform)) -> Picture {
    on_stage(move |stage| {
        stage.shoot(
            |_| (),
            |world| {
                // Behind the camera, 8 m wide, in the way of the light.
                let base = cut_out(world, 8);
                let bump = is_sunken.then(|| Bump {
                    parallax: Some(Parallax::default()),
                    ..bump(world, sunken(), BumpHeight::World(DEPTH))
                });
                let at = Transform::from_xyz(3.5, 0.0, 3.5 - sunk).with_scale(Vec3::splat(4.0));
                show(world, grid(), base, bump, at);
                show_bevy(world, grid(), default(), default());
                // 45° off the normals.
                let far = Transform::from_xyz(7.0, 0.0, 7.0).looking_at(Vec3::ZERO, Vec3::Y);
                lamp(world, far);
            },
        )
    })
}

/// The shadow of a surface has holes where the lamp sees them.
#[test]
fn light_falls_through_the_holes_it_sees() {
    let lamps: [(&str, fn(&mut World, Transform)); 2] = [
        ("sun", |world, at| {
            world.spawn((
                DirectionalLight {
                    shadow_maps_enabled: true,
                    ..default()
                },
                at,
            ));
        }),
        ("spot", |world, at| {
            world.spawn((
                SpotLight {
                    shadow_maps_enabled: true,
                    intensity: 1e6,
                    range: 30.0,
                    ..default()
                },
                at,
            ));
        }),
    ];
    for (name, lamp) in lamps {
        let found = shadows(true, 0.0, lamp);
        let expected = shadows(false, DEPTH, lamp);
        let moved = found.distance(&shadows(false, 0.0, lamp));
        println!("{name}: {:.0} % from the mesh's", 100.0 * moved);
        assert!(moved > 0.3, "{name}: {moved}");
        assert_same(
            &format!("light through holes, {name}"),
            &found,
            &expected,
            0.01,
        );
    }
}

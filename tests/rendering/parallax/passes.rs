//! Every way Bevy draws a surface shows the same relief where it is seen.

use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::prelude::*;
use bevy::render::view::Msaa;
use bevy_fresco::plugin::bump::{BumpHeight, Parallax, insert_uv_gradients};

use super::{View, Wall};
use crate::bumps::{degrees, normal, show, show_prepass, waves_map};
use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::picture::{Picture, assert_same};
use crate::scenery::{add, checker};
use crate::stage::on_stage;

type Camera = fn(&mut EntityWorldMut);

fn wall() -> Wall {
    let mut wall = Wall::new(waves_map([256; 2]), BumpHeight::World(0.1));
    wall.at.rotation = Quat::from_rotation_x(-0.9) * Quat::from_rotation_z(0.4);
    wall
}

fn normals(camera: Camera, see_prepass: bool, has_gradients: bool) -> Picture {
    on_stage(move |stage| {
        stage.show_normals(!see_prepass);
        stage.shoot(
            |eye| {
                View::front(0.5).set(eye);
                camera(eye);
            },
            |world| {
                let wall = wall();
                let mut mesh = wall.mesh();
                if has_gradients {
                    insert_uv_gradients(&mut mesh).unwrap();
                }
                let bump = wall.bump(world);
                show(world, mesh, wall.base, Some(bump), wall.at);
                if see_prepass {
                    show_prepass(world, Transform::from_xyz(0.0, 0.0, 1.5));
                }
            },
        )
    })
}

/// Normals of the forward pass, with such a parallax or without.
fn normals_with(parallax: Option<Parallax>) -> Picture {
    on_stage(move |stage| {
        stage.show_normals(true);
        stage.shoot(
            |camera| View::front(0.5).set(camera),
            |world| {
                let wall = wall();
                let mut bump = wall.bump(world);
                bump.parallax = parallax;
                show(world, wall.mesh(), wall.base, Some(bump), wall.at);
            },
        )
    })
}

/// Normals of all passes are those of the forward one: of the relief that is seen, not of that under the mesh.
#[test]
fn all_passes_see_the_same_relief() {
    let cases: [(&str, Camera, bool); 5] = [
        (
            "forward, MSAA",
            |c| {
                c.insert(Msaa::Sample4);
            },
            false,
        ),
        (
            "loaded from the prepass",
            |c| {
                c.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
            },
            false,
        ),
        (
            "MSAA with a prepass",
            |c| {
                c.insert((Msaa::Sample4, DepthPrepass, NormalPrepass));
            },
            false,
        ),
        (
            "the prepass",
            |c| {
                c.insert((DepthPrepass, NormalPrepass));
            },
            true,
        ),
        (
            "the prepass of the deferred renderer",
            |c| {
                c.insert((DEFERRED, NormalPrepass));
            },
            true,
        ),
    ];
    let forward = normals(|_| (), false, false);
    let mut shifted = 0;
    let flat = normals_with(None);
    for pixel in 0..forward.pixels.len() {
        let apart = degrees(normal(&forward, pixel), normal(&flat, pixel));
        shifted += usize::from(apart > 2.0);
    }
    assert!(shifted > 2000, "parallax turns normals at {shifted} pixels");
    for (name, camera, see_prepass) in cases {
        for has_gradients in [false, true] {
            let picture = normals(camera, see_prepass, has_gradients);
            // Beside the wall there are no normals.
            let mut angles: Vec<f32> = (0..forward.pixels.len())
                .filter(|&i| normal(&forward, i) != Vec3::ZERO)
                .map(|i| degrees(normal(&forward, i), normal(&picture, i)))
                .collect();
            assert!(angles.len() > 2000);
            angles.sort_by(f32::total_cmp);
            let worst = angles[angles.len() - 1 - angles.len() / 1000];
            println!("{name}, {has_gradients}: {worst:.3}° at all but a thousandth of pixels");
            // 10 bits of the prepass; where a crest hides what is behind it, pixels lie on one side or the other.
            assert!(worst < 0.15, "{name}: {worst}°");
        }
    }
}

/// Colours of forward and deferred are the same, and are not those of a flat wall.
#[test]
fn colours_of_deferred_are_those_of_forward() {
    let shoot = |deferred: bool, is_flat: bool| {
        on_stage(move |stage| {
            stage.shoot(
                |camera| {
                    View::front(0.5).set(camera);
                    if deferred {
                        camera.insert(DEFERRED);
                    }
                },
                |world| {
                    let light = Transform::from_xyz(1.5, 0.8, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
                    world.spawn((DirectionalLight::default(), light));
                    let mut wall = wall();
                    wall.base = StandardMaterial {
                        base_color_texture: Some(add(world, checker())),
                        reflectance: 0.0,
                        perceptual_roughness: 1.0,
                        opaque_render_method: method(deferred),
                        ..wall.base
                    };
                    let mut bump = wall.bump(world);
                    if is_flat {
                        bump.parallax = None;
                    }
                    show(world, wall.mesh(), wall.base, Some(bump), wall.at);
                },
            )
        })
    };
    let forward = shoot(false, false);
    assert_same("parallax, deferred", &shoot(true, false), &forward, 0.01);
    let apart = forward.distance(&shoot(false, true));
    println!("parallax moves colours by {:.1} %", 100.0 * apart);
    assert!(apart > 0.1, "{apart}");
}

/// The map may lie on the second texture coordinates.
#[test]
fn the_other_texture_coordinates_can_be_chosen() {
    use bevy::mesh::UvChannel;
    let shoot = |channel: UvChannel| {
        on_stage(move |stage| {
            stage.show_normals(true);
            stage.shoot(
                |camera| View::front(0.5).set(camera),
                |world| {
                    let wall = wall();
                    let mut mesh = wall.mesh();
                    if channel == UvChannel::Uv1 {
                        // Bevy's material needs some of the first too.
                        let uvs = mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0).unwrap();
                        let none = vec![[0.0_f32; 2]; mesh.count_vertices()];
                        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, none);
                        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
                    }
                    let mut bump = wall.bump(world);
                    bump.uv_channel = channel;
                    show(world, mesh, wall.base, Some(bump), wall.at);
                },
            )
        })
    };
    let [first, second] = [UvChannel::Uv0, UvChannel::Uv1].map(shoot);
    assert_same("parallax on UV_1", &second, &first, 0.001);
}

/// Far away relief is flat where it is told to be: as without parallax.
#[test]
fn relief_fades() {
    let fading = |fade| Some(Parallax { fade, ..default() });
    let flat = normals_with(None);
    // The camera is 3 m away.
    let [near, half, far] = [10.0..20.0, 2.0..4.0, 1.0..2.0].map(|fade| normals_with(fading(fade)));
    let [near, half, far] = [near, half, far].map(|picture| picture.distance(&flat));
    println!("apart from flat: {near:.4} before it fades, {half:.4} half-way, {far:.6} behind");
    assert!(near > 1.5 * half && half > 0.01 && far < 1e-6);
}

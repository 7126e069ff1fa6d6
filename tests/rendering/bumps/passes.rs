//! Bump test 14: every way Bevy draws a surface shows the same normals.

use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::pbr::{Lightmap, Material, ScreenSpaceAmbientOcclusion};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::render_resource::AsBindGroup;
use bevy::render::view::Msaa;
use bevy::shader::{Shader, ShaderRef};
use bevy_fresco::plugin::bump::{BumpHeight, insert_uv_gradients};

use super::{bump, degrees, error, normal, on_plane, show, waves_map, waves_on_grid};
use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::picture::{Picture, assert_same};
use crate::scenery::{add, grid, lightmap, lit, skinned};
use crate::stage::{exposure, on_stage};

const HEIGHT: f32 = 0.15;

/// A pane before the scene that shows the normals of the prepass, as ambient occlusion and reflections see
/// them.
#[derive(Asset, AsBindGroup, TypePath, Clone, Default)]
pub(crate) struct PrepassNormals {}

const PANE: Handle<Shader> = bevy::asset::uuid_handle!("0d1f7f0e-6c1c-4a51-9a6d-3f4a5d0f5a11");

impl Material for PrepassNormals {
    fn fragment_shader() -> ShaderRef {
        PANE.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        AlphaMode::Premultiplied
    }
}

const PANE_SHADER: &str = "
#import bevy_pbr::{forward_io::VertexOutput, prepass_utils::prepass_normal}
@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    return vec4(prepass_normal(in.position, 0u), 1.0);
}
";

/// Puts the pane before the scene.
pub(crate) fn show_prepass(world: &mut World, at: Transform) {
    let mut shaders = world.resource_mut::<Assets<Shader>>();
    let shader = Shader::from_wgsl(PANE_SHADER, "pane.wgsl");
    shaders.insert(&PANE, shader).unwrap();
    let pane = Mesh3d(add(world, grid()));
    let material = MeshMaterial3d(add(world, PrepassNormals {}));
    world.spawn((pane, material, at));
}

type Camera = fn(&mut EntityWorldMut);

fn shoot(camera: Camera, deferred: bool, see_prepass: bool, has_gradients: bool) -> Picture {
    on_stage(move |stage| {
        stage.show_normals(!see_prepass && !deferred);
        stage.shoot(
            |eye| {
                if deferred {
                    eye.insert(DEFERRED);
                }
                camera(eye);
            },
            |world| {
                let waves = bump(world, waves_map([256; 2]), BumpHeight::World(HEIGHT));
                let base = StandardMaterial {
                    opaque_render_method: method(deferred),
                    ..default()
                };
                let mut mesh = grid();
                if has_gradients {
                    insert_uv_gradients(&mut mesh).unwrap();
                }
                show(world, mesh, base, Some(waves), default());
                if see_prepass {
                    show_prepass(world, Transform::from_xyz(0.0, 0.0, 0.5));
                }
            },
        )
    })
}

#[test]
fn all_passes_show_the_same_normals() {
    let cases: [(&str, Camera, bool, bool); 7] = [
        ("forward", |_| (), false, false),
        (
            "forward, loaded from the prepass",
            |c| {
                c.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
            },
            false,
            false,
        ),
        (
            "forward, MSAA",
            |c| {
                c.insert(Msaa::Sample4);
            },
            false,
            false,
        ),
        (
            "forward, MSAA with a prepass",
            |c| {
                c.insert((Msaa::Sample4, DepthPrepass, NormalPrepass));
            },
            false,
            false,
        ),
        (
            "the prepass",
            |c| {
                c.insert((DepthPrepass, NormalPrepass));
            },
            false,
            true,
        ),
        (
            "the prepass for ambient occlusion",
            |c| {
                c.insert(ScreenSpaceAmbientOcclusion::default());
            },
            false,
            true,
        ),
        (
            "the prepass of the deferred renderer",
            |c| {
                c.insert(NormalPrepass);
            },
            true,
            true,
        ),
    ];
    for (name, camera, deferred, see_prepass) in cases {
        for has_gradients in [false, true] {
            let picture = shoot(camera, deferred, see_prepass, has_gradients);
            let truth = |i: usize| Some(waves_on_grid(on_plane(&picture, i), HEIGHT));
            let (most, mean) = error(&picture, truth);
            println!("{name}, {has_gradients}: {most:.3}° at most, {mean:.3}° RMS");
            assert!(most < 0.15, "{name}: {most}°");
        }
    }
}

/// The deferred renderer keeps normals where no test can read them, so light is compared: of a light at 60°
/// 0.15° are half a percent.
#[test]
fn deferred_light_is_that_of_forward() {
    let shoot = |deferred: bool| {
        on_stage(move |stage| {
            stage.shoot(
                |camera| {
                    if deferred {
                        camera.insert(DEFERRED);
                    }
                },
                |world| {
                    let light = Transform::from_xyz(1.5, 0.8, 1.0).looking_at(Vec3::ZERO, Vec3::Y);
                    world.spawn((DirectionalLight::default(), light));
                    let waves = bump(world, waves_map([256; 2]), BumpHeight::World(HEIGHT));
                    let base = StandardMaterial {
                        reflectance: 0.0,
                        perceptual_roughness: 1.0,
                        opaque_render_method: method(deferred),
                        ..default()
                    };
                    show(world, grid(), base, Some(waves), default());
                },
            )
        })
    };
    assert_same("bumps, deferred", &shoot(true), &shoot(false), 0.005);
}

/// Normals in the alpha modes whose pixels may be left out, and on skinned meshes.
#[test]
fn other_meshes_and_materials_have_bumps() {
    type Change = fn(&mut World, Entity);
    let no_change: Change = |_, _| ();
    let bind: Change = |world, entity| {
        use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
        let joints = vec![
            world.spawn(Transform::default()).id(),
            world.spawn(Transform::default()).id(),
        ];
        let bind = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
        let inverse_bindposes = add(world, bind);
        world.entity_mut(entity).insert(SkinnedMesh {
            inverse_bindposes,
            joints,
        });
    };
    let cases: [(&str, fn(Mesh) -> Mesh, AlphaMode, Change); 4] = [
        ("mask", |mesh| mesh, AlphaMode::Mask(0.5), no_change),
        ("blend", |mesh| mesh, AlphaMode::Blend, no_change),
        ("skinned", skinned, AlphaMode::Opaque, bind),
        (
            "skinned, with gradients",
            |mesh| {
                let mut mesh = skinned(mesh);
                insert_uv_gradients(&mut mesh).unwrap();
                mesh
            },
            AlphaMode::Opaque,
            bind,
        ),
    ];
    for (name, shape, alpha_mode, change) in cases {
        for has_prepass in [false, true] {
            let picture = on_stage(move |stage| {
                stage.show_normals(true);
                stage.shoot(
                    |camera| {
                        if has_prepass {
                            camera.insert((DepthPrepass, NormalPrepass));
                        }
                    },
                    |world| {
                        let waves = bump(world, waves_map([256; 2]), BumpHeight::World(HEIGHT));
                        let base = StandardMaterial {
                            alpha_mode,
                            perceptual_roughness: 1.0,
                            ..default()
                        };
                        let entity = show(world, shape(grid()), base, Some(waves), default());
                        change(world, entity);
                    },
                )
            });
            let truth = |i: usize| Some(waves_on_grid(on_plane(&picture, i), HEIGHT));
            let (most, _) = error(&picture, truth);
            println!("{name}, {has_prepass}: {most:.3}°");
            assert!(most < 0.15, "{name}: {most}°");
        }
    }
}

/// A bumped wall shows its baked light, and one with a lightmap shows that.
#[test]
fn bumped_walls_have_baked_light() {
    for deferred in [false, true] {
        for mapped in [false, true] {
            let shoot = |has_bump: bool| {
                on_stage(move |stage| {
                    stage.shoot(
                        |camera| {
                            if deferred {
                                camera.insert(DEFERRED);
                            }
                        },
                        |world| {
                            let base = StandardMaterial {
                                opaque_render_method: method(deferred),
                                ..default()
                            };
                            let waves = bump(world, waves_map([64; 2]), BumpHeight::World(HEIGHT));
                            let mesh = if mapped {
                                grid()
                            } else {
                                lit(grid(), Vec3::new(900.0, 500.0, 1300.0))
                            };
                            let waves = has_bump.then_some(waves);
                            let entity = show(world, mesh, base, waves, default());
                            if mapped {
                                let image = add(world, lightmap());
                                world
                                    .entity_mut(entity)
                                    .insert(Lightmap { image, ..default() });
                            }
                        },
                    )
                })
            };
            let (found, smooth) = (shoot(true), shoot(false));
            let shown = smooth.at(0.5, 0.5)[1] / exposure();
            println!("deferred {deferred}, lightmap {mapped}: {shown} cd/m²");
            assert!(shown > 100.0);
            assert_same("baked light on bumps", &found, &smooth, 0.005);
        }
    }
}

/// Relief that leans away beyond what can be seen is bent to the viewer.
#[test]
fn steep_relief_stays_in_sight() {
    for has_prepass in [false, true] {
        let (picture, back) = on_stage(move |stage| {
            stage.show_normals(true);
            let tilt = Quat::from_rotation_x(-1.45);
            let picture = stage.shoot(
                |camera| {
                    if has_prepass {
                        camera.insert((DepthPrepass, NormalPrepass));
                    }
                },
                |world| {
                    let waves = bump(world, waves_map([256; 2]), BumpHeight::World(4.0));
                    let at = Transform::from_rotation(tilt);
                    show(world, grid(), default(), Some(waves), at);
                },
            );
            (picture, tilt * Vec3::Z)
        });
        let mut seen = 0;
        let mut steepest = 0.0_f32;
        for pixel in 0..picture.pixels.len() {
            let n = normal(&picture, pixel);
            if n == Vec3::ZERO {
                continue;
            }
            assert!((n.length() - 1.0).abs() < 2e-3, "{n}");
            let view = -super::ray(&picture, pixel, 1.0, 3.0).normalize();
            // Half floats, and 10 bits of the prepass.
            assert!(n.dot(view) > -3e-3, "{}", n.dot(view));
            steepest = steepest.max(degrees(n, back));
            seen += 1;
        }
        println!("{seen} pixels, up to {steepest:.1}° off the surface");
        assert!(seen > 100 && steepest > 60.0);
    }
}

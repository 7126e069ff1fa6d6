//! Light that is in the bake must not light the same surface a second time.

use bevy::pbr::Lightmap;
use bevy::prelude::*;

use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::picture::Picture;
use crate::scenery::{add, grid, lightmap, lit, show_bevy, show_fresco};
use crate::stage::{exposure, on_stage};

/// How camera and material are drawn.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Forward,
    ForwardInDeferred,
    Deferred,
}

/// A grid that was baked black under one light of each kind.
fn black_under(affects_lightmapped_mesh_diffuse: bool, reflectance: f32, mode: Mode) -> Picture {
    on_stage(move |stage| {
        stage.shoot(
            |camera| {
                if mode != Mode::Forward {
                    camera.insert(DEFERRED);
                }
            },
            |world| {
                let at = Transform::from_xyz(0.0, 0.0, 2.5).looking_at(Vec3::ZERO, Vec3::Y);
                world.spawn((
                    PointLight {
                        intensity: 100_000.0,
                        affects_lightmapped_mesh_diffuse,
                        ..default()
                    },
                    at,
                ));
                world.spawn((
                    SpotLight {
                        intensity: 100_000.0,
                        affects_lightmapped_mesh_diffuse,
                        ..default()
                    },
                    at,
                ));
                world.spawn((
                    DirectionalLight {
                        illuminance: 1000.0,
                        affects_lightmapped_mesh_diffuse,
                        ..default()
                    },
                    at,
                ));
                let base = StandardMaterial {
                    reflectance,
                    perceptual_roughness: 0.3,
                    opaque_render_method: method(mode == Mode::Deferred),
                    ..default()
                };
                show_fresco(world, lit(grid(), Vec3::ZERO), base, default());
            },
        )
    })
}

fn middle(picture: &Picture) -> f32 {
    picture.at(0.5, 0.5)[1]
}

#[test]
fn baked_lights_keep_only_their_highlight() {
    for mode in [Mode::Forward, Mode::ForwardInDeferred] {
        let realtime = middle(&black_under(true, 0.0, mode));
        let baked = middle(&black_under(false, 0.0, mode));
        let glossy = middle(&black_under(false, 0.5, mode));
        println!("realtime {realtime}, baked {baked}, its highlight {glossy}");
        // 1000 lux alone are 1000/π cd/m².
        assert!(realtime > 318.0 * exposure());
        assert!(baked < 1e-3 * realtime, "the diffuse part came twice");
        assert!(glossy > 0.01 * realtime, "the highlight is gone");
    }
}

/// Bevy's deferred lighting knows nothing of lightmaps: the reason why the documentation asks for
/// forward. When this fails, Bevy has learnt it.
#[test]
fn deferred_adds_it_twice_as_bevy_does() {
    let forward = middle(&black_under(true, 0.0, Mode::Forward));
    let deferred = middle(&black_under(false, 0.0, Mode::Deferred));
    println!("deferred adds {deferred} of {forward}");
    assert!((deferred / forward - 1.0).abs() < 0.01);
}

/// As much ambient light as baked light: twice as bright only if it says it affects lightmaps.
#[test]
fn ambient_light_that_was_baked() {
    let shoot = |affects_lightmapped_meshes: bool| {
        let picture = on_stage(move |stage| {
            stage.shoot(
                |_| (),
                |world| {
                    world.insert_resource(GlobalAmbientLight {
                        brightness: 1000.0,
                        affects_lightmapped_meshes,
                        ..default()
                    });
                    show_fresco(
                        world,
                        lit(grid(), Vec3::splat(1000.0)),
                        default(),
                        default(),
                    );
                },
            )
        });
        middle(&picture) / (1000.0 * exposure())
    };
    let [without, with] = [false, true].map(shoot);
    println!("ambient left out {without}, added {with}");
    assert!((without - 1.0).abs() < 0.01);
    assert!(with > 1.3);
}

/// An environment's diffuse part gives way to baked light, and only there.
#[test]
fn environment_gives_way() {
    let shoot = |baked: bool, reflectance: f32| {
        let picture = on_stage(move |stage| {
            stage.shoot(
                |camera| {
                    let light = camera.world_scope(|world| EnvironmentMapLight {
                        intensity: 1000.0,
                        ..EnvironmentMapLight::solid_color(
                            &mut world.resource_mut::<Assets<Image>>(),
                            Color::WHITE,
                        )
                    });
                    camera.insert(light);
                },
                |world| {
                    let mesh = if baked {
                        lit(grid(), Vec3::ZERO)
                    } else {
                        grid()
                    };
                    let base = StandardMaterial {
                        reflectance,
                        ..default()
                    };
                    show_fresco(world, mesh, base, default());
                },
            )
        });
        middle(&picture) / (1000.0 * exposure())
    };
    let without = shoot(true, 0.0);
    let glossy = shoot(true, 0.5);
    let with = shoot(false, 0.0);
    println!("environment on baked {without}, its reflection {glossy}, elsewhere {with}");
    assert!(without < 1e-3);
    assert!(glossy > 0.02);
    assert!(with > 0.9);
}

/// Two entities side by side, one with a texture and one with light on its vertices: neither takes
/// the other's.
#[test]
fn beside_a_lightmapped_entity() {
    let picture = on_stage(|stage| {
        stage.shoot(
            |_| (),
            |world| {
                let half = Vec3::new(0.45, 0.9, 1.0);
                let image = add(world, lightmap());
                let left = Transform::from_xyz(-0.5, 0.0, 0.0).with_scale(half);
                let entity = show_bevy(world, grid(), default(), left);
                world
                    .entity_mut(entity)
                    .insert(Lightmap { image, ..default() });
                let right = Transform::from_xyz(0.5, 0.0, 0.0).with_scale(half);
                show_fresco(world, lit(grid(), Vec3::splat(300.0)), default(), right);
            },
        )
    });
    let right = Vec3::from(picture.at(0.75, 0.5)) / exposure();
    assert!((right - 300.0).abs().max_element() < 3.0, "{right}");
    let left = Vec3::from(picture.at(0.25, 0.5)) / exposure();
    assert!((left.x - 700.0).abs() < 30.0, "{left}");
}

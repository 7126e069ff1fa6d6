//! The same light on vertices and in a texture of Bevy's `Lightmap`: the same picture.

use bevy::camera::Hdr;
use bevy::core_pipeline::oit::OrderIndependentTransparencySettings;
use bevy::core_pipeline::prepass::{
    DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass,
};
use bevy::material::OpaqueRendererMethod;
use bevy::pbr::{Lightmap, ScreenSpaceAmbientOcclusion};
use bevy::prelude::*;
use bevy::render::view::Msaa;

use crate::picture::{Picture, assert_same};
use crate::scenery::{add, checker, grid, grid_lit_unevenly, lightmap, show_bevy, show_fresco};
use crate::stage::on_stage;

/// What makes a camera a deferred one.
pub(crate) const DEFERRED: (DepthPrepass, DeferredPrepass) = (DepthPrepass, DeferredPrepass);

/// How a material of a deferred camera is drawn.
pub(crate) fn method(deferred: bool) -> OpaqueRendererMethod {
    if deferred {
        OpaqueRendererMethod::Deferred
    } else {
        OpaqueRendererMethod::Forward
    }
}

/// What may differ between the pictures.
#[derive(Clone, Copy, Default)]
struct Case {
    camera: Option<fn(&mut EntityWorldMut)>,
    world: Option<fn(&mut World)>,
    base: Option<fn(&mut World) -> StandardMaterial>,
    mesh: Option<fn(Mesh) -> Mesh>,
}

fn tilted() -> Transform {
    Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, -0.5, 0.4, 0.1))
}

impl Case {
    fn shoot(self, through_vertices: bool) -> Picture {
        on_stage(move |stage| {
            let camera = self.camera.unwrap_or(|_| ());
            stage.shoot(camera, move |world| {
                self.world.unwrap_or(|_| ())(world);
                let base = self
                    .base
                    .map_or_else(StandardMaterial::default, |b| b(world));
                let shape = self.mesh.unwrap_or(|mesh| mesh);
                if through_vertices {
                    show_fresco(world, shape(grid_lit_unevenly()), base, tilted());
                } else {
                    let image = add(world, lightmap());
                    let entity = show_bevy(world, shape(grid()), base, tilted());
                    world
                        .entity_mut(entity)
                        .insert(Lightmap { image, ..default() });
                }
            })
        })
    }

    fn compare(self, name: &str) {
        let [found, expected] = [true, false].map(|vertices| self.shoot(vertices));
        assert_same(name, &found, &expected, 0.01);
    }
}

fn point_light(world: &mut World) {
    world.spawn((
        PointLight {
            intensity: 50_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(0.5, 0.8, 1.5),
    ));
}

fn deferred_base(_: &mut World) -> StandardMaterial {
    StandardMaterial {
        base_color: Color::linear_rgb(0.8, 0.6, 0.4),
        opaque_render_method: OpaqueRendererMethod::Deferred,
        ..default()
    }
}

fn blended(world: &mut World, alpha_mode: AlphaMode) -> StandardMaterial {
    StandardMaterial {
        base_color_texture: Some(add(world, checker())),
        alpha_mode,
        ..default()
    }
}

#[test]
fn forward() {
    Case::default().compare("forward");
}

#[test]
fn forward_with_point_light_and_shadows() {
    let world: Option<fn(&mut World)> = Some(point_light);
    Case { world, ..default() }.compare("point light");
}

#[test]
fn forward_with_prepasses() {
    Case {
        camera: Some(|camera| {
            camera.insert((DepthPrepass, NormalPrepass, MotionVectorPrepass));
        }),
        world: Some(point_light),
        ..default()
    }
    .compare("prepasses");
}

#[test]
fn multisampled() {
    Case {
        camera: Some(|camera| {
            camera.insert((Msaa::Sample4, DepthPrepass, NormalPrepass));
        }),
        world: Some(point_light),
        ..default()
    }
    .compare("multisampled");
}

#[test]
fn eight_bits() {
    Case {
        camera: Some(|camera| {
            camera.remove::<Hdr>();
        }),
        ..default()
    }
    .compare("eight bits");
}

#[test]
fn tonemapped_in_the_shader() {
    Case {
        camera: Some(|camera| {
            camera.remove::<Hdr>();
            camera.insert(bevy::core_pipeline::tonemapping::Tonemapping::AcesFitted);
        }),
        world: Some(point_light),
        ..default()
    }
    .compare("tonemapped");
}

#[test]
fn ambient_light() {
    for affects_lightmapped_meshes in [false, true] {
        let set: fn(&mut World) = if affects_lightmapped_meshes {
            |world| {
                world.insert_resource(GlobalAmbientLight {
                    brightness: 500.0,
                    affects_lightmapped_meshes: true,
                    ..default()
                });
            }
        } else {
            |world| {
                world.insert_resource(GlobalAmbientLight {
                    brightness: 500.0,
                    affects_lightmapped_meshes: false,
                    ..default()
                });
            }
        };
        Case {
            world: Some(set),
            ..default()
        }
        .compare(&format!("ambient {affects_lightmapped_meshes}"));
    }
}

#[test]
fn ambient_occlusion() {
    Case {
        camera: Some(|camera| {
            camera.insert(ScreenSpaceAmbientOcclusion::default());
        }),
        world: Some(|world| {
            world.insert_resource(GlobalAmbientLight {
                brightness: 500.0,
                ..default()
            });
            point_light(world);
            // Something to be occluded by.
            let cube = Mesh::from(Cuboid::from_length(0.7));
            show_bevy(world, cube, default(), tilted());
        }),
        ..default()
    }
    .compare("ambient occlusion");
}

#[test]
fn deferred() {
    Case {
        camera: Some(|camera| {
            camera.insert(DEFERRED);
        }),
        world: Some(point_light),
        base: Some(deferred_base),
        ..default()
    }
    .compare("deferred");
}

#[test]
fn deferred_with_motion_vectors_and_normals() {
    Case {
        camera: Some(|camera| {
            camera.insert((DEFERRED, NormalPrepass, MotionVectorPrepass));
        }),
        world: Some(point_light),
        base: Some(deferred_base),
        ..default()
    }
    .compare("deferred with all prepasses");
}

/// Where no light leaves anything out, both renderers show the same.
#[test]
fn deferred_as_forward() {
    let case = |deferred: bool| Case {
        camera: Some(if deferred {
            |camera| {
                camera.insert(DEFERRED);
            }
        } else {
            |_| ()
        }),
        world: Some(point_light),
        base: Some(if deferred {
            deferred_base
        } else {
            |world| StandardMaterial {
                opaque_render_method: OpaqueRendererMethod::Forward,
                ..deferred_base(world)
            }
        }),
        ..default()
    };
    let [deferred, forward] = [true, false].map(|d| case(d).shoot(true));
    assert_same("deferred as forward", &deferred, &forward, 0.01);
}

#[test]
fn alpha() {
    let bases: [(&str, fn(&mut World) -> StandardMaterial); 4] = [
        ("mask", |world| blended(world, AlphaMode::Mask(0.5))),
        ("blend", |world| blended(world, AlphaMode::Blend)),
        ("add", |world| blended(world, AlphaMode::Add)),
        ("premultiplied", |world| {
            blended(world, AlphaMode::Premultiplied)
        }),
    ];
    for (name, base) in bases {
        Case {
            world: Some(point_light),
            base: Some(base),
            ..default()
        }
        .compare(name);
    }
}

#[test]
fn order_independent_transparency() {
    Case {
        camera: Some(|camera| {
            camera.insert(OrderIndependentTransparencySettings::default());
        }),
        world: Some(point_light),
        base: Some(|world| blended(world, AlphaMode::Blend)),
        ..default()
    }
    .compare("order independent");
}

#[test]
fn alpha_mask_deferred() {
    Case {
        camera: Some(|camera| {
            camera.insert(DEFERRED);
        }),
        world: Some(point_light),
        base: Some(|world| StandardMaterial {
            opaque_render_method: OpaqueRendererMethod::Deferred,
            ..blended(world, AlphaMode::Mask(0.5))
        }),
        ..default()
    }
    .compare("mask deferred");
}

#[test]
fn alpha_to_coverage() {
    Case {
        camera: Some(|camera| {
            camera.insert(Msaa::Sample4);
        }),
        base: Some(|world| blended(world, AlphaMode::AlphaToCoverage)),
        ..default()
    }
    .compare("alpha to coverage");
}

#[test]
fn specular_transmission() {
    Case {
        world: Some(point_light),
        base: Some(|_| StandardMaterial {
            specular_transmission: 0.4,
            ..default()
        }),
        ..default()
    }
    .compare("specular transmission");
}

#[test]
fn clearcoat_and_tangents() {
    Case {
        world: Some(point_light),
        base: Some(|_| StandardMaterial {
            clearcoat: 1.0,
            ..default()
        }),
        mesh: Some(|mesh| {
            let count = mesh.count_vertices();
            mesh.with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, 1.0]; count])
        }),
        ..default()
    }
    .compare("clearcoat");
}

#[test]
fn fog() {
    Case {
        camera: Some(|camera| {
            camera.insert(DistanceFog {
                color: Color::WHITE,
                falloff: FogFalloff::Linear {
                    start: 1.0,
                    end: 6.0,
                },
                ..default()
            });
        }),
        ..default()
    }
    .compare("fog");
}

/// An entity with a `Lightmap` shows that, not its vertices' light.
#[test]
fn a_real_lightmap_comes_first() {
    let shoot = |ours: bool| {
        on_stage(move |stage| {
            stage.shoot(
                |_| (),
                move |world| {
                    let image = add(world, lightmap());
                    let entity = if ours {
                        let mesh = crate::scenery::lit(grid(), Vec3::splat(9000.0));
                        show_fresco(world, mesh, default(), tilted())
                    } else {
                        show_bevy(world, grid(), default(), tilted())
                    };
                    world
                        .entity_mut(entity)
                        .insert(Lightmap { image, ..default() });
                },
            )
        })
    };
    assert_same("real lightmap", &shoot(true), &shoot(false), 1e-4);
}

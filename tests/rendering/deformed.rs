//! Skins, morph targets and ranges of visibility: light stays on the vertices that move.
//!
//! Bevy's own `Lightmap` cannot be had here, so the other picture is of an unlit surface.

use bevy::camera::visibility::VisibilityRange;
use bevy::core_pipeline::prepass::{MotionVectorPrepass, NormalPrepass};
use bevy::mesh::morph::{MeshMorphWeights, MorphAttributes, MorphWeights};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::picture::assert_same;
use crate::scenery::{add, grid, lit, show_bevy, show_fresco, skinned};
use crate::stage::{exposure, on_stage};

const LIGHT: Vec3 = Vec3::new(900.0, 500.0, 1300.0);

/// Compares a lit mesh with an unlit one, drawn in the modes that have vertex shaders of their own.
fn compare(name: &'static str, shape: fn(Mesh) -> Mesh, pose: fn(&mut World, Entity)) {
    for deferred in [false, true] {
        let shoot = |baked: bool| {
            on_stage(move |stage| {
                stage.shoot(
                    |camera| {
                        camera.insert((NormalPrepass, MotionVectorPrepass));
                        if deferred {
                            camera.insert(DEFERRED);
                        }
                    },
                    |world| {
                        let opaque_render_method = method(deferred);
                        let at = Transform::from_scale(Vec3::splat(0.5));
                        let shown = LIGHT * exposure();
                        let entity = if baked {
                            let base = StandardMaterial {
                                opaque_render_method,
                                ..default()
                            };
                            show_fresco(world, lit(shape(grid()), LIGHT), base, at)
                        } else {
                            let base = StandardMaterial {
                                base_color: Color::linear_rgb(shown.x, shown.y, shown.z),
                                unlit: true,
                                opaque_render_method,
                                ..default()
                            };
                            show_bevy(world, shape(grid()), base, at)
                        };
                        pose(world, entity);
                    },
                )
            })
        };
        let name = format!("{name} {}", if deferred { "deferred" } else { "forward" });
        assert_same(&name, &shoot(true), &shoot(false), 0.01);
    }
}

#[test]
fn skinned_mesh() {
    compare("skinned", skinned, |world, entity| {
        let still = world.spawn(Transform::default()).id();
        let moved = world
            .spawn(Transform::from_xyz(0.8, 0.6, 0.0).with_scale(Vec3::splat(0.5)))
            .id();
        let bind = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
        let inverse_bindposes = add(world, bind);
        world.entity_mut(entity).insert(SkinnedMesh {
            inverse_bindposes,
            joints: vec![still, moved],
        });
    });
}

fn morphed(mesh: Mesh) -> Mesh {
    let count = mesh.count_vertices();
    let target = (0..count)
        .map(|i| MorphAttributes {
            position: Vec3::new(0.5, (i % 7) as f32 * 0.05, 0.0),
            ..default()
        })
        .collect();
    mesh.with_morph_targets(target)
}

fn half_way(world: &mut World, entity: Entity) {
    let mesh = world.get::<Mesh3d>(entity).unwrap().0.clone();
    world.entity_mut(entity).insert((
        MorphWeights::new(vec![0.5], Some(mesh)).unwrap(),
        MeshMorphWeights::Value { weights: vec![0.5] },
    ));
}

#[test]
fn morphed_mesh() {
    compare("morphed", morphed, half_way);
}

#[test]
fn fading_with_distance() {
    compare(
        "fading",
        |mesh| mesh,
        |world, entity| {
            world.entity_mut(entity).insert(VisibilityRange {
                start_margin: 0.0..0.0,
                end_margin: 2.0..4.0,
                use_aabb: false,
            });
        },
    );
}

//! Light that arrives, changes and goes while the app runs, in the ways an app brings it.

use bevy::core_pipeline::prepass::{MotionVectorPrepass, NormalPrepass};
use bevy::prelude::*;
use bevy_fresco::plugin::{ATTRIBUTE_BAKED_LIGHT, FrescoMaterial};

use crate::like_bevys_lightmap::{DEFERRED, method};
use crate::scenery::{add, fresco, grid, lit, show_bevy};
use crate::stage::{exposure, on_stage};

fn base(deferred: bool) -> StandardMaterial {
    StandardMaterial {
        opaque_render_method: method(deferred),
        ..default()
    }
}

type Change = fn(&mut World, Entity);

/// What is done to the entity, and what it then shows in cd/m².
const CHANGES: [(&str, Change, f32); 7] = [
    ("light in Bevy's material", put_light_into_mesh, 0.0),
    ("our material", swap_material, 500.0),
    (
        "other light in the mesh",
        |w, e| relight(w, e, 900.0),
        900.0,
    ),
    ("no light in the mesh", take_light_out_of_mesh, 0.0),
    ("light in the mesh again", put_light_into_mesh, 500.0),
    ("another mesh", swap_mesh, 300.0),
    ("gain", halve_gain, 150.0),
];

fn change_mesh(world: &mut World, entity: Entity, change: impl FnOnce(&mut Mesh)) {
    let handle = world.get::<Mesh3d>(entity).unwrap().0.clone();
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    change(&mut meshes.get_mut(&handle).unwrap());
}

fn relight(world: &mut World, entity: Entity, light: f32) {
    change_mesh(world, entity, |mesh| {
        let count = mesh.count_vertices();
        mesh.insert_attribute(ATTRIBUTE_BAKED_LIGHT, vec![[light; 3]; count]);
    });
}

fn put_light_into_mesh(world: &mut World, entity: Entity) {
    relight(world, entity, 500.0);
}

fn take_light_out_of_mesh(world: &mut World, entity: Entity) {
    change_mesh(world, entity, |mesh| {
        mesh.remove_attribute(ATTRIBUTE_BAKED_LIGHT);
    });
}

fn swap_mesh(world: &mut World, entity: Entity) {
    let mesh = add(world, lit(grid(), Vec3::splat(300.0)));
    world.entity_mut(entity).insert(Mesh3d(mesh));
}

fn swap_material(world: &mut World, entity: Entity) {
    let bevys = world.get::<MeshMaterial3d<StandardMaterial>>(entity);
    let bevys = bevys.unwrap().0.clone();
    let base = world.resource::<Assets<StandardMaterial>>().get(&bevys);
    let ours = fresco(base.unwrap().clone());
    let ours = MeshMaterial3d(add(world, ours));
    world
        .entity_mut(entity)
        .remove::<MeshMaterial3d<StandardMaterial>>()
        .insert(ours);
}

fn halve_gain(world: &mut World, entity: Entity) {
    let handle = world.get::<MeshMaterial3d<FrescoMaterial>>(entity);
    let handle = handle.unwrap().0.clone();
    let mut materials = world.resource_mut::<Assets<FrescoMaterial>>();
    let mut material = materials.get_mut(&handle).unwrap();
    material.extension.baked_light_gain = 0.5;
}

#[test]
fn light_follows_what_the_app_does() {
    for deferred in [false, true] {
        on_stage(move |stage| {
            let mut entity = Entity::PLACEHOLDER;
            stage.shoot(
                |camera| {
                    camera.insert((NormalPrepass, MotionVectorPrepass));
                    if deferred {
                        camera.insert(DEFERRED);
                    }
                },
                |world| {
                    // Something to be seen while the grid is black.
                    let lamp = StandardMaterial {
                        emissive: LinearRgba::WHITE,
                        ..base(deferred)
                    };
                    let at = Transform::from_xyz(-0.8, 0.8, 0.2).with_scale(Vec3::splat(0.05));
                    show_bevy(world, grid(), lamp, at);
                    entity = show_bevy(world, grid(), base(deferred), default());
                },
            );
            for (name, change, expected) in CHANGES {
                let picture = stage.change(|world| change(world, entity));
                let found = picture.at(0.5, 0.5)[0] / exposure();
                println!("{name}: {found}");
                assert!(
                    (found - expected).abs() < 0.01 * expected.max(1.0),
                    "{name}: {found}"
                );
            }
        });
    }
}

//! Meshes raised by height maps under baked light: source, displaced, lit.

use bevy::prelude::*;
use bevy_fresco::plugin::displacement::{DisplacedMesh, Displacement, DisplacementStatus};
use bevy_fresco::plugin::radiosity::{BakedLighting, NoStaticLighting};

use crate::displaced::{TRIANGLES, Writes, by_texels, count_writes};
use crate::world::Room;

/// A room whose red wall is raised by `scale`, its light up to date.
fn room(scale: f32) -> Room {
    let mut room = Room::new();
    let wall = room.red_wall;
    room.app
        .init_resource::<Writes>()
        .add_systems(Last, count_writes);
    let displacement = by_texels(room.world(), scale);
    room.world().entity_mut(wall).insert(displacement);
    room.settle();
    room
}

/// Source, displaced and lit mesh of the wall, which must show the lit one.
fn chain(room: &Room) -> [Handle<Mesh>; 3] {
    let world = room.app.world();
    let made = world.get::<DisplacedMesh>(room.red_wall).unwrap();
    let baked = world.get::<BakedLighting>(room.red_wall).unwrap();
    assert_eq!(baked.source, made.displaced);
    assert_eq!(world.get::<Mesh3d>(room.red_wall).unwrap().0, baked.lit);
    [
        made.source.clone(),
        made.displaced.clone(),
        baked.lit.clone(),
    ]
}

fn positions(room: &Room, mesh: &Handle<Mesh>) -> Vec<[f32; 3]> {
    let mesh = room.app.world().resource::<Assets<Mesh>>().get(mesh);
    let positions = mesh.unwrap().attribute(Mesh::ATTRIBUTE_POSITION);
    positions.unwrap().as_float3().unwrap().to_vec()
}

fn set_scale(room: &mut Room, scale: f32) {
    let wall = room.red_wall;
    room.edit::<Displacement>(wall, |d| d.settings.scale = scale);
}

#[test]
fn light_is_baked_on_the_raised_mesh() {
    let mut room = room(0.3);
    let [source, displaced, lit] = chain(&room);
    assert_eq!(positions(&room, &lit), positions(&room, &displaced));
    let light = room.light(room.red_wall);
    assert_eq!(light.len(), positions(&room, &lit).len());
    assert!(light.iter().all(|l| l.is_finite()) && light.iter().any(|l| l.max_element() > 1.0));
    let status = room.app.world().get::<DisplacementStatus>(room.red_wall);
    let triangles = status.unwrap().report().unwrap().triangles;
    assert_eq!(triangles as usize, TRIANGLES);
    // The source is as it was, and one bake was enough: it waited for the relief.
    assert_eq!(positions(&room, &source).len(), 4);
    assert_eq!(room.status().finished, 1);
    room.settle();
    assert_eq!(room.status().finished, 1);
}

#[test]
fn nobody_writes_for_ever() {
    let mut room = room(0.3);
    for _ in 0..5 {
        room.app.update();
    }
    let before = room.app.world().resource::<Writes>().0;
    // One by who spawned it, one raised, one lit; and Bevy marks meshes of new materials, in the same frame or the
    // next.
    assert!(before <= 4, "{before} writes");
    let (shown, finished) = (chain(&room), room.status().finished);
    for _ in 0..300 {
        room.app.update();
    }
    assert_eq!(room.app.world().resource::<Writes>().0, before);
    assert_eq!(chain(&room), shown);
    assert_eq!(room.status().finished, finished);
}

#[test]
fn new_relief_is_lit_anew() {
    let mut room = room(0.1);
    let (before, light) = (chain(&room), room.light(room.red_wall));
    set_scale(&mut room, 0.4);
    room.settle();
    let after = chain(&room);
    assert_eq!(after[0], before[0]);
    assert_ne!(after[1], before[1]);
    assert_eq!(positions(&room, &after[2]), positions(&room, &after[1]));
    assert_ne!(room.light(room.red_wall), light);
}

/// Relief that is another for a moment and then as before has its light at once: no bake would bring it.
#[test]
fn relief_that_comes_back_has_its_light() {
    let mut room = room(0.1);
    let light = room.light(room.red_wall);
    let wall = room.red_wall;
    let source = chain(&room)[0].clone();
    room.edit::<Mesh3d>(wall, |shown| shown.0 = source.clone());
    room.settle();
    for _ in 0..5 {
        room.app.update();
    }
    assert_eq!(chain(&room)[0], source);
    assert_eq!(room.light(wall), light);
}

#[test]
fn links_are_taken_out_one_by_one() {
    let mut room = room(0.2);
    let wall = room.red_wall;
    let [source, displaced, _] = chain(&room);
    let shown = |room: &Room| room.app.world().get::<Mesh3d>(wall).unwrap().0.clone();
    // Without light it is the raised mesh still.
    room.world().entity_mut(wall).insert(NoStaticLighting);
    room.settle();
    assert_eq!(shown(&room), displaced);
    room.world().entity_mut(wall).remove::<NoStaticLighting>();
    room.settle();
    assert_eq!(chain(&room)[1], displaced);
    // Without relief it is the source, lit.
    room.world().entity_mut(wall).remove::<Displacement>();
    room.settle();
    let world = room.app.world();
    let baked = world.get::<BakedLighting>(wall).unwrap();
    assert_eq!(baked.source, source);
    assert_eq!(shown(&room), baked.lit);
    assert!(world.get::<DisplacedMesh>(wall).is_none());
    room.world().entity_mut(wall).insert(NoStaticLighting);
    room.settle();
    assert_eq!(shown(&room), source);
}

/// A clone shows the lit copy of the other at first, and must not be raised twice.
#[test]
fn clones_of_lit_relief_are_raised_once() {
    let mut room = room(0.2);
    let wall = room.red_wall;
    let [source, displaced, _] = chain(&room);
    let clone = room.world().entity_mut(wall).clone_and_spawn();
    room.settle();
    let world = room.app.world();
    let made = world.get::<DisplacedMesh>(clone).unwrap();
    assert_eq!(made.source, source);
    let (first, second) = (displaced, made.displaced.clone());
    assert_eq!(positions(&room, &first), positions(&room, &second));
}

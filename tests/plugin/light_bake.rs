//! Light that is saved in one world and shown in another.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_fresco::plugin::radiosity::{BakedLighting, RadiositySettings, StaticLighting};
use bevy_fresco::plugin::{
    ATTRIBUTE_BAKED_LIGHT, ATTRIBUTE_BAKED_LIGHT_GRADIENT, FrescoView, LightBake, LightBakeError,
    LightBakeId, LitBy, LitByStatus,
};
use bevy_fresco::radiosity::BakeSettings;

use crate::world::{Room, is_moved, material, mesh, settings};

/// A lit room whose meshes were split for the light.
fn baked() -> (Room, LightBake) {
    let mut room = Room::new();
    room.world().insert_resource(RadiositySettings {
        bake: BakeSettings {
            refine: true,
            directional: true,
            error: 0.1,
            ..settings().bake
        },
        ..settings()
    });
    room.settle();
    let root = room.root;
    let bake = LightBake::of(room.world(), root).unwrap();
    (room, bake)
}

/// The same room in another world, where nothing is baked and meshes get what was saved.
fn shown(bake: LightBake, edit: impl FnOnce(&mut Room)) -> Room {
    let mut room = Room::new();
    let root = room.root;
    edit(&mut room);
    let handle = room.world().resource_mut::<Assets<LightBake>>().add(bake);
    room.world()
        .entity_mut(root)
        .remove::<StaticLighting>()
        .insert(LitBy(handle));
    for _ in 0..5 {
        room.app.update();
    }
    room
}

fn status(room: &Room) -> &LitByStatus {
    room.app.world().get(room.root).unwrap()
}

fn values(
    room: &Room,
    entity: Entity,
    attribute: bevy::mesh::MeshVertexAttribute,
) -> &VertexAttributeValues {
    let world = room.app.world();
    let mesh = world.get::<Mesh3d>(entity).unwrap();
    let mesh = world.resource::<Assets<Mesh>>().get(mesh).unwrap();
    mesh.attribute(attribute).unwrap()
}

#[test]
fn meshes_get_the_light_that_was_saved() {
    let (room, bake) = baked();
    let bytes = bake.to_bytes();
    let read = LightBake::from_bytes(&bytes).unwrap();
    assert_eq!(read, bake);
    assert_eq!(read.len(), 4);
    let again = shown(read, |_| ());
    let done = LitByStatus {
        lit: 4,
        ..default()
    };
    assert_eq!(*status(&again), done);
    for (there, here) in [
        (room.walls, again.walls),
        (room.red_wall, again.red_wall),
        (room.block, again.block),
        (room.lamp, again.lamp),
    ] {
        for attribute in [
            ATTRIBUTE_BAKED_LIGHT,
            ATTRIBUTE_BAKED_LIGHT_GRADIENT,
            Mesh::ATTRIBUTE_POSITION,
            Mesh::ATTRIBUTE_NORMAL,
            Mesh::ATTRIBUTE_UV_0,
        ] {
            let [a, b] = [
                values(&room, there, attribute),
                values(&again, here, attribute),
            ];
            assert_eq!(a.get_bytes(), b.get_bytes(), "{}", attribute.name);
        }
        assert!(is_moved(&again.app, here));
        assert!(again.app.world().get::<BakedLighting>(here).is_none());
    }
    // The light is not baked into the file a second time, nor switched off.
    let point = again.app.world().get::<PointLight>(again.point).unwrap();
    assert!(!point.affects_lightmapped_mesh_diffuse);
}

#[test]
fn damaged_files_are_told_from_sound_ones() {
    let (_, bake) = baked();
    let bytes = bake.to_bytes();
    for end in (0..bytes.len()).step_by(1 + bytes.len() / 500) {
        assert!(LightBake::from_bytes(&bytes[..end]).is_err(), "{end}");
    }
    // Some changes only make other light: none may panic, or be taken for more than there is.
    for at in (0..bytes.len()).step_by(1 + bytes.len() / 2000) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x55;
        if let Ok(read) = LightBake::from_bytes(&changed) {
            assert_eq!(read.len(), bake.len());
        }
    }
    let mut longer = bytes.clone();
    longer.push(0);
    let error = LightBake::from_bytes(&longer).unwrap_err().to_string();
    assert!(error.contains("damaged"), "{error}");
    let error = LightBake::from_bytes(b"glTF").unwrap_err().to_string();
    assert!(error.contains("no light_bake"), "{error}");
}

#[test]
fn twins_are_told_apart_by_ids() {
    let mut room = Room::new();
    let root = room.root;
    let shape = mesh(room.world(), Cuboid::new(0.1, 0.1, 0.1).into());
    let white = material(room.world(), Color::WHITE);
    let mut twin = |x: f32| {
        room.world()
            .spawn((
                Name::new("twin"),
                Mesh3d(shape.clone()),
                MeshMaterial3d(white.clone()),
                Transform::from_xyz(x, 0.2, 0.4),
                ChildOf(root),
            ))
            .id()
    };
    let (left, right) = (twin(-0.3), twin(0.3));
    room.settle();
    let error = LightBake::of(room.world(), root).unwrap_err();
    assert!(
        matches!(&error, LightBakeError::Ambiguous(name) if name.contains("twin")),
        "{error}"
    );
    for (entity, id) in [(left, "left"), (right, "right")] {
        let mut entity = room.world().entity_mut(entity);
        entity.insert(LightBakeId(id.into()));
    }
    assert_eq!(LightBake::of(room.world(), root).unwrap().len(), 6);
}

#[test]
fn other_meshes_get_no_light_and_it_is_said() {
    let (_, bake) = baked();
    let room = shown(bake, |room| {
        let other = mesh(room.world(), Cuboid::new(0.6, 0.6, 0.61).into());
        let block = room.block;
        room.world().entity_mut(block).insert(Mesh3d(other));
        let lamp = room.lamp;
        room.world().entity_mut(lamp).despawn();
    });
    let status = status(&room);
    assert_eq!((status.lit, status.waiting), (2, 1));
    let [problem] = &*status.problems else {
        panic!("{status:?}");
    };
    assert!(
        problem.contains("\"block\"") && problem.contains("another mesh"),
        "{problem}"
    );
}

#[test]
fn what_comes_later_gets_its_light_then() {
    let (_, bake) = baked();
    let (mut own, mut name) = (None, None);
    let mut room = shown(bake, |room| {
        let (block, lamp) = (room.block, room.lamp);
        own = room.world().entity_mut(block).take::<Mesh3d>();
        name = room.world().entity_mut(lamp).take::<Name>();
    });
    assert_eq!((status(&room).lit, status(&room).waiting), (2, 2));
    let (block, lamp) = (room.block, room.lamp);
    room.world().entity_mut(lamp).insert(name.unwrap());
    room.app.update();
    assert_eq!((status(&room).lit, status(&room).waiting), (3, 1));
    // There, but not loaded.
    let mesh = own.unwrap();
    let loaded = room.world().resource_mut::<Assets<Mesh>>().remove(&mesh.0);
    let handle = room.world().resource::<Assets<Mesh>>().reserve_handle();
    let entity = Mesh3d(handle.clone());
    room.world().entity_mut(block).insert(entity);
    for _ in 0..3 {
        room.app.update();
    }
    assert_eq!((status(&room).lit, status(&room).waiting), (3, 1));
    let mut meshes = room.world().resource_mut::<Assets<Mesh>>();
    meshes.insert(&handle, loaded.unwrap()).unwrap();
    for _ in 0..3 {
        room.app.update();
    }
    assert_eq!((status(&room).lit, status(&room).waiting), (4, 0));
}

#[test]
fn only_all_of_the_light_is_saved() {
    let mut room = Room::new();
    let root = room.root;
    let of = |room: &mut Room| LightBake::of(room.world(), root).map(|bake| bake.len());
    assert_eq!(of(&mut room), Err(LightBakeError::NotUpToDate));
    room.settle();
    assert_eq!(of(&mut room), Ok(4));
    for view in [
        FrescoView::Indirect,
        FrescoView::Elements,
        FrescoView::Error,
    ] {
        room.world().insert_resource(view);
        room.settle();
        assert_eq!(of(&mut room), Err(LightBakeError::View));
    }
    room.world().insert_resource(FrescoView::Irradiance);
    room.settle();
    assert_eq!(of(&mut room), Ok(4));
    let point = room.point;
    assert_eq!(
        LightBake::of(room.world(), point).unwrap_err(),
        LightBakeError::Nothing
    );
}

#[test]
fn files_are_whole_or_not_there() {
    let (_, bake) = baked();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.light_bake");
    bake.write(&path).unwrap();
    bake.write(&path).unwrap();
    let read = LightBake::from_bytes(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(read, bake);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(
        bake.write(folder.path().join("nowhere/room.light_bake"))
            .is_err()
    );
    // What is in the way stays.
    let taken = folder.path().join("taken.light_bake");
    std::fs::create_dir(&taken).unwrap();
    assert!(bake.write(&taken).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

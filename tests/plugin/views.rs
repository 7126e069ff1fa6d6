//! What meshes carry for views, and that light is what it was afterwards.

use bevy::prelude::*;
use bevy_fresco::plugin::FrescoView;
use bevy_fresco::plugin::radiosity::{RadiosityGizmos, RadiositySettings};

use crate::world::Room;

fn look(room: &mut Room, view: FrescoView) {
    room.world().insert_resource(view);
    room.settle();
}

#[test]
fn views_come_and_go_without_a_ray() {
    let mut room = Room::lit();
    let shaded = room.all_light();
    for (view, name) in FrescoView::ALL {
        look(&mut room, view);
        let work = room.report().work;
        assert!(
            room.status().finished == 1 || work.rays() == 0,
            "{name}: {work:?}"
        );
        for (entity, values) in room.all_light() {
            assert!(!values.is_empty(), "{name}: {entity}");
            let is_sound = |v: &Vec3| v.is_finite() && v.min_element() >= 0.0;
            assert!(values.iter().all(is_sound), "{name}: {entity}");
        }
    }
    look(&mut room, FrescoView::Shaded);
    assert_eq!(room.all_light(), shaded);
}

#[test]
fn parts_of_the_light_add_up() {
    let mut room = Room::lit();
    let all = room.all_light();
    look(&mut room, FrescoView::Direct);
    let direct = room.all_light();
    look(&mut room, FrescoView::Indirect);
    let indirect = room.all_light();
    let (mut rest, mut level) = (0.0, 0.0);
    for ((all, direct), indirect) in all.iter().zip(&direct).zip(&indirect) {
        for ((a, d), i) in all.1.iter().zip(&direct.1).zip(&indirect.1) {
            rest += (*a - *d - *i).length_squared();
            level += a.length_squared();
        }
    }
    let apart = (rest / level).sqrt();
    assert!(apart < 0.03, "{apart}");
}

#[test]
fn elements_tile_their_surfaces() {
    let mut room = Room::lit();
    // Turned, moved and stretched: elements come back in the mesh's own space.
    room.edit::<Transform>(room.block, |at| {
        at.rotate_y(0.3);
        at.scale = Vec3::new(1.0, 1.2, 0.8);
    });
    look(&mut room, FrescoView::Elements);
    let world = room.app.world();
    let shown = world.get::<Mesh3d>(room.block).unwrap();
    let mesh = world.resource::<Assets<Mesh>>().get(shown).unwrap();
    let corners = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
    let corners: Vec<Vec3> = (corners.as_float3().unwrap().iter())
        .map(|&p| p.into())
        .collect();
    let normals = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).unwrap();
    let mut area = 0.0;
    for (t, normal) in corners
        .as_chunks::<3>()
        .0
        .iter()
        .zip(normals.as_float3().unwrap().iter().step_by(3))
    {
        let cross = (t[1] - t[0]).cross(t[2] - t[0]);
        assert!(cross.dot((*normal).into()) > 0.0);
        area += 0.5 * cross.length();
        for corner in t {
            let far = corner.abs().max_element();
            assert!((far - 0.3).abs() < 1e-4, "{corner} is not on the block");
        }
    }
    let truth = 6.0 * 0.6 * 0.6;
    assert!((area / truth - 1.0).abs() < 1e-3, "{area} for {truth}");
}

/// Ends of all lines that are drawn, two by two.
fn lines(room: &mut Room) -> Vec<[Vec3; 2]> {
    let world = room.world();
    let mut shown = world.query::<&Mesh3d>();
    let handles: Vec<_> = shown.iter(world).map(|mesh| mesh.0.clone()).collect();
    let meshes = world.resource::<Assets<Mesh>>();
    let mut ends = Vec::new();
    for mesh in handles.iter().filter_map(|handle| meshes.get(handle)) {
        if mesh.primitive_topology() == bevy::mesh::PrimitiveTopology::LineList {
            let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
            let positions = positions.as_float3().unwrap().as_chunks::<2>().0;
            ends.extend(positions.iter().map(|ends| ends.map(Vec3::from)));
        }
    }
    ends
}

fn draw(room: &mut Room, gizmos: RadiosityGizmos) -> Vec<[Vec3; 2]> {
    let finished = room.status().finished;
    room.world().insert_resource(gizmos);
    for _ in 0..3 {
        room.app.update();
    }
    assert_eq!(room.status().finished, finished, "lines are no change");
    lines(room)
}

#[test]
fn lines_show_what_an_element_sees() {
    let mut room = Room::lit();
    assert!(lines(&mut room).is_empty());
    // Down onto the floor, in front of the block.
    let ray = Ray3d {
        origin: Vec3::new(-0.5, 0.0, 0.5),
        direction: Dir3::NEG_Y,
    };
    let seen = draw(
        &mut room,
        RadiosityGizmos {
            form_factors: Some(ray),
            ..default()
        },
    );
    let from = seen[0][0];
    // Elements have sides of half a metre here.
    assert!(from.distance(Vec3::new(-0.5, -1.0, 0.5)) < 0.5, "{from}");
    let sights: Vec<_> = seen.iter().filter(|ends| ends[0] == from).collect();
    assert!(sights.len() > 50, "{}", sights.len());
    // All of it is above the floor and in the room.
    let is_seen = |to: Vec3| to.y > -1.0 && to.abs().max_element() < 1.01;
    assert!(sights.iter().all(|ends| is_seen(ends[1])));
    let with_cube = draw(
        &mut room,
        RadiosityGizmos {
            form_factors: Some(ray),
            hemicube: true,
            ..default()
        },
    );
    assert_eq!(with_cube.len(), seen.len() + 12);
    assert!(draw(&mut room, RadiosityGizmos::default()).is_empty());
}

#[test]
fn lines_show_where_faces_were_cut() {
    let mut room = Room::new();
    room.world().resource_mut::<RadiositySettings>().bake.refine = true;
    // Onto the floor.
    room.edit::<Transform>(room.block, |at| at.translation.y = -0.7);
    room.settle();
    let cut = draw(
        &mut room,
        RadiosityGizmos {
            contacts: true,
            ..default()
        },
    );
    let of_foot: f32 = (cut.iter())
        // Lines are lifted by a fiftieth of their length.
        .filter(|[a, b]| a.y.max(b.y) < -0.98)
        .filter(|[a, b]| {
            let on_foot = |p: &Vec3| ((p.x - 0.3).abs().max((p.z - 0.1).abs()) - 0.3).abs() < 0.015;
            on_foot(a) && on_foot(b)
        })
        .map(|[a, b]| a.distance(*b))
        .sum();
    // Four sides of 0.6 m, on the floor at least.
    assert!(of_foot > 2.3, "{of_foot}");
    let elements = draw(
        &mut room,
        RadiosityGizmos {
            elements: true,
            ..default()
        },
    );
    assert!(elements.len() > 3 * 300, "{}", elements.len());
}

use bevy_fresco::radiosity::Scene;
use glam::{Vec3, vec3};

use super::shapes::{
    Builder, Look, bumpy_sphere, column, geodesic_sphere, grey, join, lamp, rect, room,
    square_lamp, torus, whole_room,
};

/// A cube of 1 m of one reflectance whose ceiling glows.
pub(crate) fn unit_cube(reflectance: f32) -> Scene {
    let [floor, ceiling, walls @ ..] = room(Vec3::ZERO, Vec3::ONE);
    let glowing = Look {
        emission: Vec3::ONE,
        ..grey(reflectance)
    };
    Builder::default()
        .with("floor", floor, grey(reflectance))
        .with("ceiling", ceiling, glowing)
        .with("walls", join(walls), grey(reflectance))
        .finish()
}

/// A sphere seen from inside whose faces emit and reflect by chance.
pub(super) fn integrating_sphere(elements: u32) -> Scene {
    const LOOKS: u32 = 32;
    let cuts = (elements as f32 / 20.0).sqrt().round().max(1.0) as u32;
    let sphere = geodesic_sphere(cuts);
    let mut scene = Builder::default();
    for look in 0..LOOKS {
        let mut part = sphere.clone();
        let mut number = 0;
        part.triangles.retain(|_| {
            number += 1;
            (chance(number) * LOOKS as f32) as u32 == look
        });
        part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let look = Look {
            reflectance: Vec3::splat(0.9 * chance(1000 * look + 1)),
            emission: Vec3::splat(chance(1000 * look + 2)),
            double_sided: false,
        };
        scene = scene.with("part of the sphere", part, look);
    }
    scene.finish()
}

/// A number 0..1 that looks like chance (a round of the hash by Wang 2007).
fn chance(seed: u32) -> f32 {
    let mut x = (seed ^ 61) ^ (seed >> 16);
    x = x.wrapping_mul(9);
    x = (x ^ (x >> 4)).wrapping_mul(0x27d4_eb2d);
    x ^= x >> 15;
    (x >> 8) as f32 / (1 << 24) as f32
}

/// Side of the slit that looks to room B.
const ROOM_B: f32 = 4.05;

/// Two rooms joined by a slit in the wall between; the lamp hangs in the first.
pub(super) fn two_rooms(_: u32) -> Scene {
    let hall = whole_room(Vec3::ZERO, vec3(8.0, 3.0, 4.0));
    let (y, z) = (Vec3::Y, Vec3::Z);
    let (height, from, to) = (2.2, 1.85, 2.15);
    // Seen from room B; from room A the same with the sides the other way round.
    let beside = |x: f32| {
        [
            (vec3(x, 0.0, 0.0), y * 3.0, z * from),
            (vec3(x, 0.0, to), y * 3.0, z * (4.0 - to)),
            (vec3(x, height, from), y * (3.0 - height), z * (to - from)),
        ]
    };
    let side_b = beside(ROOM_B).map(|(a, u, v)| rect(a, u, v));
    let side_a = beside(3.95).map(|(a, u, v)| rect(a, v, u));
    let x = Vec3::X * (ROOM_B - 3.95);
    let jambs = [
        rect(vec3(3.95, 0.0, from), x, y * height),
        rect(vec3(3.95, 0.0, to), y * height, x),
        rect(vec3(3.95, height, from), x, z * (to - from)),
    ];
    Builder::default()
        .with("hall", hall, grey(0.8))
        .with("wall to B", join(side_b), grey(0.8))
        .with("wall to A", join(side_a), grey(0.8))
        .with("jambs", join(jambs), grey(0.8))
        .with("lamp", square_lamp(vec3(1.5, 2.98, 1.0), 0.6), lamp(20.0))
        .finish()
}

pub(super) fn in_room_b(center: Vec3) -> bool {
    center.x > ROOM_B - 1e-3
}

/// A closed room with a column; sweeps of solvers are counted in it.
pub(crate) fn bright_room(reflectance: f32) -> Scene {
    let size = vec3(4.0, 3.0, 4.0);
    let pillar = column(vec3(2.4, 0.0, 1.4), vec3(2.8, 3.0, 1.8));
    Builder::default()
        .with("room", whole_room(Vec3::ZERO, size), grey(reflectance))
        .with("column", pillar, grey(reflectance))
        .with("lamp", square_lamp(vec3(1.2, 2.98, 2.4), 0.5), lamp(10.0))
        .finish()
}

/// A hall of 10 m with four columns under 64 lamps of 2 cm.
pub(super) fn hall(_: u32) -> Scene {
    let lamps = (0..64).map(|i| {
        let (x, z) = ((i % 8) as f32, (i / 8) as f32);
        square_lamp(vec3(0.9 + x * 1.17, 3.9, 0.9 + z * 1.17), 0.02)
    });
    let columns = [[2.5, 2.5], [7.0, 2.5], [2.5, 7.0], [7.0, 7.0]]
        .map(|[x, z]| column(vec3(x, 0.0, z), vec3(x + 0.5, 4.0, z + 0.5)));
    Builder::default()
        .with(
            "hall",
            whole_room(Vec3::ZERO, vec3(10.0, 4.0, 10.0)),
            grey(0.6),
        )
        .with("columns", join(columns), grey(0.6))
        .with("lamps", join(lamps), lamp(5000.0))
        .finish()
}

/// Rings and lumps of some eleven thousand triangles in a room.
pub(super) fn clutter(_: u32) -> Scene {
    let rings = [
        torus(
            vec3(1.3, 1.0, 1.4),
            vec3(0.0, 1.0, 0.0),
            [0.7, 0.25],
            [64, 24],
        ),
        torus(
            vec3(2.6, 1.6, 2.6),
            vec3(0.6, 0.8, 0.0),
            [0.8, 0.2],
            [64, 24],
        ),
        torus(
            vec3(1.2, 2.2, 2.9),
            vec3(0.0, 0.6, 0.8),
            [0.5, 0.2],
            [64, 24],
        ),
    ];
    let lumps = [
        bumpy_sphere(vec3(2.9, 0.7, 1.2), 0.6, 7),
        bumpy_sphere(vec3(1.0, 0.6, 3.0), 0.5, 7),
    ];
    Builder::default()
        .with(
            "room",
            whole_room(Vec3::ZERO, vec3(4.0, 3.5, 4.0)),
            grey(0.7),
        )
        .with("rings", join(rings), grey(0.5))
        .with("lumps", join(lumps), grey(0.6))
        .with("lamp", square_lamp(vec3(2.0, 3.48, 2.0), 0.8), lamp(10.0))
        .finish()
}

/// Twenty slats 40 cm deep, 2 cm apart.
pub(super) fn louvres(_: u32) -> Scene {
    let slats = (0..20).map(|i| {
        let y = 0.8 + 0.02 * i as f32;
        rect(vec3(0.8, y, 0.5), Vec3::Z, Vec3::X * 0.4)
    });
    let both = Look {
        double_sided: true,
        ..grey(0.7)
    };
    Builder::default()
        .with("room", whole_room(Vec3::ZERO, Vec3::splat(2.0)), grey(0.7))
        .with("slats", join(slats), both)
        .with("lamp", square_lamp(vec3(0.5, 1.98, 1.0), 0.4), lamp(10.0))
        .finish()
}

//! Surfaces at one place.

use bevy_fresco::radiosity::{BakeSettings, Object, Scene};
use glam::Vec3;

use crate::common::{grey, mean_over, quad, room, scene, values};
use crate::solved::{apart, baked, mean, of_object, solved};

/// A unit room of cells `1/n` with a luminous ceiling, its walls again in cells `1/m`.
fn walls_twice(n: u32, m: u32, other_reflectance: f32) -> Scene {
    let mut objects = room(Vec3::ONE, n, [0, 1, 0, 0, 0, 0]);
    if m > 0 {
        objects.extend(room(Vec3::ONE, m, [2, 1, 2, 2, 2, 2]));
    }
    scene(
        objects,
        vec![grey(0.7, 0.0), grey(0.7, 1.0), grey(other_reflectance, 0.0)],
    )
}

/// Every wall modelled twice with other triangles, so that none is a duplicate to be left out, and
/// rays find now one and now the other by a rounding: both carry the light of one, and no element
/// is dark between bright ones. (Walls of the same triangles: `light::walls_modelled_twice`.)
#[test]
fn coincident_walls() {
    let settings = BakeSettings::BALANCED;
    let once = solved(walls_twice(4, 0, 0.7), &settings);
    let twice = solved(walls_twice(4, 3, 0.7), &settings);
    for wall in 0..6 {
        let truth = mean(of_object(&once, wall), |e| e.irradiance.x);
        for object in [wall, wall + 6] {
            let found = mean(of_object(&twice, object), |e| e.irradiance.x);
            eprintln!("{wall} {object} {found} {truth}");
        }
        let (lo, hi) = of_object(&once, wall).fold((f32::MAX, 0.0_f32), |a, e| (a.0.min(e.irradiance.x), a.1.max(e.irradiance.x)));
        let (lo2, hi2) = of_object(&twice, wall).chain(of_object(&twice, wall+6)).fold((f32::MAX, 0.0_f32), |a, e| (a.0.min(e.irradiance.x), a.1.max(e.irradiance.x)));
        eprintln!("range {lo}..{hi}  {lo2}..{hi2}");
    }
    let a = baked(walls_twice(4, 0, 0.7), &settings);
    let b = baked(walls_twice(4, 3, 0.7), &settings);
    for o in 0..6 {
        let d = crate::solved::differences(
            &b.objects[o].light.iter().map(|l| l.x).collect::<Vec<_>>(),
            &a.objects[o].light.iter().map(|l| l.x).collect::<Vec<_>>());
        eprintln!("bake {o}: {d:?}");
    }
}

const CORNELL: Vec3 = Vec3::new(5.56, 5.488, 5.592);

/// The Cornell box without blocks, its lamp so far below the ceiling, of a share of its size.
fn cornell(below: f32, lamp: [f32; 4], reflectance: f32) -> Scene {
    let mut objects = room(CORNELL, 8, [0; 6]);
    let [x0, x1, z0, z1] = lamp;
    let corner = Vec3::new(x0, CORNELL.y - below, z0);
    objects.push(quad("lamp", corner, Vec3::X * (x1 - x0), Vec3::Z * (z1 - z0), 1, 1));
    scene(objects, vec![grey(reflectance, 0.0), grey(0.0, 1.0)])
}

#[test]
fn coplanar_lamp() {
    let small = [2.13, 3.43, 2.27, 3.32];
    let wide = [0.3, 5.2, 0.3, 5.2];
    for lamp in [small, wide] {
        for rho in [0.0, 0.7] {
            for below in [0.0, 1e-6, 1e-5, 1e-3] {
                let s = cornell(below, lamp, rho);
                let floor: Object = s.objects[0].clone();
                let b = baked(s.clone(), &BakeSettings::BALANCED);
                let e = solved(s, &BakeSettings::BALANCED);
                eprintln!("{lamp:?} rho {rho} below {below}: centre {} mean {} elements {} ", b.objects[0].light[4*9+4].x, mean_over(&floor, &b.objects[0].light),
                    mean(of_object(&e, 0), |e| e.irradiance.x));
            }
        }
    }
    let _ = (values, apart);
}
#[test]
fn probe() {
    let wide = [0.3, 5.2, 0.3, 5.2];
    for (name, preset) in [("draft", BakeSettings::DRAFT), ("balanced", BakeSettings::BALANCED), ("final", BakeSettings::FINAL)] {
        for seed in 0..3 {
            let s = cornell(1e-3, wide, 0.0);
            let floor: Object = s.objects[0].clone();
            let settings = BakeSettings { seed, ..preset.clone() };
            let b = baked(s.clone(), &settings);
            let e = solved(s, &settings);
            eprintln!("{name} {seed}: centre {} mean {} elements {} (truth .20089 .16400)", b.objects[0].light[4*9+4].x, mean_over(&floor, &b.objects[0].light),
                mean(of_object(&e, 0), |e| e.irradiance.x));
        }
    }
}

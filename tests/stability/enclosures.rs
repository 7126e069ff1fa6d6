//! Reflectance up to 1 and beyond, and scenes that are open.

use bevy_fresco::radiosity::{BakeSettings, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene, values};
use crate::solved::{apart, baked, mean, of_object, solved};

/// A closed box of uniform emission 1 − ρ has radiance 1 everywhere, and errs by ρ / (1 − ρ) times
/// the share of rays that leak: at ρ = 0.999 a leak of one ray in a million shows.
#[test]
fn furnace_of_bright_elements() {
    for rho in [0.5, 0.9, 0.99, 0.999] {
        let s = scene(room(Vec3::new(2.0, 1.0, 3.0), 4, [0; 6]), vec![grey(rho, 1.0 - rho)]);
        let settings = BakeSettings { max_reflectance: 0.9995, solver_tolerance: 1e-4, ..BakeSettings::BALANCED };
        let light = solved(s, &settings);
        let worst = light.elements.iter().map(|e| apart(e.radiosity.x.into(), 1.0)).fold(0.0, f64::max);
        let leaks = (0..light.elements.len()).map(|e| 1.0 - light.row_sum(e)).sum::<f64>();
        eprintln!("rho {rho}: worst {worst} leaks {leaks} sweeps {} {:?}", light.report.solver.sweeps, light.report.solver);
    }
}

fn lit_room(reflectance: f32) -> Scene {
    scene(room(Vec3::ONE, 2, [0, 1, 0, 0, 0, 0]), vec![grey(reflectance, 0.0), grey(0.5, 1.0)])
}

/// A reflectance no surface has is taken for the nearest one it could have, bit for bit, and the
/// report says so: 1 and more for `max_reflectance`, less than 0 for 0.
#[test]
fn impossible_reflectance() {
    let settings = BakeSettings::DRAFT;
    for (impossible, possible, note) in [
        (1.0, settings.max_reflectance, "were clamped"),
        (1.5, settings.max_reflectance, "lies outside 0..1"),
        (1e30, settings.max_reflectance, "lies outside 0..1"),
        (-0.5, 0.0, "lies outside 0..1"),
    ] {
        let bake = baked(lit_room(impossible), &settings);
        let notes = &bake.report.notes;
        assert!(notes.iter().any(|n| n.contains(note)), "{impossible}: {notes:?}");
        assert!(bake.report.solver.converged, "{impossible}");
        assert_eq!(values(&bake), values(&baked(lit_room(possible), &settings)), "{impossible}");
    }
    // As bright as can be asked for: still an end to it.
    let brightest = BakeSettings { max_reflectance: 1.0_f32.next_down(), ..settings };
    let light = solved(lit_room(1.0), &brightest);
    eprintln!("{:?}", light.report.solver);
    assert!(light.elements.iter().all(|e| e.irradiance.is_finite()));
}

/// Two unit squares facing each other at distance 1, one of which emits, and nothing else.
#[test]
fn open_plates() {
    let plates = |e: f32, sky: f32| {
        let low = quad("low", Vec3::ZERO, Vec3::Z, Vec3::X, 8, 0);
        let high = quad("high", Vec3::Y, Vec3::X, Vec3::Z, 8, 1);
        let mut s = scene(vec![low, high], vec![grey(0.5, 0.0), grey(0.5, e)]);
        s.sky = Vec3::splat(sky);
        s
    };
    // Howell C-11.
    let factor = 0.199_824_895_698_387_4;
    let settings = BakeSettings::FINAL;
    let light = solved(plates(1.0, 0.0), &settings);
    let arrived = light.report.energy.arrived.x;
    eprintln!("arrived {arrived} {} gap {} {:?}", apart(arrived, factor), light.report.energy.relative_error(), light.report.energy);
    let down = mean(of_object(&light, 0), |e| e.direct.x);
    eprintln!("down {down}");
    let light = solved(plates(0.0, 1.0), &settings);
    eprintln!("sky: {} of {}", mean(of_object(&light, 0), |e| e.direct.x), 1.0 - factor);
    eprintln!("energy {:?} gap {}", light.report.energy, light.report.energy.relative_error());
}

/// Surfaces that emit 1 − ρ under a sky of radiance 1 send 1 wherever light goes: reflected or
/// passed by, nothing shows where a surface ends. (All surfaces have two sides: a black back
/// would show.)
#[test]
fn open_furnace() {
    for rho in [0.2, 0.8] {
        let mut m = grey(rho, 1.0 - rho);
        m.double_sided = true;
        let mut objects = vec![
            quad("floor", Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, 4, 0),
            quad("roof", Vec3::new(1.0, 1.0, 1.0), Vec3::X * 2.0, Vec3::Z * 2.0 + Vec3::Y, 4, 0),
            quad("wall", Vec3::new(2.0, 0.0, 0.5), Vec3::Y, Vec3::Z * 3.0, 4, 0),
        ];
        objects.extend(room(Vec3::splat(0.7), 2, [0; 6]).into_iter().skip(2));
        let mut s = scene(objects, vec![m]);
        s.sky = Vec3::ONE;
        let light = solved(s.clone(), &BakeSettings::BALANCED);
        let worst = light.elements.iter().map(|e| apart(e.radiosity.x.into(), 1.0)).fold(0.0, f64::max);
        let m = light.elements.iter().map(|e| e.radiosity.x).sum::<f32>() / light.elements.len() as f32;
        let sk = light.elements.iter().zip(0..).map(|(_, i)| 1.0 - light.row_sum(i)).sum::<f64>() / light.elements.len() as f64;
        let b = baked(s, &BakeSettings::BALANCED);
        let worst_v = values(&b).iter().map(|&v| apart(v.into(), 1.0)).fold(0.0, f64::max);
        eprintln!("open furnace {rho}: worst {worst} mean {m} sky {sk} vertices {worst_v}");
    }
}

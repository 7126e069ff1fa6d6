//! How the error of hit lists falls with the number of rays.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use bevy_fresco::radiosity::{BakeSettings, Light, LightKind, ValidScene, solve_elements};
use common::{block, grey, room, scene};
use glam::Vec3;

/// A room with two blocks and a bulb, whose direct light has no noise.
fn lit_room() -> ValidScene {
    let mut objects = room(Vec3::ONE, 1, [0; 6]);
    objects.extend(block(
        Vec3::new(0.15, 0.0, 0.5),
        Vec3::new(0.3, 0.6, 0.3),
        1,
        0,
    ));
    objects.extend(block(Vec3::new(0.55, 0.0, 0.2), Vec3::splat(0.3), 1, 0));
    let mut s = scene(objects, vec![grey(0.65, 0.0)]);
    s.lights.push(Light {
        name: "bulb".into(),
        power: Vec3::splat(100.0),
        kind: LightKind::Point {
            position: Vec3::new(0.5, 0.9, 0.5),
            range: f32::INFINITY,
        },
        ..Light::default()
    });
    s.validate().unwrap()
}

fn light(scene: &ValidScene, element_rays: u32, elements: u32) -> Vec<(f64, f64)> {
    let settings = BakeSettings {
        element_rays,
        elements,
        solver_tolerance: 1e-6,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    let solved = solve_elements(scene, &settings, &()).unwrap();
    let light = solved.elements.iter();
    light
        .map(|e| (f64::from(e.area), f64::from(e.radiosity.x)))
        .collect()
}

/// The error of radiosity, relative L2 over the surface, is 3 % (64 / S)^0.7 of `S` rays within a
/// factor of 1.5, whatever the number of elements.
#[test]
fn error_falls_with_the_rays() {
    let scene = lit_room();
    for elements in [500, 2000] {
        let truth = light(&scene, 4096, elements);
        let whole: f64 = truth.iter().map(|(a, b)| a * b * b).sum();
        for rays in [16, 32, 64, 128, 256, 512] {
            let found = light(&scene, rays, elements);
            let gap = found.iter().zip(&truth);
            let gap: f64 = gap.map(|((a, x), (_, y))| a * (x - y).powi(2)).sum();
            let error = (gap / whole).sqrt();
            let law = 0.03 * (64.0 / f64::from(rays)).powf(0.7);
            assert!(
                error < 1.5 * law && law < 1.5 * error,
                "{elements} elements, {rays} rays: {error:.4} for {law:.4}"
            );
        }
    }
}

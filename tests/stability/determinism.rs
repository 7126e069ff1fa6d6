//! The same answer every time.

use bevy_fresco::radiosity::{
    AlphaMode, BakeSettings, ElementLight, Light, LightKind, Material, Scene, solve_elements,
};
use glam::Vec3;

use crate::common::{grey, quad, room, scene};

/// Something of everything: a lamp, a sun through a missing wall, the sky, a veil of chance, a
/// sheet of two sides, two walls at one place.
fn everything() -> Scene {
    let veil = Material {
        alpha: AlphaMode::Blend,
        base_color: glam::Vec4::new(0.5, 0.5, 0.5, 0.4),
        double_sided: true,
        ..grey(0.5, 0.0)
    };
    let mut objects = room(Vec3::ONE, 5, [0; 6]);
    objects.truncate(5);
    objects.push(quad("again", Vec3::ZERO, Vec3::Z, Vec3::X, 3, 0));
    objects.push(quad(
        "lamp",
        Vec3::new(0.4, 0.9, 0.4),
        Vec3::X * 0.2,
        Vec3::Z * 0.2,
        1,
        1,
    ));
    objects.push(quad(
        "veil",
        Vec3::new(0.2, 0.1, 0.7),
        Vec3::X * 0.7,
        Vec3::Y * 0.7,
        2,
        2,
    ));
    let mut s = scene(objects, vec![grey(0.7, 0.0), grey(0.0, 5.0), veil]);
    s.sky = Vec3::new(0.2, 0.3, 0.5);
    s.lights.push(Light {
        power: Vec3::ONE,
        kind: LightKind::Directional {
            direction: Vec3::new(0.2, -0.5, -1.0),
        },
        ..Light::default()
    });
    s
}

/// Elements, form factors and what the report says of them are the same to the bit on 1, 2 and 8
/// threads, twice each. (Light of vertices: `any_number_of_threads_gives_the_same_bits` in
/// `behaviour`.)
#[test]
#[cfg(feature = "parallel")]
fn threads() {
    let s = everything().validate().unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            solve_elements(
                &s,
                &BakeSettings {
                    refine: false,
                    adapt: false,
                    ..BakeSettings::DRAFT
                },
                &(),
            )
            .unwrap()
        })
    };
    let rows = |light: &ElementLight| {
        let count = light.elements.len();
        (0..count)
            .step_by(37)
            .map(|e| light.row(e))
            .collect::<Vec<_>>()
    };
    let one = on(1);
    for threads in [1, 2, 2, 8, 8] {
        let other = on(threads);
        assert_eq!(other.elements, one.elements, "{threads} threads");
        assert_eq!(rows(&other), rows(&one), "{threads} threads");
        let (a, b) = (&other.report, &one.report);
        assert_eq!(a.counts, b.counts);
        assert_eq!(a.energy, b.energy);
        assert_eq!(a.form_factors, b.form_factors);
        assert_eq!(a.solver, b.solver);
        assert_eq!(a.work, b.work);
        assert_eq!(a.notes, b.notes);
    }
}

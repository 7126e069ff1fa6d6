//! Reflectance up to 1 and beyond, scenes that are open, surfaces of one side and of two.

use bevy_fresco::radiosity::{BakeSettings, Light, LightKind, Material, Scene};
use glam::Vec3;

use crate::common::{grey, quad, room, scene, values};
use crate::solved::{apart, baked, furthest_from_one, mean, of_object, range, solved, tight};

/// A closed box of uniform emission 1 − ρ has radiance 1 everywhere. A share of rays that leak
/// lowers it by ρ / (1 − ρ) times that share, a thousandfold at ρ = 0.999, and next to none does.
/// (At vertices: `furnace` in `truth`.)
///
/// With a luminous ceiling alone the solver has work to do, which the mean-field correction keeps
/// to a few sweeps, where plain Gauss–Seidel needs thousands. What is left of it is a closed box's
/// balance: all that the ceiling emits is absorbed.
#[test]
fn furnace_near_reflectance_one() {
    let settings = BakeSettings {
        max_reflectance: 0.9995,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    let size = Vec3::new(2.0, 1.0, 3.0);
    for rho in [0.5, 0.9, 0.99, 0.999] {
        let uniform = scene(room(size, 4, [0; 6]), vec![grey(rho, 1.0 - rho)]);
        let light = solved(uniform, &settings);
        assert!(tight(&light, &settings), "{rho}");
        let rows = 0..light.elements.len();
        let leak = rows.map(|e| 1.0 - light.row_sum(e)).fold(0.0, f64::max);
        let allowed = f64::from(rho) * leak / (1.0 - f64::from(rho)) + 1e-5;
        assert!(furthest_from_one(&light) < allowed, "{rho}");

        let walls = room(size, 4, [0, 1, 0, 0, 0, 0]);
        let light = solved(
            scene(walls, vec![grey(rho, 0.0), grey(rho, 1.0)]),
            &settings,
        );
        let solver = &light.report.solver;
        assert!(solver.converged && solver.sweeps <= 25, "{rho}: {solver:?}");
        // Σ A (1 − ρ) H = Σ A E, of areas 22 and 6.
        let arriving = mean(light.elements.iter(), |e| e.irradiance.x);
        let truth = 6.0 / 22.0 / (1.0 - f64::from(rho));
        assert!(apart(arriving, truth) < 0.02, "{rho}: {arriving}, {truth}");
    }
}

fn lit_room(reflectance: f32) -> Scene {
    let walls = room(Vec3::ONE, 2, [0, 1, 0, 0, 0, 0]);
    scene(walls, vec![grey(reflectance, 0.0), grey(0.5, 1.0)])
}

/// A reflectance that no surface has is taken for the nearest one it could have, to the bit, and
/// the report says so: 1 and more for `max_reflectance`, less than 0 for 0.
#[test]
fn impossible_reflectance() {
    let settings = BakeSettings {
        refine: false,
        adapt: false,
        ..BakeSettings::DRAFT
    };
    for (impossible, possible, note) in [
        (1.0, settings.max_reflectance, "were clamped"),
        (1.5, settings.max_reflectance, "lies outside 0..1"),
        (1e30, settings.max_reflectance, "lies outside 0..1"),
        (-0.5, 0.0, "lies outside 0..1"),
    ] {
        let bake = baked(lit_room(impossible), &settings);
        let notes = &bake.report.notes;
        assert!(
            notes.iter().any(|n| n.contains(note)),
            "{impossible}: {notes:?}"
        );
        assert!(bake.report.solver.converged, "{impossible}");
        let meant = baked(lit_room(possible), &settings);
        assert_eq!(values(&bake), values(&meant), "{impossible}");
    }
}

/// Reflectance as near to 1 as `f32` goes: rounding alone is more than the tolerance. The bake ends,
/// its light is finite, and the report says that it did not converge and how far off it may be.
#[test]
fn reflectance_beyond_the_solver() {
    let settings = BakeSettings {
        max_reflectance: 1.0_f32.next_down(),
        refine: false,
        adapt: false,
        ..BakeSettings::DRAFT
    };
    let mut s = lit_room(1.0);
    s.materials[1].base_color = s.materials[0].base_color;
    let light = solved(s, &settings);
    let solver = &light.report.solver;
    assert!(!solver.converged && solver.sweeps == settings.max_sweeps);
    assert!(solver.error_bound > 1.0);
    assert!(light.elements.iter().all(|e| e.irradiance.is_finite()));
    assert!(
        light
            .report
            .notes
            .iter()
            .any(|n| n.contains("the solver stopped"))
    );
}

/// Unit squares facing each other at distance 1, and nothing else.
fn plates(emission: f32, sky: f32) -> Scene {
    let low = quad("low", Vec3::ZERO, Vec3::Z, Vec3::X, 8, 0);
    let high = quad("high", Vec3::Y, Vec3::X, Vec3::Z, 8, 1);
    let mut s = scene(vec![low, high], vec![grey(0.5, 0.0), grey(0.5, emission)]);
    s.sky = Vec3::splat(sky);
    s
}

/// Of what one of two plates emits the form factor's share reaches the other (Howell's catalogue,
/// C-11: 0.19982), and of a sky's light what the other plate leaves free. What arrives is absorbed
/// or escapes.
#[test]
fn open_plates() {
    let factor = 0.199_824_9;
    for (emission, sky, share) in [(1.0, 0.0, factor), (0.0, 1.0, 1.0 - factor)] {
        let light = solved(
            plates(emission, sky),
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::FINAL
            },
        );
        let arrived = mean(of_object(&light, 0), |e| e.direct.x);
        assert!(apart(arrived, share) < 2e-3, "{arrived}, {share}");
        let energy = &light.report.energy;
        assert!(energy.relative_error() < 1e-3, "{energy:?}");
        // As much is reflected as is absorbed, and the other plate misses 1 − F of it.
        let truth = energy.absorbed.x * (1.0 - factor);
        assert!(apart(energy.escaped.x, truth) < 5e-3, "{energy:?}");
    }
}

/// Surfaces that emit 1 − ρ under a sky of radiance 1 send out 1, as the sky does: wherever a ray
/// goes it finds 1, reflected or not, and every element and vertex has 1, to the tolerance of the
/// solver. All surfaces have two sides, since a black back would show.
#[test]
fn open_furnace() {
    for rho in [0.2, 0.8] {
        let mut material = grey(rho, 1.0 - rho);
        material.double_sided = true;
        let slope = Vec3::Z * 2.0 + Vec3::Y;
        let mut objects = vec![
            quad("floor", Vec3::ZERO, Vec3::Z * 4.0, Vec3::X * 4.0, 4, 0),
            quad("roof", Vec3::ONE, Vec3::X * 2.0, slope, 4, 0),
            quad(
                "wall",
                Vec3::new(2.0, 0.0, 0.5),
                Vec3::Y,
                Vec3::Z * 3.0,
                4,
                0,
            ),
        ];
        objects.extend(room(Vec3::splat(0.7), 2, [0; 6]).into_iter().skip(2));
        let mut s = scene(objects, vec![material]);
        s.sky = Vec3::ONE;
        let light = solved(
            s.clone(),
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::BALANCED
            },
        );
        let escaping = (0..light.elements.len())
            .filter(|&e| light.row_sum(e) < 1.0)
            .count();
        assert!(2 * escaping > light.elements.len(), "not an open scene");
        assert!(furthest_from_one(&light) < 1e-3, "{rho}");
        for v in values(&baked(
            s,
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::BALANCED
            },
        )) {
            assert!((v - 1.0).abs() < 1e-3, "{rho}: {v}");
        }
    }
}

/// A sheet between two suns, above a floor.
fn sheet(double_sided: bool) -> Scene {
    let paper = Material {
        double_sided,
        ..grey(0.0, 0.0)
    };
    let low = Vec3::new(-1.0, 0.0, -1.0);
    let objects = vec![
        quad("sheet", low + Vec3::Y, Vec3::Z * 2.0, Vec3::X * 2.0, 4, 0),
        quad("floor", 0.5 * low, Vec3::Z, Vec3::X, 4, 1),
    ];
    let mut s = scene(objects, vec![paper, grey(0.0, 0.0)]);
    for (lux, direction) in [(3.0, Vec3::NEG_Y), (1.0, Vec3::new(2.0, 1.0, 0.0))] {
        s.lights.push(Light {
            power: Vec3::splat(lux * std::f32::consts::PI),
            kind: LightKind::Directional { direction },
            ..Light::default()
        });
    }
    s
}

/// A sheet of one side has elements on that side only, lit by what that side faces, and stops light
/// from behind all the same; of two sides, it has elements on both, each lit by its own sun.
/// (What a sheet reflects: `sides` in `light`.)
#[test]
fn sides_of_a_sheet() {
    let one = solved(
        sheet(false),
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::DRAFT
        },
    );
    let two = solved(
        sheet(true),
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::DRAFT
        },
    );
    let count = of_object(&one, 0).count();
    assert_eq!(of_object(&two, 0).count(), 2 * count);
    let side = |y: f32| of_object(&two, 0).filter(move |e| e.normal.y * y > 0.0);
    let near = |(low, high): (f32, f32), truth: f32| low > 0.999 * truth && high < 1.001 * truth;
    assert!(near(range(of_object(&one, 0)), 3.0));
    assert!(near(range(side(1.0)), 3.0));
    // The lower sun comes in under the floor, by a cosine of 1/√5.
    assert!(near(range(side(-1.0)), 0.2_f32.sqrt()));
    for light in [&one, &two] {
        assert_eq!(mean(of_object(light, 1), |e| e.irradiance.x), 0.0);
    }
}

/// The same light from above and from below: both sides of a sheet get the same, within 1 %.
#[test]
fn two_sides_alike() {
    let paper = Material {
        double_sided: true,
        ..grey(0.8, 0.0)
    };
    let mut objects = room(Vec3::ONE, 2, [1, 1, 0, 0, 0, 0]);
    objects.push(quad(
        "sheet",
        Vec3::new(0.2, 0.5, 0.2),
        Vec3::Z * 0.6,
        Vec3::X * 0.6,
        4,
        2,
    ));
    let s = scene(objects, vec![grey(0.5, 0.0), grey(0.5, 1.0), paper]);
    let light = solved(
        s,
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
    );
    let side = |y: f32| of_object(&light, 6).filter(move |e| e.normal.y * y > 0.0);
    let [front, back] = [1.0, -1.0].map(|y| mean(side(y), |e| e.irradiance.x));
    assert!(apart(front, back) < 0.01, "{front}, {back}");
}

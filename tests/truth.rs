//! Bakes of scenes whose answer is known in closed form.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use bevy_fresco::radiosity::{BakeSettings, bake};
use common::{grey, inward_sphere, mean_over, quad, room, scene, values};
use glam::Vec3;

/// A closed box of uniform emission E and reflectance ρ: radiance is E/(1 − ρ) everywhere, so the
/// light that arrives is E/(1 − ρ) too.
#[test]
fn furnace() {
    for (rho, tolerance) in [(0.5, 0.001), (0.9, 0.003), (0.99, 0.01)] {
        let objects = room(Vec3::new(2.0, 1.0, 3.0), 8, [0; 6]);
        let areas = objects.clone();
        let scene = scene(objects, vec![grey(rho, 1.0)]).validate().unwrap();
        let bake = bake(
            &scene,
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::BALANCED
            },
            &(),
        )
        .unwrap();
        let truth = 1.0 / (1.0 - f64::from(rho));
        let mean = areas
            .iter()
            .zip(&bake.objects)
            .map(|(o, l)| mean_over(o, &l.light))
            .sum::<f64>()
            / 6.0;
        assert!(
            (mean / truth - 1.0).abs() < tolerance,
            "rho {rho}: mean {mean}, truth {truth}"
        );
        for v in values(&bake) {
            assert!(
                (f64::from(v) / truth - 1.0).abs() < 10.0 * tolerance,
                "rho {rho}: vertex {v}, truth {truth}"
            );
        }
        assert!(bake.report.solver.converged);
        assert!(bake.report.energy.relative_error() < 1e-3);
    }
}

/// Continuum values of the unit cube with a ceiling that emits 1, computed by graded Galerkin
/// solutions extrapolated to zero element size.
#[test]
fn unit_cube() {
    let truths = [
        (
            0.5,
            0.171_216,
            0.181_105_6,
            1.104_361,
            0.197_605,
            0.177_647_6,
        ),
        (
            0.8,
            0.660_980,
            0.687_878_9,
            1.587_504,
            0.713_083,
            0.683_663_8,
        ),
    ];
    for (rho, floor, wall, ceiling, floor_centre, wall_centre) in truths {
        let n = 16;
        let objects = room(Vec3::ONE, n, [0, 1, 0, 0, 0, 0]);
        let shapes = objects.clone();
        let scene = scene(objects, vec![grey(rho, 0.0), grey(rho, 1.0)])
            .validate()
            .unwrap();
        let bake = bake(
            &scene,
            &BakeSettings {
                refine: false,
                adapt: false,
                ..BakeSettings::FINAL
            },
            &(),
        )
        .unwrap();
        // Radiosity, as the truths are, is emission + ρ × arriving light.
        let rho = f64::from(rho);
        let mean = |i: usize| rho * mean_over(&shapes[i], &bake.objects[i].light);
        let centre = |i: usize| {
            rho * f64::from(bake.objects[i].light[((n / 2) * (n + 1) + n / 2) as usize].x)
        };
        let check = |what: &str, found: f64, truth: f64| {
            assert!(
                (found / truth - 1.0).abs() < 0.01,
                "rho {rho}: {what} {found}, truth {truth}"
            );
        };
        check("mean floor", mean(0), floor);
        check("mean wall", (2..6).map(mean).sum::<f64>() / 4.0, wall);
        check("mean ceiling", mean(1) + 1.0, ceiling);
        check("floor centre", centre(0), floor_centre);
        check("wall centre", centre(2), wall_centre);
        assert!(bake.report.energy.relative_error() < 1e-3);
    }
}

/// Inside a sphere every element sees all others alike, so whatever the pattern of emission E(x)
/// and reflectance ρ(x), irradiance is uniform: H = mean E / (1 − mean ρ).
#[test]
fn integrating_sphere() {
    let mut sphere = inward_sphere(16, 0);
    // Two materials, in patches of the sphere chosen by a fixed rule.
    let mut other = sphere.clone();
    other.material.0 = 1;
    let bright = |t: &[u32; 3]| {
        let p = sphere.positions[t[0] as usize]
            + sphere.positions[t[1] as usize]
            + sphere.positions[t[2] as usize];
        p.x > 0.6 || p.y * p.z > 0.9
    };
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| sphere.positions[v as usize].as_dvec3());
        (b - a).cross(c - a).length()
    };
    let (chosen, rest): (Vec<_>, Vec<_>) = sphere.triangles.iter().partition(|t| bright(t));
    let share =
        chosen.iter().map(area).sum::<f64>() / sphere.triangles.iter().map(area).sum::<f64>();
    other.triangles = chosen;
    sphere.triangles = rest;
    let shapes = [sphere.clone(), other.clone()];
    let scene = scene(vec![sphere, other], vec![grey(0.8, 0.0), grey(0.3, 2.0)])
        .validate()
        .unwrap();
    let bake = bake(
        &scene,
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
        &(),
    )
    .unwrap();
    let truth = 2.0 * share / (1.0 - (0.8 * (1.0 - share) + 0.3 * share));
    let found = [0, 1].map(|i| mean_over(&shapes[i], &bake.objects[i].light));
    let mean = found[0] * (1.0 - share) + found[1] * share;
    assert!(
        (mean / truth - 1.0).abs() < 0.005,
        "mean {mean}, truth {truth}"
    );
    for f in found {
        assert!((f / truth - 1.0).abs() < 0.01, "{found:?}, truth {truth}");
    }
}

/// A floor under a point light, no other surface: E = I cos θ / d².
#[test]
fn point_light_on_a_floor() {
    use bevy_fresco::radiosity::{Light, LightKind};
    let floor = quad(
        "floor",
        Vec3::new(-1.0, 0.0, -1.0),
        Vec3::Z * 2.0,
        Vec3::X * 2.0,
        32,
        0,
    );
    let positions = floor.positions.clone();
    let mut s = scene(vec![floor], vec![grey(0.5, 0.0)]);
    let candela = 3.0;
    s.lights.push(Light {
        name: "lamp".into(),
        power: Vec3::splat(candela * 4.0 * std::f32::consts::PI),
        kind: LightKind::Point {
            position: Vec3::new(0.1, 0.7, -0.2),
            range: f32::INFINITY,
        },
        ..Light::default()
    });
    let bake = bake(
        &s.validate().unwrap(),
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
        &(),
    )
    .unwrap();
    for (p, light) in positions.iter().zip(&bake.objects[0].light) {
        let d = Vec3::new(0.1, 0.7, -0.2) - *p;
        let truth = candela * d.y / d.length().powi(3) / std::f32::consts::PI;
        assert!(
            (light.x / truth - 1.0).abs() < 0.01,
            "at {p}: {} for {truth}",
            light.x
        );
    }
}

//! Radiosity with form factors by hemicube.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use bevy_fresco::radiosity::{
    BakeSettings, ElementLight, FormFactors, Object, Scene, solve_elements,
};
use common::{grey, quad, room, scene};
use glam::{Mat3, Vec3};

fn hemicube(resolution: u32, elements: u32) -> BakeSettings {
    BakeSettings {
        elements,
        form_factors: FormFactors::Hemicube { resolution },
        emitter_rays: 64,
        refine: false,
        adapt: false,
        ..BakeSettings::FINAL
    }
}

fn solve(scene: &Scene, settings: &BakeSettings) -> ElementLight {
    solve_elements(&scene.clone().validate().unwrap(), settings, &()).unwrap()
}

/// The area-weighted mean of what `of` says of the elements of an object.
fn mean(light: &ElementLight, object: u32, of: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (e, element) in light.elements.iter().enumerate() {
        if element.object.0 == object {
            sum += f64::from(element.area) * of(e);
            area += f64::from(element.area);
        }
    }
    sum / area
}

/// A room of 5.5 m with two blocks and a lamp in the ceiling.
fn cornell() -> Vec<Object> {
    let mut objects = room(Vec3::splat(5.5), 1, [0; 6]);
    for (place, height, turn) in [
        (Vec3::new(1.3, 0.0, 1.7), 1.65, -0.3),
        (Vec3::new(3.6, 0.0, 3.5), 3.3, 0.3),
    ] {
        let size = Vec3::new(1.6, height, 1.6);
        for mut side in room(size, 1, [0; 6]).into_iter().skip(1) {
            for p in &mut side.positions {
                *p = place + Mat3::from_rotation_y(turn) * (*p - 0.5 * Vec3::new(1.6, 0.0, 1.6));
            }
            for n in &mut side.normals {
                *n = -(Mat3::from_rotation_y(turn) * *n);
            }
            for t in &mut side.triangles {
                t.swap(1, 2);
            }
            objects.push(side);
        }
    }
    let lamp = quad(
        "lamp",
        Vec3::new(2.1, 5.45, 2.2),
        Vec3::X * 1.3,
        Vec3::Z,
        1,
        1,
    );
    objects.push(lamp);
    objects
}

fn lit(objects: Vec<Object>) -> Scene {
    scene(objects, vec![grey(0.7, 0.0), grey(0.7, 10.0)])
}

/// Seen from the middle of the one, the other fills 0.968 of the view at a gap of a tenth; the mean
/// over the one is what counts.
#[test]
fn near_squares_are_not_judged_from_their_middles() {
    for (gap, truth) in [(0.1, 0.826_994_522_397), (0.01, 0.980_416_602_926)] {
        let lower = quad("lower", Vec3::ZERO, Vec3::Z, Vec3::X, 1, 0);
        let upper = quad("upper", Vec3::Y * gap, Vec3::X, Vec3::Z, 1, 0);
        let mut scene = scene(vec![lower, upper], vec![grey(0.5, 0.0)]);
        scene.sky = Vec3::ONE;
        for resolution in [16, 64, 256] {
            let light = solve(&scene, &hemicube(resolution, 2));
            assert_eq!(light.elements.len(), 2);
            assert_eq!(light.report.form_factors.near_pairs, 2);
            for (i, j) in [(0, 1), (1, 0)] {
                let found = light.form_factor(i, j);
                assert!(
                    (found / truth - 1.0).abs() < 0.01,
                    "gap {gap}, R {resolution}: {found}"
                );
            }
        }
    }
}

/// One element a wall: 0.199825 to the opposite one, 0.200044 to each other.
#[test]
fn six_walls_of_a_cube() {
    let light = solve(
        &lit(room(Vec3::ONE, 1, [0, 1, 0, 0, 0, 0])),
        &hemicube(32, 6),
    );
    assert_eq!(light.elements.len(), 6);
    for i in 0..6 {
        for j in (0..6).filter(|&j| j != i) {
            let truth = if i / 2 == j / 2 {
                0.199_824_895_698
            } else {
                0.200_043_776_075
            };
            let found = light.form_factor(i, j);
            assert!((found / truth - 1.0).abs() < 0.01, "{i} {j}: {found}");
        }
        assert!((light.row_sum(i) - 1.0).abs() < 1e-5);
    }
}

/// Means of the unit cube under a ceiling that emits 1, ρ = 0.5 and 0.8 (graded Galerkin solutions
/// extrapolated to zero element size).
#[test]
fn unit_cube() {
    for (rho, floor, wall, ceiling) in [
        (0.5, 0.171_216, 0.181_105_6, 1.104_361),
        (0.8, 0.660_980, 0.687_878_9, 1.587_504),
    ] {
        let materials = vec![grey(rho, 0.0), grey(rho, 1.0)];
        let scene = scene(room(Vec3::ONE, 1, [0, 1, 0, 0, 0, 0]), materials);
        let light = solve(&scene, &hemicube(64, 6 * 128));
        let radiosity = |o| mean(&light, o, |e| light.elements[e].radiosity.x.into());
        let walls = (2..6).map(radiosity).sum::<f64>() / 4.0;
        for (found, truth) in [
            (radiosity(0), floor),
            (walls, wall),
            (radiosity(1), ceiling),
        ] {
            assert!(
                (found / truth - 1.0).abs() < 0.01,
                "rho {rho}: {found}, truth {truth}"
            );
        }
        assert!(light.report.energy.relative_error() < 1e-3);
    }
}

/// Near pairs are put into a row without opening it.
#[test]
fn rows_of_a_closed_room_sum_to_one() {
    let light = solve(
        &lit(room(Vec3::new(2.0, 1.0, 3.0), 1, [0, 1, 0, 0, 0, 0])),
        &hemicube(32, 500),
    );
    let found = &light.report.form_factors;
    assert!(
        found.near_pairs > 500 && found.largest_row_sum < 1.0 + 1e-5,
        "{found:?}"
    );
    for e in 0..light.elements.len() {
        assert!(
            (light.row_sum(e) - 1.0).abs() < 1e-5,
            "element {e}: {}",
            light.row_sum(e)
        );
    }
}

/// The light of a room is that which rays find, within what one point of an element may differ from
/// the whole of it.
#[test]
fn a_room_is_as_bright_as_by_rays() {
    let scene = lit(cornell());
    let by_rays = BakeSettings {
        form_factors: FormFactors::HitList,
        element_rays: 4096,
        ..hemicube(64, 2000)
    };
    let rays = solve(&scene, &by_rays);
    for (resolution, limit) in [(16, 0.04), (64, 0.03)] {
        let cube = solve(&scene, &hemicube(resolution, 2000));
        let (mut off, mut all, mut bias) = (0.0, 0.0, 0.0);
        for (c, r) in cube.elements.iter().zip(&rays.elements) {
            let area = f64::from(r.area);
            let difference = f64::from(c.irradiance.x - r.irradiance.x);
            off += area * difference.powi(2);
            all += area * f64::from(r.irradiance.x).powi(2);
            bias += area * difference;
        }
        let relative = (off / all).sqrt();
        assert!(relative < limit, "R {resolution}: {relative}");
        let arriving = |l: &ElementLight| -> f64 {
            l.elements
                .iter()
                .map(|e| f64::from(e.area * e.irradiance.x))
                .sum()
        };
        assert!(
            (bias / arriving(&rays)).abs() < 0.005,
            "R {resolution}: {bias}"
        );
    }
}

/// Every wall twice, cut along the other diagonal, and with a twin that faces away: the light of
/// the first is what it is without the others.
#[test]
fn walls_at_one_place_are_one_wall() {
    let single = cornell();
    let mut double = single.clone();
    for wall in &single[..single.len() - 1] {
        let mut again = wall.clone();
        // A quad of one cell: its corners go 0, 2, 3, 1 around.
        again.triangles = vec![[2, 3, 1], [2, 1, 0]];
        let mut turned = wall.clone();
        for t in &mut turned.triangles {
            t.swap(1, 2);
        }
        double.extend([turned, again]);
    }
    let settings = hemicube(64, 1000);
    let alone = solve(&lit(single.clone()), &settings);
    let settings = BakeSettings {
        elements: 3000,
        ..settings
    };
    let among = solve(&lit(double.clone()), &settings);
    let irradiance = |l: &ElementLight, o| mean(l, o, |e| l.elements[e].irradiance.x.into());
    for wall in 0..single.len() as u32 - 1 {
        let (a, b) = (irradiance(&alone, wall), irradiance(&among, wall));
        assert!(
            // One viewpoint an element, and other elements: that alone makes 3 % (docs/accuracy.md).
            (a / b - 1.0).abs() < 0.04,
            "{}: {a}, among twins {b}",
            single[wall as usize].name
        );
    }
    let energy =
        |l: &ElementLight| -> f64 { (0..single.len() as u32 - 1).map(|o| irradiance(l, o)).sum() };
    assert!((energy(&alone) / energy(&among) - 1.0).abs() < 0.01);
    assert_eq!(solve(&lit(double), &settings).elements, among.elements);
}

/// The same bits on any number of threads.
#[test]
fn threads_do_not_matter() {
    let scene = lit(cornell());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| solve(&scene, &hemicube(32, 600)))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.elements, three.elements);
    for e in 0..one.elements.len() {
        assert_eq!(one.row(e), three.row(e));
    }
}

//! What the methods find on meshes, against closed forms.

use bevy_fresco::radiosity::{BakeSettings, FormFactors, Scene, polygon_to_polygon};
use glam::{DVec3, Vec3};

use crate::common::{grey, inward_sphere, scene};
use crate::meshes::{between, disk, inside_out, settings, solved, squares};
use crate::truth::form_factors;

const ANALYTIC: FormFactors = FormFactors::Analytic { visibility_rays: 1 };

const AREA_SAMPLING: FormFactors = FormFactors::AreaSampling { samples: 16 };

/// The form factor from object 0 to object 1 by each method.
fn by_each_method(scene: &Scene, elements: u32) -> [f64; 3] {
    [FormFactors::HitList, ANALYTIC, AREA_SAMPLING].map(|form_factors| {
        let settings = BakeSettings {
            elements,
            element_rays: 4096,
            form_factors,
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        };
        between(&solved(scene.clone(), &settings), 0, 1)
    })
}

fn assert_near(id: &str, found: [f64; 3], truth: f64, tolerance: [f64; 3]) {
    let errors = found.map(|f| f / truth - 1.0);
    for (error, tolerance) in errors.into_iter().zip(tolerance) {
        assert!(error.abs() < tolerance, "{id}: {found:?} for {truth}");
    }
}

#[test]
fn disks_see_each_other() {
    let truths = form_factors();
    let disks: Vec<_> = truths
        .iter()
        .filter(|t| t.kind == "coaxial_disks")
        .collect();
    assert_eq!(disks.len(), 4);
    for t in disks {
        let [r1, r2, h] = ["r1", "r2", "h"].map(|name| t.number(name) as f32);
        let objects = vec![disk(r1, 0.0, true, 48), disk(r2, h, false, 48)];
        let found = by_each_method(&scene(objects, vec![grey(0.5, 1.0)]), 400);
        // Area sampling finds too much of what is near, and what is too much for a row is cut off.
        let pairs = if h < 0.5 { 0.1 } else { 2e-3 };
        assert_near(&t.id, found, t.value, [6e-3, 2e-4, pairs]);
    }
}

#[test]
fn an_outer_sphere_sees_the_inner() {
    for t in form_factors()
        .iter()
        .filter(|t| t.kind.starts_with("concentric"))
    {
        let ratio = (t.number("r1") / t.number("r2")) as f32;
        let objects = vec![inward_sphere(6, 0), inside_out(inward_sphere(6, 0), ratio)];
        let found = by_each_method(&scene(objects, vec![grey(0.5, 1.0)]), 500);
        // One shadow ray a pair is noise in a row: what it has above 1 is cut off, what it lacks
        // is not made up for.
        let pairs = if ratio > 0.8 { 0.1 } else { 0.01 };
        assert_near(&t.id, found, t.value, [2e-3, 5e-3, pairs]);
    }
}

/// From anywhere inside a sphere a piece of it is seen by its share of the area.
#[test]
fn inside_a_sphere_all_see_all_alike() {
    let scene = scene(vec![inward_sphere(6, 0)], vec![grey(0.5, 1.0)]);
    let settings = settings(&scene, 4.0 * std::f64::consts::PI / 288.0, ANALYTIC);
    let light = solved(scene, &settings);
    let total: f64 = light.elements.iter().map(|e| f64::from(e.area)).sum();
    let (mut squares, mut count) = (0.0, 0);
    for i in 0..light.elements.len() {
        assert!(
            (light.row_sum(i) - 1.0).abs() < 1e-3,
            "{}",
            light.row_sum(i)
        );
        for (j, f) in light
            .row(i)
            .into_iter()
            .enumerate()
            .filter(|(j, _)| *j != i)
        {
            squares += (f * total / f64::from(light.elements[j].area) - 1.0).powi(2);
            count += 1;
        }
    }
    let rms = (squares / f64::from(count)).sqrt();
    // Flat pieces of 15° stand for curved ones: neighbours see 10 % and more too little or much.
    assert!(rms < 0.05, "{rms}");
}

/// A strip `length` along y, from `a` to `b` in the plane of x and z, that faces `(b − a) × y`.
fn strip(a: DVec3, b: DVec3, length: f64) -> [DVec3; 4] {
    let half = DVec3::Y * 0.5 * length;
    [a - half, b - half, b + half, a + half]
}

/// Strips so long that their ends tell by their share of the length only.
#[test]
fn long_strips_are_as_endless() {
    let length = 1e4;
    let mut checked = 0;
    for t in form_factors() {
        let f = match &*t.kind {
            "infinite_opposed_strips" => {
                let z = DVec3::Z * t.number("h_over_w");
                let below = strip(DVec3::ZERO, DVec3::X, length);
                polygon_to_polygon(&below, &strip(z + DVec3::X, z, length))
            }
            "infinite_wedge_equal_widths" => {
                let (sin, cos) = t.number("deg").to_radians().sin_cos();
                let below = strip(DVec3::ZERO, DVec3::X, length);
                polygon_to_polygon(
                    &below,
                    &strip(DVec3::new(cos, 0.0, sin), DVec3::ZERO, length),
                )
            }
            "infinite_parallel_cylinders" => long_prisms(t.number("x"), length),
            _ => continue,
        };
        assert!((f - t.value).abs() < 4e-4, "{}: {f} for {}", t.id, t.value);
        checked += 1;
    }
    assert_eq!(checked, 9);
}

/// Two prisms of the same surface as cylinders of radius 1 whose axes are `2 x` apart. What two
/// convex bodies face of each other, nothing hides.
fn long_prisms(x: f64, length: f64) -> f64 {
    let corners = 64;
    let turn = std::f64::consts::TAU / f64::from(corners);
    let reach = 0.5 * turn / (0.5 * turn).sin();
    let side = |center: f64, i: i32| {
        // Half a side on: flat sides face each other where cylinders are nearest.
        let at = |i: i32| {
            let (sin, cos) = (turn * (f64::from(i) + 0.5)).sin_cos();
            DVec3::new(center + reach * cos, 0.0, reach * sin)
        };
        strip(at(i + 1), at(i), length)
    };
    let pairs = (0..corners).flat_map(|i| (0..corners).map(move |j| (i, j)));
    let sum: f64 = pairs
        .map(|(i, j)| polygon_to_polygon(&side(0.0, i), &side(2.0 * x, j)))
        .sum();
    sum / f64::from(corners)
}

#[test]
fn hidden_squares_exchange_the_visible_share() {
    let method = FormFactors::Analytic {
        visibility_rays: 16_384,
    };
    let mut checked = 0;
    for t in form_factors()
        .iter()
        .filter(|t| t.kind.starts_with("obstructed"))
    {
        let scene = squares(1.0, Some(t.pair("blocker")));
        let settings = settings(&scene, 0.5, method);
        let f = between(&solved(scene, &settings), 0, 1);
        assert!((f - t.value).abs() < 1e-3, "{}: {f} for {}", t.id, t.value);
        checked += 1;
    }
    assert_eq!(checked, 4);
}

/// A blocker midway lets 0 or 1 through from centre to centre; the truth is between.
#[test]
fn half_hidden_is_neither_hidden_nor_seen() {
    for (rays, tolerance) in [(64, 0.05), (256, 0.02), (4096, 0.005)] {
        let errors = (0..16).map(|seed| {
            let scene = squares(1.0, Some([0.25, 0.75]));
            let method = FormFactors::Analytic {
                visibility_rays: rays,
            };
            let settings = BakeSettings {
                seed,
                ..settings(&scene, 0.5, method)
            };
            between(&solved(scene, &settings), 0, 1) / 0.099_506_294_6 - 1.0
        });
        let errors: Vec<f64> = errors.collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 16.0).sqrt();
        assert!(rms < tolerance, "{rays} rays: {rms}");
    }
}

/// Baum, Rushmeier and Winget (1989): one point is 17 % wrong at a gap of a tenth.
#[test]
fn near_squares_are_no_points() {
    for (gap, truth) in [(0.1, 0.826_994_522_4), (0.01, 0.980_416_602_9)] {
        let scene = squares(gap, None);
        let settings = settings(&scene, 0.5, ANALYTIC);
        let light = solved(scene, &settings);
        let f = between(&light, 0, 1);
        assert!((f - truth).abs() < 1e-5, "gap {gap}: {f}");
        assert_eq!(light.report.form_factors.scaled_rows, 0);
    }
}

/// Objects that stand about face all ways; one in the room's middle is half in the floor.
#[test]
fn turned_triangles_agree_with_rays() {
    let mut objects = crate::common::room(Vec3::ONE, 2, [0; 6]);
    objects.push(inside_out(inward_sphere(2, 0), 0.2));
    for p in &mut objects[6].positions {
        *p += Vec3::new(0.4, 0.1, 0.5);
    }
    let scene = scene(objects, vec![grey(0.5, 1.0)]);
    let with = |form_factors, element_rays| {
        let settings = BakeSettings {
            elements: 150,
            element_rays,
            form_factors,
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        };
        solved(scene.clone(), &settings)
    };
    let rays = with(FormFactors::HitList, 4096);
    let closed = with(
        FormFactors::Analytic {
            visibility_rays: 256,
        },
        1,
    );
    assert_eq!(rays.elements.len(), closed.elements.len());
    for i in 0..7 {
        for j in 0..7 {
            let (a, b) = (between(&rays, i, j), between(&closed, i, j));
            assert!(
                (a - b).abs() < 2e-3,
                "{i} to {j}: {a} by rays, {b} in closed form"
            );
        }
    }
}

/// Fine meshes have elements of dozens of triangles, which others stand in for.
#[test]
fn elements_of_many_triangles() {
    let objects = vec![inward_sphere(24, 0), inside_out(inward_sphere(24, 0), 0.5)];
    let scene = scene(objects, vec![grey(0.5, 1.0)]);
    let found = by_each_method(&scene, 150);
    // Elements 40° wide: stand-ins overlap in part and leave gaps between.
    assert_near("fine spheres", found, 0.25, [2e-3, 0.03, 0.03]);
}

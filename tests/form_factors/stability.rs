//! Where form factors go wrong if they do.

use bevy_fresco::radiosity::{
    BakeSettings, ElementLight, FormFactors, Scene, point_to_polygon, polygon_to_polygon,
};
use glam::{DVec2, DVec3, Quat, Vec3};

use crate::common::{block, grey, quad, room, scene};
use crate::meshes::solved;
use crate::truth::form_factors;

/// The cells of a parallelogram.
fn cells(p: &[DVec3], n: u32) -> Vec<[DVec3; 4]> {
    let (u, v) = ((p[1] - p[0]) / f64::from(n), (p[3] - p[0]) / f64::from(n));
    let cell = |k: u32| {
        let a = p[0] + u * f64::from(k / n) + v * f64::from(k % n);
        [a, a + u, a + u + v, a + v]
    };
    (0..n * n).map(cell).collect()
}

/// Squares that share an edge at 30° to 150°, and their form factors.
fn hinged() -> Vec<(Vec<DVec3>, Vec<DVec3>, f64)> {
    let truths = form_factors();
    let hinged = truths
        .iter()
        .filter(|t| t.id.starts_with("poly unit squares sharing"));
    let found: Vec<_> = hinged
        .map(|t| {
            (
                t.polygon("from").unwrap(),
                t.polygon("to").unwrap(),
                t.value,
            )
        })
        .collect();
    assert_eq!(found.len(), 6);
    found
}

/// The kernel has a pole along a common edge. The integral over the outlines has none, and its
/// parts add up to the whole however finely both are cut.
#[test]
fn touching_polygons_are_exact() {
    for (a, b, truth) in hinged() {
        for n in [1, 2, 4, 8] {
            let onto = |from: &[DVec3; 4]| -> f64 {
                cells(&b, n)
                    .iter()
                    .map(|to| polygon_to_polygon(from, to))
                    .sum()
            };
            let parts = cells(&a, n);
            let f = parts.iter().map(onto).sum::<f64>() / parts.len() as f64;
            assert!(
                (f / truth - 1.0).abs() < 1e-12,
                "{n} × {n}: {f} for {truth}"
            );
        }
    }
}

/// Gauss points, by halves of the rules of 4, 8 and 16 points.
fn gauss(n: usize) -> Vec<DVec2> {
    let half: &[(f64, f64)] = match n {
        1 => &[(0.0, 1.0)],
        4 => &[
            (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        ],
        8 => &[
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
            (0.960_289_856_497_536_2, 0.101_228_536_290_376_3),
        ],
        16 => &[
            (0.095_012_509_837_637_4, 0.189_450_610_455_068_6),
            (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
            (0.458_016_777_657_227_4, 0.169_156_519_395_002_6),
            (0.617_876_244_402_643_8, 0.149_595_988_816_576_7),
            (0.755_404_408_355_003, 0.124_628_971_255_534_1),
            (0.865_631_202_387_831_8, 0.095_158_511_682_492_6),
            (0.944_575_023_073_232_6, 0.062_253_523_938_647_5),
            (0.989_400_934_991_649_9, 0.027_152_459_411_754_2),
        ],
        _ => panic!("no rule of {n} points"),
    };
    let both = half.iter().flat_map(|&(x, w)| {
        [
            DVec2::new(0.5 - 0.5 * x, 0.5 * w),
            DVec2::new(0.5 + 0.5 * x, 0.5 * w),
        ]
    });
    both.collect()
}

/// What points make of touching squares: why few of them are never used there.
#[test]
fn touching_polygons_need_many_points() {
    for (n, at_most, at_least) in [
        (1, 0.2, 0.05),
        (4, 3e-3, 5e-4),
        (8, 2e-4, 1e-5),
        (16, 2e-5, 5e-7),
    ] {
        let mut worst = 0.0_f64;
        for (a, b, truth) in hinged() {
            let normal = (a[1] - a[0]).cross(a[3] - a[0]);
            let rule = gauss(n);
            let weight: f64 = rule.iter().map(|p| p.y).sum();
            let at = |s: &DVec2, t: &DVec2| {
                let p = a[0] + (a[1] - a[0]) * s.x + (a[3] - a[0]) * t.x;
                s.y * t.y * point_to_polygon(p, normal, &b)
            };
            let f: f64 = rule
                .iter()
                .flat_map(|s| rule.iter().map(move |t| (s, t)))
                .map(|(s, t)| at(s, t))
                .sum();
            worst = worst.max((f / (weight * weight) / truth - 1.0).abs());
        }
        assert!(
            worst < at_most && worst > at_least,
            "{n} × {n} points: {worst:.1e}"
        );
    }
}

/// Across the hand-over from outlines to areas, and out to where only areas can tell.
#[test]
fn far_polygons_do_not_cancel() {
    let square = |z: f64| {
        let p = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        p.map(|(x, y)| DVec3::new(x, y, z))
    };
    let mut facing = square(0.0);
    facing.reverse();
    for k in 0..60 {
        let z = 1.2_f64.powi(k);
        let f = polygon_to_polygon(&square(0.0), &facing.map(|p| p + DVec3::Z * z));
        // ∫∫ z² / π r⁴ with the separations' moments 1/6, 1/15 and 1/36 in 1/z².
        let series = 1.0 - 2.0 / 3.0 / (z * z) + 3.0 * (2.0 / 15.0 + 2.0 / 36.0) / z.powi(4);
        let next = 4.0 * (2.0 / 28.0 + 6.0 / 90.0) / z.powi(6);
        let truth = series / (std::f64::consts::PI * z * z);
        if z > 8.0 {
            assert!(
                (f / truth - 1.0).abs() < 1.1 * next + 1e-12,
                "at {z}: {f:e} for {truth:e}"
            );
        }
    }
}

/// What reaches behind the other's plane does not count, and no more than that.
#[test]
fn polygons_through_each_other_count_in_front() {
    let below =
        [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x - 1.0, y, 0.0));
    let right =
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let wall =
        [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)].map(|(y, z)| DVec3::new(0.0, y, z - 1.0));
    let upper = wall.map(|p| DVec3::new(p.x, p.y, p.z.max(0.0)));
    let truth = polygon_to_polygon(&right, &upper);
    assert!((truth - 0.200_043_776_075_403).abs() < 1e-13);
    // Half of what is below sees half of the wall.
    assert!((polygon_to_polygon(&below, &wall) - 0.5 * truth).abs() < 1e-14);
    assert!((polygon_to_polygon(&wall, &below) - 0.5 * truth).abs() < 1e-14);
}

#[test]
fn what_is_no_polygon_exchanges_nothing() {
    let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let nan = square.map(|p| p * f64::NAN);
    let line = [DVec3::Z, DVec3::Z + DVec3::X, DVec3::Z + DVec3::X * 2.0];
    let others: [&[DVec3]; 7] = [
        &[],
        &[DVec3::Z],
        &line[..2],
        &line,
        &nan,
        &square,
        &[DVec3::Z; 4],
    ];
    for other in others {
        assert_eq!(polygon_to_polygon(&square, other), 0.0, "{other:?}");
        assert_eq!(polygon_to_polygon(other, &square), 0.0, "{other:?}");
        assert_eq!(
            point_to_polygon(DVec3::ZERO, DVec3::Z, other),
            0.0,
            "{other:?}"
        );
    }
    assert_eq!(
        point_to_polygon(DVec3::ZERO, DVec3::ZERO, &square.map(|p| p + DVec3::Z)),
        0.0
    );
}

/// A closed room, and two boxes in it or none.
fn closed_room(boxes: bool) -> Scene {
    let mut objects = room(Vec3::ONE, 1, [0, 1, 0, 0, 0, 0]);
    if boxes {
        objects.extend(block(
            Vec3::new(0.15, 0.0, 0.2),
            Vec3::new(0.3, 0.6, 0.3),
            1,
            0,
        ));
        objects.extend(block(Vec3::new(0.55, 0.0, 0.5), Vec3::splat(0.3), 1, 0));
    }
    scene(objects, vec![grey(0.7, 0.0), grey(0.7, 1.0)])
}

fn with(scene: Scene, form_factors: FormFactors) -> ElementLight {
    let settings = BakeSettings {
        elements: 300,
        form_factors,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    };
    solved(scene, &settings)
}

/// Nothing escapes an empty room: closed forms add up to 1.
#[test]
fn rows_of_a_closed_room_sum_to_one() {
    let light = with(
        closed_room(false),
        FormFactors::Analytic { visibility_rays: 1 },
    );
    let largest = light.report.form_factors.largest_row_sum;
    assert!((largest - 1.0).abs() < 5e-4, "{largest}");
    for i in 0..light.elements.len() {
        assert!(
            (light.row_sum(i) - 1.0).abs() < 5e-4,
            "{}",
            light.row_sum(i)
        );
    }
}

/// In a closed room with boxes, sums are shadow rays' noise about 1; floor under boxes sees
/// nothing but their black insides.
#[test]
fn more_shadow_rays_close_rows_better() {
    let mut before = f64::INFINITY;
    for (rays, at_most) in [(1, 0.1), (16, 0.03), (256, 0.01)] {
        let light = with(
            closed_room(true),
            FormFactors::Analytic {
                visibility_rays: rays,
            },
        );
        let report = &light.report.form_factors;
        let excess = report.largest_row_sum - 1.0;
        assert!(excess < at_most && excess < before, "{rays} rays: {excess}");
        before = excess;
        assert!(light.report.solver.converged);
    }
}

/// The kernel's pole shows in the sums of the rows; scaling keeps the solver safe.
#[test]
fn area_sampling_exceeds_one_and_is_scaled() {
    let light = with(closed_room(true), FormFactors::AreaSampling { samples: 4 });
    let report = &light.report.form_factors;
    assert!(
        report.largest_row_sum > 1.2 && report.scaled_rows > 50,
        "{report:?}"
    );
    assert!((0..light.elements.len()).all(|i| light.row_sum(i) <= 1.0 + 1e-6));
    assert!(light.report.solver.converged);
}

/// `A_i F_ij = A_j F_ji`, where neither row was scaled.
#[test]
fn pairs_are_reciprocal() {
    for method in [
        FormFactors::Analytic { visibility_rays: 2 },
        FormFactors::AreaSampling { samples: 2 },
    ] {
        let light = with(closed_room(true), method);
        let rows: Vec<Vec<f64>> = (0..light.elements.len()).map(|i| light.row(i)).collect();
        let mut checked = 0;
        let whole = |i: usize| light.row_sum(i) < 1.0 - 1e-6;
        for i in (0..rows.len()).filter(|&i| whole(i)) {
            for j in (0..rows.len()).filter(|&j| whole(j)) {
                let (there, back) = (rows[i][j], rows[j][i]);
                let areas = [i, j].map(|e| f64::from(light.elements[e].area));
                let error = (areas[0] * there - areas[1] * back).abs();
                assert!(error <= 1e-6 * areas[0] * there, "{i} {j}: {there} {back}");
                checked += usize::from(there > 0.0);
            }
        }
        assert!(checked > 100, "{}: {checked}", method.name());
    }
}

/// Triangles thrown about, through each other and all: whatever the method, the solver converges.
#[test]
fn any_scene_can_be_solved() {
    for seed in 0..6_u32 {
        let mut objects = Vec::new();
        for k in 0..12 {
            let r = |i: u32| ((seed * 97 + k * 13 + i * 7) as f32 * 0.618_034).fract();
            let turn = Quat::from_euler(glam::EulerRot::XYZ, 6.0 * r(0), 6.0 * r(1), 6.0 * r(2));
            let size = if k % 4 == 0 { 1e-3 } else { 0.2 + r(3) };
            objects.push(quad(
                "any",
                Vec3::new(r(4), r(5), r(6)),
                turn * Vec3::X,
                turn * Vec3::Y * size,
                1,
                0,
            ));
        }
        let mut scene = scene(objects, vec![grey(0.9, 1.0)]);
        scene.sky = Vec3::splat(if seed % 2 == 0 { 0.0 } else { 1.0 });
        scene.materials[0].double_sided = seed % 3 == 0;
        for method in [
            FormFactors::Analytic { visibility_rays: 2 },
            FormFactors::AreaSampling { samples: 2 },
        ] {
            let light = with(scene.clone(), method);
            assert!(light.report.solver.converged, "{}", method.name());
            for (i, e) in light.elements.iter().enumerate() {
                assert!(
                    e.radiosity.is_finite() && light.row_sum(i) <= 1.0 + 1e-6,
                    "{e:?}"
                );
            }
        }
    }
}

/// A floor under an even sky: all of its view.
#[test]
fn open_views_are_sky() {
    let mut scene = scene(
        vec![quad("floor", Vec3::ZERO, Vec3::Z, Vec3::X, 1, 0)],
        vec![grey(0.5, 0.0)],
    );
    scene.sky = Vec3::ONE;
    for method in [
        FormFactors::Analytic { visibility_rays: 1 },
        FormFactors::AreaSampling { samples: 1 },
    ] {
        for e in with(scene.clone(), method).elements {
            assert!(
                (e.irradiance.x - 1.0).abs() < 1e-6,
                "{}: {e:?}",
                method.name()
            );
        }
    }
}

//! Closed forms against the values, all 72; polygons against all that are polygons.

use bevy_fresco::radiosity::{point_to_polygon, polygon_to_polygon};
use glam::DVec3;

use crate::closed_form::*;
use crate::truth::{Truth, form_factors};

/// The formula for a value; `None` where there is none but a polygon's.
fn formula(t: &Truth) -> Option<f64> {
    let n = |name| t.number(name);
    let range = |a: &str, b: &str| [t.number(a), t.number(b)];
    Some(match &*t.kind {
        "parallel_opposed_rectangles" => opposed_rectangles(n("a"), n("b"), n("c")),
        "perpendicular_rectangles_common_edge" => hinged_rectangles(n("w"), n("h"), n("l")),
        "parallel_rectangles_offset" => parallel_rectangles(
            range("x1", "x2"),
            range("y1", "y2"),
            range("xi1", "xi2"),
            range("eta1", "eta2"),
            n("z"),
        ),
        "perpendicular_rectangles_offset" => perpendicular_rectangles(
            range("x1", "x2"),
            range("y1", "y2"),
            range("eta1", "eta2"),
            range("z1", "z2"),
        ),
        "coaxial_disks" => coaxial_disks(n("r1"), n("r2"), n("h")),
        "point_to_parallel_rectangle_corner" => point_to_parallel_rectangle(n("a"), n("b"), n("c")),
        "point_to_perpendicular_rectangle_corner" => {
            point_to_standing_rectangle(n("a"), n("b"), n("c"))
        }
        "point_to_sphere_fully_visible" => point_to_sphere(n("r"), n("d"), n("cos_theta")),
        "sphere_to_coaxial_disk" => sphere_to_disk(n("r"), n("h")),
        "sphere_interior" => inside_sphere(n("theta2")),
        "concentric_spheres_outer_to_inner" => concentric_spheres(n("r1"), n("r2")),
        "infinite_opposed_strips" => strips(n("h_over_w")),
        "infinite_wedge_equal_widths" => wedge(n("deg").to_radians()),
        "infinite_parallel_cylinders" => cylinders(n("x")),
        "infinite_strips_with_baffle_crossed_strings" => {
            strips_with_baffle(n("w"), n("h"), n("baffle"))
        }
        "obstructed_parallel_squares" => obstructed_squares(t.pair("blocker")),
        "polygon_polygon" | "point_to_polygon_lambert" => return None,
        other => panic!("{} is of the kind {other}, which has no formula", t.id),
    })
}

/// Twelve digits: C-11 and C-13 cancel three of sixteen at ten sizes' distance.
#[test]
fn closed_forms_have_the_known_values() {
    let truths = form_factors();
    assert_eq!(truths.len(), 72);
    let mut checked = 0;
    for t in &truths {
        if let Some(f) = formula(t) {
            assert!((f - t.value).abs() < 1e-12, "{}: {f} for {}", t.id, t.value);
            checked += 1;
        }
    }
    assert_eq!(checked, 72 - 12 - 3);
}

fn rectangle(origin: [f64; 3], u: DVec3, v: DVec3) -> Vec<DVec3> {
    let origin = DVec3::from_array(origin);
    vec![origin, origin + u, origin + u + v, origin + v]
}

/// The polygon that a point looks at, and its normal.
fn looked_at(t: &Truth) -> Option<(DVec3, DVec3, Vec<DVec3>)> {
    match &*t.kind {
        "point_to_polygon_lambert" => {
            Some((t.vector("point"), t.vector("normal"), t.polygon("polygon")?))
        }
        "point_to_parallel_rectangle_corner" => {
            let (u, v) = (DVec3::Y * t.number("b"), DVec3::X * t.number("a"));
            Some((
                DVec3::ZERO,
                DVec3::Z,
                rectangle([0.0, 0.0, t.number("c")], u, v),
            ))
        }
        "point_to_perpendicular_rectangle_corner" => {
            let (u, v) = (DVec3::X * t.number("b"), DVec3::Z * t.number("a"));
            Some((
                DVec3::ZERO,
                DVec3::Z,
                rectangle([0.0, t.number("c"), 0.0], u, v),
            ))
        }
        _ => None,
    }
}

/// The polygons that a value is about.
fn polygons(t: &Truth) -> Option<(Vec<DVec3>, Vec<DVec3>)> {
    if t.kind == "parallel_opposed_rectangles" {
        let (u, v) = (DVec3::X * t.number("a"), DVec3::Y * t.number("b"));
        let above = rectangle([0.0, 0.0, t.number("c")], v, u);
        return Some((rectangle([0.0; 3], u, v), above));
    }
    Some((t.polygon("from")?, t.polygon("to")?))
}

/// A rotation, a size and a place that nothing is aligned with.
fn elsewhere(p: DVec3) -> DVec3 {
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -2.0);
    turn * p * 7.3 + DVec3::new(12.0, -5.0, 3.0)
}

#[test]
fn points_see_polygons_as_the_values_say() {
    let truths = form_factors();
    let cases: Vec<_> = truths
        .iter()
        .filter_map(|t| Some((t, looked_at(t)?)))
        .collect();
    assert_eq!(cases.len(), 3 + 4 + 4);
    for (t, (point, normal, polygon)) in cases {
        let f = point_to_polygon(point, normal, &polygon);
        assert!((f - t.value).abs() < 1e-14, "{}: {f} for {}", t.id, t.value);
        let turned: Vec<DVec3> = polygon.iter().copied().map(elsewhere).collect();
        let up = elsewhere(normal) - elsewhere(DVec3::ZERO);
        let f = point_to_polygon(elsewhere(point), up, &turned);
        assert!(
            (f - t.value).abs() < 1e-13,
            "{} turned: {f} for {}",
            t.id,
            t.value
        );
        let behind: Vec<DVec3> = polygon.into_iter().rev().collect();
        assert_eq!(point_to_polygon(point, normal, &behind), 0.0, "{}", t.id);
    }
}

#[test]
fn polygons_see_polygons_as_the_values_say() {
    let truths = form_factors();
    let cases: Vec<_> = truths
        .iter()
        .filter_map(|t| Some((t, polygons(t)?)))
        .collect();
    assert_eq!(cases.len(), 6 + 5 + 3 + 4 + 12);
    for (t, (from, to)) in cases {
        let f = polygon_to_polygon(&from, &to);
        // Turned, edges that touched are 1e-15 apart: no worse.
        let [from_there, to_there] =
            [&from, &to].map(|p| p.iter().copied().map(elsewhere).collect::<Vec<DVec3>>());
        let turned = polygon_to_polygon(&from_there, &to_there);
        for f in [f, turned] {
            assert!((f - t.value).abs() < 1e-12, "{}: {f} for {}", t.id, t.value);
        }
        let behind: Vec<DVec3> = to.into_iter().rev().collect();
        assert_eq!(polygon_to_polygon(&from, &behind), 0.0, "{}", t.id);
    }
}

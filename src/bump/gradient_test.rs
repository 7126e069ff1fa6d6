use std::f32::consts::TAU;

use glam::{DVec3, Mat3, Quat, Vec2, Vec3};

use super::gradient::*;
use crate::bump::blinn_normal;
use crate::height_map::{HeightMap, Kernel, Wrap};
use crate::mesh::test_meshes::random;

fn signed(random: &mut impl FnMut() -> f32) -> f32 {
    2.0 * random() - 1.0
}

fn direction(random: &mut impl FnMut() -> f32) -> Vec3 {
    let z = signed(random);
    let (y, x) = (std::f32::consts::PI * signed(random)).sin_cos();
    Vec3::new(x, y, 0.0) * (1.0 - z * z).max(0.0).sqrt() + Vec3::Z * z
}

fn degrees(a: Vec3, b: Vec3) -> f32 {
    // By the cross product: the cosine of small angles says nothing in f32.
    let [a, b]: [DVec3; 2] = [a, b].map(Into::into);
    a.cross(b).length().atan2(a.dot(b)).to_degrees() as f32
}

/// Bump test 1: `n' = normalize(−hx, −hy, 1)` on a plane, the sign with it.
#[test]
fn relief_on_a_plane_has_the_normal_of_the_relief() {
    let height = |x: f32, y: f32| 0.1 * (TAU * x).sin() * (TAU * y).cos();
    let heights = (0..256 * 256).map(|i| {
        let (x, y) = ((i % 256) as f32 + 0.5, (i / 256) as f32 + 0.5);
        height(x / 256.0, y / 256.0)
    });
    let map = HeightMap::new([256; 2], heights.collect(), [Wrap::Repeat; 2]).unwrap();
    let plane = Steps {
        normal: Vec3::Z,
        along: [Vec3::X, Vec3::Y],
    };
    for i in 0..500 {
        let uv = Vec2::new((i as f32 * 0.618).fract(), (i as f32 * 0.733).fract());
        let slopes = map.at(uv, Kernel::CatmullRom).slopes;
        let (x, y) = (TAU * uv.x, TAU * uv.y);
        let [hx, hy] = [x.cos() * y.cos(), -x.sin() * y.sin()].map(|s| 0.1 * TAU * s);
        let truth = Vec3::new(-hx, -hy, 1.0).normalize();
        let found = bumped_normal(Vec3::Z, surface_gradient(plane, slopes.into()));
        assert!(degrees(found, truth) < 0.1, "{found} for {truth}");
        let blinn = blinn_normal(Vec3::X, Vec3::Y, slopes).unwrap();
        assert!(degrees(found, blinn) < 1e-3);
    }
}

/// A surface of revolution at `(u, v)`, raised by `height`: `P`, `N`, their derivatives.
struct Round {
    normal: Vec3,
    along: [Vec3; 2],
    normal_changes: [Vec3; 2],
}

fn cylinder(radius: f32, u: f32) -> Round {
    let (normal, turned) = (
        Vec3::new(u.cos(), u.sin(), 0.0),
        Vec3::new(-u.sin(), u.cos(), 0.0),
    );
    Round {
        normal,
        along: [radius * turned, Vec3::Z],
        normal_changes: [turned, Vec3::ZERO],
    }
}

fn sphere(radius: f32, [u, v]: [f32; 2]) -> Round {
    let normal = Vec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin());
    let by_u = Vec3::new(-v.cos() * u.sin(), v.cos() * u.cos(), 0.0);
    let by_v = Vec3::new(-v.sin() * u.cos(), -v.sin() * u.sin(), v.cos());
    Round {
        normal,
        along: [radius * by_u, radius * by_v],
        normal_changes: [by_u, by_v],
    }
}

/// The truth of a raised surface by differences in f64.
fn raised(point: impl Fn(f64, f64) -> DVec3, [u, v]: [f32; 2]) -> Vec3 {
    let (u, v, e) = (f64::from(u), f64::from(v), 1e-5);
    let by_u = point(u + e, v) - point(u - e, v);
    let by_v = point(u, v + e) - point(u, v - e);
    by_u.cross(by_v).normalize().as_vec3()
}

/// Bump test 2: Blinn's formula on round surfaces, and the truth with the term he leaves out.
#[test]
fn round_surfaces_have_blinns_normal_or_the_true_one() {
    for relief in [0.01_f32, 0.05] {
        // Slope 1 at its steepest, heights of `relief` beside the radius.
        let wave = 1.0 / relief;
        let (mut blinn_off, mut exact_off) = (0.0_f32, 0.0_f32);
        for i in 0..400 {
            let u = i as f32 * 0.01571;
            let around = cylinder(1.0, u);
            let height = relief * (wave * u).sin();
            let slopes = Vec2::new((wave * u).cos(), 0.0);
            let steps = Steps {
                normal: around.normal,
                along: around.along,
            };
            let found = bumped_normal(steps.normal, surface_gradient(steps, slopes.into()));
            let letter = blinn_normal(around.along[0], around.along[1], slopes).unwrap();
            assert!(degrees(found, letter) < 0.01);
            let truth = raised(
                |u, v| {
                    let r = 1.0 + f64::from(relief) * (f64::from(wave) * u).sin();
                    DVec3::new(r * u.cos(), r * u.sin(), v)
                },
                [u, 0.0],
            );
            let exact = displaced_normal(steps, around.normal_changes, height, slopes.into());
            blinn_off = blinn_off.max(degrees(found, truth));
            exact_off = exact_off.max(degrees(exact, truth));
        }
        assert!(exact_off < 0.1, "{exact_off}");
        // Slopes are off by 1 + h/R: 0.29° and 1.4° where relief is steepest and highest at once,
        // less here.
        let bound = (1.0 + relief).atan() - 1.0_f32.atan();
        assert!(blinn_off < bound.to_degrees() && blinn_off > exact_off);
    }
}

#[test]
fn a_sphere_with_relief_has_its_true_normal() {
    for i in 0..400 {
        let uv = [i as f32 * 0.7, ((i as f32 * 0.37).fract() - 0.5) * 2.8];
        let (relief, m) = (0.05_f32, 12.0_f32);
        let around = sphere(2.0, uv);
        let height = relief * (m * uv[1]).sin();
        let changes = [0.0, relief * m * (m * uv[1]).cos()];
        let steps = Steps {
            normal: around.normal,
            along: around.along,
        };
        let truth = raised(
            |u, v| {
                let r = 2.0 + f64::from(relief) * (f64::from(m) * v).sin();
                DVec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin()) * r
            },
            uv,
        );
        let exact = displaced_normal(steps, around.normal_changes, height, changes);
        assert!(degrees(exact, truth) < 0.1, "{exact} for {truth}");
        let letter = blinn_normal(around.along[0], around.along[1], changes.into()).unwrap();
        let found = bumped_normal(steps.normal, surface_gradient(steps, changes));
        assert!(degrees(found, letter) < 0.1);
    }
}

/// Bump test 3: texture coordinates that have less and less area, down to none.
#[test]
fn texture_coordinates_without_area_do_no_harm() {
    let random = &mut random(3);
    let mut compared = 0;
    for i in 0..100_000 {
        let [a, b] = [direction(random), direction(random)];
        let n = a.cross(b);
        let Some(normal) = n.try_normalize() else {
            continue;
        };
        let squeezed = match i % 10 {
            0 => 0.0,
            k => 10_f32.powi(-k),
        };
        let uv = [
            Vec2::new(1.0, 0.3),
            Vec2::new(1.0, 0.3) + Vec2::new(-0.3, 1.0) * squeezed,
        ];
        let slopes = Vec2::new(signed(random), signed(random));
        let steps = Steps {
            normal,
            along: [a, b],
        };
        let [by_u, by_v] = uv_gradients(steps, uv);
        let found = bumped_normal(normal, slopes.x * by_u + slopes.y * by_v);
        assert!((found.length() - 1.0).abs() < 1e-5, "{found}");
        // Triangles of some area have a truth to compare with.
        if n.length() > 0.01 {
            let [a, b, n]: [DVec3; 3] = [a, b, n].map(Into::into);
            let n = n.normalize();
            let change = |uv: Vec2| {
                f64::from(slopes.x) * f64::from(uv.x) + f64::from(slopes.y) * f64::from(uv.y)
            };
            let gradient =
                (change(uv[0]) * b.cross(n) + change(uv[1]) * n.cross(a)) / n.dot(a.cross(b));
            let steep = f64::from(MAX_SLOPE).min(gradient.length());
            let truth = (n - gradient.normalize_or_zero() * steep).normalize();
            assert!(degrees(found, truth.as_vec3()) < 0.5, "{found} for {truth}");
            compared += 1;
        }
    }
    assert!(compared > 90_000);
}

/// Bump test 4: mirrored meshes and texture coordinates have mirrored relief, and bumps stay bumps.
#[test]
fn what_is_mirrored_has_mirrored_relief() {
    let mirror = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
    let random = &mut random(4);
    for _ in 0..1000 {
        let turn = Quat::from_rotation_arc(Vec3::Z, direction(random));
        let [normal, a, b] = [Vec3::Z, Vec3::X * 2.0, Vec3::new(0.4, 1.0, 0.0)].map(|v| turn * v);
        let uv = [Vec2::new(1.0, 0.2), Vec2::new(-0.1, 0.7)];
        let slopes = Vec2::new(signed(random), signed(random));
        let bumped = |steps, uv: [Vec2; 2], slopes: Vec2| {
            let [by_u, by_v] = uv_gradients(steps, uv);
            bumped_normal(steps.normal, slopes.x * by_u + slopes.y * by_v)
        };
        let found = bumped(
            Steps {
                normal,
                along: [a, b],
            },
            uv,
            slopes,
        );
        // The mesh mirrored, as by a scale of −1: its corners now go round the other way.
        let mirrored = Steps {
            normal: mirror * normal,
            along: [mirror * a, mirror * b],
        };
        assert!(degrees(mirror * bumped(mirrored, uv, slopes), found) < 0.05);
        // The map mirrored: u and its slope change their sign.
        let flipped = uv.map(|uv| uv * Vec2::new(-1.0, 1.0));
        let same = bumped(
            Steps {
                normal,
                along: [a, b],
            },
            flipped,
            slopes * Vec2::new(-1.0, 1.0),
        );
        assert!(degrees(same, found) < 0.05);
        // Uphill, normals lean back.
        let [by_u, by_v] = uv_gradients(
            Steps {
                normal,
                along: [a, b],
            },
            uv,
        );
        assert!(found.dot(slopes.x * by_u + slopes.y * by_v) < 0.0);
    }
}

/// Bump tests 5 and 6: whatever the parametrisation, and per triangle as by its tangents.
#[test]
fn gradients_depend_on_no_parametrisation() {
    let random = &mut random(5);
    for _ in 0..1000 {
        let (a, b) = (direction(random), direction(random));
        let Some(normal) = a
            .cross(b)
            .try_normalize()
            .filter(|_| a.cross(b).length() > 0.1)
        else {
            continue;
        };
        let steps = Steps {
            normal,
            along: [a, b],
        };
        // Heights that are linear over the surface: the truth is the part of `g` in it.
        let g = direction(random);
        let truth = g - normal * g.dot(normal);
        let gradient = surface_gradient(steps, [g.dot(a), g.dot(b)]);
        assert!(gradient.distance(truth) < 1e-4);
        for uv in [
            [Vec2::X, Vec2::Y],
            [Vec2::new(2.0, 0.5), Vec2::new(-0.7, 0.4)],
            [Vec2::new(0.1, 3.0), Vec2::new(1.0, 0.2)],
        ] {
            // Slopes by these coordinates, by the chain rule.
            let m = uv[0].perp_dot(uv[1]);
            let pu = (uv[1].y * a - uv[0].y * b) / m;
            let pv = (uv[0].x * b - uv[1].x * a) / m;
            let slopes = Vec2::new(g.dot(pu), g.dot(pv));
            let [by_u, by_v] = uv_gradients(steps, uv);
            let found = bumped_normal(normal, slopes.x * by_u + slopes.y * by_v);
            assert!(degrees(found, bumped_normal(normal, truth)) < 0.2);
        }
    }
}

/// Bump test 15, what of it is arithmetic: nothing known, nothing bumped.
#[test]
fn what_is_not_known_bumps_nothing() {
    let flat = Steps {
        normal: Vec3::Y,
        along: [Vec3::X, Vec3::X * 2.0],
    };
    let gone = Steps {
        normal: Vec3::Y,
        along: [Vec3::ZERO; 2],
    };
    for steps in [flat, gone] {
        assert_eq!(surface_gradient(steps, [1.0, 5.0]), Vec3::ZERO);
        assert_eq!(uv_gradients(steps, [Vec2::X, Vec2::Y]), [Vec3::ZERO; 2]);
    }
    assert_eq!(
        displaced_normal(gone, [Vec3::ZERO; 2], 1.0, [0.0; 2]),
        Vec3::Y
    );
    for bad in [f32::NAN, f32::INFINITY] {
        assert_eq!(bumped_normal(Vec3::Y, Vec3::splat(bad)), Vec3::Y);
    }
    // Large or small alike.
    for size in [1e-18_f32, 1.0, 1e18] {
        let steps = Steps {
            normal: Vec3::Z,
            along: [Vec3::X * size, Vec3::Y * size],
        };
        let found = bumped_normal(Vec3::Z, surface_gradient(steps, [size, 0.0]));
        assert!(
            degrees(found, Vec3::new(-1.0, 0.0, 1.0)) < 1e-3,
            "{size}: {found}"
        );
    }
}

//! Failure modes 20, 24, 26 and 29 of adaptive tessellation.

use bevy_fresco::displacement::{
    Direction, DisplacementSettings, Spacing, Stop, Tessellation, displace,
};
use bevy_fresco::height_map::{HeightMap, Kernel};
use glam::{Vec2, Vec3};

use crate::measure::error_of_plane;
use crate::meshes::{Mesh, cube, cylinder, map, noise, plane, sphere};
use crate::watertight::{assert_watertight, cases};

fn settings(tessellation: Tessellation) -> DisplacementSettings {
    DisplacementSettings {
        tessellation,
        ..DisplacementSettings::default()
    }
}

fn adaptive(tolerance: f32) -> DisplacementSettings {
    settings(Tessellation::Adaptive { tolerance })
}

#[test]
fn mode_20_nothing_is_torn_where_faces_are_bisected() {
    let map = noise(16, 1);
    for (what, mesh, tolerance) in cases() {
        for direction in [Direction::Smooth, Direction::FaceNormal] {
            let settings = DisplacementSettings {
                scale: 0.1,
                direction,
                ..adaptive(0.01)
            };
            let bases = [mesh.base()];
            let displaced = displace(&bases, &map, &settings, &()).unwrap();
            assert!(
                displaced.report.triangles > 100,
                "{what}: {:?}",
                displaced.report
            );
            assert_watertight(what, &bases, &displaced, tolerance);
        }
    }
}

/// A hill on a twentieth of the map, the rest flat.
fn hill() -> HeightMap {
    map([512; 2], |x, y| {
        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / 512.0;
        let r = at.distance(Vec2::new(0.6, 0.35)) / 0.126;
        if r < 1.0 {
            (1.0 - r * r).powi(2) * (0.6 + 0.4 * (40.0 * at.x).sin() * (40.0 * at.y).cos())
        } else {
            0.0
        }
    })
}

#[test]
fn mode_24_a_map_that_is_flat_but_for_a_twentieth_takes_few_triangles() {
    let map = hill();
    let flat = map.heights().iter().filter(|&&h| h == 0.0).count();
    assert!(flat as f32 > 0.945 * map.heights().len() as f32);
    for spacing in [4.0, 2.0, 1.0] {
        let uniform = settings(Tessellation::Uniform(Spacing::Texels(spacing)));
        let even = displace(&[plane(1.0).base()], &map, &uniform, &()).unwrap();
        let error = error_of_plane(&even, &map, &uniform, 1024);
        let adaptive = adaptive(error);
        let adapted = displace(&[plane(1.0).base()], &map, &adaptive, &()).unwrap();
        let reached = error_of_plane(&adapted, &map, &adaptive, 1024);
        let share = adapted.report.triangles as f64 / even.report.triangles as f64;
        assert_eq!(adapted.report.stop, Stop::Reached);
        assert!(reached <= 1.02 * error, "{reached} of {error}");
        assert!(share <= 0.15, "{share}");
    }
}

/// Two texels of a million in two triangles.
#[test]
fn mode_24_a_spike_in_a_large_flat_face_is_found() {
    for (x0, y0) in [(700, 333), (0, 0), (1023, 512), (511, 511)] {
        for kernel in [Kernel::Bilinear, Kernel::CatmullRom, Kernel::BSpline] {
            let map = map([1024; 2], |x, y| {
                if y == y0 && (x == x0 || x == (x0 + 1) % 1024) {
                    1.0
                } else {
                    0.0
                }
            });
            let settings = DisplacementSettings {
                kernel,
                scale: 0.05,
                ..adaptive(0.002)
            };
            let displaced = displace(&[plane(1.0).base()], &map, &settings, &()).unwrap();
            let highest = displaced.report.bounds.max.z;
            // A B-spline passes below single texels.
            let peak = if kernel == Kernel::BSpline {
                0.02
            } else {
                0.045
            };
            assert!(highest > peak, "{kernel:?} at {x0} {y0}: {highest}");
            assert!(displaced.report.triangles < 3000, "{:?}", displaced.report);
            assert_watertight("spike", &[plane(1.0).base()], &displaced, 0.0);
        }
    }
}

#[test]
fn what_is_flat_or_a_slope_is_left_alone() {
    let ramp = HeightMap::new(
        [256; 2],
        (0..256 * 256).map(|i| (i % 256) as f32 / 256.0).collect(),
        [bevy_fresco::height_map::Wrap::Clamp; 2],
    )
    .unwrap();
    let grey = map([256; 2], |_, _| 0.7);
    for mesh in [plane(1.0), cube(), sphere(12, 6)] {
        let displaced = displace(&[mesh.base()], &grey, &adaptive(1e-4), &()).unwrap();
        assert_eq!(displaced.report.triangles as usize, mesh.triangles.len());
    }
    let displaced = displace(&[plane(1.0).base()], &ramp, &adaptive(1e-3), &()).unwrap();
    // Only where it goes on level beyond its outer texels.
    assert!(displaced.report.triangles < 20, "{:?}", displaced.report);
}

/// The error that is reported is the one that is there.
#[test]
fn reported_errors_are_true() {
    let map = map([128; 2], |x, y| {
        let [x, y] = [x, y].map(|k| std::f32::consts::TAU * (k as f32 + 0.5) / 128.0);
        0.5 + 0.25 * (3.0 * x).sin() + 0.25 * (2.0 * x + 5.0 * y).cos()
    });
    for tolerance in [0.01, 0.003, 0.001] {
        let settings = DisplacementSettings {
            scale: 0.1,
            ..adaptive(tolerance)
        };
        let displaced = displace(&[plane(1.0).base()], &map, &settings, &()).unwrap();
        let found = displaced.report.error.unwrap();
        let there = error_of_plane(&displaced, &map, &settings, 700);
        assert_eq!(displaced.report.stop, Stop::Reached);
        assert!(
            found <= tolerance && there <= 1.05 * tolerance,
            "{found} {there} {tolerance}"
        );
        assert!(
            there > 0.3 * tolerance,
            "{there} of {tolerance}: too many triangles"
        );
    }
}

/// Longest-edge bisection leaves no angle below half of the smallest on the base.
#[test]
fn mode_26_pieces_do_not_get_thin() {
    let angles = |positions: &[Vec3], triangles: &[[u32; 3]]| {
        let of = |t: &[u32; 3]| {
            let p = t.map(|v| positions[v as usize]);
            let angle = |i: usize| (p[(i + 1) % 3] - p[i]).angle_between(p[(i + 2) % 3] - p[i]);
            angle(0).min(angle(1)).min(angle(2))
        };
        triangles.iter().map(of).fold(f32::INFINITY, f32::min)
    };
    for mesh in [plane(1.0), cube(), sphere(10, 5), cylinder(7, 2, false)] {
        let settings = DisplacementSettings {
            scale: 0.1,
            ..adaptive(0.004)
        };
        let displaced = displace(&[mesh.base()], &hill(), &settings, &()).unwrap();
        let part = &displaced.parts[0];
        let on_base = part.mesh.positions(&mesh.positions, &mesh.triangles);
        let (before, after) = (
            angles(&mesh.positions, &mesh.triangles),
            angles(&on_base, &part.mesh.triangles),
        );
        assert!(after > 0.49 * before, "{after} of {before}");
    }
}

#[test]
fn mode_29_room_is_kept_to_and_the_worst_comes_first() {
    let map = hill();
    let mesh = plane(1.0);
    let of =
        |settings: DisplacementSettings| displace(&[mesh.base()], &map, &settings, &()).unwrap();
    let free = of(adaptive(2e-4));
    let mut before = f32::INFINITY;
    for share in [0.1, 0.3, 0.6] {
        let most = (share * free.report.triangles as f32) as u32;
        let few = of(DisplacementSettings {
            max_triangles: most,
            ..adaptive(2e-4)
        });
        assert_eq!(few.report.stop, Stop::Triangles);
        let count = few.report.triangles as u32;
        assert!(count <= most && count + 40 > most, "{count} of {most}");
        let error = few.report.error.unwrap();
        assert!(error < before, "{error} after {before}");
        before = error;
        assert_watertight("few triangles", &[mesh.base()], &few, 0.0);
    }
    let small = of(DisplacementSettings {
        max_bytes: 64 << 10,
        ..adaptive(2e-4)
    });
    assert_eq!(small.report.stop, Stop::Memory);
    assert!(small.report.bytes <= 64 << 10 && small.report.bytes > 60 << 10);
    assert_watertight("little memory", &[mesh.base()], &small, 0.0);
}

/// A map of 4096² texels, waves of 32 all over, in 8 MiB.
#[test]
fn mode_29_a_large_rough_map_fits_its_budget() {
    let wave = |k: u32| (std::f32::consts::TAU * k as f32 / 32.0).sin();
    let map = map([4096; 2], |x, y| 0.5 + 0.25 * (wave(x) + wave(y)));
    let settings = DisplacementSettings {
        max_bytes: 8 << 20,
        scale: 0.01,
        ..adaptive(1e-6)
    };
    let displaced = displace(&[plane(1.0).base()], &map, &settings, &()).unwrap();
    let report = &displaced.report;
    assert_eq!(report.stop, Stop::Memory);
    assert!(
        report.bytes <= 8 << 20 && report.bytes > 7 << 20,
        "{report:?}"
    );
    let error = report.error.unwrap();
    assert!(error > 1e-6 && error < 0.005, "{error}");
}

/// Charts that say otherwise at their seam do not make it finer for ever.
#[test]
fn seams_that_do_not_fit_come_to_an_end() {
    let mut mesh: Mesh = cube();
    for (i, uv) in mesh.uvs.iter_mut().enumerate() {
        *uv = *uv * 0.8 + Vec2::splat(0.13 * (i / 4) as f32);
    }
    let map = map([64; 2], |x, y| {
        let [x, y] = [x, y].map(|k| std::f32::consts::TAU * (k as f32 + 0.5) / 64.0);
        0.5 + 0.3 * (2.0 * x).sin() * (3.0 * y).cos()
    });
    let settings = DisplacementSettings {
        scale: 0.2,
        ..adaptive(0.005)
    };
    let displaced = displace(&[mesh.base()], &map, &settings, &()).unwrap();
    assert_watertight("ill-fitting seams", &[mesh.base()], &displaced, 0.0);
    assert!(displaced.report.seam_gap > 0.02);
    assert_eq!(displaced.report.stop, Stop::Reached);
    assert!(displaced.report.triangles < 100_000);
}

//! Failure modes 23, 25, 28 and 30: positions, normals, bounds and levels against what is known.

use std::f64::consts::{PI, TAU};

use bevy_fresco::displacement::{
    Direction, Displaced, DisplacementSettings, Spacing, Tessellation, displace,
};
use bevy_fresco::height_map::{HeightMap, Wrap};
use glam::{DVec2, DVec3, Vec3, dvec3, vec2, vec3};

use crate::meshes::{Mesh, cube, map, noise, plane, sphere};

/// Height of the waves, and how many there are around the equator.
const HIGH: f64 = 0.1;
const WAVES: f64 = 8.0;

/// Waves on the unit sphere that vanish at its poles.
fn waves(uv: DVec2) -> f64 {
    HIGH * (TAU * WAVES * uv.x).sin() * (PI * uv.y).sin().powi(2)
}

/// The waves as a map, 128 texels a period.
fn map_of_waves() -> HeightMap {
    let size = [1024, 512];
    let heights = (0..size[0] * size[1]).map(|i| {
        let texel = DVec2::new(f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5);
        waves(texel / DVec2::new(1024.0, 512.0)) as f32
    });
    HeightMap::new(size, heights.collect(), [Wrap::Repeat, Wrap::Clamp]).unwrap()
}

/// The place on the unit sphere, raised.
fn raised(uv: DVec2) -> DVec3 {
    let ((sin, cos), (across, along)) = ((PI * uv.y).sin_cos(), (TAU * uv.x).sin_cos());
    dvec3(sin * along, cos, -sin * across) * (1.0 + waves(uv))
}

fn uv_of(p: DVec3) -> DVec2 {
    let u = (-p.z).atan2(p.x) / TAU;
    DVec2::new(u.rem_euclid(1.0), (p.y / p.length()).acos() / PI)
}

fn normal_at(uv: DVec2) -> DVec3 {
    const STEP: f64 = 1e-5;
    let slope = |d: DVec2| (raised(uv + d) - raised(uv - d)) / (2.0 * STEP);
    let n = slope(DVec2::X * STEP).cross(slope(DVec2::Y * STEP));
    // u runs to the east and v down: inwards.
    -n.normalize()
}

fn settings(tessellation: Tessellation) -> DisplacementSettings {
    DisplacementSettings {
        scale: 1.0,
        tessellation,
        ..DisplacementSettings::default()
    }
}

/// The largest distance from points of the triangles to the raised sphere, along its radius.
fn distance_to_waves(displaced: &Displaced) -> f64 {
    const WEIGHTS: [[f64; 3]; 6] = [
        [0.33, 0.34, 0.33],
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.5],
        [0.5, 0.0, 0.5],
        [0.7, 0.2, 0.1],
        [0.1, 0.2, 0.7],
    ];
    let part = &displaced.parts[0];
    let of_triangle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| part.positions[v as usize].as_dvec3());
        let distance = |w: [f64; 3]| {
            let p = a * w[0] + b * w[1] + c * w[2];
            (p.length() - 1.0 - waves(uv_of(p))).abs()
        };
        WEIGHTS.into_iter().map(distance).fold(0.0, f64::max)
    };
    part.mesh
        .triangles
        .iter()
        .map(of_triangle)
        .fold(0.0, f64::max)
}

#[test]
fn mode_23_a_raised_sphere_converges_with_the_square_of_the_spacing() {
    let map = map_of_waves();
    let error = |columns: u32| {
        let spacing = std::f32::consts::PI / columns as f32;
        let settings = settings(Tessellation::Uniform(Spacing::Metres(spacing)));
        let mesh = sphere(columns, columns / 2);
        distance_to_waves(&displace(&[mesh.base()], &map, &settings, &()).unwrap())
    };
    let errors = [32, 64, 128, 256].map(error);
    for pair in errors[1..].windows(2) {
        let slope = (pair[0] / pair[1]).log2();
        assert!((slope - 2.0).abs() < 0.2, "{slope} of {errors:?}");
    }
    assert!(errors[3] < 0.02 * HIGH, "{errors:?}");
}

#[test]
fn mode_25_normals_are_those_of_the_raised_surface() {
    let map = map_of_waves();
    // Eight vertices a period, 22° and less between the base's facets.
    let mesh = sphere(64, 32);
    let displaced = displace(&[mesh.base()], &map, &settings(Tessellation::Base), &()).unwrap();
    let part = &displaced.parts[0];
    let mut squares = 0.0;
    let mut count = 0.0;
    for (p, n) in part.positions.iter().zip(&part.normals) {
        let uv = uv_of(p.as_dvec3());
        // What is a degree from a pole has no texture coordinates that differ.
        if (0.01..0.99).contains(&uv.y) {
            let angle = n.as_dvec3().angle_between(normal_at(uv)).to_degrees();
            squares += angle * angle;
            count += 1.0;
        }
    }
    let rms = f64::sqrt(squares / count);
    assert!(rms < 0.5, "{rms}°");
    // The base's own normals are no answer.
    let flat = part.mesh.interpolate(&mesh.triangles, |corners, w| {
        let [a, b, c] = corners.map(|v| mesh.normals[v as usize]);
        a * w.x + b * w.y + c * w.z
    });
    let off = flat.iter().zip(&part.normals);
    let off = off
        .map(|(a, b)| a.angle_between(*b).to_degrees())
        .fold(0.0, f32::max);
    assert!(off > 20.0, "{off}°");
}

#[test]
fn mode_25_there_is_no_seam_in_the_normals() {
    // Relief that does not fit at the seam of the sphere, to make it hard.
    let map = noise(64, 5);
    for mesh in [sphere(24, 12), crate::meshes::cylinder(16, 3, false)] {
        let uniform = settings(Tessellation::Uniform(Spacing::Texels(1.0)));
        let settings = DisplacementSettings {
            scale: 0.05,
            ..uniform
        };
        let displaced = displace(&[mesh.base()], &map, &settings, &()).unwrap();
        let part = &displaced.parts[0];
        let mut at: std::collections::HashMap<[u32; 3], Vec3> = Default::default();
        let mut shared = 0;
        for (p, n) in part.positions.iter().zip(&part.normals) {
            let place = (*p + Vec3::ZERO).to_array().map(f32::to_bits);
            let before = *at.entry(place).or_insert(*n);
            shared += u32::from(before != *n || shared == 0);
            let jump = n.angle_between(before).to_degrees();
            assert!(jump < 0.1, "{jump}° at {p}");
        }
        assert!(at.len() < part.positions.len(), "nothing lies on a seam");
    }
}

#[test]
fn mode_25_hard_edges_stay_hard_and_soft_ones_soft() {
    let jump = |crease_angle: f32| {
        let settings = DisplacementSettings {
            scale: 0.05,
            crease_angle,
            tessellation: Tessellation::Uniform(Spacing::Texels(1.0)),
            ..DisplacementSettings::default()
        };
        let flat = map([16; 2], |_, _| 1.0);
        let displaced = displace(&[cube().base()], &flat, &settings, &()).unwrap();
        let part = &displaced.parts[0];
        let mut most = 0.0_f32;
        for (i, p) in part.positions.iter().enumerate() {
            for (j, q) in part.positions.iter().enumerate().take(i) {
                if p == q {
                    most = most.max(part.normals[i].angle_between(part.normals[j]));
                }
            }
        }
        most.to_degrees()
    };
    assert!((jump(0.5) - 90.0).abs() < 0.1, "{}", jump(0.5));
    assert!(jump(1.7) < 0.1, "{}", jump(1.7));
}

/// A box raised by one grey along its faces is a larger box, and keeps its normals.
#[test]
fn faces_of_a_box_move_out_by_the_height() {
    let settings = DisplacementSettings {
        scale: 0.25,
        direction: Direction::FaceNormal,
        tessellation: Tessellation::Uniform(Spacing::Metres(0.3)),
        ..DisplacementSettings::default()
    };
    let displaced = displace(&[cube().base()], &map([4; 2], |_, _| 1.0), &settings, &()).unwrap();
    let part = &displaced.parts[0];
    for (p, n) in part.positions.iter().zip(&part.normals) {
        assert!((p.dot(*n) - 1.25).abs() < 1e-5, "{p} {n}");
        assert!((n.abs().max_element() - 1.0).abs() < 1e-5);
    }
    assert!((part.bounds.max - Vec3::splat(1.25)).length() < 1e-5);
    assert!((part.bounds.min + Vec3::splat(1.25)).length() < 1e-5);
}

#[test]
fn mode_28_bounds_hold_everything_and_no_more() {
    for (mesh, seed) in [(cube(), 1), (sphere(12, 6), 2), (plane(3.0), 3)] {
        let settings = settings(Tessellation::Uniform(Spacing::Texels(1.0)));
        let displaced = displace(&[mesh.base()], &noise(32, seed), &settings, &()).unwrap();
        let positions = &displaced.parts[0].positions;
        let [min, max] = [displaced.report.bounds.min, displaced.report.bounds.max];
        assert_eq!(displaced.parts[0].bounds, displaced.report.bounds);
        assert!(
            positions
                .iter()
                .all(|p| p.cmpge(min).all() && p.cmple(max).all())
        );
        for axis in 0..3 {
            assert!(positions.iter().any(|p| p[axis] == min[axis]));
            assert!(positions.iter().any(|p| p[axis] == max[axis]));
        }
    }
}

#[test]
fn mode_30_the_mid_level_stays_where_it_is() {
    let grey = map([8; 2], |_, _| 0.75);
    for (mid_level, height) in [(0.0, 0.3), (0.5, 0.1), (0.75, 0.0), (1.0, -0.1)] {
        let settings = DisplacementSettings {
            scale: 0.4,
            mid_level,
            tessellation: Tessellation::Uniform(Spacing::Texels(1.0)),
            ..DisplacementSettings::default()
        };
        let displaced = displace(&[plane(1.0).base()], &grey, &settings, &()).unwrap();
        for p in &displaced.parts[0].positions {
            assert!((p.z - height).abs() < 1e-6, "{p}");
        }
    }
}

/// What repeats is the same at u = 0 and u = 1; what is held is the border's.
#[test]
fn mode_30_maps_go_on_beyond_their_border() {
    let rough = noise(16, 9);
    let clamped = HeightMap::new([16; 2], rough.heights().to_vec(), [Wrap::Clamp; 2]).unwrap();
    let settings = settings(Tessellation::Uniform(Spacing::Texels(1.0)));
    let mut twice = plane(1.0);
    twice.uvs.iter_mut().for_each(|uv| *uv *= 2.0);
    let heights = |map: &HeightMap, mesh: &Mesh| {
        let displaced = displace(&[mesh.base()], map, &settings, &()).unwrap();
        let part = &displaced.parts[0];
        let key = |p: &Vec3| ((p.x * 32.0).round() as i32, (p.y * 32.0).round() as i32);
        let of = |p: &Vec3| (key(p), p.z);
        part.positions
            .iter()
            .map(of)
            .collect::<std::collections::HashMap<_, _>>()
    };
    let tiled = heights(&rough, &twice);
    for (&(x, y), z) in &tiled {
        assert!((tiled[&(x % 16, y % 16)] - z).abs() < 1e-6, "{x} {y}");
    }
    let held = heights(&clamped, &twice);
    for (&(x, y), z) in &held {
        // v runs down: the map lies in the upper left quarter. Half a texel beyond its border heights are
        // on their way to the border's.
        let inside = (x.min(17), y.max(15));
        assert!((held[&inside] - z).abs() < 1e-6, "{x} {y}");
    }
}

/// A slope shows in the normals the right way round, mirrored or not.
#[test]
fn relief_stands_out_and_is_not_dug_in() {
    let ramp = HeightMap::new(
        [64, 1],
        (0..64).map(|x| (x as f32 + 0.5) / 64.0).collect(),
        [Wrap::Clamp; 2],
    );
    let ramp = ramp.unwrap();
    for flip in [false, true] {
        let mut mesh = plane(1.0);
        if flip {
            mesh.uvs
                .iter_mut()
                .for_each(|uv| *uv = vec2(1.0 - uv.x, uv.y));
        }
        let settings = settings(Tessellation::Uniform(Spacing::Texels(1.0)));
        let displaced = displace(&[mesh.base()], &ramp, &settings, &()).unwrap();
        let part = &displaced.parts[0];
        let rise = if flip { -1.0 } else { 1.0 };
        for (p, n) in part.positions.iter().zip(&part.normals) {
            if (0.1..0.9).contains(&p.x) {
                let truth = vec3(-rise, 0.0, 1.0).normalize();
                assert!(n.angle_between(truth).to_degrees() < 0.1, "{p}: {n}");
                let height = if flip { 1.0 - p.x } else { p.x };
                assert!((p.z - height).abs() < 1e-5);
            }
        }
    }
}

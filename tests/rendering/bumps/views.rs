//! The same relief from near and far, in more and fewer pixels, large and small.

use std::f32::consts::TAU;

use bevy::prelude::*;
use bevy_fresco::height_map::Wrap;
use bevy_fresco::plugin::bump::{BumpFilter, BumpHeight};

use super::{bump, degrees, error, normal, ray, relief, sheet, show};
use crate::scenery::grid;
use crate::stage::on_stage;

/// Mean slope of what is seen of a grid at `distance`, its waves measured in `height`.
fn mean_slope(distance: f32, size: u32, scale: Vec3, height: BumpHeight) -> f32 {
    let picture = on_stage(move |stage| {
        stage.show_normals(true);
        stage.size = size;
        stage.shoot(
            |_| (),
            |world| {
                // One wave, so that it is many pixels long from afar too.
                let map = relief([256; 2], Wrap::Repeat, |u, v| {
                    0.6 * (TAU * u).sin() + 0.4 * (TAU * v).cos()
                });
                let waves = bump(world, map, height);
                let at = Transform::from_xyz(0.0, 0.0, 3.0 - distance).with_scale(scale);
                show(world, grid(), default(), Some(waves), at);
            },
        )
    });
    // Whole waves, for a mean that does not depend on which part is seen.
    let half = scale.truncate() - 0.02;
    let (mut sum, mut count) = (0.0_f64, 0.0);
    for pixel in 0..picture.pixels.len() {
        let at = ray(&picture, pixel, distance / 3.0, distance).xy();
        if at.abs().cmplt(half).all() {
            let n = normal(&picture, pixel);
            sum += f64::from(n.xy().length() / n.z);
            count += 1.0;
        }
    }
    (sum / count) as f32
}

/// Bump test 9: three distances, two resolutions: the same slopes.
#[test]
fn slopes_depend_on_no_view() {
    let truth = mean_slope(3.0, 256, Vec3::ONE, BumpHeight::World(0.15));
    for distance in [3.0, 4.5, 6.0] {
        for size in [64, 128] {
            let found = mean_slope(distance, size, Vec3::ONE, BumpHeight::World(0.15));
            println!(
                "{distance} m, {size} pixels: {:+.2} %",
                100.0 * (found / truth - 1.0)
            );
            assert!((found / truth - 1.0).abs() < 0.01);
        }
    }
}

/// Bump test 9, scales: heights of the mesh and of the map grow with the object, those of the world do not.
#[test]
fn heights_have_the_unit_they_are_given_in() {
    let slope = |scale: f32, height| mean_slope(3.0 * scale, 128, Vec3::splat(scale), height);
    let truth = slope(1.0, BumpHeight::World(0.15));
    for scale in [0.5, 1.0, 2.0] {
        // The map is 2 m wide at a scale of 1.
        for (name, height, expected) in [
            ("mesh", BumpHeight::Mesh(0.15), truth),
            ("map", BumpHeight::Uv(0.075), truth),
            ("world", BumpHeight::World(0.15), truth / scale),
        ] {
            let found = slope(scale, height);
            println!("{name} × {scale}: {found:.4} for {expected:.4}");
            assert!((found / expected - 1.0).abs() < 0.01, "{name} × {scale}");
        }
    }
}

/// Heights of the mesh under an uneven scale, aslant to it: the relief is that of the mesh displaced and then
/// scaled.
#[test]
fn uneven_scales_scale_the_relief() {
    let turn = Quat::from_euler(EulerRot::XYZ, 0.6, 0.5, 0.2);
    let scale = Vec3::new(1.4, 0.6, 0.9);
    // A plane that lies aslant in its mesh, and a map that rises evenly along u and v.
    let slopes = Vec2::new(0.3, -0.2);
    let picture = on_stage(move |stage| {
        stage.show_normals(true);
        stage.shoot(
            |_| (),
            |world| {
                let map = relief([64; 2], Wrap::Clamp, |u, v| slopes.dot(Vec2::new(u, v)));
                let rise = bump(world, map, BumpHeight::Mesh(1.0));
                let mesh = sheet(4, |p| {
                    let at = turn * (p - 0.5).extend(0.0);
                    // Away from the border of the map.
                    (at, turn * Vec3::Z, 0.25 + 0.5 * p)
                });
                let at = Transform::from_scale(scale);
                show(world, mesh, super::seen_from_everywhere(), Some(rise), at);
            },
        )
    });
    // The displaced plane's tangents, scaled. Half of the map lies on 1 m.
    let along = [Vec3::X, Vec3::Y].into_iter().zip(slopes.to_array());
    let [a, b]: [Vec3; 2] = along
        .map(|(along, slope)| scale * (turn * (along + Vec3::Z * 0.5 * slope)))
        .collect::<Vec<_>>()
        .try_into()
        .unwrap();
    let truth = a.cross(b).normalize();
    let seen = |i: usize| picture.pixels[i].iter().any(|v| *v != 0.0);
    let (most, _) = error(&picture, |i| seen(i).then_some(truth));
    println!("{most:.3}°");
    assert!(most < 0.1, "{most}°");
}

/// Bump test 8: 32 texels a wave at 64 pixels a texel, the steepest slope 45°.
#[test]
fn magnified_maps_are_smooth() {
    const TEXELS: f32 = 32.0;
    // Each row of pixels shows one texel, half a texel further than the row above: 2 m are a texel.
    let height = 2.0 * TEXELS / TAU;
    let rows = |row: u32, size: u32| 0.5 * row as f32 * 64.0 / size as f32;
    for filter in [
        BumpFilter::Linear,
        BumpFilter::CatmullRom,
        BumpFilter::BSpline,
    ] {
        let picture = on_stage(move |stage| {
            stage.show_normals(true);
            stage.shoot(
                |_| (),
                |world| {
                    let map = relief([TEXELS as u32, 4], Wrap::Repeat, |u, _| (TAU * u).sin());
                    let mut wave = bump(world, map, BumpHeight::World(height));
                    wave.filter = filter;
                    for row in 0..64 {
                        let first = rows(row, 64);
                        let strip = sheet(1, |p| {
                            let y = 1.0 - 2.0 * (row as f32 + p.y) / 64.0;
                            let u = (first + p.x) / TEXELS;
                            let at = Vec3::new(2.0 * p.x - 1.0, y, 0.0);
                            (at, Vec3::Z, Vec2::new(u, 0.3 + p.y / 256.0))
                        });
                        show(world, strip, default(), Some(wave.clone()), default());
                    }
                },
            )
        });
        let slope_at = |u: f32| (TAU * u / TEXELS).cos();
        let place = |i: usize| rows(i as u32 / 64, 64) + ((i % 64) as f32 + 0.5) / 64.0;
        let (most, mean) = error(&picture, |i| {
            Some(Vec3::new(-slope_at(place(i)), 0.0, 1.0).normalize())
        });
        // Facets would be steps of degrees between pixels where the truth turns by 0.2° a pixel at most.
        let steps = (1..picture.pixels.len()).filter(|i| i % 64 != 0);
        let step = steps
            .map(|i| degrees(normal(&picture, i), normal(&picture, i - 1)))
            .fold(0.0, f32::max);
        // No facets: second differences over an eighth of a texel, so that the rounding of pixels is small beside
        // them. The truth's are 0.035° at most; heights that are linear between texels would have 11°, as slopes
        // jump there. Those of Catmull–Rom bend where texels meet, the B-spline's do not.
        let second = |i: usize| {
            normal(&picture, i - 8) - 2.0 * normal(&picture, i) + normal(&picture, i + 8)
        };
        let kink = (8..picture.pixels.len() - 8)
            .filter(|i| (8..56).contains(&(i % 64)))
            .map(|i| second(i).length().to_degrees())
            .fold(0.0, f32::max);
        println!(
            "{filter:?}: {mean:.3}° RMS, {most:.3}° at most, steps of {step:.3}°, kinks of {kink:.3}°"
        );
        let [most_mean, most_kink] = match filter {
            BumpFilter::Linear => [0.3, 0.3],
            BumpFilter::CatmullRom => [0.2, 0.3],
            BumpFilter::BSpline => [0.2, 0.1],
        };
        assert!(mean < most_mean, "{mean}°");
        assert!(step < 0.3, "{step}°");
        assert!(kink < most_kink, "{kink}°");
    }
}

use std::f32::consts::TAU;

use super::{HeightMap, Kernel, Wrap};
use glam::Vec2;

fn map(size: [u32; 2], height: impl Fn(f32, f32) -> f32) -> HeightMap {
    let [w, h] = size;
    let heights = (0..w * h).map(|i| {
        let (x, y) = ((i % w) as f32 + 0.5, (i / w) as f32 + 0.5);
        height(x / w as f32, y / h as f32)
    });
    HeightMap::new(size, heights.collect(), [Wrap::Repeat; 2]).unwrap()
}

/// Error of the slope's angle in degrees, root mean square and at most, on a sine of `n` texels.
fn sine_errors(kernel: Kernel, n: u32) -> [f64; 2] {
    let sine = map([n, 1], |u, _| (TAU * u).sin() / TAU);
    let (mut squares, mut most) = (0.0, 0.0_f64);
    let points = 4096;
    for i in 0..points {
        let u = (i as f32 + 0.5) / points as f32;
        let found = f64::from(sine.at(Vec2::new(u, 0.5), kernel).slopes.x).atan();
        let off = (found - f64::from((TAU * u).cos()).atan())
            .to_degrees()
            .abs();
        squares += off * off / f64::from(points);
        most = most.max(off);
    }
    [squares.sqrt(), most]
}

/// The table in [`Kernel`]'s documentation.
#[test]
fn slopes_of_a_sine_are_as_far_off_as_the_table_says() {
    let table = [
        (Kernel::Bilinear, [[7.5, 20.6], [3.8, 10.8], [1.9, 5.5]]),
        (Kernel::Forward, [[13.0, 21.1], [6.7, 11.1], [3.4, 5.6]]),
        (Kernel::Central, [[3.7, 5.3], [0.94, 1.3], [0.24, 0.32]]),
        (
            Kernel::HalfCentral,
            [[1.9, 3.0], [0.49, 0.74], [0.12, 0.18]],
        ),
        (Kernel::BSpline, [[2.5, 3.0], [0.62, 0.74], [0.15, 0.18]]),
        (Kernel::CatmullRom, [[1.3, 3.0], [0.29, 0.74], [0.07, 0.18]]),
    ];
    for (kernel, rows) in table {
        for (n, told) in [8, 16, 32].into_iter().zip(rows) {
            for (found, told) in sine_errors(kernel, n).into_iter().zip(told) {
                // Figures of two digits.
                let close = (found - told).abs() <= 0.05 * told + 0.005;
                assert!(close, "{kernel:?}, {n} texels: {found}, not {told}");
            }
        }
    }
}

#[test]
fn planes_are_planes() {
    // Away from the border, where the ramp starts again.
    let ramp = map([32, 16], |u, v| 0.25 + 2.0 * u - 3.0 * v);
    for kernel in Kernel::ALL {
        for uv in [
            Vec2::new(0.31, 0.4),
            Vec2::new(0.5, 0.5),
            Vec2::new(0.7, 0.62),
        ] {
            let found = ramp.at(uv, kernel);
            let height = 0.25 + 2.0 * uv.x - 3.0 * uv.y;
            assert!((found.height - height).abs() < 1e-5, "{kernel:?} {found:?}");
            assert!(found.slopes.distance(Vec2::new(2.0, -3.0)) < 1e-4);
        }
    }
}

/// Slopes of the smooth kernels are those of their own heights, by differences in f64.
#[test]
fn slopes_are_derivatives() {
    let bumpy = map([8, 8], |u, v| {
        (TAU * (u + 2.0 * v)).sin() + (9.0 * u * v).cos()
    });
    for kernel in [Kernel::Bilinear, Kernel::BSpline, Kernel::CatmullRom] {
        for i in 0..200 {
            let uv = Vec2::new((i as f32 * 0.618).fract(), (i as f32 * 0.414).fract());
            let e = 1e-3;
            let at = |off: Vec2| bumpy.at(uv + off, kernel).height;
            let by_x = (at(Vec2::X * e) - at(Vec2::X * -e)) / (2.0 * e);
            let by_y = (at(Vec2::Y * e) - at(Vec2::Y * -e)) / (2.0 * e);
            let found = bumpy.at(uv, kernel).slopes;
            // Linear pieces have corners, which differences cut.
            let cut = (uv * 8.0 - 0.5 - (uv * 8.0 - 0.5).round())
                .abs()
                .min_element()
                < 0.01;
            let close = found.distance(Vec2::new(by_x, by_y)) < 0.05;
            assert!(
                close || (kernel == Kernel::Bilinear && cut),
                "{kernel:?} at {uv}"
            );
        }
    }
}

#[test]
fn a_tiled_map_has_no_seam_and_one_texel_no_slope() {
    let sine = map([16, 16], |u, v| (TAU * u).sin() * (TAU * v).cos());
    for kernel in Kernel::ALL {
        let [a, b] = [0.0, 1.0].map(|u| sine.at(Vec2::new(u, 0.3), kernel));
        assert!((a.height - b.height).abs() < 1e-6);
        assert!(a.slopes.distance(b.slopes) < 1e-4);
        let flat = map([1, 1], |_, _| 0.7).at(Vec2::new(0.3, 12.9), kernel);
        assert!((flat.height - 0.7).abs() < 1e-6 && flat.slopes.length() < 1e-6);
    }
}

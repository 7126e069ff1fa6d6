use glam::Vec2;

use super::HeightMap;

/// How heights and slopes are found between texels.
///
/// Error of the slope's angle on a sine of 45° at its steepest, root mean square and at most, by texels
/// a period (`cargo test --no-default-features height_map`):
///
/// | kernel | taps | 8 | 16 | 32 |
/// |---|---|---|---|---|
/// | [`Bilinear`](Self::Bilinear) | 4 | 7.5° / 20.6° | 3.8° / 10.8° | 1.9° / 5.5° |
/// | [`Forward`](Self::Forward) | 9 | 13.0° / 21.1° | 6.7° / 11.1° | 3.4° / 5.6° |
/// | [`Central`](Self::Central) | 12 | 3.7° / 5.3° | 0.94° / 1.3° | 0.24° / 0.32° |
/// | [`HalfCentral`](Self::HalfCentral) | 9 | 1.9° / 3.0° | 0.49° / 0.74° | 0.12° / 0.18° |
/// | [`BSpline`](Self::BSpline) | 16 | 2.5° / 3.0° | 0.62° / 0.74° | 0.15° / 0.18° |
/// | [`CatmullRom`](Self::CatmullRom) | 16 | 1.3° / 3.0° | 0.29° / 0.74° | 0.07° / 0.18° |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Linear between texels, and its slope: what a graphics card's filter does. Shows facets when
    /// magnified.
    Bilinear,
    /// Differences to one texel ahead, of heights linear between texels. Moves relief by half a texel.
    Forward,
    /// Differences between a texel ahead and a texel behind.
    Central,
    /// Differences between half a texel ahead and half a texel behind: Blinn's, as narrow as texels allow.
    HalfCentral,
    /// Cubic B-spline: twice smooth, passes by the texels and so takes steps of 8-bit maps off. Fine
    /// relief gets lower.
    BSpline,
    /// Cubic through the texels (E. Catmull and R. Rom, "A class of local interpolating splines", 1974):
    /// the most faithful, and the steps of 8-bit maps with it.
    #[default]
    CatmullRom,
}

/// A map at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relief {
    /// Height.
    pub height: f32,
    /// `F_u` and `F_v`: height by texture coordinate, the whole map being 1 wide and 1 high.
    pub slopes: Vec2,
}

/// Weights of four neighbouring texels for the height, and for its slope by texel.
type Weights = [[f32; 4]; 2];

impl Kernel {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Bilinear,
        Self::Forward,
        Self::Central,
        Self::HalfCentral,
        Self::BSpline,
        Self::CatmullRom,
    ];

    /// Weights of the texels −1, 0, 1, 2 at `t` (0..1) from texel 0 towards 1.
    ///
    /// Differences of what is linear between texels are as linear in texels as the others:
    ///
    /// ```text
    ///   ε = ½, t < ½:   F(t + ½) − F(t − ½) = (1 − s) f₀ + s f₁ − (1 − s) f₋₁ − s f₀     s = t + ½
    /// ```
    fn weights(self, t: f32) -> Weights {
        let linear = [0.0, 1.0 - t, t, 0.0];
        match self {
            Self::Bilinear => [linear, [0.0, -1.0, 1.0, 0.0]],
            Self::Forward => [linear, [0.0, t - 1.0, 1.0 - 2.0 * t, t]],
            Self::Central => [linear, [t - 1.0, -t, 1.0 - t, t].map(|w| 0.5 * w)],
            Self::HalfCentral if t < 0.5 => {
                let s = t + 0.5;
                [linear, [s - 1.0, 1.0 - 2.0 * s, s, 0.0]]
            }
            Self::HalfCentral => {
                let s = t - 0.5;
                [linear, [0.0, s - 1.0, 1.0 - 2.0 * s, s]]
            }
            Self::BSpline => {
                let (r, t2, t3) = (1.0 - t, t * t, t * t * t);
                let height = [
                    r * r * r,
                    3.0 * t3 - 6.0 * t2 + 4.0,
                    -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0,
                    t3,
                ];
                let slope = [-r * r, 3.0 * t2 - 4.0 * t, -3.0 * t2 + 2.0 * t + 1.0, t2];
                [height.map(|w| w / 6.0), slope.map(|w| 0.5 * w)]
            }
            Self::CatmullRom => {
                let (t2, t3) = (t * t, t * t * t);
                let height = [
                    -t3 + 2.0 * t2 - t,
                    3.0 * t3 - 5.0 * t2 + 2.0,
                    -3.0 * t3 + 4.0 * t2 + t,
                    t3 - t2,
                ];
                let slope = [
                    -3.0 * t2 + 4.0 * t - 1.0,
                    9.0 * t2 - 10.0 * t,
                    -9.0 * t2 + 8.0 * t + 1.0,
                    3.0 * t2 - 2.0 * t,
                ];
                [height.map(|w| 0.5 * w), slope.map(|w| 0.5 * w)]
            }
        }
    }
}

impl HeightMap {
    /// Height and slopes at texture coordinates `uv`.
    pub fn at(&self, uv: Vec2, kernel: Kernel) -> Relief {
        let [width, height] = self.size().map(f64::from);
        // Coordinates of maps that repeat may be large: fractions in f64.
        let place = |share: f32, n: f64| {
            let texel = f64::from(share) * n - 0.5;
            (texel.floor() as i64, (texel - texel.floor()) as f32)
        };
        let ((x, s), (y, t)) = (place(uv.x, width), place(uv.y, height));
        let [across, across_slope] = kernel.weights(s);
        let [down, down_slope] = kernel.weights(t);
        let mut relief = Relief::default();
        for (j, row) in (-1..).zip(0..4) {
            let texels = [-1, 0, 1, 2].map(|i| self.texel(x + i, y + j));
            let sum =
                |weights: [f32; 4]| -> f32 { texels.iter().zip(weights).map(|(h, w)| h * w).sum() };
            relief.height += down[row] * sum(across);
            relief.slopes.x += down[row] * sum(across_slope);
            relief.slopes.y += down_slope[row] * sum(across);
        }
        relief.slopes *= Vec2::new(width as f32, height as f32);
        relief
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use super::*;
    use crate::height_map::Wrap;

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
}

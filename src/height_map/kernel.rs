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
    #[inline]
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
        let ((x, s), (y, t)) = (place(uv.x, width), place(uv.y, height));
        self.between([x, y], [s, t], kernel)
    }

    /// Height alone at texture coordinates `uv`: that of [`at`](Self::at), for less work.
    pub fn height(&self, uv: Vec2, kernel: Kernel) -> f32 {
        let [width, height] = self.size().map(f64::from);
        let ((x, s), (y, t)) = (place(uv.x, width), place(uv.y, height));
        let [across, down] = [kernel.weights(s)[0], kernel.weights(t)[0]];
        let [columns, rows] = [self.four(0, x), self.four(1, y)];
        let mut sum = 0.0;
        for (row, weight) in rows.into_iter().zip(down) {
            if weight != 0.0 {
                sum += weight * dot(self.row(row, columns), across);
            }
        }
        sum
    }

    /// Height and slopes at `[s, t]` (0..1) from the centre of texel `[x, y]` to that of the next.
    pub(super) fn between(&self, [x, y]: [i64; 2], [s, t]: [f32; 2], kernel: Kernel) -> Relief {
        let [across, across_slope] = kernel.weights(s);
        let [down, down_slope] = kernel.weights(t);
        let columns = self.four(0, x);
        let mut relief = Relief::default();
        for (i, row) in self.four(1, y).into_iter().enumerate() {
            let texels = self.row(row, columns);
            let height = dot(texels, across);
            relief.height += down[i] * height;
            relief.slopes.x += down[i] * dot(texels, across_slope);
            relief.slopes.y += down_slope[i] * height;
        }
        let [width, height] = self.size();
        relief.slopes *= Vec2::new(width as f32, height as f32);
        relief
    }

    /// Columns or rows −1, 0, 1, 2 from one on.
    #[inline]
    fn four(&self, axis: usize, i: i64) -> [usize; 4] {
        let n = i64::from(self.size()[axis]);
        if (1..n - 2).contains(&i) {
            let i = i as usize;
            return [i - 1, i, i + 1, i + 2];
        }
        [-1, 0, 1, 2].map(|step| self.inside(axis, i + step))
    }

    #[inline]
    fn row(&self, row: usize, columns: [usize; 4]) -> [f32; 4] {
        let width = self.size()[0] as usize;
        let row = &self.heights()[row * width..][..width];
        columns.map(|column| row[column])
    }
}

/// The texel whose centre lies before a texture coordinate, and how far the coordinate is on the way to the
/// next.
fn place(share: f32, n: f64) -> (i64, f32) {
    // Coordinates of maps that repeat may be large: fractions in f64.
    let texel = f64::from(share) * n - 0.5;
    // What `floor` gives, which is a call of a function on processors of any age.
    let toward_zero = texel as i64;
    let before = toward_zero - i64::from(toward_zero as f64 > texel);
    (before, (texel - before as f64) as f32)
}

#[inline]
fn dot(texels: [f32; 4], weights: [f32; 4]) -> f32 {
    texels.iter().zip(weights).map(|(h, w)| h * w).sum()
}

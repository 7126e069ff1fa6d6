//! Form factors that can be written down, from Howell's catalogue (Howell, "A catalog of radiation
//! heat transfer configuration factors"; its numbers in brackets) and from Hottel.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Two opposed `a × b` rectangles, `c` apart (C-11).
pub(crate) fn opposed_rectangles(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let logarithm = 0.5 * (sx * sx * sy * sy / (1.0 + x * x + y * y)).ln();
    let slants = x * sy * (x / sy).atan() + y * sx * (y / sx).atan();
    2.0 / (PI * x * y) * (logarithm + slants - x * x.atan() - y * y.atan())
}

/// From a `w × l` rectangle to an `h × l` rectangle that stands on its edge `l` (C-14).
pub(crate) fn hinged_rectangles(w: f64, h: f64, l: f64) -> f64 {
    let (w, h) = (w / l, h / l);
    let (w2, h2) = (w * w, h * h);
    let d2 = w2 + h2;
    let d = d2.sqrt();
    let angles = w * (1.0 / w).atan() + h * (1.0 / h).atan() - d * (1.0 / d).atan();
    let logarithms = ((1.0 + w2) * (1.0 + h2) / (1.0 + d2)).ln()
        + w2 * (w2 * (1.0 + d2) / ((1.0 + w2) * d2)).ln()
        + h2 * (h2 * (1.0 + d2) / ((1.0 + h2) * d2)).ln();
    (angles + 0.25 * logarithms) / (PI * w)
}

/// A sum over the ends of four ranges, ends first of a range negative.
fn alternating(ranges: [[f64; 2]; 4], term: impl Fn([f64; 4]) -> f64) -> f64 {
    let corner = |bits: usize| {
        let ends = std::array::from_fn(|k| ranges[k][bits >> k & 1]);
        let sign = if bits.count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        sign * term(ends)
    };
    (0..16).map(corner).sum()
}

/// From the rectangle `x`, `y` at height 0 to the rectangle `xi`, `eta` at height `z` (C-13).
pub(crate) fn parallel_rectangles(
    x: [f64; 2],
    y: [f64; 2],
    xi: [f64; 2],
    eta: [f64; 2],
    z: f64,
) -> f64 {
    let term = |[x, y, xi, eta]: [f64; 4]| {
        let (a, b) = (x - xi, y - eta);
        let (along_a, along_b) = (a.hypot(z), b.hypot(z));
        let slants = b * along_a * (b / along_a).atan() + a * along_b * (a / along_b).atan();
        slants - 0.5 * z * z * (a * a + b * b + z * z).ln()
    };
    alternating([x, y, xi, eta], term) / (TAU * (x[1] - x[0]) * (y[1] - y[0]))
}

/// From the rectangle `x`, `y` in the plane z = 0 to the rectangle `eta`, `z` in the plane x = 0,
/// `eta` along y (C-15).
pub(crate) fn perpendicular_rectangles(
    x: [f64; 2],
    y: [f64; 2],
    eta: [f64; 2],
    z: [f64; 2],
) -> f64 {
    let term = |[x, y, eta, z]: [f64; 4]| {
        let (r, c) = (x.hypot(z), y - eta);
        let square = r * r + c * c;
        if square == 0.0 {
            return 0.0;
        }
        c * r * c.atan2(r) - 0.25 * (r * r - c * c) * square.ln()
    };
    alternating([x, y, eta, z], term) / (TAU * (x[1] - x[0]) * (y[1] - y[0]))
}

/// From a disk of radius `r1` to one of `r2` on the same axis, `h` away (C-41).
pub(crate) fn coaxial_disks(r1: f64, r2: f64, h: f64) -> f64 {
    let (near, far) = (r1 / h, r2 / h);
    let s = 1.0 + (1.0 + far * far) / (near * near);
    let ratio = r2 / r1;
    // 1/2 (s − √(s² − 4 ratio²)) without its cancellation.
    2.0 * ratio * ratio / (s + (s * s - 4.0 * ratio * ratio).sqrt())
}

/// From a point to an `a × b` rectangle parallel to it, one corner straight above at `c` (B-3).
/// Odd in `a` and in `b`.
pub(crate) fn point_to_parallel_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / sx * (y / sx).atan() + y / sy * (x / sy).atan()) / TAU
}

/// From a point facing up to a rectangle of height `a` and width `b` that stands at distance `c`,
/// one lower corner straight ahead (B-4).
pub(crate) fn point_to_standing_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / b, c / b);
    let d = x.hypot(y);
    ((1.0 / y).atan() - y / d * (1.0 / d).atan()) / TAU
}

/// From a point to a sphere of radius `r`, all of it above the horizon, its centre at distance `d`
/// and at an angle of cosine `cos` from the normal.
pub(crate) fn point_to_sphere(r: f64, d: f64, cos: f64) -> f64 {
    cos * (r / d).powi(2)
}

/// From a sphere to a disk of radius `r`, its centre `h` from the sphere's, facing it.
pub(crate) fn sphere_to_disk(r: f64, h: f64) -> f64 {
    let slope = r / h;
    0.5 * (1.0 - 1.0 / (1.0 + slope * slope).sqrt())
}

/// From anywhere inside a sphere to a cap of it, of half-angle `theta`: its share of the area.
pub(crate) fn inside_sphere(theta: f64) -> f64 {
    0.5 * (1.0 - theta.cos())
}

/// From the outer of two concentric spheres to the inner.
pub(crate) fn concentric_spheres(inner: f64, outer: f64) -> f64 {
    (inner / outer).powi(2)
}

/// Two opposed endless strips, as far apart as `ratio` times their width.
pub(crate) fn strips(ratio: f64) -> f64 {
    1.0 / (ratio.hypot(1.0) + ratio)
}

/// Two endless strips of the same width that share an edge at an angle.
pub(crate) fn wedge(angle: f64) -> f64 {
    1.0 - (0.5 * angle).sin()
}

/// Two endless cylinders of the same radius, `2 x` radii from axis to axis.
pub(crate) fn cylinders(x: f64) -> f64 {
    ((x * x - 1.0).sqrt() + (1.0 / x).asin() - x) / PI
}

/// Two opposed strips of width `w`, `h` apart, a baffle of width `baffle` midway and centred:
/// Hottel's crossed strings, pulled tight round its ends.
pub(crate) fn strips_with_baffle(w: f64, h: f64, baffle: f64) -> f64 {
    (2.0 * (0.5 * (w - baffle)).hypot(0.5 * h) - h) / w
}

/// Two opposed unit squares 1 apart, hidden from each other by the square `blocker` × `blocker`
/// midway: what each point sees of the other, less the shadow on it.
///
/// The shadow of the point at `x` is `2 b − x`; it meets the edge of the square at 0 and 1, where
/// the integral is cut.
pub(crate) fn obstructed_squares(blocker: [f64; 2]) -> f64 {
    let shadow = |x: f64| blocker.map(|b| (2.0 * b - x).clamp(0.0, 1.0));
    let corner = |x: f64, y: f64| point_to_parallel_rectangle(x, y, 1.0);
    let sees = |x: f64, y: f64, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]| {
        corner(x1 - x, y1 - y) - corner(x0 - x, y1 - y) - corner(x1 - x, y0 - y)
            + corner(x0 - x, y0 - y)
    };
    let open = |x, y| sees(x, y, [0.0, 1.0], [0.0, 1.0]) - sees(x, y, shadow(x), shadow(y));
    let mut cuts = vec![0.0, 1.0];
    let kinks = blocker.into_iter().flat_map(|b| [2.0 * b, 2.0 * b - 1.0]);
    cuts.extend(kinks.filter(|c| (0.0..1.0).contains(c)));
    cuts.sort_by(f64::total_cmp);
    let over =
        |f: &dyn Fn(f64) -> f64| -> f64 { cuts.windows(2).map(|c| integral(f, c[0], c[1])).sum() };
    over(&|x| over(&|y| open(x, y)))
}

/// The integral of a function that is smooth inside `from..to` (tanh-sinh: Takahasi and Mori 1974).
pub(crate) fn integral(f: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let step = 1.0 / 16.0;
    let term = |k: i32| {
        let t = f64::from(k) * step;
        let u = FRAC_PI_2 * t.sinh();
        let weight = FRAC_PI_2 * t.cosh() / u.cosh().powi(2);
        weight * f(0.5 * (from + to) + 0.5 * (to - from) * u.tanh())
    };
    0.5 * (to - from) * step * (-52..=52).map(term).sum::<f64>()
}

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::DVec3;

use super::gauss::{legendre, on_polygon};

/// The form factor from a small surface at `point` that faces `normal` to a polygon, nothing
/// between them: the share of what leaves the surface that reaches the polygon.
///
/// The polygon is planar, of any shape that does not cross itself. It has a front, the side from
/// which its corners run anticlockwise, and seen from behind it counts nothing, as does what lies
/// below the plane of the surface. Lengths are in any unit; `normal` of any length but 0. The
/// result lies in 0..=1, and is good to about 1e-15 until the polygon is a thousand times farther
/// off than it is wide.
///
/// Lambert's formula (1760), with an arc tangent that loses nothing where angles are small: edges
/// seen from the point are angles `θ` about axes `Γ`, and
///
/// ```text
///   ┌──────────────────────────────────────────────────────────────────────────────────┐
///   │  F = 1/2π Σ_i θ_i n · Γ_i,    tan θ_i = |v_i × v_i+1| / v_i · v_i+1,  v = corner − point │
///   └──────────────────────────────────────────────────────────────────────────────────┘
/// ```
///
/// ```
/// use bevy_fresco::radiosity::point_to_polygon;
/// use glam::DVec3;
///
/// // From the floor to a quarter of the infinite ceiling, nearly.
/// let far = 1e6;
/// let ceiling = [(0.0, 0.0), (0.0, far), (far, far), (far, 0.0)];
/// let ceiling = ceiling.map(|(x, y)| DVec3::new(x, y, 1.0));
/// let f = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling);
/// assert!((f - 0.25).abs() < 1e-6);
/// assert_eq!(point_to_polygon(DVec3::ZERO, -DVec3::Z, &ceiling), 0.0);
/// ```
pub fn point_to_polygon(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    share(lambert(point, normal.normalize_or_zero(), polygon))
}

/// The form factor from one convex planar polygon to another, nothing between them: the share of
/// what leaves `a` that reaches `b`.
///
/// A polygon has a front, the side from which its corners run anticlockwise, and exchanges light
/// with what lies before it; polygons may pass through each other's planes. They may touch, share
/// an edge, be slivers or far away: the error is below 1e-10. Lengths are in any unit. By
/// reciprocity `area(a) · F(a, b) = area(b) · F(b, a)`.
///
/// The integral over both areas is one over both outlines, twice Stokes' theorem (Moon 1936;
/// Sparrow 1963), and along edges of the first it has a closed form (Mitalas and Stephenson 1966):
///
/// ```text
///   ┌─────────────────────────────────────────────────────────────────────┐
///   │  A F = 1/2π Σ_e Σ_f (d_e · d_f) ∫_f ∫_e ln r ds dt                  │
///   │                                                                     │
///   │  ∫_e ln r ds = [ z/2 ln(z² + h²) − z + h atan(z/h) ] over z along e │
///   └─────────────────────────────────────────────────────────────────────┘
/// ```
///
/// with `h` the distance from a point of `f` to the line of `e`. The integral over `f` is a Gauss
/// rule on pieces that are no longer than they are far from where its integrand is not smooth. The
/// terms cancel as the distance grows, so polygons far apart are integrated over their areas.
///
/// ```
/// use bevy_fresco::radiosity::polygon_to_polygon;
/// use glam::DVec3;
///
/// // Two walls of a cube that share an edge (Howell's catalogue, C-14).
/// let floor = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
/// let wall = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(y, z)| DVec3::new(0.0, y, z));
/// assert!((polygon_to_polygon(&floor, &wall) - 0.200_043_776_075).abs() < 1e-12);
/// ```
pub fn polygon_to_polygon(a: &[DVec3], b: &[DVec3]) -> f64 {
    share(exchange(a, b, &EXACT) / area_vector(a).length())
}

/// A form factor, if it is one: 0 for the degenerate and what faces away.
fn share(f: f64) -> f64 {
    // A sum of no number is not above 0 either.
    if f > 0.0 { f.min(1.0) } else { 0.0 }
}

/// Area times unit normal of the front.
pub(super) fn area_vector(polygon: &[DVec3]) -> DVec3 {
    let fan = polygon.windows(2).skip(1);
    let cross = fan.map(|far| (far[0] - polygon[0]).cross(far[1] - polygon[0]));
    0.5 * cross.sum::<DVec3>()
}

/// Gives `keep` the corners of the part of a polygon where `height` is positive (Sutherland and
/// Hodgman 1974).
pub(crate) fn clip(polygon: &[DVec3], height: impl Fn(DVec3) -> f64, mut keep: impl FnMut(DVec3)) {
    let Some(&last) = polygon.last() else {
        return;
    };
    let mut before = (last, height(last));
    for &corner in polygon {
        let now = (corner, height(corner));
        if (before.1 > 0.0) != (now.1 > 0.0) {
            keep(before.0 + (now.0 - before.0) * (before.1 / (before.1 - now.1)));
        }
        if now.1 > 0.0 {
            keep(corner);
        }
        before = now;
    }
}

/// Lambert's sum over the part of a polygon above the horizon, of one sign if it shows its front;
/// in proportion to the length of `normal`.
pub(super) fn lambert(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let edge = |a: DVec3, b: DVec3| {
        let axis = a.cross(b);
        let sine = axis.length();
        if sine > 0.0 {
            normal.dot(axis) / sine * sine.atan2(a.dot(b))
        } else {
            0.0
        }
    };
    let (mut sum, mut first, mut last) = (0.0, None, None);
    clip(
        polygon,
        |p| normal.dot(p - point),
        |p| {
            let v = p - point;
            sum += last.map_or(0.0, |l| edge(v, l));
            first = first.or(Some(v));
            last = Some(v);
        },
    );
    let closing = first.zip(last).map_or(0.0, |(f, l)| edge(f, l));
    (sum + closing) / TAU
}

/// How carefully outlines are integrated.
pub(super) struct Care {
    /// Gauss rule on a piece of an edge.
    rule: Vec<(f64, f64)>,
    /// How often an edge may be halved towards what it touches.
    halvings: u32,
}

/// To rounding: the last piece, of 2⁻²⁰ of an edge, is wrong by 1e-5 of its length squared.
static EXACT: LazyLock<Care> = LazyLock::new(|| Care {
    rule: legendre(12),
    halvings: 20,
});

/// To about 1e-5, and 20 times as fast.
pub(super) static QUICK: LazyLock<Care> = LazyLock::new(|| Care {
    rule: legendre(4),
    halvings: 3,
});

/// Polygons farther apart than this many times their size are integrated over their areas. The
/// outlines have lost two digits there; six points a side lose none.
const FAR: f64 = 8.0;

/// `A_a F_ab` of the parts of two polygons that are before each other.
pub(super) fn exchange(a: &[DVec3], b: &[DVec3], care: &Care) -> f64 {
    let before = |polygon: &[DVec3], other: &[DVec3]| {
        let mut front = Vec::with_capacity(polygon.len() + 1);
        if let (Some(&point), normal) = (other.first(), area_vector(other)) {
            clip(polygon, |p| normal.dot(p - point), |p| front.push(p));
        }
        front
    };
    let (a, b) = (before(a, b), before(b, a));
    if a.len() < 3 || b.len() < 3 {
        return 0.0;
    }
    let middle = |p: &[DVec3]| p.iter().sum::<DVec3>() / p.len() as f64;
    let (from, to) = (middle(&a), middle(&b));
    let size = |p: &[DVec3], m: DVec3| p.iter().map(|c| c.distance(m)).fold(0.0, f64::max);
    let sizes = size(&a, from) + size(&b, to);
    if from.distance(to) > FAR * sizes {
        areas(&a, &b)
    } else {
        outlines(&a, &b, sizes, care)
    }
}

/// The kernel `cos cos / π r²` integrated over both areas.
fn areas(a: &[DVec3], b: &[DVec3]) -> f64 {
    static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| legendre(6));
    let normal = |polygon: &[DVec3]| area_vector(polygon).normalize_or_zero();
    let (normal_a, normal_b) = (normal(a), normal(b));
    let points: Vec<(DVec3, f64)> = on_polygon(b, &RULE).collect();
    let from = |(x, w): (DVec3, f64)| {
        let to = |&(y, v): &(DVec3, f64)| v * kernel(y - x, normal_a, normal_b);
        w * points.iter().map(to).sum::<f64>()
    };
    on_polygon(a, &RULE).map(from).sum()
}

/// `cos θ cos θ' / π r²` between small surfaces `ray` apart, 0 behind either.
pub(super) fn kernel(ray: DVec3, normal: DVec3, normal_there: DVec3) -> f64 {
    let square = ray.length_squared();
    let cosines = normal.dot(ray).max(0.0) * (-normal_there.dot(ray)).max(0.0);
    if cosines > 0.0 {
        cosines / (PI * square * square)
    } else {
        0.0
    }
}

/// The integral over both outlines. Measured in lengths of `unit`, distances have small logarithms,
/// so that less cancels: around a closed outline the factor makes no difference.
fn outlines(a: &[DVec3], b: &[DVec3], unit: f64, care: &Care) -> f64 {
    let edges = |polygon: &[DVec3]| -> Vec<Edge> {
        let next = polygon.iter().cycle().skip(1);
        polygon
            .iter()
            .zip(next)
            .filter_map(|(&p, &q)| Edge::new(p, q))
            .collect()
    };
    let others = edges(b);
    let mut sum = 0.0;
    for e in edges(a) {
        for f in &others {
            let cosine = e.direction.dot(f.direction);
            // Perpendicular edges are worth nothing, rounded ones next to nothing.
            if cosine.abs() > 1e-15 {
                sum += cosine * Logarithm::new(&e, f, unit).integral((0.0, f.length), care, 0);
            }
        }
    }
    sum / TAU
}

struct Edge {
    from: DVec3,
    direction: DVec3,
    length: f64,
}

impl Edge {
    fn new(from: DVec3, to: DVec3) -> Option<Self> {
        let length = from.distance(to);
        (length > 0.0).then(|| Self {
            from,
            direction: (to - from) / length,
            length,
        })
    }
}

/// `∫_e ln r ds` as a function along an edge `f`.
struct Logarithm<'a> {
    e: &'a Edge,
    f: &'a Edge,
    unit: f64,
    /// Where along `f`, and how far beside it in the complex plane, the function is not smooth: at
    /// the ends of `e`, and where the lines pass each other if that is within `e`.
    rough: [(f64, f64); 3],
}

impl<'a> Logarithm<'a> {
    fn new(e: &'a Edge, f: &'a Edge, unit: f64) -> Self {
        let beside = |p: DVec3| {
            let t = (p - f.from).dot(f.direction);
            (t, p.distance(f.from + f.direction * t))
        };
        let ends = [e.from, e.from + e.direction * e.length].map(beside);
        let across = e.direction.cross(f.direction);
        let sine = across.length();
        let between = f.from - e.from;
        // Where the lines pass each other, along each.
        let along_e = between.cross(f.direction).dot(across) / (sine * sine);
        let along_f = between.cross(e.direction).dot(across) / (sine * sine);
        let apart = between.dot(across).abs() / (sine * sine);
        let passes = sine > 1e-9 && (0.0..=e.length).contains(&along_e);
        let crossing = if passes { (along_f, apart) } else { ends[0] };
        Self {
            e,
            f,
            unit,
            rough: [ends[0], ends[1], crossing],
        }
    }

    fn integral(&self, (from, to): (f64, f64), care: &Care, halved: u32) -> f64 {
        let width = to - from;
        let near = |&(t, apart): &(f64, f64)| apart.hypot(t - t.clamp(from, to)) < width;
        if halved < care.halvings && self.rough.iter().any(near) {
            let middle = 0.5 * (from + to);
            return self.integral((from, middle), care, halved + 1)
                + self.integral((middle, to), care, halved + 1);
        }
        let at = |&(x, weight): &(f64, f64)| weight * self.value(from + width * (0.5 + 0.5 * x));
        0.5 * width * care.rule.iter().map(at).sum::<f64>()
    }

    fn value(&self, t: f64) -> f64 {
        let y = self.f.from + self.f.direction * t - self.e.from;
        let z = y.dot(self.e.direction);
        let h = (y - self.e.direction * z).length();
        let primitive = |z: f64| {
            let square = (z * z + h * h) / (self.unit * self.unit);
            let logarithm = if square > 0.0 { square.ln() } else { 0.0 };
            0.5 * z * logarithm - z + h * z.atan2(h)
        };
        primitive(self.e.length - z) - primitive(-z)
    }
}

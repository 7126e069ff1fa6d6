use glam::Vec3;

/// The weight 1. Multiples of 2⁻²⁴ in `0..=1` and their complements are exact in `f32`.
pub(super) const ONE: u32 = 1 << 24;

/// Weights of a triangle's corners in units of 2⁻²⁴; their sum is [`ONE`].
pub(super) type Weights = [u32; 3];

pub(super) fn corner(corner: usize) -> Weights {
    let mut weights = [0; 3];
    weights[corner] = ONE;
    weights
}

/// The point of the edge from `corner` to the next where the second of the two has weight `t`.
pub(super) fn on_edge(corner: usize, t: u32) -> Weights {
    let mut weights = [0; 3];
    weights[corner] = ONE - t;
    weights[(corner + 1) % 3] = t;
    weights
}

/// The nearest to weights that sum to 1 within rounding.
pub(super) fn nearest(weights: [f64; 3]) -> Weights {
    let round = |w: f64| (w.clamp(0.0, 1.0) * f64::from(ONE)).round() as u32;
    let first = round(weights[0]);
    let second = round(weights[1]).min(ONE - first);
    [first, second, ONE - first - second]
}

/// Half-way between two points. A unit left over goes to the used corner with the lowest `class`,
/// so the triangles of an edge agree on it.
pub(super) fn middle(a: Weights, b: Weights, classes: [u32; 3]) -> Weights {
    let mut middle = [0, 1, 2].map(|i| (a[i] + b[i]) / 2);
    let left = ONE - middle.iter().sum::<u32>();
    let used = (0..3).filter(|&i| a[i] + b[i] > 0);
    if let Some(lowest) = used.min_by_key(|&i| classes[i]) {
        middle[lowest] += left;
    }
    middle
}

pub(super) fn to_vec3(weights: Weights) -> Vec3 {
    Vec3::from(weights.map(|w| w as f32 / ONE as f32))
}

use glam::{Mat3, Vec3, Vec3A, Vec3Swizzles};

use crate::radiosity::element::ElementId;
use crate::radiosity::form_factor::View;
use crate::radiosity::occlusion::{OFFSET, TIE};
use crate::radiosity::sampling::{frame, hash, unit_float};
use crate::radiosity::triangle::face_normal;

/// An input triangle, ready to be looked at.
pub(super) struct Facet {
    triangle: u32,
    /// The three corners, x, y and z apart.
    corners: [Vec3A; 3],
    normal: Vec3,
    /// `normal · corner`.
    height: f32,
    /// Cells along an edge.
    cells: f32,
    /// Light can pass.
    transmits: bool,
}

impl Facet {
    pub(super) fn new(view: &View, triangle: u32) -> Self {
        let corners = view.scene.corners(view.scene.triangles[triangle as usize]);
        let normal = face_normal(corners);
        let sides = 1 + usize::from(view.elements.side_at(triangle, [0.0; 2], true).is_some());
        Self {
            triangle,
            corners: [0, 1, 2].map(|axis| Vec3A::from(corners.map(|c| c[axis]))),
            normal,
            height: normal.as_dvec3().dot(corners[0].as_dvec3()) as f32,
            cells: (view.elements.of_triangle(triangle).count() / sides).isqrt() as f32,
            transmits: view.occluders.transmits(triangle),
        }
    }
}

/// Where a hemicube stands, and how it is turned.
pub(super) struct Eye {
    triangle: u32,
    position: Vec3,
    /// Its axes; the third is the normal.
    axes: Mat3,
}

/// A triangle as the eye sees it.
///
/// With corners `a`, `b`, `c` seen from the eye, a direction `d` meets the triangle where
/// `d = λ_a a + λ_b b + λ_c c` with all `λ` of one sign, that of its distance. By Cramer's rule,
///
/// ```text
///   λ_a = d · (b × c) / det    λ_b = d · (c × a) / det    λ_c = d · (a × b) / det
///   ┌──────────────────────────────────────────────────────────────────────────┐
///   │  edge functions  e = d · (b × c), …      barycentrics  e_b/Σe, e_c/Σe      │
///   │  1/t = d · n / h     with unit normal n and h = n · a                    │
///   └──────────────────────────────────────────────────────────────────────────┘
/// ```
///
/// All are linear in `d`, and so in the place on a face: nothing needs to be clipped, not even what
/// reaches behind the eye (Olano and Greer 1997, "Triangle Scan Conversion using 2D Homogeneous
/// Coordinates"). Two triangles that share an edge get the same edge function but for its sign, to
/// the last bit, so that no pixel on it is lost or drawn twice.
pub(super) struct Seen {
    pub(super) triangle: u32,
    /// It is cut into this many cells along an edge.
    pub(super) cells: f32,
    /// Light can pass.
    pub(super) transmits: bool,
    /// Seen from behind.
    pub(super) back: bool,
    /// Corners along each axis of the eye.
    pub(super) corners: [Vec3A; 3],
    /// Edge functions along each axis, positive inside; each opposite the corner of its lane.
    pub(super) edges: [Vec3A; 3],
    /// `n/h`: the inverse depth along each axis.
    pub(super) inverse_depth: [f32; 3],
}

impl Eye {
    /// On the element, at the point nearest to its centre of area.
    pub(super) fn new(view: &View, element: ElementId) -> Self {
        let (center, _) = view.elements.middle(view.scene, element);
        let mut best = (f32::INFINITY, 0, center, Vec3::Z);
        for (triangle, corners, normal) in view.elements.shape(view.scene, element) {
            let point = nearest(corners, center);
            let distance = point.distance_squared(center);
            if distance < best.0 {
                best = (distance, triangle, point, normal);
            }
        }
        let (_, triangle, point, normal) = best;
        let seed = view.elements.seed(element, view.settings.seed);
        // A turn of its own for each element makes noise of what would be a pattern.
        let roll = std::f32::consts::TAU * unit_float(hash(seed, 0xC0BE));
        Self {
            triangle,
            position: point + normal * OFFSET,
            axes: frame(normal) * Mat3::from_rotation_z(roll),
        }
    }

    /// How a triangle looks from here; `None` if it is below the horizon, edge on, or the one the
    /// eye is on.
    pub(super) fn see(&self, facet: &Facet) -> Option<Seen> {
        let [x, y, z] = facet.corners;
        let p = self.position;
        let (x, y, z) = (x - p.x, y - p.y, z - p.z);
        let along = |axis: Vec3| x * axis.x + y * axis.y + z * axis.z;
        let above = along(self.axes.z_axis);
        if above.max_element() <= 0.0 || facet.triangle == self.triangle {
            return None;
        }
        // Positive: the eye is behind the plane.
        let height = facet.height - facet.normal.dot(p);
        if height == 0.0 {
            return None;
        }
        let back = height > 0.0;
        let corners = [along(self.axes.x_axis), along(self.axes.y_axis), above];
        // The black side of two faces back to back must not show by a rounding.
        let inverse = 1.0 / (height + if back { TIE } else { 0.0 });
        let normal = self.axes.transpose() * facet.normal;
        Some(Seen {
            triangle: facet.triangle,
            cells: facet.cells,
            transmits: facet.transmits,
            back,
            corners,
            edges: crosses(&corners).map(|e| if back { e } else { -e }),
            inverse_depth: (normal * inverse).to_array(),
        })
    }

    /// Where the hemicube stands, and its axes.
    #[cfg(test)]
    pub(super) fn place(&self) -> (Vec3, [Vec3; 3]) {
        let axes = self.axes;
        (self.position, [axes.x_axis, axes.y_axis, axes.z_axis])
    }
}

/// `b × c`, `a × b` in lanes, given corners by axis.
fn crosses([x, y, z]: &[Vec3A; 3]) -> [Vec3A; 3] {
    let (bx, by, bz) = (x.yzx(), y.yzx(), z.yzx());
    let (cx, cy, cz) = (x.zxy(), y.zxy(), z.zxy());
    [by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx]
}

/// The point of a triangle nearest to `p`.
fn nearest([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let normal = (b - a).cross(c - a);
    let inside = |u: Vec3, v: Vec3| normal.dot((v - u).cross(p - u)) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        return p - normal * (normal.dot(p - a) / normal.length_squared().max(f32::MIN_POSITIVE));
    }
    let on_edge = |u: Vec3, v: Vec3| {
        let along = v - u;
        let t = along.dot(p - u) / along.length_squared().max(f32::MIN_POSITIVE);
        u + along * t.clamp(0.0, 1.0)
    };
    [on_edge(a, b), on_edge(b, c), on_edge(c, a)]
        .into_iter()
        .min_by(|u, v| u.distance_squared(p).total_cmp(&v.distance_squared(p)))
        .unwrap_or(a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_points_are_inside_on_edges_and_at_corners() {
        let t = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0];
        for (p, expected) in [
            (Vec3::new(0.5, 0.5, 3.0), Vec3::new(0.5, 0.5, 0.0)),
            (Vec3::new(1.0, -1.0, -1.0), Vec3::X),
            (Vec3::new(2.0, 2.0, 1.0), Vec3::new(1.0, 1.0, 0.0)),
            (Vec3::new(-1.0, -2.0, 1.0), Vec3::ZERO),
        ] {
            assert!((nearest(t, p) - expected).length() < 1e-6, "{p}");
        }
    }

    #[test]
    fn crosses_are_those_of_corners() {
        let [a, b, c] = [
            Vec3::new(1.0, 2.0, 3.0),
            Vec3::new(-2.0, 0.5, 4.0),
            Vec3::new(0.0, -1.0, 7.0),
        ];
        let axes = [0, 1, 2].map(|k| Vec3A::new(a[k], b[k], c[k]));
        let lanes = crosses(&axes);
        for (lane, expected) in [b.cross(c), c.cross(a), a.cross(b)].into_iter().enumerate() {
            assert_eq!(Vec3::from(lanes.map(|l| l[lane])), expected);
        }
    }
}

use glam::{DVec3, Vec3};

use super::emitter::Receiver;
use super::form_factor::{clip, point_to_polygon};
use super::sampling::triangle as triangle_point;

/// Corners that a rectangle has above the horizon, at most.
const CORNERS: usize = 5;

/// A shining polygon as a receiver sees it: the part above the receiver's horizon.
///
/// What it brings with nothing between has a closed form. What stands between is asked by shadow
/// rays to points `i` of equal density, each of which counts by what it would bring. `V_i` is the
/// light that passes,
///
/// ```text
///   ┌─────────────────────────────────┐
///   │  H = L F · Σ g_i V_i / Σ g_i    │     g = cos θ cos θ' / d²
///   └─────────────────────────────────┘
/// ```
///
/// so that without shadow, and in full shadow, `H` is exact after a single ray, and near the polygon
/// the growth of 1/d² cancels.
pub(crate) struct Facet {
    /// Form factor from the receiver, nothing between.
    pub(crate) factor: f64,
    pub(crate) area: f32,
    /// Unit normal of the side that the receiver sees.
    normal: Vec3,
    /// Relative to the receiver.
    corners: [Vec3; CORNERS],
    /// The triangles that a fan from the first corner makes of it: for each, its share of the area
    /// with those before.
    fan: [f32; CORNERS - 2],
    triangles: usize,
}

/// The way to a point of a facet.
pub(crate) struct Way {
    /// Relative to the receiver.
    pub(crate) to: Vec3,
    pub(crate) distance: f32,
    /// What the point brings: cos θ cos θ' / d².
    pub(crate) brings: f32,
}

impl Facet {
    /// A convex polygon of up to four corners, anticlockwise as seen from its front, of which
    /// `normal` is the unit normal; `None` if its front cannot be seen.
    pub(crate) fn new<const N: usize>(
        receiver: &Receiver,
        polygon: [Vec3; N],
        normal: Vec3,
    ) -> Option<Self> {
        let here = receiver.position.as_dvec3();
        let up = receiver.normal.as_dvec3();
        let polygon = polygon.map(|p| p.as_dvec3() - here);
        let factor = point_to_polygon(DVec3::ZERO, up, &polygon);
        if factor <= 0.0 {
            return None;
        }
        let (mut corners, mut count) = ([Vec3::ZERO; CORNERS], 0);
        clip(
            &polygon,
            |p| up.dot(p),
            |p| {
                // Rounding may cut a sliver more often.
                if let Some(corner) = corners.get_mut(count) {
                    *corner = p.as_vec3();
                    count += 1;
                }
            },
        );
        let (mut fan, mut area) = ([1.0; CORNERS - 2], 0.0);
        let triangles = count.checked_sub(2).filter(|&n| n > 0)?;
        for k in 0..triangles {
            let [a, b] = [corners[k + 1] - corners[0], corners[k + 2] - corners[0]];
            area += a.cross(b).length();
            fan[k] = area;
        }
        let share = |part: f32| part / area;
        (area > 0.0).then(|| Self {
            factor,
            area: 0.5 * area,
            normal,
            corners,
            fan: fan.map(share),
            triangles,
        })
    }

    /// The way to point `u`, `v` (each 0..1), area-uniform, from a receiver that faces `up`; `None`
    /// where it brings nothing.
    pub(crate) fn way(&self, up: Vec3, [u, v]: [f32; 2]) -> Option<Way> {
        let fan = &self.fan[..self.triangles];
        let k = fan.partition_point(|&end| end <= u).min(fan.len() - 1);
        let start = if k == 0 { 0.0 } else { fan[k - 1] };
        // What is left of u after choosing the triangle is uniform again.
        let u = ((u - start) / (fan[k] - start).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let b = triangle_point(u, v);
        let to = self.corners[0] * b.x + self.corners[k + 1] * b.y + self.corners[k + 2] * b.z;
        let distance = to.length();
        let way = to / distance;
        let brings = up.dot(way) * -self.normal.dot(way) / (distance * distance);
        (brings > 0.0 && brings.is_finite()).then_some(Way {
            to,
            distance,
            brings,
        })
    }
}

impl Way {
    pub(crate) fn direction(&self) -> Vec3 {
        self.to / self.distance
    }
}

use glam::{DVec3, Vec3};

use super::Direction;
use super::corner::corners;
use super::surface::Sheet;

/// Mitres are no longer than this: that of an edge of 60°.
const MITRE_LIMIT: f64 = 2.0;

/// Normals whose sum is shorter than this share of their number cancel out.
const CANCELLED: f64 = 1e-3;

/// Which way is out at every place, and at how many places nobody knows.
///
/// With the normals `n` of the triangles around a place weighted by their angles `w`,
///
/// ```text
///                                             smooth        by the height along each face
///         Σ w n                            ┌──────────┐     ┌───────────────────────────┐
///   m =  ───────      μ = mean of n · m    │  d = m   │     │  d = m / μ,  at most 2 m   │
///        |Σ w n|        = |Σ w n| / Σ w    └──────────┘     └───────────────────────────┘
/// ```
///
/// Where all `n` lean by the same angle from `m`, as at edges and corners of boxes, `d · n = 1` for each: the
/// faces move out by the height itself. Smooth directions take the normals of vertices, the others those of
/// faces.
pub(super) fn directions(
    sheets: &[Sheet],
    places: usize,
    direction: Direction,
) -> (Vec<Vec3>, u64) {
    let mut sums = vec![(DVec3::ZERO, 0.0_f64); places];
    for sheet in sheets {
        for corner in corners(sheet) {
            let normal = match direction {
                Direction::Smooth => sheet.normal_of(corner.vertex),
                Direction::FaceNormal => corner.facet,
            };
            let sum = &mut sums[sheet.places[corner.vertex as usize] as usize];
            sum.0 += corner.angle * normal.as_dvec3();
            sum.1 += corner.angle;
        }
    }
    let mut undirected = 0;
    let out = sums.into_iter().map(|(sum, weight)| {
        let length = sum.length();
        if weight > 0.0 && length <= CANCELLED * weight {
            undirected += 1;
        }
        if length <= CANCELLED * weight {
            return Vec3::ZERO;
        }
        let stretch = match direction {
            Direction::Smooth => 1.0,
            Direction::FaceNormal => (weight / length).min(MITRE_LIMIT),
        };
        (sum / length * stretch).as_vec3()
    });
    (out.collect(), undirected)
}

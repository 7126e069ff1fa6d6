use glam::{DVec3, Vec3};

use super::surface::Sheet;

/// A corner of a triangle with area.
pub(super) struct Corner {
    /// Vertex.
    pub(super) vertex: u32,
    /// Which triangle.
    pub(super) triangle: usize,
    /// Which of its corners.
    pub(super) index: usize,
    /// Interior angle in radians: what sums over the triangles around a vertex are weighted by, because they
    /// then do not depend on how faces are cut into triangles (G. Thürmer and C. A. Wüthrich, "Computing
    /// vertex normals from polygonal facets", Journal of Graphics Tools 3(1), 1998).
    pub(super) angle: f64,
    /// Unit normal of the triangle.
    pub(super) facet: Vec3,
}

/// All corners of triangles with area, in order.
pub(super) fn corners<'a>(sheet: &'a Sheet) -> impl Iterator<Item = Corner> + 'a {
    let triangles = sheet.triangles.iter().enumerate();
    triangles.flat_map(|(triangle, &vertices)| {
        let at = vertices.map(|v| sheet.positions[v as usize].as_dvec3());
        facet_normal(at).into_iter().flat_map(move |facet| {
            (0..3).map(move |index| Corner {
                vertex: vertices[index],
                triangle,
                index,
                angle: angle(at, index),
                facet,
            })
        })
    })
}

/// Unit normal of a triangle; `None` if it has no area that `f32` positions could tell.
pub(super) fn facet_normal([a, b, c]: [DVec3; 3]) -> Option<Vec3> {
    let cross = (b - a).cross(c - a);
    let longest = [b - a, c - b, a - c]
        .map(|e| e.length_squared())
        .into_iter()
        .fold(0.0, f64::max);
    // A height of less than a rounding of the longest edge.
    (cross.length() > f64::from(f32::EPSILON) * longest).then(|| cross.normalize().as_vec3())
}

fn angle(at: [DVec3; 3], index: usize) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|i| at[(index + i) % 3]);
    (b - a).angle_between(c - a)
}

use glam::Vec3;

/// A point on a triangle of a source mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index of the source triangle.
    pub triangle: u32,
    /// Weights of the triangle's three corners, in its own order; each in `0..=1`, their sum 1.
    pub barycentrics: Vec3,
}

impl SurfacePoint {
    /// The corner `corner` (0, 1 or 2) of `triangle`.
    pub fn corner(triangle: u32, corner: usize) -> Self {
        let mut weights = [0.0; 3];
        weights[corner] = 1.0;
        Self {
            triangle,
            barycentrics: weights.into(),
        }
    }
}

/// A mesh cut out of a source mesh: the same surface, more vertices.
///
/// Each vertex knows the source triangle it lies on, so any attribute of the source (position,
/// normal, texture coordinate, colour, skin weight) follows by interpolation: see
/// [`RefinedMesh::interpolate`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefinedMesh {
    /// Where each vertex lies on the source mesh.
    pub vertices: Vec<SurfacePoint>,
    /// Vertex indices, three a triangle, wound as the source triangle is.
    pub triangles: Vec<[u32; 3]>,
}

impl RefinedMesh {
    /// Carries an attribute of the source mesh over to the refined one.
    ///
    /// `value` is called with the source vertex indices of a triangle and the weights of the three.
    ///
    /// Weights are dyadic along split edges, and a vertex on an edge has weight exactly 0 for the
    /// corner opposite, so two triangles that share the edge compute the same bits.
    pub fn interpolate<T>(
        &self,
        source_triangles: &[[u32; 3]],
        mut value: impl FnMut([u32; 3], Vec3) -> T,
    ) -> Vec<T> {
        self.vertices
            .iter()
            .map(|p| value(source_triangles[p.triangle as usize], p.barycentrics))
            .collect()
    }
}

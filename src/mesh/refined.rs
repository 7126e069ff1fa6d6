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
        Self {
            triangle,
            barycentrics: Vec3::AXES[corner],
        }
    }

    /// The weights of the same point on the source triangle `triangle`, which may be another one
    /// that has the point's edge or corner.
    ///
    /// `None` if the point does not lie on that triangle, going by vertex indices.
    pub fn barycentrics_on(&self, triangle: u32, source_triangles: &[[u32; 3]]) -> Option<Vec3> {
        if self.triangle == triangle {
            return Some(self.barycentrics);
        }
        let from = source_triangles[self.triangle as usize];
        let to = source_triangles[triangle as usize];
        let mut weights = Vec3::ZERO;
        for (vertex, weight) in from.into_iter().zip(self.barycentrics.to_array()) {
            if weight != 0.0 {
                weights[to.iter().position(|&v| v == vertex)?] += weight;
            }
        }
        Some(weights)
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
    /// Which source triangle each triangle was cut out of.
    pub sources: Vec<u32>,
}

impl RefinedMesh {
    /// The vertices that `triangles` use, in their order, and no triangle yet; and the new index
    /// of each of the `vertex_count` source vertices.
    pub(crate) fn with_used_vertices(
        vertex_count: usize,
        triangles: &[[u32; 3]],
    ) -> (Self, Vec<Option<u32>>) {
        let mut first_use = vec![None; vertex_count];
        for (triangle, corners) in triangles.iter().enumerate() {
            for (corner, &vertex) in corners.iter().enumerate() {
                first_use[vertex as usize]
                    .get_or_insert_with(|| SurfacePoint::corner(triangle as u32, corner));
            }
        }
        let mut mesh = Self::default();
        let new_index = first_use
            .into_iter()
            .map(|point| point.map(|point| mesh.push_vertex(point)))
            .collect();
        (mesh, new_index)
    }

    pub(super) fn push_vertex(&mut self, point: SurfacePoint) -> u32 {
        self.vertices.push(point);
        (self.vertices.len() - 1) as u32
    }

    pub(crate) fn push_triangle(&mut self, source: u32, corners: [u32; 3]) {
        self.triangles.push(corners);
        self.sources.push(source);
    }

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

    /// The position of each vertex, in the unit of `source_positions`.
    ///
    /// Vertices on an edge get the same bits whichever of the edge's triangles they are told by,
    /// up to the sign of zero, also where the two meshes only have their positions in common.
    pub fn positions(&self, source_positions: &[Vec3], source_triangles: &[[u32; 3]]) -> Vec<Vec3> {
        self.interpolate(source_triangles, |corners, weights| {
            let [a, b, c] = corners.map(|vertex| source_positions[vertex as usize]);
            blend(a, b, c, weights)
        })
    }

    /// Composes two refinements: `finer` refines the triangles of `self`, which refines
    /// `source_triangles`. The vertices of the result lie on `source_triangles`.
    ///
    /// Weights stay exact as long as those of the two have 24 bits together.
    ///
    /// # Panics
    ///
    /// If the three do not belong together: an index is out of range, or a triangle of `self` has
    /// a vertex that is not on the triangle's source.
    pub fn then(&self, source_triangles: &[[u32; 3]], finer: &Self) -> Self {
        let vertices = finer.vertices.iter().map(|point| {
            let triangle = self.sources[point.triangle as usize];
            let corners = self.triangles[point.triangle as usize].map(|vertex| {
                self.vertices[vertex as usize]
                    .barycentrics_on(triangle, source_triangles)
                    .expect("a refined triangle's corners lie on its source triangle")
            });
            SurfacePoint {
                triangle,
                barycentrics: blend(corners[0], corners[1], corners[2], point.barycentrics),
            }
        });
        Self {
            vertices: vertices.collect(),
            triangles: finer.triangles.clone(),
            sources: (finer.sources.iter())
                .map(|&source| self.sources[source as usize])
                .collect(),
        }
    }
}

/// The weighted sum of three points. Where a weight is 0 the order of the other two does not
/// matter to a single bit, because addition of two floats commutes.
pub(super) fn blend(a: Vec3, b: Vec3, c: Vec3, weights: Vec3) -> Vec3 {
    a * weights.x + b * weights.y + c * weights.z
}

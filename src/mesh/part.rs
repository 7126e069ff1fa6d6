use glam::Vec3;

use super::refined::{RefinedMesh, SurfacePoint, blend};

/// A mesh that is refined together with others.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Of its vertices; finite.
    pub positions: &'a [Vec3],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// Whether its triangles may be cut at all.
    ///
    /// If not, nobody cuts the edges they have either. A mesh that others need not match is
    /// better left out: a face waits for ever if its longest edge may not be cut, and so do the
    /// neighbours that wait for that face.
    pub refine: bool,
}

/// Where a vertex of a refined part comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A vertex of the part as given.
    Given(u32),
    /// On the edge that was cut between two vertices of the refined part, the lower number first. Both
    /// are lower than its own.
    Between([u32; 2]),
}

/// One part, refined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// Used vertices of the part as given come first, in their order, then those between them in
    /// order of making. Triangles are in the order of their sources.
    pub mesh: RefinedMesh,
    /// Of each vertex.
    pub origins: Vec<Origin>,
}

/// A part as it grows: its vertices, and what tells where they are.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    /// The triangles as given, in numbers of used vertices.
    pub(super) triangles: Vec<[u32; 3]>,
    vertices: Vec<SurfacePoint>,
    origins: Vec<Origin>,
    pub(super) positions: Vec<Vec3>,
    pub(super) nodes: Vec<u32>,
}

impl Sheet {
    /// Without nodes.
    pub(super) fn new(part: &Part) -> Self {
        let (mesh, new_index) =
            RefinedMesh::with_used_vertices(part.positions.len(), part.triangles);
        let used = (0..).zip(&new_index).filter(|(_, new)| new.is_some());
        let corners = |corners: &[u32; 3]| {
            corners.map(|vertex| new_index[vertex as usize].unwrap_or_default())
        };
        Self {
            triangles: part.triangles.iter().map(corners).collect(),
            origins: used.map(|(given, _)| Origin::Given(given)).collect(),
            positions: mesh.positions(part.positions, part.triangles),
            vertices: mesh.vertices,
            nodes: Vec::new(),
        }
    }

    /// Where each vertex lies on the part.
    pub(super) fn points(&self) -> &[SurfacePoint] {
        &self.vertices
    }

    /// Where a point of the part is.
    pub(super) fn position(&self, point: SurfacePoint) -> Vec3 {
        let source = self.triangles[point.triangle as usize];
        let [a, b, c] = source.map(|vertex| self.positions[vertex as usize]);
        blend(a, b, c, point.barycentrics)
    }

    /// The number of the new vertex.
    pub(super) fn push_between(&mut self, ends: [u32; 2], point: SurfacePoint, node: u32) -> u32 {
        self.positions.push(self.position(point));
        self.vertices.push(point);
        self.origins.push(Origin::Between(ends));
        self.nodes.push(node);
        (self.vertices.len() - 1) as u32
    }

    /// The refined part, but for its triangles.
    pub(super) fn refined(&self) -> Refined {
        Refined::with_vertices(self.vertices.clone(), self.origins.clone())
    }

    /// The refined part, but for its triangles.
    pub(super) fn into_refined(self) -> Refined {
        Refined::with_vertices(self.vertices, self.origins)
    }
}

impl Refined {
    fn with_vertices(vertices: Vec<SurfacePoint>, origins: Vec<Origin>) -> Self {
        let mesh = RefinedMesh {
            vertices,
            ..RefinedMesh::default()
        };
        Self { mesh, origins }
    }
}

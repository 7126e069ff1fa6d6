use crate::mesh::RefinedMesh;

/// The base cut into small triangles, still where it was.
#[derive(Debug, Default)]
pub(super) struct Tessellated {
    /// Of each mesh given.
    pub(super) parts: Vec<RefinedMesh>,
    /// Vertices at one place.
    pub(super) twins: Twins,
}

/// Groups of vertices that are at one place, two or more each: those of texture seams, hard edges, and where
/// meshes meet. They are numbered through all parts.
#[derive(Debug, Default)]
pub(super) struct Twins {
    members: Vec<u32>,
    /// Behind the last member of each group.
    ends: Vec<usize>,
}

impl Tessellated {
    pub(super) fn vertex_count(&self) -> usize {
        self.parts.iter().map(|part| part.vertices.len()).sum()
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// The number of each part's first vertex.
    pub(super) fn first_vertices(&self) -> Vec<u32> {
        let mut next = 0;
        let first = |part: &RefinedMesh| {
            let first = next;
            next += part.vertices.len() as u32;
            first
        };
        self.parts.iter().map(first).collect()
    }
}

impl Twins {
    /// Adds a group if it is more than one vertex.
    pub(super) fn push(&mut self, members: impl IntoIterator<Item = u32>) {
        let before = self.members.len();
        self.members.extend(members);
        match self.members.len() - before {
            0 | 1 => self.members.truncate(before),
            _ => self.ends.push(self.members.len()),
        }
    }

    /// Groups `vertices`, given with the number of the place each is at.
    pub(super) fn of_places(mut vertices: Vec<(u32, u32)>) -> Self {
        let mut twins = Self::default();
        vertices.sort_unstable();
        for group in vertices.chunk_by(|a, b| a.0 == b.0) {
            twins.push(group.iter().map(|&(_, vertex)| vertex));
        }
        twins
    }

    pub(super) fn groups(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .map(|(start, &end)| &self.members[start..end])
    }
}

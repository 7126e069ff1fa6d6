use glam::{Vec2, Vec3};

use super::DisplacementError;

/// A mesh to be displaced. Meshes that are displaced together are one surface where their vertices meet.
#[derive(Clone, Copy, Debug, Default)]
pub struct Base<'a> {
    /// Of the vertices, in metres.
    pub positions: &'a [Vec3],
    /// Of the vertices, of any length; or none at all, and they are made from the faces.
    pub normals: &'a [Vec3],
    /// Where each vertex is on the map.
    pub uvs: &'a [Vec2],
    /// Vertex indices, counter-clockwise as seen from outside.
    pub triangles: &'a [[u32; 3]],
}

/// The largest coordinate of a position: products of two stay finite.
const FARTHEST: f32 = 1e15;

/// Everything that is used as a number or an index must be one.
pub(super) fn check(bases: &[Base]) -> Result<(), DisplacementError> {
    let triangles: u64 = bases.iter().map(|base| base.triangles.len() as u64).sum();
    let vertices: u64 = bases.iter().map(|base| base.positions.len() as u64).sum();
    if triangles.max(vertices) > u64::from(u32::MAX / 3) {
        return Err(DisplacementError::TooLarge(triangles));
    }
    (bases.iter().enumerate()).try_for_each(|(part, base)| base.check(part))
}

impl Base<'_> {
    fn check(&self, part: usize) -> Result<(), DisplacementError> {
        let vertices = self.positions.len();
        if self.uvs.is_empty() && vertices > 0 {
            return Err(DisplacementError::NoUvs { part });
        }
        let count = |what, found| match found == vertices {
            true => Ok(()),
            false => Err(DisplacementError::Count {
                part,
                vertices,
                what,
                found,
            }),
        };
        count("texture coordinates", self.uvs.len())?;
        if !self.normals.is_empty() {
            count("normals", self.normals.len())?;
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(DisplacementError::Index {
                    part,
                    triangle,
                    vertex,
                    count: vertices,
                });
            }
        }
        let near = |p: &Vec3| p.abs().max_element() <= FARTHEST && p.is_finite();
        let not_finite = |what, vertex: Option<usize>| match vertex {
            None => Ok(()),
            Some(vertex) => Err(DisplacementError::NotFinite { part, vertex, what }),
        };
        not_finite("position", self.positions.iter().position(|p| !near(p)))?;
        let uv = self.uvs.iter().position(|uv| !uv.is_finite());
        not_finite("texture coordinate", uv)
    }
}

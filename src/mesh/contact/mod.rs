//! Cuts meshes along the lines where they touch or cross.
//!
//! Light is discontinuous there: a block on a floor shades what is under it and not what is
//! beside it, and a vertex can tell only one of the two. So the floor gets vertices along the
//! outline of the block, one for either side.
//!
//! ```text
//!   ┌────────────┐      ┌────────────┐    a  feature edges close to a face: projected onto it
//!   │   ┌────┐   │      │\  ┌────┐  /│    b  faces that cross: both have the line
//!   │   │    │   │  ►   │ \ │\   │ / │    c  edges on edges: their ends are put in
//!   │   └────┘   │      │  \│ \  │/  │
//!   └────────────┘      └───┴──\─┴───┘
//! ```
//!
//! The triangles of all objects are one set (`Shape`), and edges are known by the positions of
//! their ends, so that texture seams, hard edges and objects do not tell them apart. `touch` finds
//! contacts between pairs of triangles, which `near` has found; faces with many are bisected
//! first (`crowded`); each triangle's segments are
//! `arrange`d so that they only meet at their ends; `edge_points` gathers what all triangles of an
//! edge want on it; `triangulate` cuts the triangles, and `sides` parts the vertices.

mod arrange;
mod crowded;
mod cut;
mod edge_points;
mod frame;
mod near;
mod shape;
mod sides;
#[cfg(test)]
mod tests;
mod touch;
mod triangulate;
mod weights;

use glam::Vec3;

use self::edge_points::EdgePoints;
use self::shape::Shape;
use self::touch::Contacts;
use super::refined::RefinedMesh;

/// A mesh that may touch or cross others, or itself.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Where its vertices are.
    pub positions: &'a [Vec3],
    /// Vertex indices, three a triangle.
    pub triangles: &'a [[u32; 3]],
    /// Whether its faces are cut.
    pub cut: bool,
    /// Whether it cuts others: what light passes does not.
    pub cuts: bool,
}

/// A mesh cut where others touch or cross it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutMesh {
    /// The same surface with vertices along the contacts.
    pub mesh: RefinedMesh,
    /// Of each vertex: which side of a contact it is on. Vertices at one place with different numbers
    /// lie on different sides; 0 away from contacts.
    pub sides: Vec<u32>,
}

/// What [`split_at_contacts`] made of the surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactCuts {
    /// Of each surface; `None` if no contact changes it.
    pub meshes: Vec<Option<CutMesh>>,
    /// Triangles left as they are because too many contacts lie on them.
    pub crowded: usize,
}

/// Cuts meshes along the lines where they touch or cross.
///
/// Surfaces that are at most `tolerance` apart count as touching, and triangles that are not
/// twice as long take no part. Points are put on an edge for all triangles that have it by
/// position, with the same weights, so that what had no cracks has none after.
///
/// `go_on` is asked now and then; `None` if it said no. Takes time in `O(n log n)` in the number
/// of triangles, unless most are close to most others.
///
/// # Panics
///
/// If a triangle has a vertex that does not exist.
pub fn split_at_contacts(
    surfaces: &[Surface],
    tolerance: f32,
    go_on: &dyn Fn() -> bool,
) -> Option<ContactCuts> {
    let shape = Shape::new(surfaces, tolerance);
    let contacts = touch::find(&shape, go_on)?;
    let Some(finer) = crowded::bisect(&shape, &contacts, surfaces) else {
        return cut_at_contacts(surfaces, &shape, contacts, go_on);
    };
    let finer: Vec<Finer> = (finer.into_iter().zip(surfaces))
        .map(|(mesh, surface)| Finer::new(mesh, surface))
        .collect();
    let bisected: Vec<Surface> = (finer.iter().zip(surfaces))
        .map(|(finer, surface)| finer.surface(surface))
        .collect();
    let shape = Shape::new(&bisected, tolerance);
    let contacts = touch::find(&shape, go_on)?;
    let cuts = cut_at_contacts(&bisected, &shape, contacts, go_on)?;
    let together = (finer.into_iter().zip(surfaces).zip(cuts.meshes))
        .map(|((finer, surface), cut)| finer.then(surface, cut));
    Some(ContactCuts {
        meshes: together.collect(),
        crowded: cuts.crowded,
    })
}

/// A surface bisected, or as it was.
struct Finer {
    mesh: Option<RefinedMesh>,
    positions: Vec<Vec3>,
}

impl Finer {
    fn new(mesh: Option<RefinedMesh>, surface: &Surface) -> Self {
        let positions = mesh.as_ref().map_or_else(Vec::new, |mesh| {
            mesh.positions(surface.positions, surface.triangles)
        });
        Self { mesh, positions }
    }

    fn surface<'a>(&'a self, given: &Surface<'a>) -> Surface<'a> {
        match &self.mesh {
            None => *given,
            Some(mesh) => Surface {
                positions: &self.positions,
                triangles: &mesh.triangles,
                ..*given
            },
        }
    }

    /// Bisected and then cut, of the surface as given.
    fn then(self, given: &Surface, cut: Option<CutMesh>) -> Option<CutMesh> {
        let Some(mesh) = self.mesh else {
            return cut;
        };
        Some(match cut {
            Some(CutMesh { mesh: cut, sides }) => CutMesh {
                mesh: mesh.then(given.triangles, &cut),
                sides,
            },
            None => CutMesh {
                sides: vec![0; mesh.vertices.len()],
                mesh,
            },
        })
    }
}

/// Cuts faces along the contacts found.
fn cut_at_contacts(
    surfaces: &[Surface],
    shape: &Shape,
    contacts: Contacts,
    go_on: &dyn Fn() -> bool,
) -> Option<ContactCuts> {
    let arranged = arrange::all(shape, contacts, go_on)?;
    let edge_points = EdgePoints::new(shape, arranged.on_edges);
    let mut meshes = Vec::with_capacity(surfaces.len());
    let mut nodes = edge_points.nodes_end();
    for (object, surface) in surfaces.iter().enumerate() {
        if !go_on() {
            return None;
        }
        let mesh = (surface.cut)
            .then(|| cut::object(shape, object, &edge_points, &arranged.on_faces, &mut nodes))
            .and_then(|pieces| sides::part(shape, object, surface, pieces, &mut nodes));
        meshes.push(mesh);
    }
    Some(ContactCuts {
        meshes,
        crowded: arranged.crowded,
    })
}

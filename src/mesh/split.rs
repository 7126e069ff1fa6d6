use std::collections::HashMap;
use std::fmt;

use glam::Vec3;

use super::refined::{RefinedMesh, SurfacePoint, blend};

/// How often a triangle may be split. Weights are multiples of 2^-depth, which an `f32` holds
/// exactly up to here. 2²⁴ pieces an edge are beyond any sensible mesh.
const MAX_DEPTH: u32 = 24;

/// Why [`split_long_edges`] refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplitError {
    /// The maximum edge length is not a positive number.
    InvalidMaxEdge(f32),
    /// The refined mesh would be too large.
    TooManyVertices {
        /// How many vertices were allowed.
        limit: usize,
        /// The maximum edge length that was asked for, in metres.
        max_edge: f32,
    },
    /// The maximum edge length is below what `f32` positions of this size can resolve.
    TooFine {
        /// The maximum edge length that was asked for, in metres.
        max_edge: f32,
    },
}

impl fmt::Display for SplitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InvalidMaxEdge(max_edge) => {
                write!(
                    f,
                    "the maximum edge length has to be positive, not {max_edge}"
                )
            }
            Self::TooManyVertices { limit, max_edge } => write!(
                f,
                "splitting edges longer than {max_edge} m takes more than {limit} vertices; \
                 choose a larger maximum edge length"
            ),
            Self::TooFine { max_edge } => write!(
                f,
                "edges cannot be split down to {max_edge} m with 32-bit coordinates; \
                 choose a larger maximum edge length"
            ),
        }
    }
}

impl std::error::Error for SplitError {}

/// Bisects edges until none is longer than `max_edge` metres.
///
/// The vertices that `triangles` use come first, in their order, with the midpoints behind;
/// vertices that no triangle uses are dropped. Midpoints are shared by the triangles that share
/// both ends of the edge. The pieces of a triangle follow each other, in the order of the source.
///
/// Whether an edge is split depends on the positions of its ends alone, so two triangles split a
/// common edge alike, even if they belong to different meshes: see the [module](super) for the
/// method and what it does to angles. Lengths are those between [`RefinedMesh::positions`].
///
/// A mesh without long edges comes back as it is, whatever `max_vertices` says. Takes time linear
/// in the size of the result. Positions have to be finite.
///
/// # Errors
///
/// [`SplitError::InvalidMaxEdge`] if `max_edge` is not finite and positive,
/// [`SplitError::TooManyVertices`] as soon as splitting takes more than `max_vertices`, and
/// [`SplitError::TooFine`] if it does not come to an end.
///
/// # Panics
///
/// If a triangle has a vertex that does not exist.
pub fn split_long_edges(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    max_edge: f32,
    max_vertices: usize,
) -> Result<RefinedMesh, SplitError> {
    if !(max_edge.is_finite() && max_edge > 0.0) {
        return Err(SplitError::InvalidMaxEdge(max_edge));
    }
    if fewest_vertices(positions, triangles, max_edge) > max_vertices as f64 {
        return Err(SplitError::TooManyVertices {
            limit: max_vertices,
            max_edge,
        });
    }
    let (mesh, new_index) = RefinedMesh::with_used_vertices(positions.len(), triangles);
    let mut splitter = Splitter {
        max_edge,
        max_vertices: max_vertices.min(u32::MAX as usize),
        positions: mesh.positions(positions, triangles),
        mesh,
        midpoints: HashMap::new(),
    };
    for (source, corners) in triangles.iter().enumerate() {
        let vertices = corners.map(|vertex| new_index[vertex as usize].unwrap_or_default());
        splitter.split(source as u32, vertices)?;
    }
    Ok(splitter.mesh)
}

/// A number of vertices that splitting edges longer than `max_edge` is sure to exceed, known before
/// it starts; 0 for a mesh without long edges.
///
/// A triangle whose edges are at most `L` long has at most the area `√3/4 L²` of an equilateral
/// one, and a mesh has at least a quarter as many vertices as triangles (half as many if closed).
pub fn fewest_vertices(positions: &[Vec3], triangles: &[[u32; 3]], max_edge: f32) -> f64 {
    let largest = 0.25 * 3.0_f64.sqrt() * f64::from(max_edge).powi(2);
    let pieces = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|vertex| positions[vertex as usize].as_dvec3());
        let pieces = 0.5 * (b - a).cross(c - a).length() / largest;
        if pieces > 1.0 { pieces } else { 0.0 }
    };
    0.25 * triangles.iter().map(pieces).sum::<f64>()
}

struct Splitter {
    max_edge: f32,
    max_vertices: usize,
    mesh: RefinedMesh,
    /// Of the vertices of `mesh`.
    positions: Vec<Vec3>,
    /// By the ends of the edge, the lower one first.
    midpoints: HashMap<[u32; 2], u32>,
}

/// A corner of a piece of the source triangle at hand.
#[derive(Clone, Copy)]
struct Corner {
    vertex: u32,
    /// On the source triangle at hand, where the vertex itself may be known by a neighbour.
    barycentrics: Vec3,
}

/// The source triangle at hand.
struct Source {
    triangle: u32,
    positions: [Vec3; 3],
}

type Piece = [Corner; 3];

impl Splitter {
    fn split(&mut self, triangle: u32, vertices: [u32; 3]) -> Result<(), SplitError> {
        let source = Source {
            triangle,
            positions: vertices.map(|vertex| self.positions[vertex as usize]),
        };
        let whole = [0, 1, 2].map(|i| Corner {
            vertex: vertices[i],
            barycentrics: Vec3::AXES[i],
        });
        let mut stack = vec![(whole, 0)];
        while let Some((piece, depth)) = stack.pop() {
            let [a, b, c] = piece;
            let marked = [self.is_long(a, b), self.is_long(b, c), self.is_long(c, a)];
            if marked == [false; 3] {
                self.mesh
                    .push_triangle(triangle, piece.map(|corner| corner.vertex));
                continue;
            }
            if depth == MAX_DEPTH {
                let max_edge = self.max_edge;
                return Err(SplitError::TooFine { max_edge });
            }
            self.cut(&source, piece, marked, |part| stack.push((part, depth + 1)))?;
        }
        Ok(())
    }

    /// Cuts a piece at the midpoints of its marked edges (ab, bc, ca), at least one: the
    /// templates drawn in the module's documentation.
    fn cut(
        &mut self,
        source: &Source,
        piece: Piece,
        marked: [bool; 3],
        mut part: impl FnMut(Piece),
    ) -> Result<(), SplitError> {
        match marked.iter().filter(|&&m| m).count() {
            1 => {
                let first = marked.iter().position(|&m| m).unwrap_or_default();
                let [a, b, c] = turn(piece, first);
                let m = self.midpoint(source, a, b)?;
                part([a, m, c]);
                part([m, b, c]);
            }
            2 => {
                // The tip a lies between the two marked edges, opposite the one that is not.
                let unmarked = marked.iter().position(|&m| !m).unwrap_or_default();
                let [a, b, c] = turn(piece, unmarked + 2);
                let m = self.midpoint(source, a, b)?;
                let n = self.midpoint(source, c, a)?;
                part([a, m, n]);
                if self.is_first_diagonal_shorter([m, c], [b, n]) {
                    part([m, b, c]);
                    part([m, c, n]);
                } else {
                    part([m, b, n]);
                    part([b, c, n]);
                }
            }
            _ => {
                let [a, b, c] = piece;
                let m = self.midpoint(source, a, b)?;
                let o = self.midpoint(source, b, c)?;
                let n = self.midpoint(source, c, a)?;
                part([a, m, n]);
                part([m, b, o]);
                part([n, o, c]);
                part([m, o, n]);
            }
        }
        Ok(())
    }

    fn is_long(&self, a: Corner, b: Corner) -> bool {
        // In f64 squares neither overflow nor vanish. A difference and its negative have the same
        // square, so the answer does not depend on the edge's direction.
        self.distance_squared(a, b) > f64::from(self.max_edge) * f64::from(self.max_edge)
    }

    fn distance_squared(&self, a: Corner, b: Corner) -> f64 {
        let [a, b] = [a, b].map(|corner| self.positions[corner.vertex as usize].as_dvec3());
        a.distance_squared(b)
    }

    /// Diagonals are inside a triangle, so no neighbour has to agree; ties go to the diagonal
    /// with the lowest vertex, for the same result on every run.
    fn is_first_diagonal_shorter(&self, first: [Corner; 2], second: [Corner; 2]) -> bool {
        let lowest = |[a, b]: [Corner; 2]| a.vertex.min(b.vertex);
        let length = |[a, b]: [Corner; 2]| self.distance_squared(a, b);
        match length(first).total_cmp(&length(second)) {
            std::cmp::Ordering::Equal => lowest(first) < lowest(second),
            order => order.is_lt(),
        }
    }

    fn midpoint(&mut self, source: &Source, a: Corner, b: Corner) -> Result<Corner, SplitError> {
        let barycentrics = 0.5 * (a.barycentrics + b.barycentrics);
        let edge = [a.vertex.min(b.vertex), a.vertex.max(b.vertex)];
        if let Some(&vertex) = self.midpoints.get(&edge) {
            return Ok(Corner {
                vertex,
                barycentrics,
            });
        }
        if self.mesh.vertices.len() >= self.max_vertices {
            return Err(SplitError::TooManyVertices {
                limit: self.max_vertices,
                max_edge: self.max_edge,
            });
        }
        let vertex = self.mesh.push_vertex(SurfacePoint {
            triangle: source.triangle,
            barycentrics,
        });
        let [p, q, r] = source.positions;
        self.positions.push(blend(p, q, r, barycentrics));
        self.midpoints.insert(edge, vertex);
        Ok(Corner {
            vertex,
            barycentrics,
        })
    }
}

/// The same piece, told from its corner `first` on, counted round.
fn turn(piece: Piece, first: usize) -> Piece {
    [0, 1, 2].map(|i| piece[(first + i) % 3])
}

#[cfg(test)]
#[path = "split_test.rs"]
mod tests;

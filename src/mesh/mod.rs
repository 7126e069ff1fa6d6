//! Meshes as pure geometry: refinement that keeps shared edges together, position classes.
//!
//! Light baked into vertices is only as fine as the vertices are. [`split_long_edges`] puts more
//! of them in, and must not tear the surface: where one triangle has a vertex on an edge and its
//! neighbour has none (a T-junction), the two interpolate different light along it and a crack
//! shows.
//!
//! So edges decide, not triangles: an edge longer than the limit is bisected, and whether it is
//! follows from its two end positions alone. Every triangle that has the edge then finds the same
//! points on it, down to the bit, though the triangles may be of different meshes and share no
//! vertex index. A triangle is cut to match the edges that are marked, and its parts go round
//! again:
//!
//! ```text
//!   one: 2 parts        two: 3 parts         three: 4 parts
//!
//!         c                   a                    c
//!        /|\                 / \                  / \
//!       / | \               m---n                n---o
//!      /  |  \             /  .' \              / \ / \
//!     a---m---b           b-------c            a---m---b
//! ```
//!
//! Of the two diagonals in the middle picture the shorter is taken. It is the median to the
//! longest edge, so the first two templates are one and two steps of longest-edge bisection, and
//! the third makes four copies of the triangle at half the size. Longest-edge bisection, however
//! often, leaves no angle below half the smallest at the start (I. Rosenberg and F. Stenger, "A
//! lower bound on the angles of triangles constructed by bisection of the longest side",
//! Mathematics of Computation 29, 1975): thin triangles get no thinner than that.
//!
//! [`split_long_edges`] is the same everywhere. [`Conforming`] cuts the faces that are asked for,
//! of several meshes at once, and as few others as keep edges together. It cuts a face at its
//! longest edge only, so the bound on angles holds for every face. The other faces at that edge
//! have to be cut with it, and where it is not their longest they have to be bisected first, at
//! an edge longer still (M.-C. Rivara, "Algorithms for refining triangular grids suitable for
//! adaptive and multigrid techniques", International Journal for Numerical Methods in Engineering
//! 20, 1984; "New longest-edge algorithms for the refinement and/or improvement of unstructured
//! triangulations", the same 40, 1997):
//!
//! ```text
//!   A is asked for,      B and C are cut      A and a half of B
//!   B has a longer       at the longest       are cut at what is
//!   edge                 edge of both         now longest for both
//!
//!   +-------+            +-------+            +-------+
//!   | C   / |\           | \   / |\           | \   / |\
//!   |   /   | A>         |   x   | A>         |   x---x->
//!   | /   B |/           | /   \ |/           | /   \ |/
//!   +-------+            +-------+            +-------+
//! ```
//!
//! Edges on such a path get longer and longer, so it ends, and mostly after two or three faces:
//! the sizes of neighbours cannot differ by much, because a face with a small neighbour at its
//! longest edge would have been cut with it. So a fine spot is surrounded by faces that grow with
//! the distance to it, and what the spot costs outside grows with the logarithm of its fineness.
//!
//! [`Conforming::cut_edge`] cuts one edge where it is asked for, and whatever faces have it: for lines that
//! edges are to follow, such as those of shadows. It asks nothing of angles.
//!
//! [`split_flat_corners`] is for meshes without normals, and comes before the splitting of edges;
//! [`RefinedMesh::then`] makes one refinement of the two. [`PositionClasses`] finds the vertices
//! that are one point of the surface.
//!
//! [`project_uvs`] lays texture coordinates on meshes that have none, for textures and height maps to have a
//! place.
//!
//! Nothing here knows about materials, light or files.

mod conforming;
mod contact;
mod edge_rings;
mod flat;
mod part;
mod refined;
mod split;
#[cfg(test)]
pub(crate) mod test_meshes;
mod uv_projection;
#[cfg(test)]
mod uv_projection_test;
mod weld;

pub use conforming::{Bisected, Bisection, Conforming, Limits};
pub use contact::{ContactCuts, CutMesh, Surface, split_at_contacts};
pub use flat::split_flat_corners;
pub use part::{Origin, Part, Refined};
pub use refined::{RefinedMesh, SurfacePoint};
pub use split::{SplitError, fewest_vertices, split_long_edges};
pub use uv_projection::{UvError, UvMesh, UvProjection, UvSettings, project_uvs};
pub use weld::PositionClasses;

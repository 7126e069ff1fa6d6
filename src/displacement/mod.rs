//! Displacement: real relief from a height map (R. L. Cook, "Shade trees", SIGGRAPH 1984).
//!
//! # The surface
//!
//! On a triangle of the base the position `P` and the direction `D` are linear between the corners, and `F`
//! is the height by the map, in metres. The raised surface is
//!
//! ```text
//!   ┌──────────────┐
//!   │  S = P + F D  │         F = scale × (map(u, v) − mid level)
//!   └──────────────┘
//! ```
//!
//! `P` and `D` belong to *places*: vertices within a few roundings of each other are one, whatever their
//! normals and texture coordinates. So `S` has no gap at hard edges, texture seams and mirrored charts, as
//! long as `F` has none; and where charts do not fit, a place takes the mean of what they say. `D` is not made
//! to length 1 between the corners: a map of one grey moves the base without bending it.
//!
//! # Its normal
//!
//! Let `N` be the normal of the base, interpolated and of length 1, `a` and `b` two steps along it with
//! `a × b = N`, `∇F = Fu ∇u + Fv ∇v` the surface gradient, and `W` how the direction changes by a step: all that
//! tells the base's curvature. Steps on the raised surface and its normal are
//!
//! ```text
//!                                            ┌────────────────┐
//!   Sa = a + F W a + (∇F · a) D       n  ∝   │     Sa × Sb      │
//!   Sb = b + F W b + (∇F · b) D              └────────────────┘
//! ```
//!
//! `∇u`, `∇v` and `W` of a vertex are means over the triangles around it, so that nothing of the base's
//! facets shows. With `F W` left out this is Blinn's bump mapping. Along `N` the surface is `1 + Fκ` times as
//! long as the base, where κ are the eigenvalues of `W`; where that is not above 0 it has folded through
//! itself.
//!
//! # Where vertices are put
//!
//! ```text
//!                    ┌── uniform: edges into pieces of a texel, triangles filled ──┐
//!   bases ─ Surface ─┤                                                              ├─ raise ─► Displaced
//!                    └── adaptive: bisect while S is too far from the faces ────────┘
//! ```
//!
//! Both decide about edges by what belongs to the edge, so that all triangles at it agree and there are no
//! T-junctions: evenly by the most pieces that any of them wants ([`Tessellation::Uniform`]), or by bisecting
//! all of them together ([`Conforming`](crate::mesh::Conforming), as radiosity does).
//!
//! | file | what it does |
//! |---|---|
//! | `displace` | the pipeline as drawn |
//! | `settings`, `base`, `error`, `report` | what goes in and what comes out |
//! | `surface` | the meshes welded into one surface |
//! | `direction`, `normals`, `frame`, `corner` | `D`; `N`; `∇u`, `∇v`, `W` and the normal; corners and their angles |
//! | `heights` | `F` |
//! | `sides` | triangles that meet at edges, and which edges are seams |
//! | `uniform`, `lattice` | even tessellation: numbers along edges, and a triangle cut to fit them |
//! | `adaptive`, `deviation` | bisection to a tolerance, and how far the surface is from a face |
//! | `tessellated` | what both kinds of tessellation make |
//! | `raise` | heights, positions and normals of all vertices |
//! | `tangent` | tangents of the base on the raised surface |

mod adaptive;
mod base;
mod corner;
mod deviation;
mod direction;
mod displace;
mod error;
mod frame;
mod heights;
mod lattice;
mod normals;
mod raise;
mod report;
mod settings;
mod sides;
mod surface;
mod tangent;
mod tessellated;
mod uniform;

pub use base::Base;
pub use displace::{Displaced, DisplacedPart, Watch, displace};
pub use error::DisplacementError;
pub use report::{Bounds, DisplacementReport, Stop};
pub use settings::{Direction, DisplacementSettings, Spacing, Tessellation, result_bytes};
pub use tangent::raised_tangent;

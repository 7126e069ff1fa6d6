//! Meshes refined by the light: vertices where linear light between them would be wrong, and only
//! there.
//!
//! Light is asked for at points inside each face, and what of it no linear light on the face can
//! follow is the face's share of the error ([`face`]). The worst faces are bisected, and whatever has
//! to go with them so that no crack opens ([`Conforming`]); halves inherit the points that lie on
//! them. Then the new faces are judged, until the error asked for is reached or there are as many
//! vertices as there may be.
//!
//! ```text
//!   ┌─► ask at points ─► (misfit + strain) × area ─► the worst faces together ─┐
//!   └────────────── bisect, or cut along the step ◄────────────────────────────┘
//! ```
//!
//! A face has to meet the light of its neighbours at the corners, too: that is its strain. Else a
//! shadow that ends where faces do would never be seen.
//!
//! Bisection alone follows the edge of a hard shadow with the square root of the number of vertices,
//! because the jump takes a triangle's width and each halving of that width takes twice as many. Where
//! light steps from one level to another across a face ([`step`]), the face is cut along the step, at
//! both of its ends: two rows of vertices, as near to each other as the step is steep. So were shadows
//! meshed by those who knew their edges from geometry (Lischinski, Tampieri and Greenberg 1992,
//! "Discontinuity meshing for accurate radiosity"); here the light itself tells where they are,
//! whatever throws them.
//!
//! That all faces end up with a like share of the error is what makes the mesh the cheapest for it
//! (Dörfler 1996, "A convergent adaptive algorithm for Poisson's equation", marks like this).
//!
//! Where faces are many and small, a few of them are judged in the place of all ([`scouts`]).
//!
//! It is done twice: for the smooth light that rays gather, which few vertices can carry, and inside
//! that mesh for light with sharp edges, whose shadow rays are cheap.
//!
//! | file | |
//! |---|---|
//! | `drive` | the two refinements of a scene, one inside the other |
//! | `work` | one of them: meshes, what is known of their faces, rounds |
//! | `judging`, `face`, `scouts` | what linear light on each face leaves out |
//! | `probe` | light asked for at points |
//! | `cutting`, `step` | the worst faces bisected, or cut along a step of light |
//! | `refinement` | what comes of it |
//! | `control` | how far off the light is that was put on it |

mod control;
mod cutting;
mod drive;
mod face;
mod judging;
mod probe;
mod refinement;
mod scouts;
mod step;
mod work;

pub(crate) use control::{Control, Found};
pub(crate) use drive::{Asked, Refiner};
pub(crate) use refinement::Refinement;

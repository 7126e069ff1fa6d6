//! Displacement, held to the failure modes that other implementations have.
//!
//! | file | failure modes |
//! |---|---|
//! | `watertight` | 20 cracks, 21 T-junctions, 22 smeared texture coordinates |
//! | `accuracy` | 23 positions, 25 normals, 28 bounds, 30 mid-level and wrap |
//! | `adaptive` | 24 triangles where they are needed, 26 thin pieces, and 20 and 29 of adaptive meshes |
//! | `robust` | 27 folds, 29 budgets and broken input |
//! | `meshes`, `measure` | what is displaced, and how far it is off |

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod accuracy;
mod adaptive;
mod measure;
mod meshes;
mod robust;
mod watertight;

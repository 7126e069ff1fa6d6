//! The radiosity system `R = ρ (D + F R)`, solved.
//!
//! `D` is the direct light at each element, `F` the form factors, `R` the light reflected. Bounce
//! by bounce, `R = ρ D + ρ F ρ D + …` is a solution already; in a bright room it takes hundreds of
//! them. Solvers differ in how they get there sooner.
//!
//! ```text
//!        ┌────────────────────────── one step ◄───────────────────────────┐
//!        ▼                                                                │ no
//!   state: what arrives, residual ─► bound on the error ─► small enough? ─┤
//!                                                                         │ yes, or out of sweeps
//!   residual grows three times: Gauss–Seidel takes over                   ▼ the best so far
//! ```
//!
//! | file | |
//! |---|---|
//! | `method` | the solvers to choose from |
//! | `system` | the system, the state of light, and the bound that holds for all |
//! | `drive` | the loop that all share |
//! | `relaxation` | Jacobi, Gauss–Seidel, over-relaxation, the mean field |
//! | `progressive`, `columns`, `largest` | shooting, the largest first |
//! | `conjugate_gradients`, `symmetric` | the system symmetrised, and solved so |
//! | `glimpse` | light on its way, to look at |

mod columns;
mod conjugate_gradients;
mod drive;
#[cfg(test)]
mod enclosure;
mod glimpse;
mod largest;
mod method;
mod progressive;
mod relaxation;
#[cfg(test)]
mod solve_test;
mod symmetric;
mod system;

pub(crate) use drive::{Solution, solve};
pub(crate) use glimpse::{Glimpse, Watch};
pub use method::Solver;
pub(crate) use system::System;

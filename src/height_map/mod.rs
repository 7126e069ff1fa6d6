//! Height maps: grey images that say how far a surface stands out, and how steep it is between
//! their texels.
//!
//! A map is a function `F(u, v)` over texture coordinates, known at the centres of texels. Relief
//! is shaded by its slopes, so what counts is how these are found ([`Kernel`]). Blinn took
//! differences of neighbouring values (J. F. Blinn, "Simulation of wrinkled surfaces", SIGGRAPH
//! 1978, section 4):
//!
//! ```text
//!   ┌──────────────────────────────────────────────┐
//!   │  F_u = (F(u + ε, v) − F(u − ε, v)) / 2ε       │     ε: half a texel, or one
//!   └──────────────────────────────────────────────┘
//! ```
//!
//! with `F` linear between texels. That has two faults when a map is magnified: with ε small, slopes
//! are constant within a texel and jump at its border, so that facets show; with one-sided differences
//! relief moves by half of ε. Kernels that are smooth themselves have neither: their slope is the slope
//! of a curve through the texels ([`Kernel::CatmullRom`]) or past them ([`Kernel::BSpline`]).
//!
//! | file | what it does |
//! |---|---|
//! | `map` | the map: texels, how it goes on beyond its border, errors |
//! | `kernel` | heights and slopes between texels |
//! | `pyramid` | smaller and smaller, with what slopes vary by |

mod kernel;
#[cfg(test)]
mod kernel_test;
mod map;
mod pyramid;

pub use kernel::{Kernel, Relief};
pub use map::{HeightMap, HeightMapError, Wrap};
pub use pyramid::{Level, Moments, Pyramid};

//! Bump mapping: normals of a surface that a height map would raise, without raising it
//! (J. F. Blinn, "Simulation of wrinkled surfaces", SIGGRAPH 1978).
//!
//! # Blinn's formula
//!
//! A surface `P(u, v)` with the normal `n = Pu × Pv` is raised by `F(u, v)` along it:
//! `P' = P + F n/|n|`. Its tangents are
//!
//! ```text
//!   Pu' = Pu + Fu n/|n| + F (n/|n|)u          Pv' likewise,
//! ```
//!
//! the last term of which is small where relief is low beside the radius of curvature, and left out. Then
//!
//! ```text
//!                     ┌──────────────────────────────────────────┐
//!   n' = Pu' × Pv' =  │  n + (Fu (n × Pv) − Fv (n × Pu)) / |n|    │
//!                     └──────────────────────────────────────────┘
//! ```
//!
//! # The same without texture coordinates
//!
//! Divided by `|n|`, with `N` the unit normal, this is `N − ∇F`, where the *surface gradient*
//!
//! ```text
//!   ∇F = (Fu (Pv × N) + Fv (N × Pu)) / (N · Pu × Pv)
//! ```
//!
//! lies in the surface and says how steep the relief is in metres a metre (M. S. Mikkelsen, "Surface
//! gradient-based bump mapping framework", JCGT 9(3), 2020). It depends on no parametrisation: let `a`
//! and `b` be any two steps along the surface, and `Fa`, `Fb` how much the height changes along them.
//! Then
//!
//! ```text
//!         ┌──────────────────────────────────────────────────┐
//!   ∇F =  │  (Fa (b × N) + Fb (N × a)) / (N · a × b)          │
//!         └──────────────────────────────────────────────────┘
//! ```
//!
//! With the edges of a triangle as steps, this is the gradient *per triangle*; with the derivatives of the
//! position to the next pixels, that *on the screen*. Neither divides by the area that the triangle has in
//! texture coordinates, which may be nothing or, where textures are mirrored, negative. Gradients add up:
//! so do several bumps.
//!
//! # With the last term
//!
//! Where relief is not low, [`displaced_normal`] keeps it: the steps are then those of the raised surface,
//! `a + F dN_a + Fa N`, with `dN_a` the change of the normal along `a`.
//!
//! | file | what it does |
//! |---|---|
//! | `gradient` | gradients per triangle or from any two steps, and normals from them |
//! | `vertices` | gradients of texture coordinates at the vertices of a mesh |
//! | `roughness` | what slopes too small to be seen do to highlights |
//! | `parallax` | where a ray of sight meets the relief |
//! | `blinn` | the formula as it stands above, for comparison |
//!
//! The shader does the same (`src/plugin/bump/bump.wgsl` and `parallax.wgsl`); tests compare the two.

mod blinn;
mod gradient;
#[cfg(test)]
mod gradient_test;
#[cfg(test)]
mod normal_map_test;
mod parallax;
#[cfg(test)]
mod parallax_test;
mod roughness;
mod vertices;

pub use blinn::blinn_normal;
pub use gradient::{
    MAX_SLOPE, Steps, bumped_normal, displaced_normal, surface_gradient, uv_gradients,
};
pub use parallax::{ParallaxHit, ParallaxMap, ParallaxRay, parallax_slide};
pub use roughness::{roughened, slope_variance};
pub use vertices::vertex_uv_gradients;

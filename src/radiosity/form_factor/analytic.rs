use crate::radiosity::observer::Observer;
use crate::radiosity::parallel::Cancelled;

use super::View;
use super::pairs::{self, Pairwise};
use super::patch::Patch;
use super::traced::Traced;

/// Form factors in closed form, times the visible share.
///
/// ```text
///   ┌────────────────────────────────────────────────────┐
///   │  F_ij ≈ F_ij^open · Σ_s k_s V_s / Σ_s k_s           │     k = cos cos / π r²
///   └────────────────────────────────────────────────────┘
/// ```
///
/// A shadow ray `V_s` weighs as much as the pair of points it connects brings of the form factor:
/// where elements are near each other, those that face each other closely decide. So the kernel's
/// poles, which ruin a sum of kernels, cancel here, and what is all visible is exact.
pub(super) struct Analytic<'a> {
    view: View<'a>,
    visibility_rays: u32,
    patches: Vec<Patch>,
}

/// Pairs of points tried for each shadow ray, and at least: points of elements that see a part of
/// each other only need not see each other.
const TRIES: usize = 4;
const LEAST_TRIES: usize = 16;

impl<'a> Analytic<'a> {
    pub(super) fn new(view: View<'a>, visibility_rays: u32) -> Self {
        let patch = |e| Patch::of(view.scene, view.elements, e);
        Self {
            view,
            visibility_rays,
            patches: (0..view.elements.len()).map(patch).collect(),
        }
    }

    /// The form factor from element `i` to element `j`.
    pub(super) fn form_factor(&self, i: usize, j: usize) -> f64 {
        pairs::form_factor(self, i, j)
    }

    /// The visible share of what two elements would exchange, and the rays that took.
    fn visible(&self, i: usize, j: usize) -> (f64, u32) {
        let rays = self.visibility_rays as usize;
        let (mut seen, mut all, mut traced) = (0.0, 0.0, 0);
        let connections = self.view.connections(i, j);
        let facing = connections
            .take(LEAST_TRIES.max(TRIES * rays))
            .filter(|c| c.kernel > 0.0);
        for connection in facing.take(rays) {
            seen += connection.kernel * self.view.passing(&connection);
            all += connection.kernel;
            traced += 1;
        }
        (if all > 0.0 { seen / all } else { 0.0 }, traced)
    }
}

impl Pairwise for Analytic<'_> {
    fn view(&self) -> &View<'_> {
        &self.view
    }

    fn exchange(&self, i: usize, j: usize) -> (f64, u32) {
        let (a, b) = (&self.patches[i], &self.patches[j]);
        if !a.may_see(b) {
            return (0.0, 0);
        }
        // Rays first: of what is hidden, the closed form is not needed.
        let (visible, rays) = self.visible(i, j);
        if visible == 0.0 {
            return (0.0, rays);
        }
        let open = if i == j {
            a.exchange_within()
        } else {
            a.exchange(b)
        };
        (open * visible, rays)
    }
}

/// The whole matrix.
pub(super) fn trace(
    view: &View,
    visibility_rays: u32,
    observer: &dyn Observer,
) -> Result<(Traced, u64), Cancelled> {
    pairs::matrix(&Analytic::new(*view, visibility_rays), observer)
}

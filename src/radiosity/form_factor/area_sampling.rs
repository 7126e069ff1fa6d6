use crate::radiosity::observer::Observer;
use crate::radiosity::parallel::Cancelled;

use super::View;
use super::pairs::{self, Pairwise};
use super::traced::Traced;

/// Form factors as sums over pairs of points.
///
/// ```text
///   A_i F_ij = ∫∫ V cos θ cos θ' / π r² dA dA'
///   ┌───────────────────────────────────────────────────┐
///   │  F_ij ≈ A_j / S Σ_s V_s cos θ_s cos θ'_s / π r_s²  │
///   └───────────────────────────────────────────────────┘
/// ```
///
/// Where elements touch, the kernel has a pole and the sum an unbounded variance: some rows come
/// out far above 1. That is the method's nature, and the report tells of it.
pub(super) struct AreaSampling<'a> {
    view: View<'a>,
    samples: u32,
}

impl<'a> AreaSampling<'a> {
    pub(super) fn new(view: View<'a>, samples: u32) -> Self {
        Self { view, samples }
    }
}

impl Pairwise for AreaSampling<'_> {
    fn view(&self) -> &View<'_> {
        &self.view
    }

    fn exchange(&self, i: usize, j: usize) -> (f64, u32) {
        let (mut sum, mut rays) = (0.0, 0);
        let connections = self.view.connections(i, j).take(self.samples as usize);
        for connection in connections.filter(|c| c.kernel > 0.0) {
            sum += connection.kernel * self.view.passing(&connection);
            rays += 1;
        }
        let whole = pairs::whole_area(&self.view, i) * pairs::whole_area(&self.view, j);
        (sum / f64::from(self.samples) * whole, rays)
    }
}

/// The whole matrix.
pub(super) fn trace(
    view: &View,
    samples: u32,
    observer: &dyn Observer,
) -> Result<(Traced, u64), Cancelled> {
    pairs::matrix(&AreaSampling::new(*view, samples), observer)
}

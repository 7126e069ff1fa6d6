use glam::{DVec3, Vec3A};

use crate::radiosity::color::divide;
use crate::radiosity::parallel::Cancelled;

use super::drive::Method;
use super::glimpse::Watch;
use super::system::{State, System, map_elements};

/// Conjugate gradients (Hestenes and Stiefel 1952), for form factors that obey reciprocity.
///
/// `1 − ρ F` is not symmetric, but it is in the right inner product. The usual way there is a new
/// unknown `z = √(A/ρ) R` and the matrix `S = √(ρ_i/A_i) G_ij √(ρ_j/A_j)`, `G = A F`; said of `R`
/// itself, without a root, it is
///
/// ```text
///   ┌──────────────────────────┐
///   │  ⟨u, v⟩ = Σ A u v / ρ    │     ⟨u, ρ F v⟩ = Σ_ij u_i G_ij v_j = ⟨ρ F u, v⟩
///   └──────────────────────────┘
/// ```
///
/// A black element, ρ = 0, reflects nothing: `R`, residual and direction are 0 there and it takes
/// no part. All eigenvalues of `1 − ρ F` lie in 1 ± max ρ · row sum, above 0.
///
/// Each colour has its own ρ and so its own inner product and steps; the three share one pass over
/// `F`. Residuals are not carried along but looked at anew, so that they stay what they claim.
pub(super) struct ConjugateGradients<'a> {
    system: System<'a>,
    direction: Vec<Vec3A>,
    /// ⟨r, r⟩ of the step before.
    squares: DVec3,
}

impl<'a> ConjugateGradients<'a> {
    pub(super) fn new(system: System<'a>) -> Self {
        Self {
            system,
            direction: vec![Vec3A::ZERO; system.len()],
            squares: DVec3::ZERO,
        }
    }

    /// ⟨u, v⟩.
    fn product(
        &self,
        watch: &Watch,
        pair: impl Fn(usize) -> (DVec3, DVec3) + Send + Sync,
    ) -> Result<DVec3, Cancelled> {
        let term = |e: usize| {
            let (u, v) = pair(e);
            let rho = self.system.reflectance(e);
            let weight = f64::from(self.system.elements.area[e]) / rho;
            DVec3::select(rho.cmpgt(DVec3::ZERO), u * v * weight, DVec3::ZERO)
        };
        let sum = |range: std::ops::Range<usize>| range.map(term).sum::<DVec3>();
        let parts = map_elements(self.system.len(), watch, sum)?;
        Ok(parts.into_iter().sum())
    }
}

impl Method for ConjugateGradients<'_> {
    fn step(
        &mut self,
        now: &State,
        reflected: &mut [Vec3A],
        watch: &Watch,
    ) -> Result<(), Cancelled> {
        let system = self.system;
        let residual =
            |e: usize| system.reflectance(e) * now.arriving[e].as_dvec3() - reflected[e].as_dvec3();
        let squares = self.product(watch, |e| (residual(e), residual(e)))?;
        let keep = divide(squares, self.squares).as_dvec3();
        self.squares = squares;
        for (e, d) in self.direction.iter_mut().enumerate() {
            *d = (residual(e) + keep * d.as_dvec3()).as_vec3a();
        }
        let direction = &self.direction;
        let along = self.product(watch, |e| (residual(e), direction[e].as_dvec3()))?;
        let curvature = self.product(watch, |e| {
            let d = direction[e].as_dvec3();
            (
                d,
                d - system.reflectance(e) * system.rows.gather(e, direction),
            )
        })?;
        let length = divide(along, curvature).as_dvec3();
        for (r, d) in reflected.iter_mut().zip(direction) {
            *r = (r.as_dvec3() + length * d.as_dvec3()).as_vec3a();
        }
        Ok(())
    }

    /// Not by itself, but where rounding turns directions.
    fn may_diverge(&self) -> bool {
        true
    }
}

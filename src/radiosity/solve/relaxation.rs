use glam::{DVec3, Vec3A};

use crate::radiosity::color::divide;
use crate::radiosity::parallel::Cancelled;

use super::drive::Method;
use super::glimpse::Watch;
use super::system::{State, System, map_elements};

/// Elements relaxed before asking whether to go on: a few milliseconds' work.
const BETWEEN_QUESTIONS: usize = 4096;

/// All elements gather at once. What arrives is known from looking at the state, so that a sweep
/// costs no more than that.
pub(super) struct Jacobi<'a> {
    pub(super) system: System<'a>,
}

impl Method for Jacobi<'_> {
    fn step(
        &mut self,
        now: &State,
        reflected: &mut [Vec3A],
        _watch: &Watch,
    ) -> Result<(), Cancelled> {
        for (e, r) in reflected.iter_mut().enumerate() {
            *r = (self.system.elements.reflectance[e] * now.arriving[e]).into();
        }
        Ok(())
    }
}

/// Every element in turn gathers from the newest values and goes `omega` times as far as they say.
///
/// A row sums to at most 1 and ρ < 1, so with `omega` 1, Gauss–Seidel, it always converges, but
/// slowly where light bounces often. So a *mean-field* correction may come before each sweep: the
/// multiple `c` of ρ that, added everywhere, makes the area-weighted sum of the residual `r`
/// vanish,
///
/// ```text
///   R ← R + c ρ     Σ A r = c Σ A ρ (1 − F ρ)     (one channel at a time)
///   ┌─────────────────────────────────────┐
///   │  c = Σ A r / Σ A ρ (1 − F ρ)        │
///   └─────────────────────────────────────┘
/// ```
///
/// which removes the slowest mode, light that is everywhere too low by the same factor.
pub(super) struct Relaxation<'a> {
    system: System<'a>,
    omega: f64,
    /// `Σ A ρ (1 − F ρ)`, if there is to be a correction.
    mean_field_gain: Option<DVec3>,
}

impl<'a> Relaxation<'a> {
    pub(super) fn new(system: System<'a>, omega: f64) -> Self {
        Self {
            system,
            omega,
            mean_field_gain: None,
        }
    }

    /// Gauss–Seidel with the correction.
    pub(super) fn with_mean_field(system: System<'a>, watch: &Watch) -> Result<Self, Cancelled> {
        Ok(Self {
            system,
            omega: 1.0,
            mean_field_gain: Some(mean_field_gain(&system, watch)?),
        })
    }
}

impl Method for Relaxation<'_> {
    fn step(
        &mut self,
        now: &State,
        reflected: &mut [Vec3A],
        watch: &Watch,
    ) -> Result<(), Cancelled> {
        if let Some(gain) = self.mean_field_gain {
            let correction = divide(now.residual_sum, gain);
            let reflectance = &self.system.elements.reflectance;
            for (r, rho) in reflected.iter_mut().zip(reflectance) {
                *r = (*r + Vec3A::from(correction * *rho)).max(Vec3A::ZERO);
            }
        }
        for e in 0..reflected.len() {
            let mut next = self.system.reflect(e, reflected);
            // Nothing is rounded twice where there is nothing to add.
            if self.omega != 1.0 {
                let last = reflected[e].as_dvec3();
                next = last + (next - last) * self.omega;
            }
            reflected[e] = next.as_vec3a();
            if e % BETWEEN_QUESTIONS == 0 {
                watch.ask()?;
            }
        }
        Ok(())
    }

    fn may_diverge(&self) -> bool {
        self.omega != 1.0
    }
}

/// Σ A ρ (1 − F ρ).
fn mean_field_gain(system: &System, watch: &Watch) -> Result<DVec3, Cancelled> {
    let elements = system.elements;
    let rho: Vec<Vec3A> = elements.reflectance.iter().map(|&r| r.into()).collect();
    let gain = |e: usize| {
        let lost = DVec3::ONE - system.rows.gather(e, &rho);
        rho[e].as_dvec3() * lost * f64::from(elements.area[e])
    };
    let parts = map_elements(rho.len(), watch, |range| range.map(gain).sum::<DVec3>())?;
    Ok(parts.into_iter().sum())
}

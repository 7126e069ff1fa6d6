use glam::{BVec3, DVec3, Vec3, Vec3A};

use crate::radiosity::color::divide;
use crate::radiosity::parallel::Cancelled;

use super::drive::Method;
use super::glimpse::Watch;
use super::system::{State, System};

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
/// factor `a` on all reflected light that makes the area-weighted sum of the residual
/// `r = ρ (D + F R) − R` vanish,
///
/// ```text
///   R ← a R     Σ A ρ D = a Σ A (R − ρ F R) = a (Σ A ρ D − Σ A r)     (one channel at a time)
///   ┌─────────────────────────────────────┐
///   │  a = Σ A ρ D / (Σ A ρ D − Σ A r)    │
///   └─────────────────────────────────────┘
/// ```
///
/// which removes the slowest mode, light that is everywhere too low by the same factor. As a factor
/// it brings no light to where there is none: a dark room beside a bright one stays dark.
///
/// Where elements are few and the matrix is far from reciprocal, corrections and sweeps can undo each
/// other in turn. So if the residual has grown [`PATIENCE`] times, sweeps go on alone, which converge.
pub(super) struct Relaxation<'a> {
    system: System<'a>,
    omega: f64,
    /// `Σ A ρ D`, if there is to be a correction.
    brought: Option<DVec3>,
    /// The largest residual before the last sweep, and how often it has grown.
    last_residual: f64,
    grown: u32,
}

/// How often the residual may grow before there are no more corrections.
const PATIENCE: u32 = 3;

impl<'a> Relaxation<'a> {
    pub(super) fn new(system: System<'a>, omega: f64) -> Self {
        Self {
            system,
            omega,
            brought: None,
            last_residual: f64::INFINITY,
            grown: 0,
        }
    }

    /// Gauss–Seidel with the correction.
    pub(super) fn with_mean_field(system: System<'a>) -> Self {
        Self {
            brought: Some(brought(&system)),
            ..Self::new(system, 1.0)
        }
    }
}

impl Method for Relaxation<'_> {
    fn step(
        &mut self,
        now: &State,
        reflected: &mut [Vec3A],
        watch: &Watch,
    ) -> Result<(), Cancelled> {
        self.grown += u32::from(now.largest_residual > self.last_residual);
        self.last_residual = now.largest_residual;
        if let Some(brought) = self.brought.filter(|_| self.grown < PATIENCE) {
            let factor = mean_field(brought, now.residual_sum);
            reflected.iter_mut().for_each(|r| *r *= factor);
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

/// Σ A ρ D.
fn brought(system: &System) -> DVec3 {
    let elements = system.elements;
    let lit = elements.iter_area().zip(system.direct).enumerate();
    lit.map(|(e, (area, direct))| system.reflectance(e) * direct.as_dvec3() * area)
        .sum()
}

/// The factor on reflected light; 1 where there is none yet.
fn mean_field(brought: DVec3, residual: DVec3) -> Vec3A {
    let left = brought - residual;
    let factor = divide(brought, left);
    let known = left.cmpgt(DVec3::ZERO);
    Vec3::select(BVec3::new(known.x, known.y, known.z), factor, Vec3::ONE).into()
}

use std::ops::Range;

use glam::{DVec3, Vec3, Vec3A};

use crate::radiosity::element::Elements;
use crate::radiosity::form_factor::Matrix;
use crate::radiosity::parallel::{Cancelled, map_chunks};

use super::glimpse::Watch;

/// Elements a thread takes at a time.
const CHUNK: usize = 1024;

/// Elements between two questions whether to go on: a few milliseconds' work.
const BETWEEN_QUESTIONS: usize = 16 * CHUNK;

/// The system `R = ρ (D + F R)`.
///
/// How far reflected light `R` is from the solution `R*` follows from its residual, for any method
/// and any `R`:
///
/// ```text
///   r = ρ (D + F R) − R          R* − R = r + ρ F (R* − R)
///   ‖R* − R‖ ≤ ‖r‖ + c ‖R* − R‖    c = max ρ · row sum of F, ‖·‖ the largest of all elements
///   ┌────────────────────────────┐
///   │  ‖R* − R‖ ≤ ‖r‖ / (1 − c)  │
///   └────────────────────────────┘
/// ```
#[derive(Clone, Copy)]
pub(crate) struct System<'a> {
    pub(crate) elements: &'a Elements,
    /// `F`.
    pub(crate) rows: &'a Matrix,
    /// `D`, direct light at each element.
    pub(crate) direct: &'a [Vec3],
}

/// What can be said of some reflected light, or of part of it.
pub(super) struct State {
    /// `D + F R`.
    pub(super) arriving: Vec<Vec3>,
    pub(super) largest_residual: f64,
    /// Σ A r.
    pub(super) residual_sum: DVec3,
}

impl State {
    fn with_capacity(count: usize) -> Self {
        Self {
            arriving: Vec::with_capacity(count),
            largest_residual: 0.0,
            residual_sum: DVec3::ZERO,
        }
    }
}

impl System<'_> {
    pub(super) fn len(&self) -> usize {
        self.direct.len()
    }

    pub(super) fn reflectance(&self, e: usize) -> DVec3 {
        self.elements.reflectance[e].as_dvec3()
    }

    fn arriving(&self, e: usize, reflected: &[Vec3A]) -> DVec3 {
        self.direct[e].as_dvec3() + self.rows.gather(e, reflected)
    }

    pub(super) fn reflect(&self, e: usize, reflected: &[Vec3A]) -> DVec3 {
        self.reflectance(e) * self.arriving(e, reflected)
    }

    pub(super) fn state(&self, reflected: &[Vec3A], watch: &Watch) -> Result<State, Cancelled> {
        let parts = map_elements(self.len(), watch, |range| self.state_of(range, reflected))?;
        let mut whole = State::with_capacity(self.len());
        for part in parts {
            whole.arriving.extend(part.arriving);
            whole.largest_residual = whole.largest_residual.max(part.largest_residual);
            whole.residual_sum += part.residual_sum;
        }
        Ok(whole)
    }

    fn state_of(&self, range: Range<usize>, reflected: &[Vec3A]) -> State {
        let mut state = State::with_capacity(range.len());
        for e in range {
            let arriving = self.arriving(e, reflected);
            let r = self.reflectance(e) * arriving - reflected[e].as_dvec3();
            state.arriving.push(arriving.as_vec3());
            state.largest_residual = state.largest_residual.max(r.abs().max_element());
            state.residual_sum += r * f64::from(self.elements.area[e]);
        }
        state
    }

    /// Largest ρ · row sum: the factor by which an error shrinks in one bounce, at worst.
    pub(super) fn contraction(&self) -> f64 {
        let brightest = |e: usize| f64::from(self.elements.reflectance[e].max_element());
        (0..self.len())
            .map(|e| brightest(e) * self.rows.row_sum(e))
            .fold(0.0, f64::max)
    }
}

/// Bound on the error of any element, of the largest residual and the contraction.
pub(super) fn error_bound(residual: f64, contraction: f64) -> f64 {
    let gap = 1.0 - contraction;
    if residual > 0.0 && gap <= 0.0 {
        f64::INFINITY
    } else {
        residual / gap.max(f64::MIN_POSITIVE)
    }
}

/// Runs `work` over `0..count` in ranges, asking between them whether to go on. Results come in
/// order and do not depend on the number of threads.
pub(super) fn map_elements<T: Send>(
    count: usize,
    watch: &Watch,
    work: impl Fn(Range<usize>) -> T + Send + Sync,
) -> Result<Vec<T>, Cancelled> {
    let mut parts = Vec::with_capacity(count.div_ceil(CHUNK));
    for start in (0..count).step_by(BETWEEN_QUESTIONS) {
        watch.ask()?;
        let length = BETWEEN_QUESTIONS.min(count - start);
        let shifted = |range: Range<usize>| work(start + range.start..start + range.end);
        parts.extend(map_chunks(length, CHUNK, shifted));
    }
    Ok(parts)
}

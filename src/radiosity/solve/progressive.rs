use glam::{Vec3, Vec3A};

use crate::radiosity::parallel::Cancelled;

use super::columns::Columns;
use super::drive::Method;
use super::glimpse::{Glimpse, Watch};
use super::largest::Largest;
use super::system::{State, System, error_bound};

/// Progressive refinement: light is shot instead of gathered, the most of it first.
///
/// `R` is the light that was shot, `H = D + F R` what has arrived, and `ρ H − R` is unshot. A shot
/// of element `i` sends its unshot light to all who see it, along column `i` of `F`:
///
/// ```text
///   Δ = ρ_i H_i − R_i      the i with the largest A_i Δ_i
///   ┌─────────────────────────────────────────────┐
///   │  R_i ← R_i + Δ      H_j ← H_j + F_ji Δ      │
///   └─────────────────────────────────────────────┘
/// ```
///
/// The unshot light is the residual of the system: setting the largest to 0 is Southwell's
/// relaxation, so that shooting solves what gathering does. Any `R` is a start, also one too
/// bright: then what is unshot is negative (Chen 1990).
pub(super) struct Shooting<'a> {
    system: System<'a>,
    columns: Columns,
    contraction: f64,
    /// Bound on the error to stop at, relative to the mean.
    tolerance: f64,
    shots: u64,
    next_show: u64,
}

/// Shots between two questions whether to go on.
const BETWEEN_QUESTIONS: usize = 64;

/// A sweep's light is shown, and its residual looked at, so often.
const LOOKS: usize = 8;

impl<'a> Shooting<'a> {
    pub(super) fn new(
        system: System<'a>,
        tolerance: f32,
        watch: &Watch,
    ) -> Result<Self, Cancelled> {
        Ok(Self {
            system,
            columns: Columns::new(system.rows, watch)?,
            contraction: system.contraction(),
            tolerance: tolerance.into(),
            shots: 0,
            next_show: 1,
        })
    }

    pub(super) fn bytes(&self) -> u64 {
        self.columns.bytes()
    }

    /// `ρ H − R`.
    fn unshot(&self, e: usize, arriving: &[Vec3], reflected: &[Vec3A]) -> Vec3 {
        self.system.elements.reflectance[e] * arriving[e] - Vec3::from(reflected[e])
    }

    /// The power of the brightest channel: luminance would miss light that is too red by as much
    /// as it is not green enough.
    fn power(&self, e: usize, arriving: &[Vec3], reflected: &[Vec3A]) -> f32 {
        let unshot = self.unshot(e, arriving, reflected);
        self.system.elements.area[e] * unshot.abs().max_element()
    }

    /// With a margin: what arrives is added up in f32, shot by shot, and looked at anew only after
    /// the step.
    fn converged(&self, arriving: &[Vec3], reflected: &[Vec3A]) -> bool {
        let residual = |e: usize| self.unshot(e, arriving, reflected).abs().max_element();
        let largest = (0..self.system.len()).map(residual).fold(0.0, f32::max);
        let mean = self.system.elements.mean(reflected).max_element();
        error_bound(largest.into(), self.contraction) <= 0.5 * self.tolerance * mean
    }

    /// Shows the light after 1, 2, 4, 8... shots, and later a few times a sweep.
    fn show(&mut self, arriving: &[Vec3], reflected: &[Vec3A], watch: &Watch) {
        if self.shots < self.next_show {
            return;
        }
        let often = (self.system.len() / LOOKS).max(1) as u64;
        self.next_show = self.shots + self.shots.min(often);
        (watch.show)(&Glimpse {
            system: self.system,
            sweeps: (self.shots / self.system.len() as u64) as u32,
            shots: self.shots,
            arriving,
            reflected,
        });
    }
}

impl Method for Shooting<'_> {
    /// As many shots as there are elements, or fewer if that is enough.
    fn step(
        &mut self,
        now: &State,
        reflected: &mut [Vec3A],
        watch: &Watch,
    ) -> Result<(), Cancelled> {
        let count = self.system.len();
        let mut arriving = now.arriving.clone();
        let power = |e| self.power(e, &arriving, reflected);
        let mut powers = Largest::new((0..count).map(power).collect());
        for shot in 1..=count {
            let Some(e) = powers.index() else { break };
            let unshot = self.unshot(e, &arriving, reflected);
            reflected[e] += Vec3A::from(unshot);
            self.columns.each(e, |j, weight| {
                arriving[j] += unshot * weight;
                powers.set(j, self.power(j, &arriving, reflected));
            });
            powers.set(e, self.power(e, &arriving, reflected));
            self.shots += 1;
            if shot < count {
                self.show(&arriving, reflected, watch);
            }
            if shot % BETWEEN_QUESTIONS == 0 {
                watch.ask()?;
            }
            if shot % count.div_ceil(LOOKS) == 0 && self.converged(&arriving, reflected) {
                break;
            }
        }
        Ok(())
    }

    fn shots(&self) -> u64 {
        self.shots
    }
}

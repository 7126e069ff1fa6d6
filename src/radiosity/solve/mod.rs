mod method;

pub use method::Solver;

use std::ops::Range;

use glam::{DVec3, Vec3, Vec3A};

use crate::radiosity::color::divide;
use crate::radiosity::element::Elements;
use crate::radiosity::form_factor::Matrix;
use crate::radiosity::parallel::{Cancelled, map_chunks};
use crate::radiosity::report::SolverReport;
use crate::radiosity::settings::BakeSettings;

/// A solution of the radiosity system.
pub(crate) struct Solution {
    /// Light that arrives at each element (irradiance / π).
    pub(crate) arriving: Vec<Vec3>,
    /// Light that leaves each element by reflection (radiosity / π without emission).
    pub(crate) reflected: Vec<Vec3A>,
    pub(crate) report: SolverReport,
}

/// Solves for the reflected light `R = ρ (D + F R)`, `D` the direct light at each element.
///
/// Gauss–Seidel: every element in turn gathers from the newest values (Cohen and Greenberg 1985).
/// A row of the hit list sums to at most 1 and ρ < 1, so it always converges, but slowly where light
/// bounces often. So each sweep is followed by a *mean-field* correction: the multiple `c` of ρ
/// that, added everywhere, makes the area-weighted sum of the residual `r` vanish,
///
/// ```text
///   R ← R + c ρ     Σ A r = c Σ A ρ (1 − F ρ)     (one channel at a time)
///   ┌─────────────────────────────────────┐
///   │  c = Σ A r / Σ A ρ (1 − F ρ)        │
///   └─────────────────────────────────────┘
/// ```
///
/// which removes the slowest mode, light that is everywhere too low by the same factor. A `start`
/// that is near the solution saves sweeps.
pub(crate) fn solve(
    system: &System,
    settings: &BakeSettings,
    start: Option<Vec<Vec3A>>,
    mut go_on: impl FnMut() -> bool,
) -> Result<Solution, Cancelled> {
    let System {
        elements, direct, ..
    } = *system;
    let (tolerance, max_sweeps) = (settings.solver_tolerance, settings.max_sweeps);
    let contraction = system.contraction();
    let mean_field = system.mean_field_gain();
    let bounced_once = || (0..direct.len()).map(|e| (direct[e] * elements.reflectance[e]).into());
    let mut reflected = start.unwrap_or_else(|| bounced_once().collect());
    let mut report = SolverReport::default();
    loop {
        // The state as it is: what the bound and the correction are made of.
        let state = system.state(&reflected);
        let goal = f64::from(tolerance) * elements.mean(&reflected).max_element();
        report.residual = state.largest_residual;
        report.error_bound = report.residual / (1.0 - contraction);
        report.converged = report.error_bound <= goal;
        if report.converged || report.sweeps >= max_sweeps {
            return Ok(Solution {
                arriving: state.arriving,
                reflected,
                report,
            });
        }
        let correction = divide(state.residual_sum, mean_field);
        for (r, rho) in reflected.iter_mut().zip(&elements.reflectance) {
            *r = (*r + Vec3A::from(correction * *rho)).max(Vec3A::ZERO);
        }
        for e in 0..reflected.len() {
            reflected[e] = system.reflect(e, &reflected).as_vec3a();
            if e % BETWEEN_QUESTIONS == 0 && !go_on() {
                return Err(Cancelled);
            }
        }
        report.sweeps += 1;
    }
}

/// Elements relaxed before asking whether to go on: a few milliseconds' work.
const BETWEEN_QUESTIONS: usize = 4096;

/// Elements a thread takes at a time when the state is looked at.
const CHUNK: usize = 1024;

/// The system `R = ρ (D + F R)`.
pub(crate) struct System<'a> {
    pub(crate) elements: &'a Elements,
    /// `F`.
    pub(crate) rows: &'a Matrix,
    /// `D`, direct light at each element.
    pub(crate) direct: &'a [Vec3],
}

/// What can be said of some reflected light, or of part of it.
struct State {
    arriving: Vec<Vec3>,
    largest_residual: f64,
    /// Σ A r.
    residual_sum: DVec3,
}

impl System<'_> {
    fn arriving(&self, e: usize, reflected: &[Vec3A]) -> DVec3 {
        self.direct[e].as_dvec3() + self.rows.gather(e, reflected)
    }

    fn reflect(&self, e: usize, reflected: &[Vec3A]) -> DVec3 {
        self.elements.reflectance[e].as_dvec3() * self.arriving(e, reflected)
    }

    fn state(&self, reflected: &[Vec3A]) -> State {
        let parts = map_chunks(reflected.len(), CHUNK, |range| {
            self.state_of(range, reflected)
        });
        let mut whole = State {
            arriving: Vec::with_capacity(reflected.len()),
            largest_residual: 0.0,
            residual_sum: DVec3::ZERO,
        };
        for part in parts {
            whole.arriving.extend(part.arriving);
            whole.largest_residual = whole.largest_residual.max(part.largest_residual);
            whole.residual_sum += part.residual_sum;
        }
        whole
    }

    fn state_of(&self, range: Range<usize>, reflected: &[Vec3A]) -> State {
        let mut state = State {
            arriving: Vec::with_capacity(range.len()),
            largest_residual: 0.0,
            residual_sum: DVec3::ZERO,
        };
        for e in range {
            let arriving = self.arriving(e, reflected);
            let r = self.elements.reflectance[e].as_dvec3() * arriving - reflected[e].as_dvec3();
            state.arriving.push(arriving.as_vec3());
            state.largest_residual = state.largest_residual.max(r.abs().max_element());
            state.residual_sum += r * f64::from(self.elements.area[e]);
        }
        state
    }

    /// Largest ρ · row sum: the factor by which an error shrinks in one bounce, at worst.
    fn contraction(&self) -> f64 {
        let brightest = |e: usize| f64::from(self.elements.reflectance[e].max_element());
        (0..self.direct.len())
            .map(|e| brightest(e) * self.rows.row_sum(e))
            .fold(0.0, f64::max)
    }

    /// Σ A ρ (1 − F ρ).
    fn mean_field_gain(&self) -> DVec3 {
        let rho: Vec<Vec3A> = self
            .elements
            .reflectance
            .iter()
            .map(|&r| r.into())
            .collect();
        let gain = |e: usize| {
            let lost = DVec3::ONE - self.rows.gather(e, &rho);
            rho[e].as_dvec3() * lost * f64::from(self.elements.area[e])
        };
        let parts = map_chunks(rho.len(), CHUNK, |range| range.map(gain).sum::<DVec3>());
        parts.into_iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::form_factor::HitList;
    use crate::radiosity::sampling::{hash, unit_float};

    /// A random enclosure: `n` elements, rows of hits at random, some open, reflectances up to `brightest`.
    struct Enclosure {
        elements: Elements,
        rows: Matrix,
        direct: Vec<Vec3>,
        matrix: Vec<Vec<f64>>,
    }

    impl Enclosure {
        fn random(seed: u32) -> Self {
            let random = |a: u32, b: u32| unit_float(hash(hash(seed, a), b));
            let n = 4 + hash(seed, 1) as usize % 60;
            let rays = 16 << (hash(seed, 2) % 3);
            let brightest = [0.5, 0.9, 0.99][seed as usize % 3];
            let open = [0.0, 0.2][hash(seed, 3) as usize % 2];
            let reflectance: Vec<Vec3> = (0..n as u32)
                .map(|e| {
                    Vec3::new(random(e, 10), random(e, 11), brightest)
                        * Vec3::new(1.0, 0.5, 1.0).min(Vec3::splat(brightest))
                })
                .collect();
            let ids: Vec<Vec<Option<u32>>> = (0..n as u32)
                .map(|e| {
                    let hit = |i: u32| {
                        (random(e, 100 + i) >= open)
                            .then(|| hash(hash(seed, e), 5000 + i) % n as u32)
                    };
                    (0..rays).map(hit).collect()
                })
                .collect();
            let mut matrix = vec![vec![0.0; n]; n];
            for (e, row) in ids.iter().enumerate() {
                for &id in row.iter().flatten() {
                    matrix[e][id as usize] += 1.0 / f64::from(rays);
                }
            }
            Self {
                direct: (0..n as u32)
                    .map(|e| Vec3::new(random(e, 20), random(e, 21).powi(8), f32::from(e == 0)))
                    .collect(),
                elements: Elements::for_test(
                    reflectance,
                    (0..n as u32).map(|e| 0.1 + random(e, 30)).collect(),
                ),
                rows: Matrix::Hits(HitList::from_rows(&ids)),
                matrix,
            }
        }

        /// Reflected light by Gaussian elimination with partial pivoting, one channel.
        fn exact(&self, channel: usize) -> Vec<f64> {
            let n = self.direct.len();
            let rho = |i: usize| f64::from(self.elements.reflectance[i][channel]);
            let mut a: Vec<Vec<f64>> = (0..n)
                .map(|i| {
                    let mut row: Vec<f64> = (0..n)
                        .map(|j| f64::from(u8::from(i == j)) - rho(i) * self.matrix[i][j])
                        .collect();
                    row.push(rho(i) * f64::from(self.direct[i][channel]));
                    row
                })
                .collect();
            for k in 0..n {
                let pivot = (k..n)
                    .max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))
                    .unwrap();
                a.swap(k, pivot);
                for i in k + 1..n {
                    let factor = a[i][k] / a[k][k];
                    let pivot = a[k].clone();
                    for (x, p) in a[i].iter_mut().zip(&pivot).skip(k) {
                        *x -= factor * p;
                    }
                }
            }
            let mut x = vec![0.0; n];
            for i in (0..n).rev() {
                let known: f64 = (i + 1..n).map(|j| a[i][j] * x[j]).sum();
                x[i] = (a[i][n] - known) / a[i][i];
            }
            x
        }

        fn solved(&self, tolerance: f32, sweeps: u32) -> Solution {
            let system = System {
                elements: &self.elements,
                rows: &self.rows,
                direct: &self.direct,
            };
            let settings = BakeSettings {
                solver_tolerance: tolerance,
                max_sweeps: sweeps,
                ..BakeSettings::DRAFT
            };
            solve(&system, &settings, None, || true).unwrap()
        }

        fn largest_error(&self, solution: &Solution) -> f64 {
            (0..3)
                .flat_map(|c| {
                    self.exact(c)
                        .into_iter()
                        .zip(&solution.reflected)
                        .map(move |(x, r)| (x - f64::from(r[c])).abs())
                })
                .fold(0.0, f64::max)
        }
    }

    #[test]
    fn the_bound_covers_the_error_of_random_enclosures() {
        let mut looseness = Vec::new();
        for seed in 0..120 {
            let enclosure = Enclosure::random(seed);
            for sweeps in [0, 1, 3, 100] {
                let solution = enclosure.solved(1e-4, sweeps);
                let error = enclosure.largest_error(&solution);
                // Radiances are stored as f32: half a unit in the last place is not the solver's.
                let storage = 1e-6 * enclosure.exact(2).into_iter().fold(1.0, f64::max);
                let bound = solution.report.error_bound;
                assert!(
                    error <= bound + storage,
                    "seed {seed}, {sweeps} sweeps: error {error:e}, bound {bound:e}"
                );
                assert!(solution.report.sweeps <= sweeps);
                if sweeps == 3 {
                    looseness.push(bound / error.max(storage));
                }
            }
        }
        looseness.sort_by(f64::total_cmp);
        assert!(
            looseness[60] < 30.0,
            "median bound / error {}",
            looseness[60]
        );
    }

    #[test]
    fn bright_closed_rooms_take_few_sweeps() {
        // Rows that see everything alike: plain Gauss–Seidel needs hundreds of sweeps at ρ = 0.99.
        let n = 64;
        let ids: Vec<Vec<Option<u32>>> = (0..n)
            .map(|e| (0..128).map(|i| Some(hash(e, i) % n)).collect())
            .collect();
        let elements =
            Elements::for_test(vec![Vec3::splat(0.99); n as usize], vec![1.0; n as usize]);
        let direct: Vec<Vec3> = (0..n)
            .map(|e| Vec3::splat(f32::from(u8::from(e < 4))))
            .collect();
        let enclosure = Enclosure {
            elements,
            rows: Matrix::Hits(HitList::from_rows(&ids)),
            direct,
            matrix: Vec::new(),
        };
        let solution = enclosure.solved(1e-3, 100);
        assert!(
            solution.report.converged && solution.report.sweeps <= 20,
            "{:?}",
            solution.report
        );
    }

    #[test]
    fn stopping_early_is_reported() {
        let enclosure = Enclosure::random(2);
        let solution = enclosure.solved(1e-9, 2);
        assert!(!solution.report.converged);
        assert_eq!(solution.report.sweeps, 2);
    }
}

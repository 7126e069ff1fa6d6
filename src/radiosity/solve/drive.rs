use glam::{Vec3, Vec3A};

use crate::radiosity::parallel::Cancelled;
use crate::radiosity::report::SolverReport;
use crate::radiosity::settings::BakeSettings;

use super::Solver;
use super::conjugate_gradients::ConjugateGradients;
use super::glimpse::{Glimpse, Watch};
use super::progressive::Shooting;
use super::relaxation::{Jacobi, Relaxation};
use super::symmetric::symmetrized;
use super::system::{State, System, error_bound};

/// A solution of the radiosity system.
pub(crate) struct Solution {
    /// Light that arrives at each element (irradiance / π).
    pub(crate) arriving: Vec<Vec3>,
    /// Light that leaves each element by reflection (radiosity / π without emission).
    pub(crate) reflected: Vec<Vec3A>,
    pub(crate) report: SolverReport,
}

/// What tells one solver from another.
pub(super) trait Method {
    /// One sweep: brings `reflected`, of which all that can be said is `now`, nearer to the
    /// solution.
    fn step(
        &mut self,
        now: &State,
        reflected: &mut [Vec3A],
        watch: &Watch,
    ) -> Result<(), Cancelled>;

    /// Whether it may lead away from the solution for good. Gathering and shooting cannot, in
    /// whatever order, while ρ · row sum is below 1 (Chazan and Miranker 1969).
    fn may_diverge(&self) -> bool {
        false
    }

    /// Elements that shot their light so far, if that is what a step does.
    fn shots(&self) -> u64 {
        0
    }
}

/// A method whose residual grew so often in a row is given up.
const GROWING: u32 = 3;

/// Solves for the reflected light `R = ρ (D + F R)`, `D` the direct light at each element. A
/// `start` that is near the solution saves sweeps.
///
/// Where a method that may diverge makes the residual grow three sweeps running, Gauss–Seidel with
/// a mean field goes on from the best light so far. Light below 0, which over-relaxation and conjugate gradients may leave, is
/// cut off in the end: the solution has none, so that the error only shrinks.
pub(crate) fn solve(
    system: &System,
    settings: &BakeSettings,
    start: Option<Vec<Vec3A>>,
    watch: &Watch,
) -> Result<Solution, Cancelled> {
    let system = *system;
    let solver = settings.solver;
    let start = start.unwrap_or_else(|| first_light(&system, solver));
    let mut drive = Drive::new(settings, watch);
    let ended = match solver {
        Solver::GaussSeidelMeanField => {
            drive.run(system, Relaxation::with_mean_field(system), start)?
        }
        Solver::GaussSeidel => drive.run(system, Relaxation::new(system, 1.0), start)?,
        Solver::Jacobi => drive.run(system, Jacobi { system }, start)?,
        Solver::Sor { omega } => drive.run(system, Relaxation::new(system, omega.into()), start)?,
        Solver::ProgressiveRefinement => {
            let shooting = Shooting::new(system, settings.solver_tolerance, watch)?;
            drive.report.bytes = shooting.bytes();
            drive.run(system, shooting, start)?
        }
        Solver::ConjugateGradients => drive.symmetrized(system, start)?,
    };
    let best = match ended {
        Ended::AtLast(best) => best,
        Ended::Growing(best) => {
            drive.report.fell_back = Some(solver);
            drive.report.solver = Solver::GaussSeidelMeanField;
            let cure = Relaxation::with_mean_field(system);
            drive.run(system, cure, best.reflected)?.best()
        }
    };
    Ok(best.solution(drive.report))
}

/// Light bounced once; for shooting, all light still unshot.
fn first_light(system: &System, solver: Solver) -> Vec<Vec3A> {
    if solver == Solver::ProgressiveRefinement {
        return vec![Vec3A::ZERO; system.len()];
    }
    let bounced = |e: usize| (system.direct[e] * system.elements.reflectance[e]).into();
    (0..system.len()).map(bounced).collect()
}

/// Residuals up to this are what f32 leaves: they grow and shrink by chance.
fn rounding(reflected: &[Vec3A]) -> f64 {
    let brightest = |most: f32, r: &Vec3A| most.max(r.abs().max_element());
    16.0 * f64::from(f32::EPSILON * reflected.iter().fold(0.0, brightest))
}

/// The best light so far.
struct Best {
    residual: f64,
    arriving: Vec<Vec3>,
    reflected: Vec<Vec3A>,
}

impl Best {
    fn solution(mut self, report: SolverReport) -> Solution {
        for r in &mut self.reflected {
            *r = r.max(Vec3A::ZERO);
        }
        for h in &mut self.arriving {
            *h = h.max(Vec3::ZERO);
        }
        Solution {
            arriving: self.arriving,
            reflected: self.reflected,
            report,
        }
    }
}

/// How a method ended.
enum Ended {
    /// Converged, or out of sweeps.
    AtLast(Best),
    /// Led astray.
    Growing(Best),
}

impl Ended {
    fn best(self) -> Best {
        let (Self::AtLast(best) | Self::Growing(best)) = self;
        best
    }
}

/// The loop that all methods share.
struct Drive<'a> {
    settings: &'a BakeSettings,
    watch: &'a Watch<'a>,
    report: SolverReport,
    /// Steps so far, of all methods.
    steps: u32,
}

impl<'a> Drive<'a> {
    fn new(settings: &'a BakeSettings, watch: &'a Watch) -> Self {
        Self {
            settings,
            watch,
            report: SolverReport {
                solver: settings.solver,
                ..SolverReport::default()
            },
            steps: 0,
        }
    }

    /// Looks at the light, and while it is not good enough, lets the method take a step.
    fn run(
        &mut self,
        system: System,
        mut method: impl Method,
        mut reflected: Vec<Vec3A>,
    ) -> Result<Ended, Cancelled> {
        let contraction = system.contraction();
        let mut best: Option<Best> = None;
        let (mut before, mut growing) = (f64::INFINITY, 0);
        loop {
            self.watch.ask()?;
            let now = system.state(&reflected, self.watch)?;
            let residual = now.largest_residual;
            self.note(&system, &method, &now, &reflected);
            if best.as_ref().is_none_or(|b| residual < b.residual) {
                best = Some(Best {
                    residual,
                    arriving: now.arriving.clone(),
                    reflected: reflected.clone(),
                });
            }
            growing = if residual > before { growing + 1 } else { 0 };
            before = residual;
            let astray =
                growing >= GROWING && method.may_diverge() && residual > rounding(&reflected);
            if let Some(best) = best.take_if(|b| astray || self.enough(&system, contraction, b)) {
                let ended = if astray {
                    Ended::Growing
                } else {
                    Ended::AtLast
                };
                return Ok(ended(best));
            }
            method.step(&now, &mut reflected, self.watch)?;
            self.steps += 1;
            self.report.sweeps += 1;
        }
    }

    /// Notes a state down and shows it.
    fn note(&mut self, system: &System, method: &impl Method, now: &State, reflected: &[Vec3A]) {
        let report = &mut self.report;
        // A method that takes over starts from a state that is noted already.
        if report.residuals.len() == self.steps as usize {
            report.residuals.push(now.largest_residual);
        }
        if method.shots() > 0 {
            report.shots = method.shots();
            let sweeps = report.shots.div_ceil(system.len().max(1) as u64);
            report.sweeps = u32::try_from(sweeps).unwrap_or(u32::MAX);
        }
        (self.watch.show)(&Glimpse {
            system: *system,
            sweeps: report.sweeps,
            shots: report.shots,
            arriving: &now.arriving,
            reflected,
        });
    }

    /// Whether the best light so far will do, or has to.
    fn enough(&mut self, system: &System, contraction: f64, best: &Best) -> bool {
        let mean = system.elements.mean(&best.reflected).max_element();
        let report = &mut self.report;
        report.residual = best.residual;
        report.error_bound = error_bound(best.residual, contraction);
        report.converged = report.error_bound <= f64::from(self.settings.solver_tolerance) * mean;
        report.converged || self.steps >= self.settings.max_sweeps
    }

    /// Conjugate gradients: on a system of their own.
    fn symmetrized(&mut self, given: System, start: Vec<Vec3A>) -> Result<Ended, Cancelled> {
        let rows = symmetrized(&given, self.watch)?;
        self.report.bytes = rows.bytes();
        let system = System {
            rows: &rows,
            ..given
        };
        let ended = self.run(system, ConjugateGradients::new(system), start)?;
        if let Ended::AtLast(best) = &ended {
            let residual = given.state(&best.reflected, self.watch)?.largest_residual;
            let mean = given.elements.mean(&best.reflected).max_element();
            self.report.asymmetry = residual / mean.max(f64::MIN_POSITIVE);
        }
        Ok(ended)
    }
}

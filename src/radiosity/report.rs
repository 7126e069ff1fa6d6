use std::time::Duration;

use glam::DVec3;

use super::observer::Stage;
use super::solve::Solver;

/// What a bake did, what it cost and how good the result is.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Wall time of each stage, in the order they ran.
    pub stages: Vec<(Stage, Duration)>,
    /// How much of everything there was.
    pub counts: Counts,
    /// Peak bytes held by the bake's own tables (hit lists, samples, hierarchy, mesh), estimated.
    pub bytes: u64,
    /// Where the light went.
    pub energy: EnergyBalance,
    /// How form factors came out.
    pub form_factors: FormFactorReport,
    /// How the linear system was solved.
    pub solver: SolverReport,
    /// How far off the vertex light is, by source.
    pub error: ErrorEstimate,
    /// Why no better result was looked for.
    pub stopped: Stopped,
    /// Sampling error of the light of elements: RMS of what rays and shadow rays leave to chance, or
    /// pixels to aliasing, beside the mean light. Estimated by asking a few elements twice.
    pub element_error: f32,
    /// Sampling error of the vertex light, RMS beside the mean: estimated from two half-sets of
    /// samples fitted separately, and from what the elements' error adds. A bake that only put
    /// other colours into the samples of the one before it repeats that one's estimate.
    pub sampling_error: f32,
    /// Area-weighted mean of the stored light (irradiance / π), luminance in cd/m².
    pub mean_light: f32,
    /// What this bake really did, and did not take from the one before.
    pub work: Work,
    /// What was mended, skipped or looks wrong, one sentence each, with the name of the thing.
    pub notes: Vec<String>,
}

/// How far off vertex light is, each a relative RMSE: root mean square over the visible surface,
/// beside the mean light. Estimates by the bake itself; 0 where nothing was asked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorEstimate {
    /// All of it.
    pub total: f32,
    /// What linear interpolation between the vertices leaves out.
    pub meshing: f32,
    /// What rays and shadow rays leave to chance.
    pub sampling: f32,
    /// What elements of constant light leave out.
    pub elements: f32,
    /// What stopping the solver early leaves, at most.
    pub solver: f32,
}

impl ErrorEstimate {
    /// From its parts, which have nothing to do with each other.
    pub(crate) fn new(meshing: f32, sampling: f32, elements: f32, solver: f32) -> Self {
        let parts = [meshing, sampling, elements, solver];
        Self {
            total: parts.iter().map(|e| e * e).sum::<f32>().sqrt(),
            meshing,
            sampling,
            elements,
            solver,
        }
    }
}

/// Why a bake stopped looking for less error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stopped {
    /// Vertices were kept as given.
    #[default]
    AsGiven,
    /// The error asked for was reached.
    Error,
    /// More vertices were not allowed.
    Vertices,
    /// More memory was not allowed.
    Memory,
    /// The time was over.
    Seconds,
    /// More vertices and rays did not help: what is left is below what the method can tell apart.
    Limit,
}

/// What a bake really did; all zero if nothing had changed since the last one of its
/// [`Baker`](super::Baker).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Ray-tracing hierarchies built.
    pub hierarchy_builds: u64,
    /// Closest-hit rays traced for form factors.
    pub element_rays: u64,
    /// Closest-hit rays traced from samples inside triangles.
    pub gather_rays: u64,
    /// Shadow rays to lights without a surface.
    pub light_rays: u64,
    /// Shadow rays to emissive surfaces and bright elements.
    pub emitter_rays: u64,
    /// Shadow rays traced again to tell the sampling error.
    pub error_rays: u64,
    /// Sweeps of the solver.
    pub sweeps: u64,
    /// Fits of all vertices: 1 if vertex light was fitted anew.
    pub fits: u64,
    /// Of those, fits that chose their smoothing anew by cross-validation.
    pub cross_validations: u64,
}

impl Work {
    /// Rays of all kinds.
    pub fn rays(&self) -> u64 {
        self.element_rays + self.gather_rays + self.light_rays + self.emitter_rays + self.error_rays
    }
}

/// How much of everything a bake had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Objects that receive light.
    pub objects: u64,
    /// Input triangles that block light.
    pub triangles: u64,
    /// Vertices of the result.
    pub vertices: u64,
    /// Radiosity elements.
    pub elements: u64,
    /// Emissive triangles.
    pub emitters: u64,
    /// Point, spot, rectangular and directional lights.
    pub lights: u64,
    /// Closest-hit rays (form factors and gather).
    pub rays: u64,
    /// Shadow rays to lights and emitters.
    pub shadow_rays: u64,
    /// Samples inside triangles that vertex values were fitted to.
    pub samples: u64,
    /// Samples left out because they lie inside geometry.
    pub invalid_samples: u64,
    /// Vertices without a valid sample, filled from their neighbours along the mesh.
    pub filled_vertices: u64,
    /// Vertices with no valid sample anywhere on their piece of mesh, left black.
    pub dark_vertices: u64,
}

/// Where the light went, RGB, in units of radiance × area (cd).
///
/// For a converged bake `arrived = absorbed + escaped` within the solver's tolerance. `arrived` is
/// light where it first meets a surface (sun and sky have no finite total).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Direct light on all elements: `Σ A H_direct`.
    pub arrived: DVec3,
    /// Taken up by the surfaces: Σ A (1 − ρ) H.
    pub absorbed: DVec3,
    /// Left through openings, or met a black back face, after a bounce: `Σ A ρ H (1 − row sum)`.
    pub escaped: DVec3,
}

impl EnergyBalance {
    /// |arrived − absorbed − escaped| / arrived, the worst channel; 0 for a dark scene.
    pub fn relative_error(&self) -> f64 {
        let gap = (self.arrived - self.absorbed - self.escaped).abs();
        let scale = self.arrived.max_element();
        if scale > 0.0 {
            gap.max_element() / scale
        } else {
            0.0
        }
    }
}

/// How form factors came out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormFactorReport {
    /// Largest sum of a row, `Σ_j F_ij`, as found; more than 1 is an error of the method.
    pub largest_row_sum: f64,
    /// Rows that summed to more than 1 and were scaled down to it.
    pub scaled_rows: u64,
    /// Pairs of elements too near each other for a hemicube, found in closed form instead.
    pub near_pairs: u64,
}

/// How the linear system was solved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverReport {
    /// The solver that gave the result.
    pub solver: Solver,
    /// The solver that was asked for, if its residual grew three sweeps running, so that
    /// [`solver`](Self::solver) went on from its best.
    pub fell_back: Option<Solver>,
    /// Sweeps: each element gathered once in each, or shot once on average.
    pub sweeps: u32,
    /// Elements that shot their light, in progressive refinement: `sweeps` times as many as there
    /// are elements, or a little less.
    pub shots: u64,
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Largest `|E + ρFB − B|` of any element and channel, in cd/m².
    pub residual: f64,
    /// The residual at the start and after each sweep, of progressive refinement also after a sweep
    /// that was cut short. The result is the best of them, which need not be the last.
    pub residuals: Vec<f64>,
    /// Bound on the error that stopping early leaves in any element: residual / (1 − max(ρ · row sum)),
    /// in cd/m².
    pub error_bound: f64,
    /// For conjugate gradients, whose residual and bound are those of the symmetrised system: the
    /// largest residual that the result has in the system as given, relative to the mean light
    /// reflected. Mostly noise of the form factors; 0 for all others.
    pub asymmetry: f64,
    /// Bytes of what the solver made of the matrix: its columns, or the symmetrised one.
    pub bytes: u64,
}

use clap::{Args, ValueEnum};

use super::args::Preset;
use crate::radiosity::{FormFactors, Solver};

/// How the light that bounces is solved for.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method (the defaults are the best for nearly every scene)")]
pub(super) struct MethodArgs {
    /// How form factors between elements are found
    #[arg(long, value_enum, value_name = "METHOD", default_value = "hit-list")]
    form_factors: FormFactorsArg,
    /// Pixels along an edge of the hemicube, an even number, 16 to 512 [draft 32, balanced 64,
    /// final 128]
    #[arg(long, value_name = "N", value_parser = resolution)]
    hemicube_resolution: Option<u32>,
    /// Shadow rays between two elements, of analytic and area-sampling form factors, 1 to 16384
    /// [draft 1, balanced 4, final 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16384))]
    pair_rays: Option<u32>,
    /// Leave lamps to be found by form factors and gathering rays instead of sampling them: the
    /// way of the first radiosity programs, slow and noisy
    #[arg(long)]
    pub(super) no_emitter_sampling: bool,
    /// How the linear system is solved
    #[arg(
        long,
        value_enum,
        value_name = "SOLVER",
        default_value = "gauss-seidel-mean-field"
    )]
    solver: SolverArg,
    /// Over-relaxation of the solver sor, above 0, below 2
    #[arg(long, value_name = "W", default_value = "1.2", value_parser = omega)]
    omega: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormFactorsArg {
    /// Rays from every element, all of one weight
    HitList,
    /// The scene drawn onto a half cube over each element: for scenes of few triangles
    Hemicube,
    /// Closed forms for pairs of elements, times the visible share: for up to a few thousand elements
    Analytic,
    /// Sums over pairs of points: slow, for comparison
    AreaSampling,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SolverArg {
    /// Gauss–Seidel with a mean-field correction after each sweep
    GaussSeidelMeanField,
    /// Every element in turn gathers from the newest values
    GaussSeidel,
    /// All elements gather at once: a bounce a sweep
    Jacobi,
    /// Successive over-relaxation, see --omega
    Sor,
    /// The element with the most unshot light shoots (Southwell)
    ProgressiveRefinement,
    /// Conjugate gradients on the symmetrised system
    ConjugateGradients,
}

impl MethodArgs {
    pub(super) fn form_factors(&self, preset: Preset) -> FormFactors {
        let of = |draft, balanced, r#final| match preset {
            Preset::Draft => draft,
            Preset::Balanced => balanced,
            Preset::Final => r#final,
        };
        let pair_rays = self.pair_rays.unwrap_or(of(1, 4, 16));
        match self.form_factors {
            FormFactorsArg::HitList => FormFactors::HitList,
            FormFactorsArg::Hemicube => FormFactors::Hemicube {
                resolution: self.hemicube_resolution.unwrap_or(of(32, 64, 128)),
            },
            FormFactorsArg::Analytic => FormFactors::Analytic {
                visibility_rays: pair_rays,
            },
            FormFactorsArg::AreaSampling => FormFactors::AreaSampling { samples: pair_rays },
        }
    }

    pub(super) fn solver(&self) -> Solver {
        match self.solver {
            SolverArg::GaussSeidelMeanField => Solver::GaussSeidelMeanField,
            SolverArg::GaussSeidel => Solver::GaussSeidel,
            SolverArg::Jacobi => Solver::Jacobi,
            SolverArg::Sor => Solver::Sor { omega: self.omega },
            SolverArg::ProgressiveRefinement => Solver::ProgressiveRefinement,
            SolverArg::ConjugateGradients => Solver::ConjugateGradients,
        }
    }
}

fn resolution(text: &str) -> Result<u32, String> {
    let fits = |n: &u32| (16..=512).contains(n) && n.is_multiple_of(2);
    let number = text.trim().parse().ok().filter(fits);
    number.ok_or_else(|| "it must be an even number, 16 to 512".into())
}

fn omega(text: &str) -> Result<f32, String> {
    let number = text.trim().parse().ok();
    number
        .filter(|w| *w > 0.0 && *w < 2.0)
        .ok_or_else(|| "it must be above 0 and below 2".into())
}

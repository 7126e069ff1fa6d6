/// How the radiosity system is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Solver {
    /// Gauss–Seidel sweeps, each followed by a mean-field correction: the default.
    #[default]
    GaussSeidelMeanField,
    /// Every element in turn gathers from the newest values (Cohen and Greenberg 1985).
    GaussSeidel,
    /// All elements gather at once: a bounce of light a sweep.
    Jacobi,
    /// Successive over-relaxation: Gauss–Seidel steps, each `omega` times as long.
    Sor {
        /// Limit: above 0, below 2. 1 is Gauss–Seidel.
        omega: f32,
    },
    /// Progressive refinement: the element with the most unshot light shoots, again and again
    /// (Southwell's relaxation; Cohen, Chen, Wallace and Greenberg 1988).
    ProgressiveRefinement,
    /// Conjugate gradients on the symmetrised system.
    ConjugateGradients,
}

impl Solver {
    /// A short name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::GaussSeidelMeanField => "Gauss–Seidel with mean field",
            Self::GaussSeidel => "Gauss–Seidel",
            Self::Jacobi => "Jacobi",
            Self::Sor { .. } => "over-relaxation",
            Self::ProgressiveRefinement => "progressive refinement",
            Self::ConjugateGradients => "conjugate gradients",
        }
    }
}

/// How the radiosity system `R = ρ (D + F R)` is solved.
///
/// All give the same light within the tolerance, and all say how far they may be off: the bound of
/// the [report](crate::radiosity::SolverReport) holds whatever the method. They differ in time.
///
/// | solver | closed box, ρ = 0.6 / 0.95 / 0.99 | open room | made for |
/// |---|---|---|---|
/// | Gauss–Seidel with a mean field | 4 / 6 / 6 | 5 | everything |
/// | Gauss–Seidel | 9 / 90 / 459 | 7 | comparison |
/// | Jacobi | 16 / 178 / 916 | 13 | counting bounces |
/// | over-relaxation, ω = 1.2 | 5 / 59 / 305 | 5 | comparison |
/// | progressive refinement | 10 / 89 / 507 | 7 | looking on while it solves |
/// | conjugate gradients | 4 / 5 / 6 | 5 | bright rooms that see little of each other |
///
/// Sweeps until the light of 1,000 elements is off by 1e-4 (root of mean squares). A sweep of Jacobi
/// takes half as long as one of Gauss–Seidel, as many shots as there are elements twenty times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Solver {
    /// Gauss–Seidel sweeps, each followed by a mean-field correction: light that is everywhere too
    /// low by the same factor, which bounces take longest to find, is put in at once. The default.
    ///
    /// A handful of sweeps for any reflectance. Slower where light must cross several rooms that
    /// see little of each other, for which one factor is too few: 48 sweeps for three rooms in a
    /// row of ρ = 0.95, where Gauss–Seidel alone takes 88 and conjugate gradients 10.
    #[default]
    GaussSeidelMeanField,
    /// Every element in turn gathers from the newest values (Cohen and Greenberg 1985).
    ///
    /// Never fails while ρ · row sum is below 1, but takes as many sweeps as light takes bounces to
    /// die out, halved: hundreds in a bright closed room.
    GaussSeidel,
    /// All elements gather at once, from the values of the sweep before: a bounce of light a sweep.
    ///
    /// Twice the sweeps of Gauss–Seidel. Elements do not wait for each other, so a sweep runs on
    /// all cores; and the light after `k` sweeps is just that of the first `k + 1` bounces.
    Jacobi,
    /// Successive over-relaxation (Young 1954): Gauss–Seidel steps, each `omega` times as long.
    ///
    /// 1.1 to 1.3 saves a third of the sweeps. Which `omega` is best depends on the room. Much
    /// above 1.5 errors swing from side to side instead of dying out: where they grow three sweeps
    /// running, Gauss–Seidel with a mean field takes over and the report says so.
    Sor {
        /// Limit: above 0, below 2. 1 is Gauss–Seidel.
        omega: f32,
    },
    /// Progressive refinement: the element with the most unshot light shoots it at all others,
    /// again and again (Cohen, Chen, Wallace and Greenberg 1988), which is Southwell's relaxation
    /// (Gortler, Cohen and Slusallek 1993).
    ///
    /// Made for looking on: after a few shots most of the light is where it belongs, and with an
    /// ambient term for the rest the picture has its final brightness from the start, see
    /// [`Observer::partial`](crate::radiosity::Observer::partial). To the end it takes longer than
    /// Gauss–Seidel, much longer where surfaces are bright. Keeps the matrix a second time, by
    /// columns: twice the memory of a hit list.
    ProgressiveRefinement,
    /// Conjugate gradients (Hestenes and Stiefel 1952) on the symmetrised system.
    ///
    /// As few sweeps as the default, also in a row of rooms, where one factor for all light is not
    /// enough. It needs reciprocity, `A_i F_ij = A_j F_ji`, which form factors found from each side
    /// apart have only nearly: so it solves with the mean of both, an estimate of the light as good
    /// as the other but not the same.
    /// [`asymmetry`](crate::radiosity::SolverReport::asymmetry) says how far the two are apart.
    /// Symmetrising costs more than solving, and takes three or four times the memory of a hit
    /// list.
    ConjugateGradients,
}

impl Solver {
    /// One of each kind.
    pub const ALL: [Self; 6] = [
        Self::GaussSeidelMeanField,
        Self::GaussSeidel,
        Self::Jacobi,
        Self::Sor { omega: 1.2 },
        Self::ProgressiveRefinement,
        Self::ConjugateGradients,
    ];

    /// A short name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::GaussSeidelMeanField => "Gauss–Seidel with a mean field",
            Self::GaussSeidel => "Gauss–Seidel",
            Self::Jacobi => "Jacobi",
            Self::Sor { .. } => "over-relaxation",
            Self::ProgressiveRefinement => "progressive refinement",
            Self::ConjugateGradients => "conjugate gradients",
        }
    }

    /// What to do about it where it does not converge.
    pub(crate) const fn cure(self) -> &'static str {
        match self {
            Self::Sor { .. } => "choose an omega nearer to 1",
            _ => "choose Gauss–Seidel with a mean field",
        }
    }
}

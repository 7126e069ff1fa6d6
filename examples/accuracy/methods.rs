//! What is swept: methods, the knob of each, and what a step of the knob costs.

use bevy_fresco::radiosity::{BakeSettings, FormFactors, Solver};

/// A method and the values of its knob.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    /// What the knob counts, for people.
    pub(crate) knob: &'static str,
    pub(crate) budgets: &'static [u32],
    /// Form factors, rays of an element, and rays to lamps: `None` leaves lamps to form factors.
    pub(crate) choose: fn(u32) -> (FormFactors, u32, Option<u32>),
    /// How many times the work of a budget of 1 a budget is.
    pub(crate) work: fn(u32) -> f64,
    /// Whether the work grows with pairs of elements.
    pub(crate) pairwise: bool,
}

/// Shadow rays from an element to all lamps together, the same for all methods.
pub(crate) const LAMP_RAYS: u32 = 128;

const RAYS: [u32; 9] = [16, 32, 64, 128, 256, 512, 1024, 2048, 4096];
const PIXELS: [u32; 6] = [16, 32, 64, 128, 256, 512];

/// Methods of finding form factors; lamps are sampled.
pub(crate) const FAMILIES: [Family; 4] = [
    Family {
        name: "hit list",
        knob: "rays",
        budgets: &RAYS,
        choose: |rays| (FormFactors::HitList, rays, Some(LAMP_RAYS)),
        work: f64::from,
        pairwise: false,
    },
    Family {
        name: "hemicube",
        knob: "pixels",
        budgets: &PIXELS,
        choose: |resolution| (FormFactors::Hemicube { resolution }, 1, Some(LAMP_RAYS)),
        work: |resolution| f64::from(resolution).powi(2),
        pairwise: true,
    },
    Family {
        name: "analytic",
        knob: "rays a pair",
        budgets: &[1, 2, 4, 8, 16, 32, 64],
        choose: |visibility_rays| {
            (
                FormFactors::Analytic { visibility_rays },
                1,
                Some(LAMP_RAYS),
            )
        },
        work: f64::from,
        pairwise: true,
    },
    Family {
        name: "area sampling",
        knob: "rays a pair",
        budgets: &[1, 4, 16, 64, 256],
        choose: |samples| (FormFactors::AreaSampling { samples }, 1, Some(LAMP_RAYS)),
        work: f64::from,
        pairwise: true,
    },
];

/// Two ways with lamps: sampled with as many rays as go into form factors, and left to form
/// factors, as the first radiosity programs did.
pub(crate) const LAMPS: [Family; 3] = [
    Family {
        name: "hit list, lamps sampled",
        choose: |rays| (FormFactors::HitList, rays, Some(rays)),
        ..FAMILIES[0]
    },
    Family {
        name: "hit list finds lamps",
        choose: |rays| (FormFactors::HitList, rays, None),
        ..FAMILIES[0]
    },
    Family {
        name: "hemicube finds lamps",
        choose: |resolution| (FormFactors::Hemicube { resolution }, 1, None),
        ..FAMILIES[1]
    },
];

impl Family {
    /// The settings for a budget on about so many elements.
    pub(crate) fn settings(&self, budget: u32, elements: u32) -> BakeSettings {
        let (form_factors, element_rays, lamp_rays) = (self.choose)(budget);
        BakeSettings {
            form_factors,
            element_rays,
            emitter_rays: lamp_rays.unwrap_or(1),
            sample_emitters: lamp_rays.is_some(),
            ..base(elements)
        }
    }
}

/// What all runs have in common.
pub(crate) fn base(elements: u32) -> BakeSettings {
    BakeSettings {
        elements,
        // Methods are compared on the same elements.
        adapt: false,
        // Far below all errors charted.
        solver_tolerance: 1e-4,
        max_sweeps: 1000,
        max_reflectance: 0.995,
        max_memory: 16 << 30,
        ..BakeSettings::FINAL
    }
}

/// Solvers whose sweeps are counted.
pub(crate) const SOLVERS: [(&str, Solver); 7] = [
    ("Jacobi", Solver::Jacobi),
    ("Gauss–Seidel", Solver::GaussSeidel),
    ("SOR, ω = 1.2", Solver::Sor { omega: 1.2 }),
    ("SOR, ω = 1.5", Solver::Sor { omega: 1.5 }),
    ("progressive refinement", Solver::ProgressiveRefinement),
    ("conjugate gradients", Solver::ConjugateGradients),
    ("Gauss–Seidel + mean field", Solver::GaussSeidelMeanField),
];

//! Every method with every budget on one scene.

use bevy_fresco::radiosity::{BakeError, BakeSettings, ValidScene};

use crate::measure::{Cost, solve};
use crate::methods::{FAMILIES, Family, LAMPS};
use crate::metrics::median;
use crate::plan::Plan;
use crate::reference::{Errors, Reference};
use crate::scenes::{Judged, Subject};

/// A method with a budget on a scene, and what came of it.
pub(crate) struct Point {
    pub(crate) subject: &'static Subject,
    /// About how many elements were asked for, and how many there are.
    pub(crate) size: u32,
    pub(crate) elements: usize,
    pub(crate) family: &'static Family,
    pub(crate) budget: u32,
    pub(crate) outcome: Outcome,
}

pub(crate) enum Outcome {
    Measured(Box<Measured>),
    /// Would have taken about so many seconds.
    TooSlow(f64),
}

/// The median of several runs.
pub(crate) struct Measured {
    pub(crate) settings: BakeSettings,
    pub(crate) runs: u32,
    pub(crate) cost: Cost,
    pub(crate) errors: Errors,
    pub(crate) floor: f64,
    pub(crate) sweeps: f64,
    pub(crate) rays: f64,
    /// The solver's bound on its own error.
    pub(crate) bound: f64,
}

impl Point {
    pub(crate) fn measured(&self) -> Option<&Measured> {
        match &self.outcome {
            Outcome::Measured(measured) => Some(measured),
            Outcome::TooSlow(_) => None,
        }
    }

    /// The error this point is judged by.
    pub(crate) fn error(&self, errors: &Errors) -> f64 {
        match self.subject.judged {
            Judged::Bounced => errors.bounced.l2,
            Judged::AllInASphere => errors.total.l2,
        }
    }
}

/// Measures all methods on a scene of one size.
pub(crate) fn sweep(
    subject: &'static Subject,
    scene: &ValidScene,
    size: u32,
    reference: &Reference,
    plan: &Plan,
) -> Result<Vec<Point>, BakeError> {
    let lamps: &[Family] = if subject.compares_lamps && size == 1000 {
        &LAMPS
    } else {
        &[]
    };
    let mut points = Vec::new();
    for family in FAMILIES.iter().chain(lamps) {
        // Pairs of so many elements are gigabytes.
        if family.pairwise && size > 4000 {
            continue;
        }
        let mut pace: Option<f64> = None;
        for &budget in plan.some(family.budgets) {
            let expected = pace.map_or(0.0, |pace| pace * (family.work)(budget));
            let outcome = if expected > plan.limit {
                Outcome::TooSlow(expected)
            } else {
                let measured = measure(subject, scene, size, (family, budget), reference, plan)?;
                pace = Some(measured.cost.wall / (family.work)(budget));
                Outcome::Measured(Box::new(measured))
            };
            points.push(Point {
                subject,
                size,
                elements: reference.elements,
                family,
                budget,
                outcome,
            });
        }
    }
    Ok(points)
}

/// Runs a method several times, once only if that takes longer than it may.
fn measure(
    subject: &Subject,
    scene: &ValidScene,
    size: u32,
    (family, budget): (&Family, u32),
    reference: &Reference,
    plan: &Plan,
) -> Result<Measured, BakeError> {
    let mut settings = family.settings(budget, size);
    settings.sample_emitters &= subject.judged == Judged::Bounced;
    let (mut costs, mut errors, mut reports) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 1..=plan.runs {
        settings.seed = seed;
        let (light, cost) = solve(scene, &settings)?;
        errors.push(reference.errors(&light));
        costs.push(cost);
        reports.push(light.report);
        if cost.wall > plan.limit {
            break;
        }
    }
    let of =
        |figure: fn(&bevy_fresco::radiosity::Report) -> f64| median(reports.iter().map(figure));
    Ok(Measured {
        runs: costs.len() as u32,
        cost: Cost::median(&costs),
        errors: Errors::median(&errors),
        floor: reference.floor,
        sweeps: of(|r| f64::from(r.solver.sweeps)),
        rays: of(|r| (r.work.element_rays + r.work.light_rays + r.work.emitter_rays) as f64),
        bound: of(|r| r.solver.error_bound),
        settings,
    })
}

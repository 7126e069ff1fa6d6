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
        let mut known: Vec<(f64, Cost)> = Vec::new();
        for &budget in plan.some(family.budgets) {
            let work = (family.work)(budget);
            let expected = expected(&known, work);
            let outcome = if expected > plan.limit {
                Outcome::TooSlow(expected)
            } else {
                let measured = measure(subject, scene, size, (family, budget), reference, plan)?;
                known.push((work, measured.cost));
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

/// Seconds of a run with more work than the runs before: what they show of the power by which time
/// grows goes on, and where one run shows nothing yet, it is the root.
fn expected(known: &[(f64, Cost)], work: f64) -> f64 {
    let Some(&(done, last)) = known.last() else {
        return 0.0;
    };
    let power = match known {
        [.., (less, before), _] => {
            let grown = (last.bounces() / before.bounces()).ln() / (done / less).ln();
            grown.clamp(0.0, 1.0)
        }
        _ => 0.5,
    };
    last.wall + last.bounces() * ((work / done).powf(power) - 1.0)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on_as_it_grew() {
        let cost = |form_factors: f64| Cost {
            wall: form_factors + 1.0,
            form_factors,
            ..Cost::default()
        };
        assert_eq!(expected(&[], 16.0), 0.0);
        assert!((expected(&[(1.0, cost(3.0))], 16.0) - 13.0).abs() < 1e-9);
        let linear = [(1.0, cost(3.0)), (2.0, cost(6.0))];
        assert!((expected(&linear, 4.0) - 13.0).abs() < 1e-9);
        let constant = [(1.0, cost(3.0)), (4.0, cost(3.0))];
        assert!((expected(&constant, 16.0) - 4.0).abs() < 1e-9);
    }
}

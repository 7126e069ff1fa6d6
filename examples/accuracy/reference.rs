//! What runs are compared with: light known in closed form, or the mean of many long runs and how
//! far that may be off.

use bevy_fresco::radiosity::{
    BakeError, BakeSettings, Element, ElementLight, FormFactors, ValidScene,
};

use crate::measure::{luminance, solve};
use crate::methods::base;
use crate::metrics::{Metrics, compare};
use crate::plan::Plan;
use crate::scenes::{Judged, Subject};

/// The light of every element as it should be.
pub(crate) struct Reference {
    pub(crate) subject: &'static str,
    pub(crate) elements: usize,
    pub(crate) runs: u32,
    pub(crate) rays: u32,
    /// Standard error of the light that is judged, relative, as [`Metrics::l2`].
    pub(crate) standard_error: f64,
    /// Errors below this are not told apart from errors of the reference.
    pub(crate) floor: f64,
    /// What an independent method says, where one was asked.
    pub(crate) second: Option<Second>,
    truth: Vec<Light>,
    /// Area of elements that count, 0 of others.
    area: Vec<f64>,
}

/// The light at an element by the way it took.
#[derive(Clone, Copy, Default)]
struct Light {
    bounced: f64,
    direct: f64,
}

/// The mean of several runs of analytic form factors against the reference.
#[derive(Clone, Copy)]
pub(crate) struct Second {
    pub(crate) difference: Metrics,
    /// What the standard errors of both lead one to expect of [`Metrics::l2`].
    pub(crate) expected: f64,
}

impl Second {
    /// Whether both say the same as far as their noise lets one tell.
    pub(crate) fn agrees(&self) -> bool {
        self.difference.l2 < 2.0 * self.expected
    }
}

/// Errors of a run by the way the light took.
#[derive(Clone, Copy, Default)]
pub(crate) struct Errors {
    pub(crate) bounced: Metrics,
    pub(crate) direct: Metrics,
    pub(crate) total: Metrics,
}

impl Errors {
    pub(crate) fn median(runs: &[Self]) -> Self {
        let of = |part: fn(&Self) -> Metrics| {
            Metrics::median(&runs.iter().map(part).collect::<Vec<_>>())
        };
        Self {
            bounced: of(|e| e.bounced),
            direct: of(|e| e.direct),
            total: of(|e| e.total),
        }
    }
}

/// Below three standard errors of the reference, its own error adds more than 5 % to any other.
const STANDARD_ERRORS: f64 = 3.0;

/// Shadow rays between two elements in the second reference, and how many elements it is asked
/// on at most: it takes all pairs of them.
pub(crate) const SECOND_RAYS: u32 = 16;
const SECOND_UP_TO: usize = 1500;

impl Reference {
    /// Averages long runs; where the answer is known takes that.
    pub(crate) fn find(
        subject: &Subject,
        scene: &ValidScene,
        elements: u32,
        plan: &Plan,
    ) -> Result<Self, BakeError> {
        let runs = plan.reference_runs(elements);
        let rays = plan.reference_rays;
        let settings = |run: u32| BakeSettings {
            element_rays: rays,
            emitter_rays: rays / 2,
            sample_emitters: subject.judged == Judged::Bounced,
            seed: 1000 + run,
            ..base(elements)
        };
        let (sums, last) = average(scene, runs, settings)?;
        let area = last.as_ref().map_or_else(Vec::new, |light| {
            let area = |e| f64::from(u8::from((subject.counts)(e))) * f64::from(e.area);
            light.elements.iter().map(area).collect()
        });
        let mut reference = Self {
            subject: subject.id,
            elements: area.len(),
            runs,
            rays,
            standard_error: sums.standard_error(&area, subject.judged),
            floor: 0.0,
            second: None,
            truth: sums.mean(),
            area,
        };
        reference.floor = STANDARD_ERRORS * reference.standard_error;
        if let Some(light) = last.filter(|_| subject.judged == Judged::AllInASphere) {
            reference.know(&light);
        }
        Ok(reference)
    }

    /// Takes the closed form of the sphere: `H = mean(E) / (1 − mean(ρ))`, everywhere. It has no
    /// error of its own, so errors have no floor.
    fn know(&mut self, light: &ElementLight) {
        let (mut area, mut emission, mut reflectance) = (0.0, 0.0, 0.0);
        for element in &light.elements {
            let a = f64::from(element.area);
            area += a;
            emission += a * luminance(element.emission);
            reflectance += a * luminance(element.reflectance);
        }
        let known = Light {
            bounced: emission / (area - reflectance),
            direct: 0.0,
        };
        self.truth = vec![known; light.elements.len()];
        self.floor = 0.0;
    }

    /// Asks analytic form factors, which share nothing with hit lists but the hierarchy.
    pub(crate) fn ask_second(
        &mut self,
        scene: &ValidScene,
        elements: u32,
        judged: Judged,
    ) -> Result<(), BakeError> {
        if self.elements > SECOND_UP_TO || judged != Judged::Bounced {
            return Ok(());
        }
        let runs = self.runs.min(4);
        let settings = |run: u32| BakeSettings {
            form_factors: FormFactors::Analytic {
                visibility_rays: SECOND_RAYS,
            },
            emitter_rays: self.rays / 2,
            seed: 2000 + run,
            ..base(elements)
        };
        let (sums, _) = average(scene, runs, settings)?;
        let own = sums.standard_error(&self.area, judged);
        self.second = Some(Second {
            difference: self.compare_lights(&sums.mean()).bounced,
            expected: own.hypot(self.standard_error),
        });
        Ok(())
    }

    pub(crate) fn errors(&self, light: &ElementLight) -> Errors {
        self.compare_lights(&lights(light))
    }

    fn compare_lights(&self, found: &[Light]) -> Errors {
        let of = |part: fn(&Light) -> f64| {
            let samples: Vec<[f64; 3]> = (self.area.iter().zip(found).zip(&self.truth))
                .filter(|((area, _), _)| **area > 0.0)
                .map(|((&area, found), truth)| [area, part(found), part(truth)])
                .collect();
            compare(&samples)
        };
        Errors {
            bounced: of(|l| l.bounced),
            direct: of(|l| l.direct),
            total: of(|l| l.bounced + l.direct),
        }
    }
}

/// Adds up so many runs; the last one as well, if there was one.
fn average(
    scene: &ValidScene,
    runs: u32,
    settings: impl Fn(u32) -> BakeSettings,
) -> Result<(Sums, Option<ElementLight>), BakeError> {
    let mut sums = Sums::default();
    let mut last = None;
    for run in 0..runs {
        let (light, _) = solve(scene, &settings(run))?;
        sums.add(&lights(&light));
        last = Some(light);
    }
    Ok((sums, last))
}

fn lights(light: &ElementLight) -> Vec<Light> {
    let of = |e: &Element| Light {
        bounced: luminance(e.irradiance - e.direct),
        direct: luminance(e.direct),
    };
    light.elements.iter().map(of).collect()
}

/// Sums over runs, for means and their standard errors.
#[derive(Default)]
struct Sums {
    runs: f64,
    /// Of each element: light, and the square of what is judged.
    light: Vec<(Light, [f64; 2])>,
}

impl Sums {
    fn add(&mut self, lights: &[Light]) {
        self.runs += 1.0;
        self.light.resize(lights.len(), Default::default());
        for ((sum, squares), light) in self.light.iter_mut().zip(lights) {
            sum.bounced += light.bounced;
            sum.direct += light.direct;
            squares[0] += light.bounced.powi(2);
            squares[1] += (light.bounced + light.direct).powi(2);
        }
    }

    fn mean(&self) -> Vec<Light> {
        let mean = |(sum, _): &(Light, _)| Light {
            bounced: sum.bounced / self.runs,
            direct: sum.direct / self.runs,
        };
        self.light.iter().map(mean).collect()
    }

    /// `√(Σ A σ² / n / Σ A r²)` with the variance σ² of `n` runs.
    fn standard_error(&self, area: &[f64], judged: Judged) -> f64 {
        let (mut spread, mut of_truth) = (0.0, 0.0);
        for ((sum, squares), area) in self.light.iter().zip(area) {
            let (sum, square) = match judged {
                Judged::Bounced => (sum.bounced, squares[0]),
                Judged::AllInASphere => (sum.bounced + sum.direct, squares[1]),
            };
            let mean = sum / self.runs;
            let variance = (square / self.runs - mean * mean).max(0.0) / (self.runs - 1.0).max(1.0);
            spread += area * variance;
            of_truth += area * mean * mean;
        }
        (spread / of_truth.max(f64::MIN_POSITIVE)).sqrt()
    }
}

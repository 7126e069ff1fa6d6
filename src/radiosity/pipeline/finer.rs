use super::passes::Deadline;
use super::{Run, Solved};
use crate::radiosity::estimate::estimate_counts;
use crate::radiosity::findings::COVER;
use crate::radiosity::form_factor::FormFactors;
use crate::radiosity::settings::BakeSettings;

/// Share of the error asked for that the size of elements may leave, and as much that chance may
/// in their rays: together what vertices leave to them.
const ELEMENTS: f64 = 0.36;

/// What elements leave out goes down as their number to the power of −0.75, and what
/// chance leaves as that of their rays to the power of −0.7 (measured on the Cornell box).
const CELLS_BY_ERROR: f64 = 1.0 / 0.75;
const RAYS_BY_ERROR: f64 = 1.0 / 0.7;

/// So many times what the settings say, at most.
const MORE_ELEMENTS: f64 = 8.0;
const MORE_RAYS: f64 = 4.0;

/// Elements are not made anew for fewer than so many times as many, or their rays.
const WORTH: f64 = 1.2;

/// Share of the time and of the memory allowed that they may take.
const TIME: f64 = 0.25;
const MEMORY: u64 = 2;

/// What elements leave out, as it was told twice: of the first elements, and of so many times as many.
///
/// How elements happen to lie around a lamp makes either estimate off by up to two times. Both tell of one
/// `c` in `e = c N^−0.75`, and the mean of its squares is closer.
pub(super) fn told_twice(first: f32, second: f32, times: f32) -> f32 {
    let first = first * times.powf(-1.0 / CELLS_BY_ERROR as f32);
    (0.5 * (first * first + second * second)).sqrt()
}

impl Run<'_> {
    /// The settings with more elements and rays, where those that they say leave too much of the error
    /// asked for, and time and memory allow it. Form factors that are not made of rays take too long for
    /// that.
    pub(super) fn finer(&self, solved: &Solved, deadline: &Deadline) -> Option<BakeSettings> {
        let settings = self.settings;
        let first = self.start.before.is_none() && self.start.plan.is_none();
        let by_rays = settings.form_factors == FormFactors::HitList;
        if !(first && by_rays && settings.refine && settings.adapt) {
            return None;
        }
        let may = ELEMENTS * f64::from(settings.error);
        let times = |error: f32, power: f64, most: f64| {
            let times = (f64::from(error) / may).powf(power).min(most);
            if times > WORTH { times } else { 1.0 }
        };
        let elements = times(solved.error.cells, CELLS_BY_ERROR, MORE_ELEMENTS);
        let rays = times(COVER * solved.error.vertices, RAYS_BY_ERROR, MORE_RAYS);
        let finer = BakeSettings {
            elements: (f64::from(settings.elements) * elements) as u32,
            element_rays: (f64::from(settings.element_rays) * rays) as u32,
            ..settings.clone()
        };
        let fits = deadline.spent() * elements * rays <= TIME
            && estimate_counts(self.scene, &finer).bytes <= settings.max_memory / MEMORY;
        (fits && finer != *settings && finer.check().is_ok()).then_some(finer)
    }
}

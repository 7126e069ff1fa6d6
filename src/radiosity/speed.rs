use std::time::{Duration, Instant};

use super::element::ElementId;
use super::form_factor::{FormFactors, RowByRow, View};
use super::observer::{Observer, Stage};
use super::occlusion::OFFSET;
use super::parallel::{Cancelled, map_ranges, threads};
use super::sampling::{cosine_hemisphere, frame, sobol};
use super::sampling_error::judged_again;

/// Places that the speed of rays is measured at, and rays from each.
const PLACES: usize = 512;
const RAYS: usize = 64;
const ROUNDS: u32 = 4;

/// Wall time of a ray with all threads at work: the fastest of a few rounds, the first of which
/// finds caches cold and threads asleep.
pub(super) fn seconds_per_ray(view: &View, observer: &dyn Observer) -> Result<f64, Cancelled> {
    let count = view.elements.len();
    let step = (count / PLACES).max(1);
    let places = count / step;
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let started = Instant::now();
        map_ranges(places, 8, Stage::Occlusion, observer, |range| {
            let places = range.map(|i| ElementId((i * step) as u32));
            places.map(|e| probe(view, e)).sum::<usize>()
        })?;
        best = best.min(started.elapsed().as_secs_f64());
    }
    Ok(best / (places * RAYS).max(1) as f64)
}

/// Rays from one place on an element, as the bake gathers them. Returns how many hit something.
fn probe(view: &View, element: ElementId) -> usize {
    let seed = view.elements.seed(element, 0xE571);
    let point = view.elements.point(view.scene, element, 0.5, 0.5);
    let origin = point.position + point.normal * OFFSET;
    let around = frame(point.normal);
    let hits = (0..RAYS).filter(|&i| {
        let [u, v, ..] = sobol(i as u32, 0, seed);
        let direction = around * cosine_hemisphere(u, v);
        let occluders = &view.occluders;
        let hit = occluders.closest(origin, direction, point.triangle, seed);
        hit.is_some()
    });
    hits.count()
}

/// The speed of rows is measured for so long at least, with so many rows at least.
const WHILE: Duration = Duration::from_millis(50);
const LEAST_ROWS: usize = 4;

/// What a row of twice the resolution takes beside a row, at most.
const DENSER: f64 = 4.0;

/// Wall time of all form factors that are not made of rays, those found again to judge them
/// included; 0 for a hit list, whose rays are counted.
pub(super) fn seconds_of_rows(view: &View, observer: &dyn Observer) -> Result<f64, Cancelled> {
    let started = Instant::now();
    let Some(rows) = RowByRow::new(*view) else {
        return Ok(0.0);
    };
    let set_up = started.elapsed().as_secs_f64();
    let count = view.elements.len();
    let whole = match view.settings.form_factors {
        // Each pair is found once, for both its rows.
        FormFactors::Analytic { .. } | FormFactors::AreaSampling { .. } => 0.5 * count as f64,
        FormFactors::HitList | FormFactors::Hemicube { .. } => count as f64,
    };
    let again = DENSER * judged_again(count) as f64;
    Ok(set_up + (whole + again) * seconds_per_row(&rows, count, observer)?)
}

/// Wall time of a row with all threads at work, of rows spread over all elements. Buffers are made
/// and caches filled in the first rounds; the last and longest is believed.
fn seconds_per_row(
    rows: &RowByRow,
    count: usize,
    observer: &dyn Observer,
) -> Result<f64, Cancelled> {
    let started = Instant::now();
    let mut tried = LEAST_ROWS.max(threads()).min(count);
    loop {
        let round = Instant::now();
        map_ranges(tried, 1, Stage::FormFactors, observer, |range| {
            let tried_rows = range.map(|i| rows.row(i * count / tried));
            tried_rows.map(|row| row.entries.len()).sum::<usize>()
        })?;
        if started.elapsed() >= WHILE || tried == count {
            return Ok(round.elapsed().as_secs_f64() / tried.max(1) as f64);
        }
        tried = (2 * tried).min(count);
    }
}

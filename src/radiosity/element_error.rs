use glam::{Vec3, Vec3A};

use super::color::luminance;
use super::element::Elements;
use super::form_factor::View;
use super::level::Level;
use super::observer::{Observer, Stage};
use super::parallel::{Cancelled, map_ranges};
use super::sampling::hash;

/// Elements that look at both solutions, and rays from each.
const RECEIVERS: usize = 512;
const RAYS: u32 = 64;

/// The share of the surface that counts: beside a lamp light is so much more than elsewhere that a few
/// receivers there would be all of the mean.
const MOST: f64 = 0.98;

/// Receivers a thread takes at a time.
const CHUNK: usize = 8;

/// What leaves elements of one size.
#[derive(Clone, Copy)]
pub(crate) struct Sent<'a> {
    pub(crate) elements: &'a Elements,
    pub(crate) light: &'a [Vec3A],
}

impl Sent<'_> {
    fn at(&self, hit: &super::occlusion::Hit) -> Vec3A {
        (self.elements.at(hit)).map_or(Vec3A::ZERO, |e| self.light[e.0 as usize])
    }
}

/// How far the light that two solutions send to the same places is apart, relative to the [`Level`] of
/// what arrives there, and the rays it took to tell.
///
/// Each ray knows the triangle and the place on it that it hit, and finds there an element of either
/// solution. What elements of constant light leave out goes with their size `h`: of two solutions the
/// finer one is off by no more than they are apart, if its elements are half as large.
///
/// ```text
///   e(h) ≈ c h     ┌──────────────────────────────┐
///                  │  e(h/2) ≈ |L(h) − L(h/2)|    │
///                  └──────────────────────────────┘
/// ```
pub(crate) fn apart(
    view: &View,
    arriving: &[Vec3],
    (fine, coarse): (Sent, Sent),
    observer: &dyn Observer,
) -> Result<(f64, u64), Cancelled> {
    let count = view.elements.len();
    let bright = fine.elements.bright(fine.light);
    let receivers = RECEIVERS.min(count);
    let parts = map_ranges(receivers, CHUNK, Stage::Error, observer, |range| {
        let mut found = Vec::with_capacity(range.len());
        for i in range {
            let (first, next) = (i * count / receivers, (i + 1) * count / receivers);
            let e = first + hash(i as u32, view.settings.seed) as usize % (next - first);
            let mut sum = Vec3A::ZERO;
            for hit in (0..RAYS).filter_map(|ray| view.hit(e, ray)) {
                let (fine, coarse) = (fine.at(&hit), coarse.at(&hit));
                // What is far brighter is not left to chance in the gather, and would be all of the mean.
                if fine.max(coarse).element_sum() <= bright {
                    sum += fine - coarse;
                }
            }
            let d = f64::from(luminance(Vec3::from(sum))) / f64::from(RAYS);
            let weight = f64::from(view.elements.area[e]) * (next - first) as f64;
            let light = f64::from(luminance(arriving[e]));
            found.push((weight, d * d, light));
        }
        found
    })?;
    let found = parts.concat();
    let level = Level::of(found.iter().map(|&(weight, _, light)| (weight, light)));
    let squares = (found.iter()).map(|&(weight, d, light)| (level.relative(d, light), weight));
    let error = mean_of_most(squares.collect()).sqrt();
    let rays = receivers as u64 * u64::from(RAYS);
    Ok((error, rays))
}

/// Mean of values with weights, without the largest.
fn mean_of_most(mut values: Vec<(f64, f64)>) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = values.iter().map(|v| v.1).sum();
    let (mut sum, mut weight) = (0.0, 0.0);
    for (value, own) in values {
        if weight + own > MOST * all {
            break;
        }
        sum += value * own;
        weight += own;
    }
    sum / f64::max(weight, f64::MIN_POSITIVE)
}

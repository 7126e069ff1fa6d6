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
///
/// Two halves of the rays are multiplied instead of squaring what all tell, so that what chance makes of
/// so few rays drops out of the mean.
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
            let mut halves = [Vec3A::ZERO; 2];
            for ray in 0..RAYS {
                let Some(hit) = view.hit(e, ray) else {
                    continue;
                };
                let (fine, coarse) = (fine.at(&hit), coarse.at(&hit));
                // What is far brighter is not left to chance in the gather, and would be all of the mean.
                if fine.max(coarse).element_sum() <= bright {
                    halves[ray as usize % 2] += fine - coarse;
                }
            }
            let [a, b] = halves.map(|sum| f64::from(luminance(sum.into())) / f64::from(RAYS / 2));
            let weight = f64::from(view.elements.area[e]) * (next - first) as f64;
            let light = f64::from(luminance(arriving[e]));
            found.push((weight, a * b, light));
        }
        found
    })?;
    let found = parts.concat();
    let level = Level::of(found.iter().map(|&(weight, _, light)| (weight, light)));
    let squares = (found.iter()).map(|&(w, square, light)| (level.relative(square, light), w));
    let error = most_of(squares.collect()).max(0.0).sqrt();
    let rays = receivers as u64 * u64::from(RAYS);
    Ok((error, rays))
}

/// Mean of values with weights, without those farthest from 0, and a standard error more.
fn most_of(mut values: Vec<(f64, f64)>) -> f64 {
    values.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let all: f64 = values.iter().map(|v| v.1).sum();
    let (mut weight, mut sums) = (0.0, [0.0; 3]);
    for (value, own) in values {
        if weight + own > MOST * all {
            break;
        }
        weight += own;
        let terms = [value * own, (value * own).powi(2), own * own];
        sums = [0, 1, 2].map(|i| sums[i] + terms[i]);
    }
    let weight = f64::max(weight, f64::MIN_POSITIVE);
    let mean = sums[0] / weight;
    let spread = (sums[1] - mean * mean * sums[2]).max(0.0).sqrt() / weight;
    mean + spread
}

use glam::{Vec3, Vec3A};

use super::color::luminance;
use super::element::Elements;
use super::form_factor::{Traced, View};
use super::glare::GLARING;
use super::level::Level;
use super::observer::{Observer, Stage};
use super::occlusion::Hit;
use super::parallel::{Cancelled, map_ranges};
use super::sampling::hash;

/// The error of a solution, beside how far it is [`apart`] from one of elements twice as large:
/// `1 / (2^1.3 − 1)`.
pub(crate) const OF_FINER: f64 = 0.684;

/// Elements that look at both solutions, and rays from each.
const RECEIVERS: usize = 512;
const RAYS: u32 = 64;

/// The share of the surface that counts: beside a lamp light is so much more than elsewhere that a few
/// receivers there would be all of the mean.
const MOST: f64 = 0.98;

/// Receivers a thread takes at a time.
const CHUNK: usize = 8;

/// What leaves the spots of elements of one size, as each half of the rays of their form factors tells it.
pub(crate) struct Sent<'a> {
    pub(crate) elements: &'a Elements,
    pub(crate) spots: [Vec<Vec3A>; 2],
}

impl<'a> Sent<'a> {
    /// Of what leaves each element by all its rays, `seen`. Form factors that are not made of rays have no
    /// halves: both are the whole.
    pub(crate) fn new(view: &View<'a>, traced: &Traced, seen: &[Vec3A]) -> Self {
        let elements = view.elements;
        let (mut a, mut b) = (seen.to_vec(), seen.to_vec());
        for e in 0..elements.len() {
            if let Some([first, second]) = traced.halves(e, elements, seen, view.scene.sky) {
                let off = Vec3A::from((first - second) * 0.5 * elements.reflectance[e]);
                a[e] += off;
                b[e] -= off;
            }
        }
        Self {
            elements,
            spots: [a, b].map(|light| elements.spread(&light)),
        }
    }

    fn at(&self, hit: &Hit) -> [Vec3A; 2] {
        let spot = self.elements.spot_at(hit);
        let light = |half: &Vec<Vec3A>| spot.map_or(Vec3A::ZERO, |spot| half[spot.0 as usize]);
        [light(&self.spots[0]), light(&self.spots[1])]
    }
}

/// How far the light that two solutions send to the same places is apart, relative to the [`Level`] of
/// what arrives there, and the rays it took to tell.
///
/// Each ray knows the triangle and the place on it that it hit, and finds there an element of either
/// solution. What elements leave out goes with a power of their size `h`, 1.3 at least (1.7 was measured on the
/// Cornell box, with light linear between their middles): so two solutions tell how far off the finer one is, if its
/// elements are half as large.
///
/// ```text
///   e(h) ≈ c h^1.3     ┌─────────────────────────────────────────┐
///                      │  e(h/2) ≈ |L(h) − L(h/2)| / (2^1.3 − 1) │
///                      └─────────────────────────────────────────┘
/// ```
///
/// Two halves of the rays are multiplied instead of squaring what all tell, and each sees what one half of
/// the elements' own rays found: so what chance makes of so few rays drops out of the mean.
pub(crate) fn apart(
    view: &View,
    arriving: &[Vec3],
    (fine, coarse): (&Sent, &Sent),
    observer: &dyn Observer,
) -> Result<(f64, u64), Cancelled> {
    let count = view.elements.len();
    let whole = |[a, b]: [Vec3A; 2]| 0.5 * (a + b);
    let glaring = GLARING * fine.elements.level(arriving).least() as f32;
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
                // What glares is not left to chance in the gather, and would be all of the mean.
                if luminance(whole(fine).max(whole(coarse)).into()) <= glaring {
                    let half = ray as usize % 2;
                    halves[half] += fine[half] - coarse[half];
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

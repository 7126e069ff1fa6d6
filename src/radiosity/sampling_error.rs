use glam::{Vec3, Vec3A};

use super::color::luminance;
use super::direct::{Sampler, ShadowRays, loose_emission};
use super::form_factor::{Row, Traced, View, row_again};
use super::observer::Observer;
use super::observer::Stage;
use super::parallel::{Cancelled, map_ranges};
use super::sampling::hash;
use super::solve::Solution;

/// What chance, or a coarse picture, leaves in the light of elements.
///
/// A few elements are asked twice. Rays and shadow rays come in two half-sets `A`, `B`: half their
/// difference is as large as the error of the whole. Form factors that are not made of rays are
/// found once more with twice the resolution.
///
/// ```text
///   d = (H_A − H_B) / 2     or     d = H − H_denser
/// ```
///
/// The errors of elements are independent, so most of them cancels in the next bounce and at
/// vertices, which see many elements: of its variance the mean of `Σ_j F_ij²` is left. What does not
/// cancel is their mean, which every bounce repeats: it grows by the factor that reflection between
/// surfaces makes light grow by,
///
/// ```text
///   ┌─────────────────────────────────────────────────────────────┐
///   │  e² = var(d) + v²     v² = Σ_j F_ij² var(ρ d) + g² mean(ρ d)²  │
///   │  g = Σ A ρ / Σ A ρ (1 − F ρ)                                  │
///   └─────────────────────────────────────────────────────────────┘
/// ```
///
/// with `e` the error at elements and `v` what of it arrives at vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SamplingError {
    /// Of light arriving at elements: RMS beside the mean.
    pub(crate) elements: f32,
    /// What that adds to the error of light arriving at vertices, the same way.
    pub(crate) vertices: f32,
}

/// Elements asked: so many of all, and at least and at most.
const SHARE: usize = 24;
const LEAST: usize = 64;
const MOST: usize = 256;

/// Elements a thread takes at a time.
const CHUNK: usize = 4;

/// What the error is found with.
pub(crate) struct Judge<'a> {
    pub(crate) view: &'a View<'a>,
    pub(crate) sampler: &'a Sampler<'a>,
    pub(crate) traced: &'a Traced,
    pub(crate) solution: &'a Solution,
}

/// Light and difference of one element asked, luminance.
struct Asked {
    area: f64,
    light: f64,
    difference: f64,
    /// The same, of the light that leaves by reflection.
    reflected: f64,
    /// `Σ_j F_ij²`.
    concentration: f64,
}

impl Judge<'_> {
    /// Asks, and says how many shadow rays that took.
    pub(crate) fn run(
        &self,
        observer: &dyn Observer,
    ) -> Result<(SamplingError, ShadowRays), Cancelled> {
        let chosen = self.chosen();
        let seen = self.seen();
        let chunks = map_ranges(chosen.len(), CHUNK, Stage::Error, observer, |range| {
            let mut rays = ShadowRays::default();
            let ask = |&e: &usize| self.ask(e, &seen, &mut rays);
            let asked: Vec<Asked> = chosen[range].iter().map(ask).collect();
            (asked, rays)
        })?;
        let (mut asked, mut rays) = (Vec::new(), ShadowRays::default());
        for (some, cost) in chunks {
            asked.extend(some);
            rays.lights += cost.lights;
            rays.emitters += cost.emitters;
        }
        Ok((self.error(&asked), rays))
    }

    /// One element of every stretch of the list, at random.
    fn chosen(&self) -> Vec<usize> {
        let count = self.view.elements.len();
        let asked = (count / SHARE).clamp(LEAST, MOST).min(count);
        let first = |i: usize| i * count / asked.max(1);
        (0..asked)
            .map(|i| {
                let length = first(i + 1) - first(i);
                first(i) + hash(i as u32, self.view.settings.seed) as usize % length
            })
            .collect()
    }

    /// What leaves each element and form factors find.
    fn seen(&self) -> Vec<Vec3A> {
        let loose = loose_emission(self.view.elements, self.view.marks);
        let reflected = self.solution.reflected.iter();
        reflected.zip(loose).map(|(&r, e)| r + e).collect()
    }

    fn ask(&self, e: usize, seen: &[Vec3A], rays: &mut ShadowRays) -> Asked {
        let (scene, elements) = (self.view.scene, self.view.elements);
        let [a, b] = self.sampler.halves(e, rays);
        let direct = (a - b) * 0.5;
        let bounced = match self.traced.halves(e, elements, seen, scene.sky) {
            Some([a, b]) => (a - b) * 0.5,
            None => row_again(self.view, e).map_or(Vec3::ZERO, |row| {
                self.traced.light(e, seen, scene.sky) - light_of(&row, seen, scene.sky)
            }),
        };
        let mut concentration = 0.0;
        let mut weights: Vec<(u32, f32)> = Vec::new();
        self.traced
            .rows
            .each(e, |id, weight| weights.push((id, weight)));
        weights.sort_by_key(|w| w.0);
        for same in weights.chunk_by(|a, b| a.0 == b.0) {
            concentration += same.iter().map(|w| f64::from(w.1)).sum::<f64>().powi(2);
        }
        let difference = f64::from(luminance(direct) + luminance(bounced));
        let rho = elements.reflectance[e];
        Asked {
            area: elements.area[e].into(),
            light: luminance(self.solution.arriving[e]).into(),
            difference,
            reflected: f64::from(luminance(direct * rho) + luminance(bounced * rho)),
            concentration,
        }
    }

    fn error(&self, asked: &[Asked]) -> SamplingError {
        let area: f64 = asked.iter().map(|a| a.area).sum();
        let mean = |of: &dyn Fn(&Asked) -> f64| {
            asked.iter().map(|a| of(a) * a.area).sum::<f64>() / area.max(f64::MIN_POSITIVE)
        };
        let level = mean(&|a| a.light);
        if level <= 0.0 {
            return SamplingError::default();
        }
        let variance = mean(&|a| a.difference.powi(2));
        let reflected = mean(&|a| a.reflected.powi(2));
        // The mean of a few errors is off by chance; the mean of all by less.
        let by_chance = |count: usize| reflected / count.max(1) as f64;
        let shift = mean(&|a| a.reflected).powi(2) - by_chance(asked.len());
        let shift = shift.max(0.0) + by_chance(self.view.elements.len());
        let left = mean(&|a| a.concentration) * reflected;
        let vertices = left + self.growth().powi(2) * shift;
        SamplingError {
            elements: ((variance + vertices).sqrt() / level) as f32,
            vertices: (vertices.sqrt() / level) as f32,
        }
    }

    /// By how much reflection between surfaces makes the mean of light grow.
    fn growth(&self) -> f64 {
        let (elements, rows) = (self.view.elements, &self.traced.rows);
        let rho: Vec<Vec3A> = elements.reflectance.iter().map(|&r| r.into()).collect();
        let (mut reflected, mut lost) = (0.0, 0.0);
        for (e, rho_e) in rho.iter().enumerate() {
            let out = f64::from(luminance((*rho_e).into())) * f64::from(elements.area[e]);
            reflected += out;
            lost += out * (1.0 - f64::from(luminance(rows.gather(e, &rho).as_vec3())));
        }
        if lost > 0.0 { reflected / lost } else { 1.0 }
    }
}

/// Light that arrives over a row.
fn light_of(row: &Row, seen: &[Vec3A], sky: Vec3) -> Vec3 {
    let entries = row.entries.iter();
    let light: Vec3A = entries.map(|&(j, f)| seen[j as usize] * f).sum();
    Vec3::from(light) + sky * row.sky
}

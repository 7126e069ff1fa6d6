use glam::{Vec3, Vec3A};

use super::color::luminance;
use super::direct::{Sampler, ShadowRays, loose_emission};
use super::element_error::{OF_FINER, Sent, apart};
use super::first_look::FirstLook;
use super::form_factor::{Matrix, RowByRow, Traced, View};
use super::observer::{Observer, Stage};
use super::parallel::{Cancelled, map_chunks, map_ranges};
use super::sampling::hash;
use super::settings::BakeSettings;
use super::solve::Solution;

/// What chance, or a coarse picture, leaves in the light of elements.
///
/// Rays and shadow rays come in two half-sets `A`, `B`: half their difference is as large as the
/// error of the whole. Where form factors are not made of rays, a few elements find theirs once more
/// with twice the resolution.
///
/// ```text
///   d = (H_A − H_B) / 2     or     d = H − H_denser
/// ```
///
/// The errors of elements are independent, so most of them cancels in the next bounce and at
/// vertices, which see many elements: of its variance the mean of `Σ_j F_ij²` is left. What does not
/// cancel is their mean, which every bounce repeats: it grows by the factor `g` that reflection
/// between surfaces makes light grow by,
///
/// ```text
///   ┌───────────────────────────────────────────────────────────────┐
///   │  e² = mean d² + v²     v² = Σ_j F_ij² mean (ρd)² + g² (mean ρd)² │
///   │  g = Σ A ρ / Σ A ρ (1 − F ρ)                                    │
///   └───────────────────────────────────────────────────────────────┘
/// ```
///
/// where to the mean comes what was cut off rows that summed to more than 1; with `e` the error at elements and `v` what of it arrives at vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SamplingError {
    /// Of light arriving at elements: RMS beside the mean.
    pub(crate) elements: f32,
    /// What that adds to the error of light arriving at vertices, the same way.
    pub(crate) vertices: f32,
    /// Not chance, but what constant light in each element leaves out of light arriving anywhere, the
    /// same way; 0 where only one solution is known.
    pub(crate) cells: f32,
}

/// Elements whose lights and emitters are asked again: one of so many, at least and at most so many.
/// Direct light is wrong at the edges of shadows, which a few elements would miss.
const DIRECT: (usize, usize, usize) = (8, 256, 1024);

/// The same of form factors, which take longer the second time than the first.
const BOUNCED: (usize, usize, usize) = (24, 64, 256);

/// How many of so many elements find form factors that are not made of rays once more.
pub(crate) fn judged_again(elements: usize) -> usize {
    asked(elements, BOUNCED)
}

fn asked(elements: usize, (one_of, least, most): (usize, usize, usize)) -> usize {
    (elements / one_of).clamp(least, most).min(elements)
}

/// Elements a thread takes at a time, of those asked again and of all.
const CHUNK: usize = 4;
const MANY: usize = 256;

/// A mean of errors whose square is more than this many times what chance makes of it is no chance: three
/// standard errors, for a few elements right beside a lamp are most of them, and their tails are heavy.
const SIGNIFICANT: f64 = 9.0;

/// What the error is found with.
pub(crate) struct Judge<'a> {
    pub(crate) view: &'a View<'a>,
    pub(crate) sampler: &'a Sampler<'a>,
    pub(crate) traced: &'a Traced,
    pub(crate) solution: &'a Solution,
    /// A solution of coarser elements.
    pub(crate) first: Option<&'a FirstLook>,
}

/// Errors of some elements, luminance, and moments of them.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    count: usize,
    area: f64,
    /// Σ A d².
    squares: f64,
    /// Σ A ρ d and Σ A (ρ d)².
    reflected: f64,
    reflected_squares: f64,
}

impl Errors {
    fn add(&mut self, area: f32, reflectance: Vec3, d: Vec3) {
        let (area, reflected) = (f64::from(area), f64::from(luminance(d * reflectance)));
        self.count += 1;
        self.area += area;
        self.squares += area * f64::from(luminance(d)).powi(2);
        self.reflected += area * reflected;
        self.reflected_squares += area * reflected.powi(2);
    }

    fn join(mut self, other: &Self) -> Self {
        self.count += other.count;
        self.area += other.area;
        self.squares += other.squares;
        self.reflected += other.reflected;
        self.reflected_squares += other.reflected_squares;
        self
    }

    /// mean d², mean (ρ d)², and the square of the mean of ρ d over `all` elements.
    fn moments(&self, all: usize) -> [f64; 3] {
        let mean = |sum: f64| sum / self.area.max(f64::MIN_POSITIVE);
        let spread = mean(self.reflected_squares);
        let by_chance = |count: usize| spread / count.max(1) as f64;
        // The mean of a few is off by chance, and means nothing unless it is well above that.
        let found = mean(self.reflected).powi(2);
        let shift = if self.count < all && found < SIGNIFICANT * by_chance(self.count) {
            by_chance(all)
        } else {
            found.max(by_chance(all))
        };
        [mean(self.squares), spread, shift]
    }
}

impl Judge<'_> {
    /// Says how large the error is, and how many shadow rays that took.
    pub(crate) fn run(&self, observer: &dyn Observer) -> Result<(SamplingError, u64), Cancelled> {
        let seen = self.seen();
        let (direct, cost) = self.direct(observer)?;
        let settings = self.view.settings;
        let denser = BakeSettings {
            form_factors: settings.form_factors.denser(),
            seed: hash(settings.seed, 0xDE45E),
            ..settings.clone()
        };
        let denser = RowByRow::new(View {
            settings: &denser,
            ..*self.view
        });
        let bounced = match denser {
            Some(denser) => self.bounced_again(&denser, &seen, observer)?,
            None => self.bounced_by_halves(&seen),
        };
        let (cells, rays) = self.left_out(&seen, observer)?;
        let error = SamplingError {
            cells,
            ..self.error(&direct, &bounced, &seen)
        };
        Ok((error, cost + rays))
    }

    /// One element of every stretch of the list, at random.
    fn chosen(&self, how_many: (usize, usize, usize)) -> Vec<usize> {
        let count = self.view.elements.len();
        let asked = asked(count, how_many);
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

    /// Errors of light from lights and emitters.
    fn direct(&self, observer: &dyn Observer) -> Result<(Errors, u64), Cancelled> {
        let chosen = self.chosen(DIRECT);
        let parts = map_ranges(chosen.len(), CHUNK, Stage::Error, observer, |range| {
            let (mut errors, mut rays) = (Errors::default(), ShadowRays::default());
            for &e in &chosen[range] {
                let [a, b] = self.sampler.halves(e, &mut rays);
                self.add(e, (a - b) * 0.5, &mut errors);
            }
            (errors, rays.lights + rays.emitters)
        })?;
        let cost = parts.iter().map(|p| p.1).sum();
        let errors = parts.iter().map(|p| &p.0);
        Ok((errors.fold(Errors::default(), Errors::join), cost))
    }

    /// Errors of light over form factors that are not made of rays.
    fn bounced_again(
        &self,
        denser: &RowByRow,
        seen: &[Vec3A],
        observer: &dyn Observer,
    ) -> Result<Errors, Cancelled> {
        let sky = self.view.scene.sky;
        let chosen = self.chosen(BOUNCED);
        let parts = map_ranges(chosen.len(), CHUNK, Stage::Error, observer, |range| {
            let mut errors = Errors::default();
            for &e in &chosen[range] {
                let d = self.traced.light(e, seen, sky) - denser.row(e).light(seen, sky);
                self.add(e, d, &mut errors);
            }
            errors
        })?;
        Ok(parts.iter().fold(Errors::default(), Errors::join))
    }

    /// Errors of light over form factors that are made of rays.
    fn bounced_by_halves(&self, seen: &[Vec3A]) -> Errors {
        let elements = self.view.elements;
        let sky = self.view.scene.sky;
        let parts = map_chunks(elements.len(), MANY, |range| {
            let mut errors = Errors::default();
            for e in range {
                if let Some([a, b]) = self.traced.halves(e, elements, seen, sky) {
                    self.add(e, (a - b) * 0.5, &mut errors);
                }
            }
            errors
        });
        parts.iter().fold(Errors::default(), Errors::join)
    }

    fn add(&self, e: usize, d: Vec3, errors: &mut Errors) {
        let elements = self.view.elements;
        errors.add(elements.area[e], elements.reflectance[e], d);
    }

    /// What elements of constant light leave out, and the rays to tell.
    fn left_out(&self, seen: &[Vec3A], observer: &dyn Observer) -> Result<(f32, u64), Cancelled> {
        let Some(first) = self.first else {
            return Ok((0.0, 0));
        };
        let fine = Sent::new(self.view, self.traced, seen);
        let coarse = Sent {
            elements: &first.elements,
            spots: first.halves.clone(),
        };
        let arriving = &self.solution.arriving;
        let (apart, rays) = apart(self.view, arriving, (&fine, &coarse), observer)?;
        Ok(((OF_FINER * apart) as f32, rays))
    }

    /// Mean light that arrives.
    fn level(&self) -> f64 {
        let elements = self.view.elements;
        let lit = elements.iter_area().zip(&self.solution.arriving);
        let light: f64 = lit.map(|(a, &l)| a * f64::from(luminance(l))).sum();
        light / elements.iter_area().sum::<f64>().max(f64::MIN_POSITIVE)
    }

    fn error(&self, direct: &Errors, bounced: &Errors, seen: &[Vec3A]) -> SamplingError {
        let elements = self.view.elements;
        let level = self.level();
        if level <= 0.0 {
            return SamplingError::default();
        }
        let [a, b] = [direct, bounced].map(|e| e.moments(elements.len()));
        let [squares, reflected, shift] = std::array::from_fn(|i| a[i] + b[i]);
        let shift = shift + self.cut_off(seen).powi(2);
        let vertices = self.concentration() * reflected + self.growth().powi(2) * shift;
        SamplingError {
            elements: ((squares + vertices).sqrt() / level) as f32,
            vertices: (vertices.sqrt() / level) as f32,
            cells: 0.0,
        }
    }

    /// Reflected light that was lost where rows were scaled down to 1, mean over elements. Chance makes
    /// some rows too large and some too small: cut the large ones, and their mean is too small.
    fn cut_off(&self, seen: &[Vec3A]) -> f64 {
        let elements = self.view.elements;
        let mut lost = 0.0;
        for (e, area) in elements.iter_area().enumerate() {
            let excess = f64::from(self.traced.excess(e));
            if excess > 0.0 {
                let light = self.traced.light(e, seen, Vec3::ZERO) * elements.reflectance[e];
                lost += area * excess * f64::from(luminance(light));
            }
        }
        lost / elements.iter_area().sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// Mean of `Σ_j F_ij²` over the surface, as some elements tell it.
    fn concentration(&self) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for e in self.chosen(BOUNCED) {
            // Elements are small where there is much light, and see much of it: they are not the surface.
            let own = f64::from(self.view.elements.area[e]);
            sum += own * concentration(&self.traced.rows, e);
            area += own;
        }
        sum / f64::max(area, f64::MIN_POSITIVE)
    }

    /// By how much reflection between surfaces makes the mean of light grow.
    fn growth(&self) -> f64 {
        let (elements, rows) = (self.view.elements, &self.traced.rows);
        let rho: Vec<Vec3A> = elements.reflectance.iter().map(|&r| r.into()).collect();
        let (mut reflected, mut lost) = (0.0, 0.0);
        for (e, area) in elements.iter_area().enumerate() {
            let out = area * f64::from(luminance(elements.reflectance[e]));
            let again = rows.gather(e, &rho).as_vec3();
            reflected += out;
            lost += out * (1.0 - f64::from(luminance(again)));
        }
        if lost > 0.0 { reflected / lost } else { 1.0 }
    }
}

/// `Σ_j F_ij²` of a row.
///
/// Where `S` rays of weight `w` tell a row, `n_j` of which met element `j`, the sum of `(n_j w)²` is at
/// least that of the rays' own squares, however small the elements are. A ray and another meet the same
/// element with the chance that is asked for:
///
/// ```text
///   ┌──────────────────────────────────────────────────┐
///   │  Σ_j F_ij² ≈ w² (Σ_j n_j² − S) / (1 − 1/S)         │
///   └──────────────────────────────────────────────────┘
/// ```
fn concentration(rows: &Matrix, e: usize) -> f64 {
    let mut weights: Vec<(u32, f32)> = Vec::new();
    rows.each(e, |id, weight| weights.push((id, weight)));
    weights.sort_by_key(|w| w.0);
    let squares: f64 = weights.iter().map(|w| f64::from(w.1).powi(2)).sum();
    let same = weights.chunk_by(|a, b| a.0 == b.0);
    let together: f64 = same
        .map(|w| w.iter().map(|w| f64::from(w.1)).sum::<f64>().powi(2))
        .sum();
    match rows {
        Matrix::Hits(hits) => {
            let own = f64::from(hits.per_ray(e));
            (together - squares).max(0.0) / (1.0 - own).max(f64::EPSILON)
        }
        Matrix::Rows(_) => together,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::form_factor::{HitList, Row};

    #[test]
    fn rows_of_weights_are_as_concentrated_as_they_say() {
        let row = Row {
            entries: vec![(0, 0.5), (2, 0.25)],
            sky: 0.25,
        };
        let rows = Matrix::of(vec![row.clone(), row.clone(), row]);
        assert_eq!(concentration(&rows, 1), 0.3125);
    }

    /// Rays that know `n` elements of one size by chance alone: with the squares of the rays' own the sum
    /// would be 1/16 and more.
    #[test]
    fn rays_do_not_make_rows_more_concentrated() {
        let (n, rays) = (1000, 16);
        let row = |e: u32| -> Vec<Option<u32>> {
            (0..rays).map(|k| Some(hash(k, hash(e, 7)) % n)).collect()
        };
        let lists: Vec<_> = (0..n).map(row).collect();
        let rows = Matrix::Hits(HitList::from_rows(&lists));
        let mean = (0..n as usize)
            .map(|e| concentration(&rows, e))
            .sum::<f64>()
            / f64::from(n);
        // 120 pairs in each of 1,000 rows: one in ten is expected to meet, give or take 9 %.
        assert!((mean * f64::from(n) - 1.0).abs() < 0.3, "{mean}");
    }
}

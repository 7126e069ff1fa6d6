use glam::{DMat3, DVec3, Vec3};

use super::step::Step;
use crate::mesh::Bisection;

/// A point where light is known, as two sets of rays tell it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Weights of the face's corners.
    pub(super) b: Vec3,
    pub(super) light: [Vec3; 2],
}

/// What is known of the light on one face of a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceLight {
    pub(super) samples: Vec<Sample>,
    /// Points that were asked, with those inside geometry.
    pub(super) asked: u32,
    /// The linear light that fits either set best, at the corners; without, too little is known.
    pub(super) fits: Option<[[DVec3; 3]; 2]>,
    /// Variance of the light of either set, mean over channels, by what sets them apart.
    pub(super) noise: f64,
    /// Mean square over the face of what no linear light on it can follow, mean over channels; below 0 by
    /// chance.
    pub(super) misfit: f64,
    /// Mean light, and over channels.
    pub(super) mean: f64,
    pub(super) area: f64,
    /// Where a line can be followed across it.
    pub(super) step: Option<Step>,
}

/// A misfit counts from so many of its standard errors on.
const SURE: f64 = 2.0;

/// Samples that three corner values fit whatever they are.
const CORNERS: usize = 3;

impl FaceLight {
    /// Hands samples on to the halves of a face: those nearer the other end of the cut edge go with
    /// `half`.
    pub(super) fn split(&mut self, cut: &Bisection) -> Self {
        let mut half = Self::default();
        let mut kept = Vec::with_capacity(self.samples.len());
        for sample in self.samples.drain(..) {
            let (is_in_half, b) = cut.hand_on(sample.b);
            let piece = if is_in_half {
                &mut half.samples
            } else {
                &mut kept
            };
            piece.push(Sample { b, ..sample });
        }
        self.samples = kept;
        half
    }

    /// Finds the misfit: what is left of the light of each set when its best linear fit is taken away,
    /// multiplied.
    ///
    /// Light on the face is `E`, sets `A` and `B` tell it as `E + ε_A` and `E + ε_B`. With `r` for what
    /// a linear fit to `n` points leaves,
    ///
    /// ```text
    ///                         ┌─────────────────────────────────┐
    ///   mean (r_A r_B) n      │  misfit² = Σ r_A r_B / (n − 3)  │
    ///                         └─────────────────────────────────┘
    /// ```
    ///
    /// because the errors of the two sets have nothing to do with each other: noise does not look
    /// like detail, on average. With `σ²` for the variance of either set, which their difference
    /// tells, the mean is off by `σ² / √(n − 3)` by chance. What does not stand out from that is
    /// taken for nothing, to either side: what chance adds on one face it takes from another, and
    /// meshes do not follow noise for ever.
    pub(super) fn judge(&mut self) {
        let light = self
            .samples
            .iter()
            .map(|s| f64::from((s.light[0] + s.light[1]).element_sum()));
        self.mean = light.sum::<f64>() / (6 * self.samples.len().max(1)) as f64;
        (self.misfit, self.noise, self.fits) = (0.0, 0.0, None);
        if self.samples.len() <= CORNERS + 1 {
            return;
        }
        let mut gram = DMat3::ZERO;
        let mut right = [[DVec3::ZERO; 3]; 2];
        for sample in &self.samples {
            let b = sample.b.as_dvec3();
            gram += DMat3::from_cols(b * b.x, b * b.y, b * b.z);
            for (set, light) in sample.light.iter().enumerate() {
                for channel in 0..3 {
                    right[set][channel] += b * f64::from(light[channel]);
                }
            }
        }
        if gram.determinant().abs() < 1e-9 {
            return;
        }
        let inverse = gram.inverse();
        let fits = right.map(|set| set.map(|channel| inverse * channel));
        let (mut sum, mut apart) = (0.0, 0.0);
        for sample in &self.samples {
            let b = sample.b.as_dvec3();
            let left = |set: usize| {
                let channels = fits[set].map(|fit| b.dot(fit));
                sample.light[set].as_dvec3() - DVec3::from(channels)
            };
            let (a, c) = (left(0), left(1));
            sum += (a * c).element_sum();
            apart += 0.5 * (a - c).length_squared();
        }
        let free = (self.samples.len() - CORNERS) as f64;
        self.noise = apart / (3.0 * free);
        self.misfit = beyond(sum / (3.0 * free), SURE * self.noise / free.sqrt());
        let by_corner = |set: [DVec3; 3]| {
            let corner = |i: usize| DVec3::new(set[0][i], set[1][i], set[2][i]);
            [corner(0), corner(1), corner(2)]
        };
        self.fits = Some(fits.map(by_corner));
    }

    /// Mean square over the face of what it takes to meet the light of its neighbours at the corners,
    /// which is `shared` there, mean over channels.
    ///
    /// Light that is off by `d` at the corners `i` and linear between them is off by
    ///
    /// ```text
    ///   ┌──────────────────────────────────┐
    ///   │  (Σ d_i² + Σ_{i<j} d_i d_j) / 6  │   in the mean square,
    ///   └──────────────────────────────────┘
    /// ```
    ///
    /// the product of two sets of which, again, knows no noise but by chance: the fit has that of 3 of
    /// `n` points.
    pub(super) fn strain(&self, shared: [[DVec3; 3]; 2]) -> f64 {
        let Some(fits) = self.fits else {
            return 0.0;
        };
        let off = |set: usize, i: usize| shared[set][i] - fits[set][i];
        let all = |set: usize| off(set, 0) + off(set, 1) + off(set, 2);
        let own: f64 = (0..CORNERS).map(|i| off(0, i).dot(off(1, i))).sum();
        // Σ_i a_i b_i + Σ_{i≠j} a_i b_j / 2
        let square = 0.5 * (own + all(0).dot(all(1))) / 6.0 / 3.0;
        let n = self.samples.len() as f64;
        beyond(square, SURE * (CORNERS as f64).sqrt() * self.noise / n)
    }
}

/// By how much a number is farther from 0 than a limit.
fn beyond(value: f64, limit: f64) -> f64 {
    value - value.clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiosity::sampling::{hash, sobol, triangle, unit_float};

    fn face(n: u32, light: impl Fn(Vec3, u32) -> [Vec3; 2]) -> FaceLight {
        let samples = (0..n).map(|i| {
            let [u, v, ..] = sobol(i, 0, 3);
            let b = triangle(u, v);
            Sample {
                b,
                light: light(b, i),
            }
        });
        FaceLight {
            samples: samples.collect(),
            area: 1.0,
            ..FaceLight::default()
        }
    }

    #[test]
    fn linear_light_fits() {
        let mut f = face(16, |b, _| [Vec3::splat(b.x * 3.0 + b.y); 2]);
        f.judge();
        assert!(f.misfit.abs() < 1e-10, "{}", f.misfit);
    }

    #[test]
    fn noise_is_no_detail_and_detail_is_not_noise() {
        let noise = |i: u32, set: u32| Vec3::splat(0.3 * (unit_float(hash(i, set)) - 0.5));
        let (mut flat, mut edged) = (0.0, 0.0);
        let runs = 200;
        for run in 0..runs {
            let of = |edge: f32| {
                let mut f = face(16, |b, i| {
                    let light = Vec3::splat(if b.x > 0.5 { edge } else { 0.0 });
                    [1, 2].map(|set| light + noise(i + 100 * run, set))
                });
                f.judge();
                f.misfit
            };
            flat += of(0.0) / f64::from(runs);
            edged += of(1.0) / f64::from(runs);
        }
        // The variance of the noise is 0.0075; a step of 1 leaves 0.05 or so.
        assert!(flat < 4e-4, "{flat}");
        assert!((0.02..0.1).contains(&edged), "{edged}");
    }

    #[test]
    fn halves_get_the_points_that_lie_on_them() {
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y];
        let place = |c: [Vec3; 3], b: Vec3| c[0] * b.x + c[1] * b.y + c[2] * b.z;
        for (edge, at) in [(0, 0.5), (1, 0.5), (2, 0.5), (0, 0.1), (1, 0.7), (2, 0.9)] {
            let before = face(32, |b, _| [place(corners, b); 2]);
            let mut first = before.clone();
            let second = first.split(&Bisection {
                face: 0,
                half: 1,
                edge,
                at,
            });
            assert_eq!(first.samples.len() + second.samples.len(), 32);
            let (i, j) = (usize::from(edge), (usize::from(edge) + 1) % 3);
            let middle = corners[i].lerp(corners[j], at);
            for (side, replaced) in [(&first, j), (&second, i)] {
                let mut c = corners;
                c[replaced] = middle;
                for s in &side.samples {
                    assert!(s.b.min_element() >= 0.0);
                    // The light was made to be the place.
                    assert!(place(c, s.b).distance(s.light[0]) < 1e-6);
                }
            }
        }
    }
}

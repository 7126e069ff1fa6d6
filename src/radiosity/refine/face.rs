use glam::{DMat3, DVec3, Vec3};

use crate::mesh::Bisection;
use crate::radiosity::level::Level;

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
    /// Mean square over the face of what no linear light on it can follow, mean over channels.
    pub(super) misfit: f64,
    /// Mean light, and over channels.
    pub(super) mean: f64,
    pub(super) area: f64,
}

/// A misfit counts from so many of its standard errors on.
const SURE: f64 = 1.5;

/// Samples that three corner values fit whatever they are.
const CORNERS: usize = 3;

impl FaceLight {
    /// Hands samples on to the halves of a face: those nearer the other end of the cut edge go with
    /// `half`.
    ///
    /// With the edge from corner `i` to corner `j` cut at its middle, a point `b` lies on the side of
    /// the larger of `b_i` and `b_j`, and there
    ///
    /// ```text
    ///   ┌─────────────────────────────────────────┐
    ///   │  b_near' = b_near − b_far   b_middle' = 2 b_far │
    ///   └─────────────────────────────────────────┘
    /// ```
    pub(super) fn split(&mut self, cut: &Bisection) -> Self {
        let (i, j) = (usize::from(cut.edge), (usize::from(cut.edge) + 1) % 3);
        let mut half = Self::default();
        let mut kept = Vec::with_capacity(self.samples.len());
        for mut sample in self.samples.drain(..) {
            let b = &mut sample.b;
            if b[i] >= b[j] {
                (b[i], b[j]) = (b[i] - b[j], 2.0 * b[j]);
                kept.push(sample);
            } else {
                (b[i], b[j]) = (2.0 * b[i], b[j] - b[i]);
                half.samples.push(sample);
            }
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
    ///                         ┌───────────────────────────────────────┐
    ///   mean (r_A r_B) n      │  misfit² = Σ r_A r_B / (n − 3)         │
    ///                         └───────────────────────────────────────┘
    /// ```
    ///
    /// because the errors of the two sets have nothing to do with each other: noise does not look
    /// like detail, on average. With `σ²` for the variance of either set, which their difference
    /// tells, the mean is off by `σ² / √(n − 3)` by chance. What does not stand out from that is
    /// taken for nothing, or meshes would follow noise for ever.
    pub(super) fn judge(&mut self) {
        let light = self
            .samples
            .iter()
            .map(|s| f64::from((s.light[0] + s.light[1]).element_sum()));
        self.mean = light.sum::<f64>() / (6 * self.samples.len().max(1)) as f64;
        self.misfit = 0.0;
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
        let noise = apart / (3.0 * free);
        self.misfit = (sum / (3.0 * free) - SURE * noise / free.sqrt()).max(0.0);
    }

    /// Its part of the mean square error, relative to the level.
    pub(super) fn error(&self, level: &Level) -> f64 {
        level.relative(self.misfit, self.mean) * self.area
    }
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
        for edge in 0..3_u8 {
            let before = face(32, |b, _| [place(corners, b); 2]);
            let mut first = before.clone();
            let second = first.split(&Bisection {
                face: 0,
                half: 1,
                edge,
            });
            assert_eq!(first.samples.len() + second.samples.len(), 32);
            let (i, j) = (usize::from(edge), (usize::from(edge) + 1) % 3);
            let middle = 0.5 * (corners[i] + corners[j]);
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

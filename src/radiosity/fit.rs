use glam::Vec3;

use super::color::{divide, luminance};
use super::gathered::TriangleSamples;
use super::gradient::bounded;
use super::kind::{ByKind, Kind};
use super::level::Level;
use super::parallel::Cancelled;
use super::quality::VertexQuality;
use super::receivers::Receivers;

/// Vertex light fitted to the samples.
pub(crate) struct Fit {
    /// Light (irradiance / π) of each unknown.
    pub(crate) light: Vec<Vec3>,
    pub(crate) smoothing: Smoothing,
    /// The part of it that rays gathered.
    pub(crate) gathered: Vec<Vec3>,
    /// Its gradient, if that is asked for.
    pub(crate) gradient: Option<Vec<Vec3>>,
    /// How sure each is, if that is asked for.
    pub(crate) quality: Option<Vec<VertexQuality>>,
    /// Area-weighted mean luminance.
    pub(crate) mean: f32,
    /// Unknowns without a sample of their own, filled along the mesh.
    pub(crate) filled: Vec<bool>,
    /// Unknowns on pieces of mesh without any sample.
    pub(crate) dark: Vec<bool>,
}

/// How noise is dealt with, as the samples themselves told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smoothing {
    /// How strongly neighbouring vertices are pulled together.
    pub(crate) lambda: ByKind<f32>,
    /// Relative RMS of the difference of two fits to half the samples each, halved: the error
    /// that chance leaves in the whole.
    pub(crate) sampling_error: f32,
    /// The same of each kind of light alone.
    pub(crate) by_kind: ByKind<f32>,
}

/// Samples of both kinds of light, by triangle of their meshes.
pub(crate) struct Samples<'a> {
    /// On the coarse meshes: bounced light, sky, wide emitters.
    pub(crate) smooth: &'a [TriangleSamples],
    /// On the fine meshes: light of lights and sampled emitters.
    pub(crate) sharp: &'a [TriangleSamples],
}

/// How strongly neighbouring vertices are at least pulled together, as a share of the samples' own
/// pull: light with sharp edges keeps them, gathered light is smooth and its noise is not.
const LEAST: ByKind<f32> = ByKind {
    smooth: 0.01,
    sharp: 0.001,
};

/// Stronger smoothing is tried in steps of this factor, up to the samples' own pull.
const STEP: f32 = 4.0;

/// Below this share of the mean, errors are no longer counted relative to the light.
const DARK: f64 = 0.1;

/// The least-squares fit stops at this relative residual: far below the samples' noise.
const TOLERANCE: f32 = 1e-4;

/// Iterations at most; a fill across a large area without samples takes the most.
const MAX_ITERATIONS: usize = 500;

/// Fits vertex values to samples inside triangles (Kavan, Bargteil and Sloan 2011, "Least Squares
/// Vertex Baking"), which follows light between vertices where point samples at vertices do not.
///
/// ```text
///   minimise  Σ_s w_s (Σ_k b_k(s) x_k − E_s)²  +  λ Σ_t A_t Σ_edges (x_i − x_j)²
///   ┌──────────────────────────────────────────────────────────┐
///   │  Σ_t (G_t + λ A_t L) x = Σ_t r_t     G_t = Σ w b bᵀ       │
///   └──────────────────────────────────────────────────────────┘
/// ```
///
/// with `L` the graph Laplacian of a triangle. Where there are no samples only the second term is
/// left: its minimum is the harmonic fill from the vertices around, along the mesh and so never
/// through a wall.
///
/// How much λ is right depends on the noise. The half-sets tell: a fit to one is judged by the
/// samples of the other (cross-validation), and λ grows as long as that gets better.
///
/// Each kind of light is fitted on its own mesh, and the coarse mesh's light is carried over to the
/// vertices of the fine one inside it. Unknowns of one of `seams` get one light. A `known` smoothing
/// is taken as it is, with the sampling error found along with it. `go_on` is asked between
/// solutions.
pub(crate) fn fit(
    samples: &Samples,
    receivers: &Receivers,
    seams: &[Vec<u32>],
    known: Option<&Smoothing>,
    go_on: &dyn Fn() -> bool,
) -> Result<Fit, Cancelled> {
    let unknowns = receivers.fine.unknowns;
    let layer = |kind: Kind, samples, unknowns| {
        fit_layer(
            samples,
            unknowns,
            kind,
            known.map(|k| k.lambda.of(kind)),
            go_on,
        )
    };
    let sharp = layer(Kind::Sharp, samples.sharp, unknowns)?;
    let smooth = layer(Kind::Smooth, samples.smooth, receivers.coarse.unknowns)?;
    let gathered = receivers.carried_over(&smooth.light);
    let both = sharp.light.iter().zip(&gathered);
    let mut whole: Vec<Vec3> = both.map(|(&a, &b)| a + b).collect();
    let (area, valid) = areas(samples.sharp, unknowns);
    let sampled: Vec<bool> = valid.iter().map(|&a| a > 0.0).collect();
    close_seams(&mut whole, &valid, seams);
    let total: f64 = (area.iter().map(|&a| f64::from(a)).sum::<f64>()).max(f64::MIN_POSITIVE);
    let mean = |f: &dyn Fn(usize) -> f64| {
        (0..unknowns)
            .map(|i| f(i) * f64::from(area[i]))
            .sum::<f64>()
            / total
    };
    let light = |i: usize| f64::from(luminance(whole[i]));
    let level = Level::of((0..unknowns).map(|i| (f64::from(area[i]), light(i))));
    let (sampling_error, by_kind) = match known {
        Some(known) => (known.sampling_error, known.by_kind),
        None => {
            let smooth = receivers.carried_over(&smooth.difference);
            let beside_mean = |difference: &dyn Fn(usize) -> Vec3| {
                let square = |i: usize| (0.5 * f64::from(luminance(difference(i)))).powi(2);
                mean(&|i| level.relative(square(i), light(i))).sqrt() as f32
            };
            (
                beside_mean(&|i| sharp.difference[i] + smooth[i]),
                ByKind {
                    smooth: beside_mean(&|i| smooth[i]),
                    sharp: beside_mean(&|i| sharp.difference[i]),
                },
            )
        }
    };
    let dark = unreached(samples.sharp, &sampled);
    Ok(Fit {
        smoothing: Smoothing {
            lambda: ByKind {
                smooth: smooth.lambda,
                sharp: sharp.lambda,
            },
            sampling_error,
            by_kind,
        },
        mean: mean(&light) as f32,
        filled: (0..unknowns).map(|i| !sampled[i] && !dark[i]).collect(),
        light: whole,
        gathered,
        gradient: None,
        quality: None,
        dark,
    })
}

/// Fits gradients to their samples as light was fitted, with the smoothing found then: they are as linear
/// in the light as the light itself.
pub(crate) fn fit_gradient(
    samples: &Samples,
    receivers: &Receivers,
    seams: &[Vec<u32>],
    fitted: &Fit,
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<Vec3>, Cancelled> {
    let unknowns = receivers.fine.unknowns;
    let lambda = fitted.smoothing.lambda;
    let layer = |samples: &[TriangleSamples], unknowns: usize, lambda: f32| {
        if go_on() {
            Ok(System::new(samples, unknowns, &[0, 1], lambda).solve())
        } else {
            Err(Cancelled)
        }
    };
    let sharp = layer(samples.sharp, unknowns, lambda.sharp)?;
    let smooth = layer(samples.smooth, receivers.coarse.unknowns, lambda.smooth)?;
    let gathered = receivers.carried_over(&smooth);
    let mut whole: Vec<Vec3> = sharp.iter().zip(&gathered).map(|(&a, &b)| a + b).collect();
    close_seams(&mut whole, &areas(samples.sharp, unknowns).1, seams);
    let bound = |(&gradient, &light)| bounded(gradient, light);
    Ok(whole.iter().zip(&fitted.light).map(bound).collect())
}

/// Surface around each unknown, and how much of it is known: of what lies inside geometry, and of all but
/// one of walls modelled twice, nothing is.
fn areas(samples: &[TriangleSamples], unknowns: usize) -> (Vec<f32>, Vec<f32>) {
    let mut area = vec![0.0_f32; unknowns];
    let mut valid = vec![0.0_f32; unknowns];
    for t in samples {
        let share = (t.taken - t.invalid) as f32 / t.taken.max(1) as f32;
        for &u in &t.unknowns {
            area[u as usize] += t.area / 3.0;
            valid[u as usize] += t.area / 3.0 * share;
        }
    }
    (area, valid)
}

/// One kind of light, fitted on its mesh.
struct Layer {
    light: Vec<Vec3>,
    /// Of the fits to the two half-sets; nothing if the smoothing was known.
    difference: Vec<Vec3>,
    lambda: f32,
}

fn fit_layer(
    triangles: &[TriangleSamples],
    unknowns: usize,
    kind: Kind,
    known: Option<f32>,
    go_on: &dyn Fn() -> bool,
) -> Result<Layer, Cancelled> {
    let mut difference = Vec::new();
    let lambda = match known {
        Some(lambda) => lambda,
        None => {
            let chosen = choose_smoothing(triangles, unknowns, kind, go_on)?;
            let [a, b] = chosen.fits;
            difference = a.into_iter().zip(b).map(|(a, b)| a - b).collect();
            chosen.lambda
        }
    };
    if !go_on() {
        return Err(Cancelled);
    }
    Ok(Layer {
        light: solve(triangles, unknowns, &[0, 1], lambda),
        difference,
        lambda,
    })
}

/// Gives vertices of different objects at one place the same light: the mean by valid area.
fn close_seams(light: &mut [Vec3], valid: &[f32], seams: &[Vec<u32>]) {
    for seam in seams {
        let weight: f32 = seam.iter().map(|&u| valid[u as usize]).sum();
        let sum: Vec3 = (seam.iter())
            .map(|&u| light[u as usize] * valid[u as usize])
            .sum();
        if weight > 0.0 {
            for &u in seam {
                light[u as usize] = sum / weight;
            }
        }
    }
}

/// Fits to each half-set and the smoothing they were made with.
struct Chosen {
    lambda: f32,
    fits: [Vec<Vec3>; 2],
    error: f64,
}

/// The smoothing with which each half-set foretells the other best.
fn choose_smoothing(
    triangles: &[TriangleSamples],
    unknowns: usize,
    kind: Kind,
    go_on: &dyn Fn() -> bool,
) -> Result<Chosen, Cancelled> {
    let attempt = |lambda| {
        if !go_on() {
            return Err(Cancelled);
        }
        let fits = [0, 1].map(|half| solve(triangles, unknowns, &[half], lambda));
        let error = squared_error(triangles, &fits[0], 1) + squared_error(triangles, &fits[1], 0);
        Ok(Chosen {
            lambda,
            fits,
            error,
        })
    };
    // A half-set is twice as noisy as the whole, which wants one step less: keep the one before.
    let mut chosen = attempt(LEAST.of(kind))?;
    let mut best = attempt(LEAST.of(kind) * STEP)?;
    if best.error >= chosen.error {
        return Ok(chosen);
    }
    while best.lambda * STEP <= 1.0 {
        let next = attempt(best.lambda * STEP)?;
        if next.error >= best.error {
            break;
        }
        chosen = std::mem::replace(&mut best, next);
    }
    Ok(chosen)
}

/// Σ w (fit − E)² / E² over the samples of a half-set, less what is the same for every fit.
///
/// Relative to the light around, as eyes judge it: else the brightest spot would decide alone.
fn squared_error(triangles: &[TriangleSamples], light: &[Vec3], half: usize) -> f64 {
    let level = |t: &TriangleSamples| -> f64 {
        let light = |h: usize| {
            t.halves[h]
                .light
                .iter()
                .map(|&l| f64::from(luminance(l)))
                .sum::<f64>()
        };
        let weight = |h: usize| f64::from(t.halves[h].weight());
        (light(0) + light(1)) / (weight(0) + weight(1)).max(f64::MIN_POSITIVE)
    };
    let area: f64 = triangles.iter().map(|t| f64::from(t.area)).sum();
    let mean = triangles
        .iter()
        .map(|t| level(t) * f64::from(t.area))
        .sum::<f64>()
        / area.max(f64::MIN_POSITIVE);
    let error = |t: &TriangleSamples| {
        let sums = &t.halves[half];
        let [a, b, c] = t.unknowns.map(|u| light[u as usize]);
        let [aa, ab, ac, bb, bc, cc] = sums.gram;
        let own =
            a * a * aa + b * b * bb + c * c * cc + (a * b * ab + a * c * ac + b * c * bc) * 2.0;
        let [x, y, z] = sums.light;
        let cross = a * x + b * y + c * z;
        let scale = level(t).powi(2) + (DARK * mean).powi(2);
        f64::from((own - cross * 2.0).element_sum()) / scale.max(f64::MIN_POSITIVE)
    };
    triangles.iter().map(error).sum()
}

/// Vertex values for some of the half-sets and one kind of light.
pub(crate) fn solve(
    triangles: &[TriangleSamples],
    unknowns: usize,
    halves: &[usize],
    smoothing: f32,
) -> Vec<Vec3> {
    let mut light = System::new(triangles, unknowns, halves, smoothing).solve();
    let limits = overshoot_limits(triangles, unknowns, halves);
    for (x, (lowest, highest)) in light.iter_mut().zip(limits) {
        *x = x.max(lowest).min(highest.max(lowest));
    }
    light
}

/// How far the fit may overshoot beside an edge of light: below a fifth of the darkest or above five times
/// the brightest triangle around, a vertex would be a dark or bright spot that is not there.
fn overshoot_limits(
    triangles: &[TriangleSamples],
    unknowns: usize,
    halves: &[usize],
) -> Vec<(Vec3, Vec3)> {
    let mut limits = vec![(Vec3::INFINITY, Vec3::ZERO); unknowns];
    for t in triangles {
        let weight: f32 = halves.iter().map(|&h| t.halves[h].weight()).sum();
        if weight <= 0.0 {
            continue;
        }
        let sum: Vec3 = halves.iter().flat_map(|&h| t.halves[h].light).sum();
        let mean = sum / weight;
        for &u in &t.unknowns {
            let (lowest, highest) = &mut limits[u as usize];
            *lowest = lowest.min(0.2 * mean);
            *highest = highest.max(5.0 * mean);
        }
    }
    let known = |(lowest, highest): (Vec3, Vec3)| {
        if lowest.x.is_finite() {
            (lowest, highest)
        } else {
            (Vec3::ZERO, Vec3::MAX)
        }
    };
    limits.into_iter().map(known).collect()
}

/// The normal equations, kept as one symmetric 3×3 matrix a triangle.
struct System {
    blocks: Vec<([u32; 3], [f32; 6])>,
    right: Vec<Vec3>,
    diagonal: Vec<f32>,
    start: Vec<Vec3>,
}

impl System {
    fn new(
        triangles: &[TriangleSamples],
        unknowns: usize,
        halves: &[usize],
        smoothing: f32,
    ) -> Self {
        // Areas span many powers of ten between scenes: count them by their mean.
        let mean_area = triangles.iter().map(|t| f64::from(t.area)).sum::<f64>()
            / triangles.len().max(1) as f64;
        let scale = (1.0 / mean_area.max(f64::MIN_POSITIVE)) as f32;
        let mut system = Self {
            blocks: Vec::with_capacity(triangles.len()),
            right: vec![Vec3::ZERO; unknowns],
            diagonal: vec![0.0; unknowns],
            start: Vec::new(),
        };
        let mut weight = vec![0.0_f32; unknowns];
        for t in triangles {
            // A half-set pulls half as much.
            let pull = 0.5 * halves.len() as f32 * smoothing * (t.area * scale).max(1e-6);
            let mut block = [2.0 * pull, -pull, -pull, 2.0 * pull, -pull, 2.0 * pull];
            for &half in halves {
                let sums = &t.halves[half];
                let right = sums.light;
                for (entry, gram) in block.iter_mut().zip(sums.gram) {
                    *entry += gram * scale;
                }
                for (&u, light) in t.unknowns.iter().zip(right) {
                    system.right[u as usize] += light * scale;
                }
                let [xx, xy, xz, yy, yz, zz] = sums.gram;
                for (k, row) in [xx + xy + xz, xy + yy + yz, xz + yz + zz]
                    .into_iter()
                    .enumerate()
                {
                    weight[t.unknowns[k] as usize] += row * scale;
                }
            }
            for (k, entry) in [block[0], block[3], block[5]].into_iter().enumerate() {
                system.diagonal[t.unknowns[k] as usize] += entry;
            }
            system.blocks.push((t.unknowns, block));
        }
        system.start = starting_values(triangles, &system.right, &weight);
        system
    }

    fn apply(&self, x: &[Vec3], y: &mut [Vec3]) {
        y.fill(Vec3::ZERO);
        for &([i, j, k], [ii, ij, ik, jj, jk, kk]) in &self.blocks {
            let (i, j, k) = (i as usize, j as usize, k as usize);
            let (a, b, c) = (x[i], x[j], x[k]);
            y[i] += a * ii + b * ij + c * ik;
            y[j] += a * ij + b * jj + c * jk;
            y[k] += a * ik + b * jk + c * kk;
        }
    }

    /// Conjugate gradients with the diagonal as preconditioner, three channels side by side.
    fn solve(&self) -> Vec<Vec3> {
        let n = self.right.len();
        let mut x = self.start.clone();
        let mut image = vec![Vec3::ZERO; n];
        self.apply(&x, &mut image);
        let mut r: Vec<Vec3> = self
            .right
            .iter()
            .zip(&image)
            .map(|(b, a)| *b - *a)
            .collect();
        let inverse: Vec<f32> = self
            .diagonal
            .iter()
            .map(|&d| if d > 0.0 { 1.0 / d } else { 0.0 })
            .collect();
        let precondition =
            |r: &[Vec3]| -> Vec<Vec3> { r.iter().zip(&inverse).map(|(r, i)| *r * *i).collect() };
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let goal = dot(&self.right, &precondition(&self.right)) * f64::from(TOLERANCE).powi(2);
        for _ in 0..MAX_ITERATIONS {
            if rz.cmple(goal).all() {
                break;
            }
            self.apply(&p, &mut image);
            let step = divide(rz, dot(&p, &image));
            for i in 0..n {
                x[i] += p[i] * step;
                r[i] -= image[i] * step;
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            let ratio = divide(next, rz);
            rz = next;
            for i in 0..n {
                p[i] = z[i] + p[i] * ratio;
            }
        }
        x
    }
}

fn dot(a: &[Vec3], b: &[Vec3]) -> glam::DVec3 {
    a.iter().zip(b).map(|(a, b)| (*a * *b).as_dvec3()).sum()
}

/// The mean of the samples around each unknown; unknowns without any take it from neighbours,
/// ring by ring.
fn starting_values(triangles: &[TriangleSamples], right: &[Vec3], weight: &[f32]) -> Vec<Vec3> {
    let mut values: Vec<Vec3> = right
        .iter()
        .zip(weight)
        .map(|(r, &w)| if w > 0.0 { *r / w } else { Vec3::ZERO })
        .collect();
    let mut known: Vec<bool> = weight.iter().map(|&w| w > 0.0).collect();
    let mut waiting: Vec<&TriangleSamples> = triangles
        .iter()
        .filter(|t| t.unknowns.iter().any(|&u| !known[u as usize]))
        .collect();
    loop {
        let mut sums = std::collections::BTreeMap::<u32, (Vec3, f32)>::new();
        for t in &waiting {
            let around: Vec<u32> = t
                .unknowns
                .into_iter()
                .filter(|&u| known[u as usize])
                .collect();
            for &u in t.unknowns.iter().filter(|&&u| !known[u as usize]) {
                for &v in &around {
                    let entry = sums.entry(u).or_default();
                    entry.0 += values[v as usize];
                    entry.1 += 1.0;
                }
            }
        }
        if sums.is_empty() {
            return values;
        }
        for (u, (sum, count)) in sums {
            values[u as usize] = sum / count;
            known[u as usize] = true;
        }
        waiting.retain(|t| t.unknowns.iter().any(|&u| !known[u as usize]));
    }
}

/// Unknowns that no chain of triangles joins to a sample.
fn unreached(triangles: &[TriangleSamples], sampled: &[bool]) -> Vec<bool> {
    let mut reached = sampled.to_vec();
    let mut waiting: Vec<&TriangleSamples> = triangles.iter().collect();
    loop {
        let before = waiting.len();
        waiting.retain(|t| {
            let any = t.unknowns.iter().any(|&u| reached[u as usize]);
            if any {
                for &u in &t.unknowns {
                    reached[u as usize] = true;
                }
            }
            !any
        });
        if waiting.len() == before {
            break;
        }
    }
    reached.into_iter().map(|r| !r).collect()
}

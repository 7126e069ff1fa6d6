use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::vertices::Inside;
use super::{Run, Solved};
use crate::radiosity::bake::BakeError;
use crate::radiosity::baked::Bake;
use crate::radiosity::estimate::vertices_within;
use crate::radiosity::fit::Fit;
use crate::radiosity::gather::{Density, Gather};
use crate::radiosity::gathered::Shining;
use crate::radiosity::kind::ByKind;
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::partial::PartialLight;
use crate::radiosity::receivers::Receivers;
use crate::radiosity::refine::{Asked, Control, Found, Refinement};
use crate::radiosity::report::Stopped;
use crate::radiosity::seams::open_seams;

/// The light of vertices, as one pass found it.
pub(crate) struct Pass {
    pub(crate) receivers: Receivers,
    pub(crate) refinement: Arc<Refinement>,
    pub(crate) density: Density,
    pub(crate) inside: Inside,
    pub(crate) fitted: Fit,
    /// How far off it is; of a bake that refines.
    pub(crate) control: Option<Control>,
    pub(crate) stopped: Stopped,
}

/// What the next pass does.
#[derive(Clone, Copy, Debug)]
struct Effort {
    /// Relative RMSE that vertices may leave.
    aim: f64,
    /// Relative RMSE that the meshes may leave.
    mesh: ByKind<f64>,
    /// Samples, so many times what the settings say.
    samples: ByKind<f32>,
}

/// Samples of any pass at least, beside what the settings say.
const LEAST_SAMPLES: f32 = 1.0;

/// Samples of any pass at most, and of the first, which is to show something soon.
const MOST_SAMPLES: f32 = 256.0;
const FIRST_SAMPLES: f64 = 4.0;

/// What chance leaves in either kind of light where samples are as the settings say, by which the first
/// pass goes: between 0.006 and 0.02 in rooms, which is soon told.
const USUAL_NOISE: f64 = 0.009;

/// Shares of the aim that meshes and samples may leave, squares of which add up to less than 1.
///
/// With `V` vertices meshes leave `m ∝ 1/V`, and `S` samples `n ∝ √(V/S)`, so that for the error `e`
///
/// ```text
///   S ∝ V / (e² − m²)      ┌─────────────────────────┐
///                          │  m² = e²/3   n² = 2e²/3 │   takes the fewest samples.
///                          └─────────────────────────┘
/// ```
///
/// Meshes may leave somewhat more than that, because to refine them takes time as well.
const MESH: ByKind<f64> = ByKind {
    smooth: 0.45,
    sharp: 0.5,
};
const SAMPLES: ByKind<f64> = ByKind {
    smooth: 0.5,
    sharp: 0.5,
};

/// What vertices leave that are fitted to all faces around them, beside what refinement goes by: the mean
/// at each vertex of what fits these faces one by one. About 0.8 for sharp light in courts and 1 for smooth light in
/// rooms, where it can be told; with less, more first passes would have to be done again.
const FIT: ByKind<f64> = ByKind {
    smooth: 1.0,
    sharp: 1.0,
};

/// Samples are spread so evenly that their error falls faster than by chance: as their number to the
/// power of −0.7.
const SAMPLES_BY_ERROR: f64 = 1.0 / 0.7;

/// Later passes aim at this share of the aim, so that most of them arrive.
const AIM: f64 = 0.88;

/// More samples alone, so many times, take less time than other meshes: those that there are count.
const MORE_ON_SAME: f64 = 3.0;

/// Steps to the right share, each of which halves what it may be off by.
const HALVINGS: u32 = 20;

/// From one pass to the next, samples at most, and mesh error at least.
const MORE_SAMPLES: f64 = 16.0;
const LESS_MESH: f64 = 0.4;

/// What meshes leave goes down faster than what is asked of them, to the power of so much: the less is asked, the
/// more rays look for detail, and the less of it noise hides.
const ASKED_BY_FOUND: f64 = 0.75;

/// Meshes are not made anew, nor samples taken, to leave this share of their error, or more.
const NOT_WORTH: f64 = 0.8;

/// From one pass to the next, so many times the vertices at most, these counted at least.
const MORE_VERTICES: usize = 8;
const FEW_VERTICES: usize = 4096;

/// A pass is of use if it leaves this share of the error of the one before, or less.
const USEFUL: f64 = 0.85;

/// So many passes in a row that were of no use are the last: the first may have had more samples where
/// the mesh was to blame.
const USELESS: u32 = 2;

/// The share of the error asked for that vertices may leave in any case: elements and solver, which
/// passes cannot mend, leave the rest.
const VERTICES: f64 = 0.75;

/// Passes at most.
const PASSES: usize = 6;

impl Run<'_> {
    /// Light at vertices: pass after pass until it is as good as was asked, where this bake places
    /// them; once, where an earlier one did or they are given.
    pub(super) fn passes(
        &mut self,
        gather: &mut Gather,
        shining: &Shining,
        solved: &Solved,
        deadline: &Deadline,
        show: &dyn Fn(&Self, &Pass),
    ) -> Result<Pass, BakeError> {
        if let Some(known) = self.known_receivers(solved) {
            let pass = self.pass(gather, shining, known, ByKind::both(1.0), None)?;
            let before = self.start.before.map(|b| &b.stages.plan);
            return Ok(match self.start.plan.or(before) {
                Some(plan) => Pass {
                    control: plan.control,
                    ..pass.stopped(plan.stopped)
                },
                None => pass,
            });
        }
        let (most, by_memory) = self.most_vertices(solved);
        let asked = f64::from(self.settings.error);
        let elements = self.findings(solved).error_of_elements();
        let aim = (asked * asked - elements * elements)
            .max(0.0)
            .sqrt()
            .max(VERTICES * asked);
        let mut effort = Effort {
            aim,
            mesh: MESH.with(FIT, |share, fit| share * aim / fit),
            samples: SAMPLES.map(|share| first_samples(share * aim)),
        };
        let (mut best, mut useless): (Option<Pass>, u32) = (None, 0);
        for left in (0..PASSES).rev() {
            let before = best.as_ref().map_or(0, |b| b.receivers.fine.vertex_count());
            let goal = Asked {
                error: effort.mesh,
                max_vertices: most.min(MORE_VERTICES * before.max(FEW_VERTICES)),
            };
            let pass = self.aimed_pass(
                gather,
                shining,
                solved,
                (&goal, best.as_ref()),
                effort,
                deadline,
            );
            let pass = match pass {
                Err(BakeError::Cancelled) if deadline.is_over() => {
                    return best
                        .ok_or(BakeError::Cancelled)
                        .map(|b| b.stopped(Stopped::Seconds));
                }
                pass => pass?,
            };
            let total = pass.bound();
            if total <= aim {
                let stopped = if total.hypot(elements) <= asked {
                    Stopped::Error
                } else {
                    Stopped::Limit
                };
                return Ok(pass.stopped(stopped));
            }
            let full = pass.refinement.full.is_some_and(|had| had >= most);
            let useful = (best.as_ref()).is_none_or(|b| total <= USEFUL * b.bound());
            useless = if useful { 0 } else { useless + 1 };
            let next = self.next(&pass, effort, full);
            let Some(next) = next.filter(|_| left > 0 && (full || useless < USELESS)) else {
                return Ok(pass.or_better(best).stopped(match (full, by_memory) {
                    (true, true) => Stopped::Memory,
                    (true, false) => Stopped::Vertices,
                    (false, _) => Stopped::Limit,
                }));
            };
            effort = next;
            show(self, &pass);
            best = Some(pass.or_better(best));
            deadline.arm();
        }
        best.ok_or(BakeError::Cancelled)
    }

    /// A pass with its effort, and how far off it leaves the light.
    fn aimed_pass(
        &mut self,
        gather: &mut Gather,
        shining: &Shining,
        solved: &Solved,
        (asked, before): (&Asked, Option<&Pass>),
        effort: Effort,
        deadline: &Deadline,
    ) -> Result<Pass, BakeError> {
        let good = |b: &&Pass| {
            let Refinement { error, full, .. } = *b.refinement;
            let fine = error.smooth <= asked.error.smooth && error.sharp <= asked.error.sharp;
            fine || full.is_some_and(|had| had >= asked.max_vertices)
        };
        let meshes = match before.filter(good) {
            Some(before) => (before.receivers.clone(), before.refinement.clone()),
            None => {
                let until = deadline.for_meshes();
                self.refine(gather, shining, solved, (asked, before), until)?
            }
        };
        let mut pass = self.pass(gather, shining, meshes, effort.samples, before)?;
        let control = self.control(gather, shining, &pass.receivers, (&pass.fitted, effort.aim))?;
        pass.control = Some(control);
        Ok(pass)
    }

    fn pass(
        &mut self,
        gather: &mut Gather,
        shining: &Shining,
        (receivers, refinement): (Receivers, Arc<Refinement>),
        samples: ByKind<f32>,
        earlier: Option<&Pass>,
    ) -> Result<Pass, BakeError> {
        gather.density = self.density(&receivers, samples);
        let inside = self.gather(gather, shining, &receivers, earlier)?;
        let seams = open_seams(&receivers.fine, gather);
        let fitted = self.fit(&inside, &receivers, &seams)?;
        Ok(Pass {
            receivers,
            refinement,
            density: gather.density,
            inside,
            fitted,
            control: None,
            stopped: Stopped::AsGiven,
        })
    }

    /// Where the next pass does more, or less; `None` if nothing would help.
    fn next(&self, pass: &Pass, effort: Effort, full: bool) -> Option<Effort> {
        let found = Parts::found(pass);
        let (error, aim) = (AIM * effort.aim, effort.aim);
        if let Some(times) = found.by_samples_alone(error, aim) {
            let samples =
                (effort.samples).with(times, |s, times| (s * times as f32).min(MOST_SAMPLES));
            return Some(Effort { samples, ..effort });
        }
        let may = found.cut_down_to(error, aim);
        let samples = found.samples(&may);
        let more = |samples: f32, times: f64, other_mesh: bool| match times > 1.0 / NOT_WORTH {
            true => (samples * times as f32).min(MOST_SAMPLES),
            false if other_mesh => (samples * times as f32).max(LEAST_SAMPLES),
            false => samples,
        };
        let finer = may.mesh.with(found.mesh, |may, found| {
            let times = (may / found.max(f64::MIN_POSITIVE)).clamp(LESS_MESH, 1.0);
            if times > NOT_WORTH {
                1.0
            } else {
                times.powf(ASKED_BY_FOUND)
            }
        });
        let remade = !full && finer.smooth.min(finer.sharp) < 1.0;
        let next = Effort {
            aim: effort.aim,
            mesh: match full {
                true => effort.mesh,
                // It may have had no room for what it was asked.
                false => (effort.mesh.with(pass.refinement.error, f64::max))
                    .with(finer, |error, times| error * times),
            },
            samples: ByKind {
                smooth: more(effort.samples.smooth, samples.smooth, finer.smooth < 1.0),
                sharp: more(effort.samples.sharp, samples.sharp, remade),
            },
        };
        // With the meshes as fine as may be, samples help until they are the smaller part.
        let useful = !full || found.noise.total() > 0.5 * found.mesh.total();
        let other = remade || next.samples != effort.samples;
        (useful && other).then_some(next)
    }

    /// Vertices that may be, and whether it is memory that limits them.
    fn most_vertices(&self, solved: &Solved) -> (usize, bool) {
        let given = solved.given.vertex_count();
        let asked = self.settings.max_vertices as usize;
        let held = vertices_within(self.scene, self.settings, given as u64);
        (asked.min(held).max(given), held < asked)
    }
}

/// Samples of the first pass, beside what the settings say, for chance to leave so much.
fn first_samples(may: f64) -> f32 {
    let times = (USUAL_NOISE / may.max(f64::MIN_POSITIVE)).powf(SAMPLES_BY_ERROR);
    times.clamp(LEAST_SAMPLES.into(), FIRST_SAMPLES) as f32
}

/// What the error of a pass is made of.
#[derive(Clone, Copy, Debug)]
struct Parts {
    /// What linear light between vertices leaves out.
    mesh: ByKind<f64>,
    /// What chance leaves in vertices.
    noise: ByKind<f64>,
}

impl Parts {
    fn found(pass: &Pass) -> Self {
        let control = pass.control.unwrap_or_default();
        let noise = pass.fitted.smoothing.by_kind.map(f64::from);
        let made_for = pass.refinement.error.with(FIT, |error, fit| fit * error);
        // Where little stands out from noise, the mesh is taken to be what it was made for.
        let left = |found: Found, (noise, made_for): (f64, f64)| {
            let left = found.square - noise * noise;
            if left > found.uncertain {
                left.sqrt()
            } else {
                made_for
            }
        };
        let parts = Self {
            mesh: (control.by_kind).with(noise.with(made_for, |n, made_for| (n, made_for)), left),
            noise,
        };
        // What cannot be told apart is everybody's.
        let more = pass.bound() / parts.total().max(f64::MIN_POSITIVE);
        Self {
            mesh: parts.mesh.map(|part| more * part),
            noise: parts.noise.map(|part| more * part),
        }
    }

    fn total(&self) -> f64 {
        self.mesh.total().hypot(self.noise.total())
    }

    /// The least that has to be done for an error of `error`: parts that are more than their share of
    /// the aim are cut down to the same multiple of it.
    fn cut_down_to(&self, error: f64, aim: f64) -> Self {
        Self::highest(error, |level| Self {
            mesh: self.mesh.with(MESH, least(level, aim)),
            noise: self.noise.with(SAMPLES, least(level, aim)),
        })
    }

    /// How many times the samples leave an error of `error` on the same meshes; `None` if that takes too
    /// many.
    fn by_samples_alone(&self, error: f64, aim: f64) -> Option<ByKind<f64>> {
        let may = Self::highest(error, |level| Self {
            mesh: self.mesh,
            noise: self.noise.with(SAMPLES, least(level, aim)),
        });
        let times = self.samples(&may);
        let left = self
            .mesh
            .total()
            .hypot(may.noise.smooth)
            .hypot(self.noise_of_edges(&may));
        (left <= aim && times.smooth.max(times.sharp) <= MORE_ON_SAME).then_some(times)
    }

    /// How many times the samples leave no more noise than that.
    fn samples(&self, may: &Self) -> ByKind<f64> {
        let times = |error: f64, may: f64, power: f64| {
            ((error / may.max(f64::MIN_POSITIVE)).powf(power))
                .clamp(1.0 / MORE_SAMPLES, MORE_SAMPLES)
        };
        ByKind {
            smooth: times(self.noise.smooth, may.noise.smooth, SAMPLES_BY_ERROR),
            sharp: times(self.noise.sharp, self.noise_of_edges(may), 2.0),
        }
    }

    /// The noise of sharp light that it is worth going down to. Where an edge of light crosses a triangle, the
    /// samples in it say as little of it as the mesh can carry: their noise goes down with what the mesh leaves, and
    /// need be no less.
    fn noise_of_edges(&self, may: &Self) -> f64 {
        (may.noise.sharp).max(SAMPLES.sharp / MESH.sharp * self.mesh.sharp)
    }

    /// The parts cut down to the highest level that leaves no more than `error`.
    fn highest(error: f64, cut: impl Fn(f64) -> Self) -> Self {
        let (mut low, mut high) = (0.0, 1.0 / MESH.smooth.min(SAMPLES.smooth));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if cut(middle).total() <= error {
                low = middle;
            } else {
                high = middle;
            }
        }
        cut(low)
    }
}

/// Cuts a part down to this multiple of its share of the aim, if it is more.
fn least(level: f64, aim: f64) -> impl Fn(f64, f64) -> f64 {
    move |part, share| part.min(level * share * aim)
}

impl Pass {
    /// Relative RMSE of its light at most, as far as control tells.
    fn bound(&self) -> f64 {
        self.control.unwrap_or_default().found.bound()
    }

    /// An earlier pass, if it was better: there may have been too little time for this one.
    fn or_better(self, earlier: Option<Self>) -> Self {
        match earlier {
            Some(earlier) if earlier.bound() < self.bound() => earlier,
            _ => self,
        }
    }

    fn stopped(self, stopped: Stopped) -> Self {
        Self { stopped, ..self }
    }
}

/// Passes on what the observer says, and stops a bake whose time is over as soon as there is a result.
pub(super) struct Deadline<'a> {
    observer: &'a dyn Observer,
    begun: Instant,
    limit: Option<Duration>,
    armed: AtomicBool,
}

/// Share of the time that is left in which meshes may be refined, so that there is some for the light
/// on them.
const FOR_MESHES: f64 = 0.5;

impl<'a> Deadline<'a> {
    pub(super) fn new(observer: &'a dyn Observer, max_seconds: Option<f32>) -> Self {
        Self {
            observer,
            begun: Instant::now(),
            limit: max_seconds.and_then(|s| Duration::try_from_secs_f32(s).ok()),
            armed: AtomicBool::new(false),
        }
    }

    /// There is a result to fall back on.
    fn arm(&self) {
        self.armed.store(true, Ordering::Relaxed);
    }

    fn is_over(&self) -> bool {
        self.armed.load(Ordering::Relaxed)
            && self.limit.is_some_and(|limit| self.begun.elapsed() > limit)
            && !self.observer.cancelled()
    }

    /// Share of the time allowed that is over.
    pub(super) fn spent(&self) -> f64 {
        let limit = self.limit.map_or(f64::INFINITY, |l| l.as_secs_f64());
        self.begun.elapsed().as_secs_f64() / limit
    }

    fn for_meshes(&self) -> Option<Instant> {
        let left = self.limit?.saturating_sub(self.begun.elapsed());
        Some(Instant::now() + left.mul_f64(FOR_MESHES))
    }
}

impl Observer for Deadline<'_> {
    fn progress(&self, stage: Stage, done: f32) {
        self.observer.progress(stage, done);
    }

    fn partial(&self, light: &PartialLight) {
        self.observer.partial(light);
    }

    fn so_far(&self, bake: &Bake) {
        self.observer.so_far(bake);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled() || self.is_over()
    }
}

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{Run, Solved};
use crate::radiosity::bake::BakeError;
use crate::radiosity::baked::Bake;
use crate::radiosity::estimate::vertices_within;
use crate::radiosity::fit::{Fit, Samples};
use crate::radiosity::gather::Gather;
use crate::radiosity::gathered::{Gathered, Shining};
use crate::radiosity::observer::{Observer, Stage};
use crate::radiosity::partial::PartialLight;
use crate::radiosity::receivers::Receivers;
use crate::radiosity::refine::{Asked, Control, Refinement};
use crate::radiosity::report::Stopped;

/// The light of vertices, as one pass found it.
pub(crate) struct Pass {
    pub(crate) receivers: Receivers,
    pub(crate) refinement: Arc<Refinement>,
    pub(crate) density: [f32; 2],
    pub(crate) gathered: Gathered,
    pub(crate) samples: Samples,
    pub(crate) fitted: Fit,
    /// How far off it is; of a bake that refines.
    pub(crate) control: Option<Control>,
    pub(crate) stopped: Stopped,
}

/// What the next pass does.
#[derive(Clone, Copy, Debug)]
struct Effort {
    /// Relative RMSE that the meshes may leave.
    mesh: f64,
    /// Samples, so many times what the settings say, of smooth light and of light with sharp edges.
    samples: [f32; 2],
}

/// The first pass is a quick look, with this share of the samples; later ones take no less.
const FIRST_SAMPLES: f32 = 0.5;

/// Shares of the error asked for that the later passes aim at: meshes, and samples of either kind of
/// light. Their squares add up to less than 1, so that most passes that aim there arrive.
const MESH: f64 = 0.75;
const SAMPLES: f64 = 0.5;

/// Share of the aim that the noise of rays may have, and of the mesh's error that that of light with
/// sharp edges may.
const SMOOTH_SAMPLES: f64 = 0.45;
const SHARP_SAMPLES: f64 = 0.45;

/// Samples are spread so evenly that their error falls faster than by chance: as their number to the
/// power of −0.7.
const SAMPLES_BY_ERROR: f64 = 1.0 / 0.7;

/// From one pass to the next, samples at most, and mesh error at least.
const MORE_SAMPLES: f64 = 16.0;
const LESS_MESH: f64 = 0.25;

/// From one pass to the next, so many times the vertices at most, these counted at least.
const MORE_VERTICES: usize = 8;
const FEW_VERTICES: usize = 1024;

/// A pass is of use if it leaves this share of the error of the one before, or less.
const USEFUL: f64 = 0.85;

/// Passes aim at this share of what is asked.
const VERTICES: f64 = 0.9;

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
            let pass = self.pass(gather, shining, known, [1.0; 2])?;
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
        // The rest is for elements and solver, which passes cannot mend.
        let aim = VERTICES * f64::from(self.settings.error);
        let mut effort = Effort {
            mesh: aim,
            samples: [FIRST_SAMPLES; 2],
        };
        let mut best: Option<Pass> = None;
        for left in (0..PASSES).rev() {
            let before = best.as_ref().map_or(0, |b| b.receivers.fine.vertex_count());
            let goal = Asked {
                error: effort.mesh,
                max_vertices: most.min(MORE_VERTICES * before.max(FEW_VERTICES)),
            };
            let good = |b: &&Pass| b.refinement.error <= effort.mesh || before >= goal.max_vertices;
            let kept = best.as_ref().filter(good);
            let meshes = kept.map(|b| (b.receivers.clone(), b.refinement.clone()));
            let next = self.aimed_pass(gather, shining, solved, (&goal, meshes), effort, deadline);
            let pass = match next {
                Err(BakeError::Cancelled) if deadline.is_over() => {
                    return best
                        .ok_or(BakeError::Cancelled)
                        .map(|b| b.stopped(Stopped::Seconds));
                }
                pass => pass?,
            };
            let total = pass.control.unwrap_or_default().bound;
            if total <= aim {
                return Ok(pass.stopped(Stopped::Error));
            }
            let full = pass.refinement.full && goal.max_vertices == most;
            let useless = (best.as_ref())
                .is_some_and(|b| total > USEFUL * b.control.unwrap_or_default().bound);
            let next = self.next(&pass, effort, aim, full);
            let Some(next) = next.filter(|_| left > 0 && (full || !useless)) else {
                return Ok(pass.stopped(match (full, by_memory) {
                    (true, true) => Stopped::Memory,
                    (true, false) => Stopped::Vertices,
                    (false, _) => Stopped::Limit,
                }));
            };
            effort = next;
            show(self, &pass);
            best = Some(pass);
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
        (asked, meshes): (&Asked, Option<(Receivers, Arc<Refinement>)>),
        effort: Effort,
        deadline: &Deadline,
    ) -> Result<Pass, BakeError> {
        let meshes = match meshes {
            Some(meshes) => meshes,
            None => self.refine(gather, shining, solved, asked, deadline.for_meshes())?,
        };
        let mut pass = self.pass(gather, shining, meshes, effort.samples)?;
        let control = self.control(gather, shining, &pass.receivers, &pass.fitted)?;
        pass.control = Some(control);
        Ok(pass)
    }

    fn pass(
        &mut self,
        gather: &mut Gather,
        shining: &Shining,
        (receivers, refinement): (Receivers, Arc<Refinement>),
        samples: [f32; 2],
    ) -> Result<Pass, BakeError> {
        gather.density = self.density(&receivers, samples);
        let (gathered, samples) = self.gather(gather, shining, &receivers)?;
        let fitted = self.fit(&samples, &receivers)?;
        Ok(Pass {
            receivers,
            refinement,
            density: gather.density,
            gathered,
            samples,
            fitted,
            control: None,
            stopped: Stopped::AsGiven,
        })
    }

    /// Where the next pass does more, or less; `None` if nothing would help.
    ///
    /// The refinement's own idea of the error is an indicator: only its ratio counts. Where an edge of
    /// light crosses a triangle, the samples in it say as little of it as the mesh can carry, so the
    /// noise of light with sharp edges goes down with what the mesh leaves, and is held against that;
    /// that of rays does not, and is held against the aim.
    fn next(&self, pass: &Pass, effort: Effort, aim: f64, full: bool) -> Option<Effort> {
        let [sharp, smooth] = pass.fitted.smoothing.by_kind.map(f64::from);
        let sampling = sharp.hypot(smooth);
        let control = pass.control.unwrap_or_default().bound;
        let mesh = (control * control - sampling * sampling)
            .max(0.01 * aim * aim)
            .sqrt();
        let times = |error: f64, aim: f64, power: f64| {
            ((error / aim).powf(power)).clamp(1.0 / MORE_SAMPLES, MORE_SAMPLES) as f32
        };
        let samples = [
            effort.samples[0] * times(smooth, SMOOTH_SAMPLES * aim, SAMPLES_BY_ERROR),
            effort.samples[1] * times(sharp, SHARP_SAMPLES * mesh.max(MESH * aim), 2.0),
        ];
        let next = Effort {
            mesh: if full {
                effort.mesh
            } else {
                effort.mesh * (MESH * aim / mesh).clamp(LESS_MESH, 1.0)
            },
            samples: samples.map(|s| s.max(FIRST_SAMPLES)),
        };
        // With the meshes as fine as may be, samples help until they are the smaller part.
        let useful = !full || sampling > 0.5 * mesh;
        let more = next.mesh < effort.mesh || sampling > SAMPLES * aim;
        (useful && more).then_some(next)
    }

    /// Vertices that may be, and whether it is memory that limits them.
    fn most_vertices(&self, solved: &Solved) -> (usize, bool) {
        let given = solved.given.vertex_count();
        let asked = self.settings.max_vertices as usize;
        let held = vertices_within(self.scene, self.settings, given as u64);
        (asked.min(held).max(given), held < asked)
    }
}

impl Pass {
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

/// Share of the time after which meshes are refined no more, so that there is some for the light on
/// them.
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

    fn for_meshes(&self) -> Option<Instant> {
        Some(self.begun + self.limit?.mul_f64(FOR_MESHES))
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

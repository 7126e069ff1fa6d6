use std::sync::Arc;
use std::time::Instant;

use super::{Pass, Run, Solved};
use crate::radiosity::bake::BakeError;
use crate::radiosity::baked::ObjectLight;
use crate::radiosity::element::{Elements, SEEN_FROM_BEHIND};
use crate::radiosity::emitter_tree::{EmitterTree, Leaf};
use crate::radiosity::fit::{Fit, Samples, fit, fit_gradient};
use crate::radiosity::form_factor::GONE;
use crate::radiosity::gather::{
    Density, Gather, GatherBefore, GatherCost, KnownRays, Validity, density,
};
use crate::radiosity::gathered::{
    Bundle, ByTriangle, Gathered, SharpLight, Shining, TriangleSamples,
};
use crate::radiosity::glare::Glare;
use crate::radiosity::kind::ByKind;
use crate::radiosity::level::Level;
use crate::radiosity::observer::Stage;
use crate::radiosity::parallel::map_ranges;
use crate::radiosity::quality::judge;
use crate::radiosity::receiver_mesh::ReceiverMesh;
use crate::radiosity::receivers::Receivers;
use crate::radiosity::refine::{Asked, Control, Refinement, Refiner};
use crate::radiosity::solve::Solution;

/// Triangles a thread takes at a time.
const CHUNK: usize = 32;

/// Rays that another pass may add to take one part of the memory allowed in so many, and twice that while it
/// does.
pub(crate) const KEPT_RAYS: u64 = 32;
const BYTES_PER_RAY: u64 = size_of::<u32>() as u64;

/// What rays from a triangle of the coarse meshes tell of samples on it.
enum Met {
    /// Which of them are not inside geometry.
    Samples(Arc<Bundle>),
    /// None is.
    Sound,
    /// Some may be.
    Doubtful,
}

impl Met {
    fn new(bundle: &Arc<Bundle>, same_mesh: bool) -> Self {
        if same_mesh {
            Self::Samples(bundle.clone())
        } else if bundle.doubtful() {
            Self::Doubtful
        } else {
            Self::Sound
        }
    }

    fn validity(&self) -> Validity<'_> {
        match self {
            Self::Samples(bundle) => Validity::Known(bundle),
            Self::Sound => Validity::Sound,
            Self::Doubtful => Validity::Doubtful,
        }
    }
}

/// Light inside the triangles.
#[derive(Clone)]
pub(crate) struct Inside {
    pub(crate) smooth: Arc<SmoothInside>,
    pub(crate) sharp: Arc<SharpInside>,
}

/// Of the coarse meshes: bounced light, sky, wide emitters.
pub(crate) struct SmoothInside {
    /// Where somebody may ask for them again.
    bundles: Option<Arc<ByTriangle<Arc<Bundle>>>>,
    pub(crate) samples: Vec<TriangleSamples>,
    /// The same of its gradient; empty if that is not asked for.
    pub(crate) gradients: Vec<TriangleSamples>,
    met: ByTriangle<Met>,
}

/// Of the fine meshes: light of lights and sampled emitters.
pub(crate) struct SharpInside {
    light: Arc<ByTriangle<SharpLight>>,
    pub(crate) samples: Vec<TriangleSamples>,
    /// The same of its gradient; empty if that is not asked for.
    pub(crate) gradients: Vec<TriangleSamples>,
}

impl Inside {
    /// Of the samples as the fit takes them.
    pub(crate) fn bytes(&self) -> u64 {
        let (smooth, sharp) = (&self.smooth, &self.sharp);
        (size_of_val(&*smooth.samples)
            + size_of_val(&*smooth.gradients)
            + size_of_val(&*sharp.samples)
            + size_of_val(&*sharp.gradients)) as u64
    }

    pub(super) fn gathered(&self) -> Gathered {
        Gathered {
            bundles: self.smooth.bundles.clone().unwrap_or_default(),
            sharp: self.sharp.light.clone(),
        }
    }
}

impl Pass {
    /// The light of objects; the gradient of what is lit from behind is turned to the front.
    pub(super) fn objects(&self, lit_from_behind: &[bool]) -> Vec<ObjectLight> {
        let meshes = &self.receivers.fine;
        let mut objects = meshes.object_light(&self.fitted.light);
        for ((object, mesh), behind) in objects.iter_mut().zip(&meshes.meshes).zip(lit_from_behind)
        {
            if let Some(gradient) = &self.fitted.gradient {
                let side = if *behind { -1.0 } else { 1.0 };
                let of = |u: &u32| gradient[*u as usize] * side;
                object.gradient = mesh.unknown.iter().map(of).collect();
            }
            if let Some(quality) = &self.fitted.quality {
                let of = |u: &u32| quality[*u as usize];
                object.quality = mesh.unknown.iter().map(of).collect();
            }
        }
        objects
    }
}

/// Object and triangle, of all.
fn triangles(meshes: &[ReceiverMesh]) -> Vec<(usize, usize)> {
    (meshes.iter().enumerate())
        .flat_map(|(o, m)| (0..m.triangles.len()).map(move |t| (o, t)))
        .collect()
}

/// From the light of elements to that of vertices.
impl Run<'_> {
    /// Where that is not known from an earlier bake, so many times what the settings say.
    pub(super) fn density(&self, receivers: &Receivers, times: ByKind<f32>) -> Density {
        (self.start.plan.map(|p| p.density))
            .or(self.start.before.map(|b| b.stages.plan.density))
            .unwrap_or_else(|| {
                let sharp = density(&receivers.fine, self.settings);
                Density {
                    smooth: times.smooth * density(&receivers.coarse, self.settings),
                    sharp: times.sharp * sharp,
                    calm: times.sharp.min(1.0) * sharp,
                }
            })
    }

    /// Which objects are seen from behind: double-sided ones whose front gets next to no light,
    /// beside their back and beside the scene.
    ///
    /// A vertex has one value, and a room modelled inside out would otherwise be black. In the dark
    /// it stays as it was.
    pub(super) fn lit_from_behind(&self, elements: &Elements, solution: &Solution) -> Vec<bool> {
        if let Some(plan) = self.start.plan {
            return plan.lit_from_behind.clone();
        }
        let sums: Vec<_> = (0..self.scene.objects.len())
            .map(|o| elements.light_of_sides(o, &solution.arriving))
            .collect();
        let mean = |(light, area): (f64, f64)| if area > 0.0 { light / area } else { 0.0 };
        let all = (sums.iter().flatten()).fold((0.0, 0.0), |a, s| (a.0 + s.0, a.1 + s.1));
        let dark = mean(all) == 0.0;
        let was = |o: usize| {
            let (old, change) = self.before()?;
            Some(old.plan.lit_from_behind[change.object_before[o]?])
        };
        (sums.iter().enumerate())
            .map(|(o, &[front, back])| match was(o) {
                Some(was) if dark => was,
                _ => mean(front) < SEEN_FROM_BEHIND * mean(back).min(mean(all)),
            })
            .collect()
    }

    /// The elements that glare: those known, as long as they are most of them.
    pub(super) fn glaring(&self, solved: &Solved) -> Arc<EmitterTree> {
        let (elements, solution) = (&*solved.elements, &solved.solution);
        if let Some(plan) = self.start.plan {
            return plan.glaring.clone();
        }
        let kept = self.before().and_then(|(old, change)| {
            let tree = &old.plan.glaring;
            let stays = |l: &Leaf| change.elements_now()[l.source as usize] != GONE;
            if change.same_elements && change.same_triangles {
                return Some(tree.clone());
            }
            tree.leaves.iter().all(stays).then(|| {
                let now = (&change.triangle_now, change.elements_now());
                Arc::new(tree.renumbered(now.0, now.1, elements.len()))
            })
        });
        let glare = Glare::new(elements, &solved.traced, solution);
        kept.filter(|tree| tree.covers(elements, &glare))
            .unwrap_or_else(|| {
                EmitterTree::glaring(self.scene, elements, &solution.reflected, &glare).into()
            })
    }

    /// The meshes of an earlier bake, or those given: for a bake that places no vertices itself.
    pub(super) fn known_receivers(&self, solved: &Solved) -> Option<(Receivers, Arc<Refinement>)> {
        let given = &solved.given;
        if !self.settings.refine {
            return Some((Receivers::same(given.clone()), Arc::default()));
        }
        if let Some(plan) = self.start.plan {
            let receivers = Receivers::new(self.scene, given, &plan.refinement);
            return Some((receivers, plan.refinement.clone()));
        }
        let (old, change) = self.before()?;
        if Arc::ptr_eq(given, &old.given) {
            return Some((old.receivers.clone(), old.plan.refinement.clone()));
        }
        let kept = (old.plan.refinement).kept(&old.given, given, &change.object_before);
        let mut receivers = Receivers::new(self.scene, given, &kept);
        receivers.share_results(&old.receivers, &change.object_before);
        Some((receivers, kept.into()))
    }

    /// Puts vertices where the light needs them, those of an `earlier` pass too where they are good enough.
    pub(super) fn refine(
        &mut self,
        gather: &Gather,
        shining: &Shining,
        solved: &Solved,
        (asked, earlier): (&Asked, Option<&Pass>),
        until: Option<Instant>,
    ) -> Result<(Receivers, Arc<Refinement>), BakeError> {
        let internal = |edge: f32| edge / self.scene.scale;
        let max_edge = self.settings.max_edge.map_or(f32::INFINITY, internal);
        let level = self.level(solved, gather.lit_from_behind);
        self.stage(Stage::Refine, |run| {
            let refiner = Refiner {
                gather,
                shining,
                observer: run.observer,
                level,
                max_edge,
                until,
            };
            let (scene, given) = (run.scene, &solved.given);
            let known = earlier.map(|e| &*e.refinement);
            let refinement = refiner.refine(scene, given, asked, known)?;
            run.work.gather_rays += refinement.rays;
            let same = earlier.filter(|e| refinement.same_coarse(&e.refinement));
            let receivers = match same {
                Some(e) => Receivers::on(scene, e.receivers.coarse.clone(), &refinement),
                None => Receivers::new(scene, given, &refinement),
            };
            Ok((receivers, refinement.into()))
        })
    }

    /// How bright the sides of surfaces are that light is put on.
    fn level(&self, solved: &Solved, lit_from_behind: &[bool]) -> Level {
        let elements = &solved.elements;
        let lit = (0..self.scene.objects.len()).flat_map(|o| {
            let side = move |e: &usize| elements.is_back(*e) == lit_from_behind[o];
            elements.of_object(o).filter(side)
        });
        Level::of(lit.map(|e| {
            let light =
                (self.settings.contribution).of(solved.solution.arriving[e], solved.arrived[e]);
            let light = light.element_sum() / 3.0;
            (f64::from(elements.area[e]), f64::from(light))
        }))
    }

    /// How far off the vertices' light is.
    pub(super) fn control(
        &mut self,
        gather: &Gather,
        shining: &Shining,
        receivers: &Receivers,
        (fitted, aim): (&Fit, f64),
    ) -> Result<Control, BakeError> {
        self.stage(Stage::Error, |run| {
            let meshes = &receivers.fine;
            let control = Control::run(gather, shining, meshes, fitted, aim, run.observer)?;
            run.work.error_rays += control.rays;
            Ok(control)
        })
    }

    /// Light inside the triangles: traced where need be, then put together. What an `earlier` pass
    /// sampled on the same meshes is kept: as densely, or the rays that it has of more.
    pub(super) fn gather(
        &mut self,
        gather: &Gather,
        shining: &Shining,
        receivers: &Receivers,
        earlier: Option<&Pass>,
    ) -> Result<Inside, BakeError> {
        let objects = self.objects_to_gather(gather);
        let smooth = earlier.filter(|e| Arc::ptr_eq(&e.receivers.coarse, &receivers.coarse));
        let smooth = match smooth {
            Some(earlier) if earlier.density.smooth == gather.density.smooth => {
                earlier.inside.smooth.clone()
            }
            earlier => {
                let fewer = earlier.and_then(|e| e.inside.smooth.bundles.as_deref());
                (self.gather_smooth(gather, receivers, shining, (&objects, fewer))?).into()
            }
        };
        let sharp = earlier.filter(|e| {
            Arc::ptr_eq(&e.receivers.fine, &receivers.fine)
                && e.density.sharp == gather.density.sharp
        });
        let sharp = match sharp {
            Some(earlier) => earlier.inside.sharp.clone(),
            None => (self.gather_sharp(gather, receivers, shining, &objects, &smooth.met)?).into(),
        };
        Ok(Inside { smooth, sharp })
    }

    /// Light that rays gather, in the coarse meshes.
    fn gather_smooth(
        &mut self,
        gather: &Gather,
        receivers: &Receivers,
        shining: &Shining,
        (objects, fewer): (&[Option<usize>], Option<&ByTriangle<Arc<Bundle>>>),
    ) -> Result<SmoothInside, BakeError> {
        let meshes = &receivers.coarse.meshes;
        let list = triangles(meshes);
        let keep = self.start.remember || self.keeps_rays(gather, meshes, &list);
        let same_samples = gather.density.smooth == gather.density.sharp;
        self.stage(Stage::Gather, |run| {
            let before = run.before_gather(gather, objects);
            let known = match (fewer, &before) {
                (Some(fewer), _) => KnownRays::Fewer(fewer),
                (None, Some(before)) => KnownRays::Before(before),
                (None, None) => KnownRays::None,
            };
            let chunks = map_ranges(list.len(), CHUNK, Stage::Gather, run.observer, |range| {
                let mut rays = 0;
                let each = list[range].iter().map(|&(o, t)| {
                    let mesh = &meshes[o];
                    let bundle = gather.bundle(mesh, o, t, known, &mut rays);
                    let samples = shining.gathered(&bundle, mesh, t);
                    let gradient = (run.settings.directional)
                        .then(|| gather.gathered_gradient(&bundle, mesh, o, t, shining));
                    let met = Met::new(&bundle, same_samples && receivers.is_same(o));
                    let bundle = keep.then_some(bundle);
                    (samples, gradient, met, bundle)
                });
                (each.collect::<Vec<_>>(), rays)
            })?;
            let (mut bundles, mut met) = (ByTriangle::of(meshes), ByTriangle::of(meshes));
            let mut samples = Vec::with_capacity(list.len());
            let mut gradients = Vec::new();
            for (each, rays) in chunks {
                run.work.gather_rays += rays;
                for (sample, gradient, m, bundle) in each {
                    samples.push(sample);
                    gradients.extend(gradient);
                    met.list.push(m);
                    bundles.list.extend(bundle);
                }
            }
            Ok(SmoothInside {
                bundles: keep.then(|| bundles.into()),
                samples,
                gradients,
                met,
            })
        })
    }

    /// Light with sharp edges, in the fine meshes.
    fn gather_sharp(
        &mut self,
        gather: &Gather,
        receivers: &Receivers,
        shining: &Shining,
        objects: &[Option<usize>],
        met: &ByTriangle<Met>,
    ) -> Result<SharpInside, BakeError> {
        let meshes = &receivers.fine.meshes;
        let list = triangles(meshes);
        self.stage(Stage::Shadows, |run| {
            let before = run.before_gather(gather, objects);
            let chunks = map_ranges(list.len(), CHUNK, Stage::Shadows, run.observer, |range| {
                let mut cost = GatherCost::default();
                let each = list[range].iter().map(|&(o, t)| {
                    let mesh = &meshes[o];
                    let validity = met.at(o, receivers.coarse_triangle(o, t)).validity();
                    let light = gather.sharp(mesh, o, t, validity, before.as_ref(), &mut cost);
                    let samples = shining.arrived(&light, mesh, t);
                    let gradient = shining.arrived_gradient(&light, mesh, t);
                    (samples, gradient, run.start.remember.then_some(light))
                });
                (each.collect::<Vec<_>>(), cost)
            })?;
            let mut light = ByTriangle::of(meshes);
            let mut samples = Vec::with_capacity(list.len());
            let mut gradients = Vec::new();
            for (each, cost) in chunks {
                run.work.gather_rays += cost.rays;
                run.work.light_rays += cost.shadow.lights;
                run.work.emitter_rays += cost.shadow.emitters;
                for (sample, gradient, l) in each {
                    samples.push(sample);
                    gradients.extend(gradient);
                    light.list.extend(l);
                }
            }
            Ok(SharpInside {
                light: light.into(),
                samples,
                gradients,
            })
        })
    }

    /// Whether there is memory for the rays of a pass that another may add to.
    fn keeps_rays(
        &self,
        gather: &Gather,
        meshes: &[ReceiverMesh],
        list: &[(usize, usize)],
    ) -> bool {
        let last =
            !self.settings.refine || self.start.plan.is_some() || self.start.before.is_some();
        let rays = || list.iter().map(|&(o, t)| gather.rays_of(&meshes[o], o, t));
        !last && rays().sum::<u64>() * BYTES_PER_RAY <= self.settings.max_memory / KEPT_RAYS
    }

    fn before_gather<'g>(
        &'g self,
        gather: &Gather,
        objects: &'g [Option<usize>],
    ) -> Option<GatherBefore<'g>> {
        let (old, change) = self.before()?;
        Some(GatherBefore {
            gathered: &old.gathered,
            change,
            object_before: objects,
            new_emitters: change.new_emitters,
            new_reflectors: !(gather.reflectors.tree)
                .same_leaves_as(&old.plan.glaring, change.elements_now()),
        })
    }

    /// For each object, which one of the earlier bake has the same samples.
    fn objects_to_gather(&self, gather: &Gather) -> Vec<Option<usize>> {
        let Some((old, change)) = self.before() else {
            return Vec::new();
        };
        let behind = |o: usize, p: usize| gather.lit_from_behind[o] == old.plan.lit_from_behind[p];
        (change.mesh_before.iter().enumerate())
            .map(|(o, before)| before.filter(|&p| behind(o, p)))
            .collect()
    }

    pub(super) fn fit(
        &mut self,
        inside: &Inside,
        receivers: &Receivers,
        seams: &[Vec<u32>],
    ) -> Result<Fit, BakeError> {
        let known = match (self.start.plan, self.start.before) {
            (Some(plan), _) => Some(&plan.smoothing),
            // Colours do not change how noisy samples are: only new samples have to be judged.
            (None, Some(before)) if self.work.rays() == 0 => Some(&before.stages.plan.smoothing),
            _ => None,
        };
        self.stage(Stage::Fit, |run| {
            let observer = run.observer;
            let samples = Samples {
                smooth: &inside.smooth.samples,
                sharp: &inside.sharp.samples,
            };
            let go_on = || !observer.cancelled();
            let mut fitted = fit(&samples, receivers, seams, known, &go_on)?;
            if run.settings.directional {
                let gradients = Samples {
                    smooth: &inside.smooth.gradients,
                    sharp: &inside.sharp.gradients,
                };
                fitted.gradient =
                    Some(fit_gradient(&gradients, receivers, seams, &fitted, &go_on)?);
            }
            if run.settings.vertex_quality {
                let square = 1.0 / (run.scene.scale * run.scene.scale);
                fitted.quality = Some(judge(&samples, receivers, &fitted, square, &go_on)?);
            }
            run.work.fits += 1;
            run.work.cross_validations += u64::from(known.is_none());
            Ok(fitted)
        })
    }
}

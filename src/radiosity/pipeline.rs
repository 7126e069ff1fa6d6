use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{BVec3, DVec3, Vec3, Vec3A};

use super::bake::BakeError;
use super::baked::{Bake, ObjectLight};
use super::bvh::BvhQuality;
use super::change::Change;
use super::color::divide;
use super::direct::{Direct, DirectBefore, Sampler};
use super::element::Elements;
use super::emitter::Emitters;
use super::emitter_tree::EmitterTree;
use super::findings::Findings;
use super::fit::{Fit, fit};
use super::form_factor::{GONE, RowTracer, RowsBefore, Traced, trace};
use super::gather::{Aids, Gather, GatherBefore, GatherCost, density};
use super::gathered::{Gathered, Shining, TriangleSamples};
use super::observer::{Observer, Stage};
use super::occlusion::{Hierarchy, Holds, Occluders};
use super::parallel::{Cancelled, map_ranges};
use super::receiver_mesh::{MeshesBefore, ReceiverMeshes};
use super::report::Work;
use super::settings::BakeSettings;
use super::solve::{Solution, gauss_seidel};
use super::stages::{Before, Plan, Stages, Start};
use super::surface::{Pyramids, Surfaces};
use super::validate::ValidScene;

/// A bake on its way.
struct Run<'a> {
    scene: &'a ValidScene,
    settings: &'a BakeSettings,
    start: Start<'a>,
    change: Option<Change>,
    observer: &'a dyn Observer,
    stages: Vec<(Stage, Duration)>,
    work: Work,
}

/// Passes a scene through all stages, each of which takes from `start` what is still true.
pub(crate) fn run(
    scene: &ValidScene,
    settings: &BakeSettings,
    start: Start,
    observer: &dyn Observer,
) -> Result<(Bake, Stages), BakeError> {
    let mut run = Run {
        scene,
        settings,
        start,
        change: None,
        observer,
        stages: Vec::new(),
        work: Work::default(),
    };
    let (pyramids, elements, receivers, target) = run.mesh()?;
    let surfaces = Surfaces::new(scene, &pyramids);
    let (hierarchy, tree) = run.occlusion(&surfaces, &elements)?;
    let occluders = Occluders::new(&hierarchy, &surfaces);
    let lit = Lit {
        occluders,
        elements: &elements,
        emitters: Emitters::at_elements(&tree, settings),
        marks: &Emitters::at_elements(&tree, settings).marks(&elements),
    };
    let traced = run.form_factors(&lit)?;
    let (direct, arrived) = run.direct(&lit, &traced)?;
    let solution = run.solve(&elements, &traced, &arrived)?;
    let lit_from_behind = run.lit_from_behind(&elements, &solution);
    let bright = run.bright(&elements, &solution);
    let density = (run.start.plan.map(|p| p.density))
        .or(run.start.before.map(|b| b.stages.plan.density))
        .unwrap_or_else(|| density(&receivers, settings));
    let gather = Gather {
        scene,
        occluders,
        elements: &elements,
        emitters: Emitters::at_samples(&tree, settings),
        reflectors: Emitters::bright_at_samples(&bright, settings),
        marks: [
            lit.marks,
            &Emitters::bright_at_samples(&bright, settings).marks(&elements),
        ],
        lit_from_behind: &lit_from_behind,
        settings,
        density,
        remember: start.remember,
        aids: Aids::new(scene),
    };
    let (gathered, samples) = run.gather(&gather, &receivers, &solution)?;
    let fitted = run.fit(&samples, &receivers)?;
    let findings = Findings {
        scene,
        settings,
        receivers: &receivers,
        elements: &elements,
        tree: &tree,
        rows: &traced.rows,
        arrived: &arrived,
        solution: &solution,
        lit_from_behind: &lit_from_behind,
        samples: &samples,
        fitted: &fitted,
        work: run.work,
    };
    let bake = Bake {
        objects: object_light(&receivers, &fitted),
        report: findings.report(run.stages, hierarchy.bytes()),
    };
    let stages = Stages {
        plan: Plan {
            target,
            density,
            emitters: tree,
            bright,
            lit_from_behind,
            smoothing: fitted.smoothing,
        },
        pyramids,
        elements,
        receivers,
        hierarchy,
        traced,
        direct,
        arrived,
        solution,
        gathered: Arc::new(gathered),
    };
    Ok((bake, stages))
}

/// What the elements look at, and what lights them.
struct Lit<'a> {
    occluders: Occluders<'a>,
    elements: &'a Elements,
    emitters: Emitters<'a>,
    /// Elements whose emission is sampled.
    marks: &'a [bool],
}

impl<'a> Run<'a> {
    /// Runs a stage: times it, and asks before and after whether to go on.
    fn stage<T>(
        &mut self,
        stage: Stage,
        work: impl FnOnce(&mut Self) -> Result<T, BakeError>,
    ) -> Result<T, BakeError> {
        if self.observer.cancelled() {
            return Err(BakeError::Cancelled);
        }
        self.observer.progress(stage, 0.0);
        let since = Instant::now();
        let made = work(self)?;
        self.stages.push((stage, since.elapsed()));
        self.observer.progress(stage, 1.0);
        if self.observer.cancelled() {
            return Err(BakeError::Cancelled);
        }
        Ok(made)
    }

    fn before(&self) -> Option<(&'a Stages, &Change)> {
        Some((self.start.before?.stages, self.change.as_ref()?))
    }

    /// Elements, the meshes that receive light, and an element's area.
    fn mesh(
        &mut self,
    ) -> Result<(Arc<Pyramids>, Arc<Elements>, Arc<ReceiverMeshes>, f32), BakeError> {
        let scene = self.scene;
        let planned = self.start.plan.map(|p| p.target);
        let Some(before) = self.start.before else {
            return self.stage(Stage::Mesh, |run| {
                let target =
                    planned.unwrap_or_else(|| Elements::target(scene, run.settings.elements));
                let pyramids = Pyramids::new(scene, None);
                let elements = run.elements(&pyramids, target);
                let receivers = ReceiverMeshes::new(scene, run.settings.max_edge, None)?;
                Ok((pyramids.into(), elements.into(), receivers.into(), target))
            });
        };
        let (old, target) = (before.stages, before.stages.plan.target);
        if scene.same_surfaces(before.scene) {
            let sides = ((before.scene, &*old.elements), (scene, &*old.elements));
            self.change = Some(Change::between(sides.0, sides.1));
            let kept = old.clone();
            return Ok((kept.pyramids, kept.elements, kept.receivers, target));
        }
        self.stage(Stage::Mesh, |run| {
            let pyramids = Pyramids::new(scene, Some((before.scene, &old.pyramids)));
            let elements = run.elements(&pyramids, target);
            let change = Change::between((before.scene, &old.elements), (scene, &elements));
            let receivers = run.receivers(old, &change)?;
            run.change = Some(change);
            Ok((pyramids.into(), elements.into(), receivers, target))
        })
    }

    fn elements(&self, pyramids: &Pyramids, target: f32) -> Elements {
        let surfaces = Surfaces::new(self.scene, pyramids);
        Elements::new(self.scene, &surfaces, target, self.settings.max_reflectance)
    }

    fn receivers(&self, old: &Stages, change: &Change) -> Result<Arc<ReceiverMeshes>, BakeError> {
        let count = old.receivers.meshes.len();
        if change.mesh_before.iter().copied().eq((0..count).map(Some)) {
            return Ok(old.receivers.clone());
        }
        let before = MeshesBefore {
            meshes: &old.receivers,
            same: &change.mesh_before,
            object: &change.object_before,
        };
        let max_edge = self.settings.max_edge;
        let mut receivers = ReceiverMeshes::new(self.scene, max_edge, Some(&before))?;
        before.share_refinements(&mut receivers);
        Ok(receivers.into())
    }

    fn occlusion(
        &mut self,
        surfaces: &Surfaces,
        elements: &Elements,
    ) -> Result<(Arc<Hierarchy>, Arc<EmitterTree>), BakeError> {
        let kept = self.before().map(|(old, change)| {
            let same = change.disturbed.is_empty() && change.same_triangles;
            let hierarchy = same.then(|| old.hierarchy.clone());
            (
                hierarchy,
                (!change.new_emitters).then(|| self.emitters(old, change)),
            )
        });
        if let Some((Some(hierarchy), Some(tree))) = kept {
            return Ok((hierarchy, tree));
        }
        let quality = if kept.is_some() {
            BvhQuality::Quick
        } else {
            BvhQuality::Best
        };
        let (hierarchy, tree) = kept.unwrap_or_default();
        let tree = self.start.plan.map(|p| p.emitters.clone()).or(tree);
        self.stage(Stage::Occlusion, |run| {
            let hierarchy = hierarchy.unwrap_or_else(|| {
                run.work.hierarchy_builds += 1;
                Hierarchy::new(run.scene, surfaces, Holds::Casting, quality).into()
            });
            let tree = match tree {
                Some(tree) => tree,
                None => {
                    let occluders = Occluders::new(&hierarchy, surfaces);
                    let seed = run.settings.seed;
                    EmitterTree::new(run.scene, elements, &occluders, seed, run.observer)?.into()
                }
            };
            Ok((hierarchy, tree))
        })
    }

    /// The tree of an earlier bake, in the numbers of this one.
    fn emitters(&self, old: &Stages, change: &Change) -> Arc<EmitterTree> {
        if change.same_triangles && !change.triangle_now.contains(&GONE) {
            return old.plan.emitters.clone();
        }
        let now = &change.triangle_now;
        Arc::new((old.plan.emitters).renumbered(now, now, self.scene.triangles.len()))
    }

    fn form_factors(&mut self, lit: &Lit) -> Result<Arc<Traced>, BakeError> {
        if let Some((old, change)) = self.before()
            && change.disturbed.is_empty()
            && change.same_elements
            && !change.new_emitters
        {
            return Ok(old.traced.clone());
        }
        self.stage(Stage::FormFactors, |run| {
            let tracer = RowTracer {
                scene: run.scene,
                occluders: lit.occluders,
                elements: lit.elements,
                emitters: lit.emitters,
                marks: lit.marks,
                rays: run.settings.element_rays,
                seed: run.settings.seed,
                remember: run.start.remember,
            };
            let before = run.before().map(|(old, change)| RowsBefore {
                traced: &old.traced,
                change,
                new_emitters: change.new_emitters,
            });
            let (traced, rays) = trace(&tracer, before.as_ref(), run.observer)?;
            run.work.element_rays += rays;
            Ok(traced.into())
        })
    }

    /// How lights and emitters reach the elements, and the light that brings.
    fn direct(
        &mut self,
        lit: &Lit,
        traced: &Traced,
    ) -> Result<(Arc<Direct>, Arc<Vec<Vec3>>), BakeError> {
        let scene = self.scene;
        let arriving =
            |direct: &Direct| Arc::new(direct.arriving(scene, lit.elements, traced, lit.marks));
        if let Some((old, change)) = self.before()
            && change.disturbed.is_empty()
            && change.same_elements
            && !change.new_emitters
            && old.direct.knows(&scene.lights, &change.light_before)
        {
            let colors = change.new_looks || !same_colors(scene, self.start.before);
            let arrived = if colors {
                arriving(&old.direct)
            } else {
                old.arrived.clone()
            };
            return Ok((old.direct.clone(), arrived));
        }
        self.stage(Stage::Direct, |run| {
            let sampler = Sampler {
                scene,
                occluders: lit.occluders,
                elements: lit.elements,
                emitters: lit.emitters,
                seed: run.settings.seed,
            };
            let before = run.before().map(|(old, change)| DirectBefore {
                direct: &old.direct,
                change,
                new_emitters: change.new_emitters,
            });
            let (direct, rays) = sampler.run(before.as_ref(), run.observer)?;
            run.work.light_rays += rays.lights;
            run.work.emitter_rays += rays.emitters;
            let arrived = arriving(&direct);
            Ok((direct.into(), arrived))
        })
    }

    fn solve(
        &mut self,
        elements: &Elements,
        traced: &Arc<Traced>,
        arrived: &Arc<Vec<Vec3>>,
    ) -> Result<Arc<Solution>, BakeError> {
        let mut warm = None;
        if let Some((old, change)) = self.before() {
            let same = Arc::ptr_eq(traced, &old.traced)
                && Arc::ptr_eq(arrived, &old.arrived)
                && !change.new_looks
                && self
                    .start
                    .before
                    .is_some_and(|b| b.settings == self.settings);
            if same && old.solution.report.converged {
                return Ok(old.solution.clone());
            }
            warm = Some(warm_start(old, change, elements, arrived));
        }
        self.stage(Stage::Solve, |run| {
            let observer = run.observer;
            let solution = gauss_seidel(
                elements,
                &traced.rows,
                arrived,
                run.settings.solver_tolerance,
                run.settings.max_sweeps,
                warm,
                || !observer.cancelled(),
            )?;
            run.work.sweeps += u64::from(solution.report.sweeps);
            Ok(solution.into())
        })
    }

    /// Which objects are seen from behind: double-sided ones whose front gets next to no light,
    /// beside their back and beside the scene.
    ///
    /// A vertex has one value, and a room modelled inside out would otherwise be black. In the dark
    /// it stays as it was.
    fn lit_from_behind(&self, elements: &Elements, solution: &Solution) -> Vec<bool> {
        if let Some(plan) = self.start.plan {
            return plan.lit_from_behind.clone();
        }
        let sums: Vec<_> = (0..self.scene.objects.len())
            .map(|o| sides_light(elements, o, solution))
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
                _ => mean(front) < 0.02 * mean(back).min(mean(all)),
            })
            .collect()
    }

    /// The elements that reflect much light: those known, as long as they are most of them.
    fn bright(&self, elements: &Elements, solution: &Solution) -> Arc<EmitterTree> {
        if let Some(plan) = self.start.plan {
            return plan.bright.clone();
        }
        let kept = self.before().and_then(|(old, change)| {
            let tree = &old.plan.bright;
            let stays =
                |l: &super::emitter_tree::Leaf| change.elements_now()[l.source as usize] != GONE;
            if change.same_elements && change.same_triangles {
                return Some(tree.clone());
            }
            tree.leaves.iter().all(stays).then(|| {
                let now = (&change.triangle_now, change.elements_now());
                Arc::new(tree.renumbered(now.0, now.1, elements.len()))
            })
        });
        kept.filter(|tree| tree.covers(elements, &solution.reflected))
            .unwrap_or_else(|| {
                EmitterTree::bright(self.scene, elements, &solution.reflected).into()
            })
    }

    /// Light inside the triangles: traced where need be, then put together.
    fn gather(
        &mut self,
        gather: &Gather,
        receivers: &ReceiverMeshes,
        solution: &Solution,
    ) -> Result<(Gathered, Vec<TriangleSamples>), BakeError> {
        let shining = Shining::new(
            gather.elements,
            &solution.reflected,
            (&self.scene.lights, self.scene.sky),
            self.settings.gather_rays,
        );
        let meshes = &receivers.meshes;
        let list: Vec<(u32, u32)> = (meshes.iter().enumerate())
            .flat_map(|(o, m)| (0..m.triangles.len() as u32).map(move |t| (o as u32, t)))
            .collect();
        self.stage(Stage::Gather, |run| {
            let objects = run.objects_to_gather(gather);
            let before = run.before().map(|(old, change)| GatherBefore {
                gathered: &old.gathered,
                change,
                object_before: &objects,
                new_emitters: change.new_emitters,
                new_reflectors: !gather
                    .reflectors
                    .tree
                    .same_leaves_as(&old.plan.bright, change.elements_now()),
            });
            let chunks = map_ranges(list.len(), CHUNK, Stage::Gather, run.observer, |range| {
                let mut cost = GatherCost::default();
                let each = list[range].iter().map(|&(o, t)| {
                    let (mesh, o, t) = (&meshes[o as usize], o as usize, t as usize);
                    let light = gather.triangle(mesh, o, t, before.as_ref(), &mut cost);
                    let samples = shining.fill(&light, mesh, t);
                    (samples, run.start.remember.then_some(light))
                });
                (each.collect::<Vec<_>>(), cost)
            })?;
            let mut gathered = Gathered {
                triangles: Vec::new(),
                first_of_object: vec![0],
            };
            for mesh in meshes {
                let end = gathered.first_of_object.last().copied().unwrap_or(0);
                gathered.first_of_object.push(end + mesh.triangles.len());
            }
            let mut samples = Vec::with_capacity(list.len());
            for (each, cost) in chunks {
                run.work.gather_rays += cost.rays;
                run.work.light_rays += cost.shadow.lights;
                run.work.emitter_rays += cost.shadow.emitters;
                for (sample, light) in each {
                    samples.push(sample);
                    gathered.triangles.extend(light);
                }
            }
            Ok((gathered, samples))
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

    fn fit(
        &mut self,
        samples: &[TriangleSamples],
        receivers: &ReceiverMeshes,
    ) -> Result<Fit, BakeError> {
        let known = match (self.start.plan, self.start.before) {
            (Some(plan), _) => Some(&plan.smoothing),
            // Colours do not change how noisy samples are: only new samples have to be judged.
            (None, Some(before)) if self.work.traced() == 0 => Some(&before.stages.plan.smoothing),
            _ => None,
        };
        self.stage(Stage::Fit, |run| {
            let unknowns = (receivers.unknowns, &*receivers.seams);
            let observer = run.observer;
            let fitted = fit(samples, unknowns, known, &|| !observer.cancelled())?;
            run.work.fits += 1;
            run.work.cross_validations += u64::from(known.is_none());
            Ok(fitted)
        })
    }
}

/// Triangles a thread takes at a time.
const CHUNK: usize = 32;

/// Whether lights and sky are as bright as they were.
fn same_colors(scene: &ValidScene, before: Option<Before>) -> bool {
    before.is_some_and(|b| {
        let powers = |s: &ValidScene| s.lights.iter().map(|l| l.power).collect::<Vec<_>>();
        scene.sky == b.scene.sky && powers(scene) == powers(b.scene)
    })
}

/// The earlier solution, as much brighter or darker in each channel as the direct light is now;
/// where there was none, light bounced once.
fn warm_start(old: &Stages, change: &Change, elements: &Elements, arrived: &[Vec3]) -> Vec<Vec3A> {
    let mean = |of: &Elements, light: &[Vec3]| {
        let light: Vec<Vec3A> = light.iter().map(|&l| l.into()).collect();
        of.mean(&light)
    };
    let was = mean(&old.elements, &old.arrived);
    let is = mean(elements, arrived);
    let scale = divide(is, was);
    let was_lit = was.cmpgt(DVec3::max(is * 1e-6, DVec3::ZERO));
    let at = |(e, before): (usize, &Option<u32>)| {
        let first = arrived[e] * elements.reflectance[e];
        let known = before.map_or(first, |p| {
            Vec3::from(old.solution.reflected[p as usize]) * scale
        });
        Vec3::select(BVec3::new(was_lit.x, was_lit.y, was_lit.z), known, first).into()
    };
    change.element_before.iter().enumerate().map(at).collect()
}

/// Light and area of an object's front and back.
fn sides_light(elements: &Elements, object: usize, solution: &Solution) -> [(f64, f64); 2] {
    let mut sums = [(0.0, 0.0); 2];
    for e in elements.of_object(object) {
        let side = &mut sums[usize::from(elements.is_back(e))];
        side.0 += f64::from(solution.arriving[e].element_sum() * elements.area[e]);
        side.1 += f64::from(elements.area[e]);
    }
    sums
}

fn object_light(receivers: &ReceiverMeshes, fitted: &Fit) -> Vec<ObjectLight> {
    let light = |u: &u32| fitted.light[*u as usize];
    (receivers.meshes.iter())
        .map(|mesh| ObjectLight {
            light: mesh.unknown.iter().map(light).collect(),
            mesh: mesh.refined.clone(),
        })
        .collect()
}

impl From<Cancelled> for BakeError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

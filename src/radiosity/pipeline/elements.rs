use std::sync::Arc;

use glam::{BVec3, DVec3, Vec3, Vec3A};

use super::Run;
use crate::radiosity::bake::BakeError;
use crate::radiosity::bvh::BvhQuality;
use crate::radiosity::change::Change;
use crate::radiosity::color::divide;
use crate::radiosity::direct::{Direct, DirectBefore, Sampler};
use crate::radiosity::element::Elements;
use crate::radiosity::emitter_tree::EmitterTree;
use crate::radiosity::first_look::FirstLook;
use crate::radiosity::form_factor::{GONE, RowsBefore, Traced, View, form_factors};
use crate::radiosity::identity::{matches, object_identities};
use crate::radiosity::layout::Layout;
use crate::radiosity::observer::Stage;
use crate::radiosity::occlusion::{Hierarchy, Holds, Occluders};
use crate::radiosity::partial::PartialLight;
use crate::radiosity::receiver_mesh::{MeshesBefore, ReceiverMeshes};
use crate::radiosity::sampling_error::{Judge, SamplingError};
use crate::radiosity::solve::{Solution, System, Watch, solve};
use crate::radiosity::stages::{Before, Stages};
use crate::radiosity::surface::{Pyramids, Surfaces};
use crate::radiosity::validate::ValidScene;

/// Textures, elements, the meshes that receive light, and how surfaces are cut.
type Meshed = (
    Arc<Pyramids>,
    Arc<Elements>,
    Arc<ReceiverMeshes>,
    Arc<Layout>,
);

/// From the scene to the light of its elements.
impl Run<'_> {
    /// Elements, the meshes that receive light, and how surfaces are cut.
    pub(super) fn mesh(&mut self) -> Result<Meshed, BakeError> {
        let scene = self.scene;
        let Some(before) = self.start.before else {
            return self.stage(Stage::Mesh, |run| {
                let layout = run
                    .start
                    .plan
                    .map_or_else(|| run.first_layout().into(), |plan| plan.layout.clone());
                let pyramids = Pyramids::new(scene, None);
                let elements = run.elements(&Surfaces::new(scene, &pyramids), &layout);
                let receivers = ReceiverMeshes::new(scene, run.settings, None)?;
                Ok((pyramids.into(), elements.into(), receivers.into(), layout))
            });
        };
        let old = before.stages;
        if scene.same_surfaces(before.scene) {
            let sides = ((before.scene, &*old.elements), (scene, &*old.elements));
            self.change = Some(Change::between(sides.0, sides.1));
            let kept = old.clone();
            return Ok((kept.pyramids, kept.elements, kept.given, kept.plan.layout));
        }
        self.stage(Stage::Mesh, |run| {
            let pyramids = Pyramids::new(scene, Some((before.scene, &old.pyramids)));
            let same = same_triangles(before.scene, scene);
            let layout = Arc::new(old.plan.layout.renumbered(&same));
            let elements = run.elements(&Surfaces::new(scene, &pyramids), &layout);
            let change = Change::between((before.scene, &old.elements), (scene, &elements));
            let receivers = run.receivers(old, &change)?;
            run.change = Some(change);
            Ok((pyramids.into(), elements.into(), receivers, layout))
        })
    }

    fn first_layout(&self) -> Layout {
        let layout = if self.settings.adapt {
            Layout::first_look(self.scene, self.settings)
        } else {
            Layout::even(self.scene, self.settings)
        };
        Layout {
            more: self.more_elements,
            ..layout
        }
    }

    pub(super) fn elements(&self, surfaces: &Surfaces, layout: &Layout) -> Elements {
        let brightest = self.settings.max_reflectance;
        Elements::new(self.scene, surfaces, layout, brightest)
    }

    fn receivers(&self, old: &Stages, change: &Change) -> Result<Arc<ReceiverMeshes>, BakeError> {
        let count = old.given.meshes.len();
        if change.mesh_before.iter().copied().eq((0..count).map(Some)) {
            return Ok(old.given.clone());
        }
        let before = MeshesBefore {
            meshes: &old.given,
            same: &change.mesh_before,
            object: &change.object_before,
        };
        let mut receivers = ReceiverMeshes::new(self.scene, self.settings, Some(&before))?;
        before.share_refinements(&mut receivers);
        Ok(receivers.into())
    }

    pub(super) fn occlusion(
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
                    let (scene, settings) = (run.scene, run.settings);
                    EmitterTree::new(scene, elements, &occluders, settings, run.observer)?.into()
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

    pub(super) fn form_factors(&mut self, view: &View) -> Result<Arc<Traced>, BakeError> {
        if let Some((old, change)) = self.before()
            && change.disturbed.is_empty()
            && change.same_elements
            && !change.new_emitters
        {
            return Ok(old.traced.clone());
        }
        self.stage(Stage::FormFactors, |run| {
            let before = run.before().map(|(old, change)| RowsBefore {
                traced: &old.traced,
                change,
                new_emitters: change.new_emitters,
            });
            let (traced, rays) = form_factors(view, before.as_ref(), run.observer)?;
            run.work.element_rays += rays;
            Ok(traced.into())
        })
    }

    /// How lights and emitters reach the elements, and the light that brings.
    pub(super) fn direct(
        &mut self,
        view: &View,
        traced: &Traced,
    ) -> Result<(Arc<Direct>, Arc<Vec<Vec3>>), BakeError> {
        let scene = self.scene;
        let arriving =
            |direct: &Direct| Arc::new(direct.arriving(scene, view.elements, traced, view.marks));
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
            let sampler = Sampler::new(view);
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

    pub(super) fn solve(
        &mut self,
        elements: &Elements,
        traced: &Arc<Traced>,
        arrived: &Arc<Vec<Vec3>>,
        receivers: &ReceiverMeshes,
    ) -> Result<Arc<Solution>, BakeError> {
        let mut warm = None;
        if let Some((old, change)) = self.before() {
            let same = Arc::ptr_eq(traced, &old.traced)
                && Arc::ptr_eq(arrived, &old.arrived)
                && !change.new_looks
                && self
                    .start
                    .before
                    .is_some_and(|b| b.settings.same_solution(self.settings));
            if same && old.solution.report.converged {
                return Ok(old.solution.clone());
            }
            warm = Some(warm_start(old, change, elements, arrived));
        }
        self.stage(Stage::Solve, |run| {
            let observer = run.observer;
            let system = System {
                elements,
                rows: &traced.rows,
                direct: arrived,
            };
            let watch = Watch {
                go_on: &|| !observer.cancelled(),
                show: &|glimpse| {
                    observer.partial(&PartialLight::new(run.scene, receivers, glimpse));
                },
            };
            let solution = solve(&system, run.settings, warm, &watch)?;
            run.work.sweeps += u64::from(solution.report.sweeps);
            Ok(solution.into())
        })
    }

    /// What sampling leaves in the light of elements. Colours do not change how noisy rays are: only
    /// new rays have to be judged.
    pub(super) fn error(
        &mut self,
        view: &View,
        traced: &Traced,
        solution: &Solution,
        first: Option<&FirstLook>,
    ) -> Result<SamplingError, BakeError> {
        if let Some((old, _)) = self.before()
            && self.work.rays() == 0
        {
            return Ok(old.error);
        }
        self.stage(Stage::Error, |run| {
            let judge = Judge {
                view,
                sampler: &Sampler::new(view),
                traced,
                solution,
                first,
            };
            let (mut error, rays) = judge.run(run.observer)?;
            run.work.error_rays += rays;
            // Elements are as fine as they were, if others.
            error.cells = run.before().map_or(error.cells, |(old, _)| old.error.cells);
            Ok(error)
        })
    }
}

/// For each new object, the old one that had the same triangles at whatever place.
fn same_triangles(old: &ValidScene, new: &ValidScene) -> Vec<Option<usize>> {
    let before = matches(&object_identities(old), &object_identities(new));
    (new.objects.iter().zip(before))
        .map(|(o, p)| p.filter(|&p| old.objects[p].triangles == o.triangles))
        .collect()
}

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

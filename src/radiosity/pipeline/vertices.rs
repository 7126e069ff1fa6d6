use std::sync::Arc;

use super::Run;
use crate::radiosity::bake::BakeError;
use crate::radiosity::element::{Elements, SEEN_FROM_BEHIND};
use crate::radiosity::emitter_tree::{EmitterTree, Leaf};
use crate::radiosity::fit::{Fit, fit};
use crate::radiosity::form_factor::GONE;
use crate::radiosity::gather::{Gather, GatherBefore, GatherCost, density};
use crate::radiosity::gathered::{Gathered, Shining, TriangleSamples};
use crate::radiosity::observer::Stage;
use crate::radiosity::parallel::map_ranges;
use crate::radiosity::receiver_mesh::ReceiverMeshes;
use crate::radiosity::solve::Solution;

/// Triangles a thread takes at a time.
const CHUNK: usize = 32;

/// From the light of elements to that of vertices.
impl Run<'_> {
    /// Samples per square root of a triangle's area.
    pub(super) fn density(&self, receivers: &ReceiverMeshes) -> f32 {
        (self.start.plan.map(|p| p.density))
            .or(self.start.before.map(|b| b.stages.plan.density))
            .unwrap_or_else(|| density(receivers, self.settings))
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

    /// The elements that reflect much light: those known, as long as they are most of them.
    pub(super) fn bright(&self, elements: &Elements, solution: &Solution) -> Arc<EmitterTree> {
        if let Some(plan) = self.start.plan {
            return plan.bright.clone();
        }
        let kept = self.before().and_then(|(old, change)| {
            let tree = &old.plan.bright;
            let stays = |l: &Leaf| change.elements_now()[l.source as usize] != GONE;
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
    pub(super) fn gather(
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

    pub(super) fn fit(
        &mut self,
        samples: &[TriangleSamples],
        receivers: &ReceiverMeshes,
    ) -> Result<Fit, BakeError> {
        let known = match (self.start.plan, self.start.before) {
            (Some(plan), _) => Some(&plan.smoothing),
            // Colours do not change how noisy samples are: only new samples have to be judged.
            (None, Some(before)) if self.work.rays() == 0 => Some(&before.stages.plan.smoothing),
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

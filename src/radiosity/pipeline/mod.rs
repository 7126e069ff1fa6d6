//! A bake from end to end, in two halves: the light of elements, and that of vertices.

mod elements;
mod finer;
mod first_look;
mod passes;
mod vertices;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;

use self::finer::told_twice;
use self::passes::Deadline;
pub(crate) use self::passes::Pass;
pub(crate) use self::vertices::KEPT_RAYS;
use super::bake::BakeError;
use super::baked::Bake;
use super::change::Change;
use super::cut::{self, Cuts};
use super::direct::Direct;
use super::element::Elements;
use super::element_light::ElementLight;
use super::emitter::Emitters;
use super::emitter_tree::EmitterTree;
use super::findings::{Findings, VertexFindings};
use super::form_factor::{Traced, View};
use super::gather::{Aids, Density, Gather};
use super::gathered::Shining;
use super::layout::Layout;
use super::observer::{Observer, Stage};
use super::occlusion::{Hierarchy, Occluders};
use super::parallel::Cancelled;
use super::receiver_mesh::ReceiverMeshes;
use super::report::Work;
use super::sampling_error::SamplingError;
use super::settings::BakeSettings;
use super::solve::Solution;
use super::stages::{Plan, Stages, Start};
use super::surface::{Pyramids, Surfaces};
use super::validate::ValidScene;

/// A bake on its way.
struct Run<'a> {
    scene: &'a ValidScene,
    settings: &'a BakeSettings,
    /// How many times as many elements these say as the settings given.
    more_elements: f32,
    start: Start<'a>,
    change: Option<Change>,
    observer: &'a dyn Observer,
    stages: Vec<(Stage, Duration)>,
    work: Work,
}

/// The light of elements, and all it was found with.
struct Solved {
    pyramids: Arc<Pyramids>,
    elements: Arc<Elements>,
    /// The receiving meshes, before the light refines them.
    given: Arc<ReceiverMeshes>,
    hierarchy: Arc<Hierarchy>,
    emitters: Arc<EmitterTree>,
    traced: Arc<Traced>,
    direct: Arc<Direct>,
    /// Direct light at each element.
    arrived: Arc<Vec<Vec3>>,
    solution: Arc<Solution>,
    error: SamplingError,
    layout: Arc<Layout>,
}

/// Passes a scene through all stages, each of which takes from `start` what is still true.
pub(crate) fn run(
    scene: &ValidScene,
    settings: &BakeSettings,
    start: Start,
    observer: &dyn Observer,
) -> Result<(Bake, Stages), BakeError> {
    let (begun, deadline) = (
        Instant::now(),
        Deadline::new(observer, settings.max_seconds),
    );
    let cuts = contacts(scene, settings, &start, observer)?;
    let cut_scene = cut::apply(scene, &cuts).map(Arc::new);
    let scene = cut_scene.as_deref().unwrap_or(scene);
    let mut run = Run::new(scene, settings, start.in_cut_scene(), &deadline);
    if settings.refine {
        run.stages.push((Stage::Contacts, begun.elapsed()));
    }
    let mut solved = run.solved()?;
    let finer = run.finer(&solved, &deadline);
    if let Some(finer) = &finer {
        run.more_elements = finer.elements as f32 / settings.elements as f32;
        run.settings = finer;
        let first = solved.error;
        solved = run.solved()?;
        solved.error.cells = told_twice(first.cells, solved.error.cells, run.more_elements);
    }
    run.lit(solved, (cuts, cut_scene.clone()), &deadline)
}

/// How surfaces are cut where they touch or cross, if vertices are placed by the light at all.
fn contacts(
    scene: &ValidScene,
    settings: &BakeSettings,
    start: &Start,
    observer: &dyn Observer,
) -> Result<Cuts, BakeError> {
    if !settings.refine {
        return Ok(Cuts::new());
    }
    observer.progress(Stage::Contacts, 0.0);
    let cuts = cut::cuts(scene, start, observer)?;
    observer.progress(Stage::Contacts, 1.0);
    if observer.cancelled() {
        return Err(BakeError::Cancelled);
    }
    Ok(cuts)
}

/// Passes a scene through the stages up to the solution.
pub(crate) fn run_elements(
    scene: &ValidScene,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<ElementLight, BakeError> {
    let mut run = Run::new(scene, settings, Start::default(), observer);
    let solved = run.solved()?;
    let report = run.findings(&solved).report(None);
    Ok(ElementLight::new(
        scene,
        &solved.elements,
        solved.traced,
        &solved.arrived,
        &solved.solution,
        report,
    ))
}

impl<'a> Run<'a> {
    fn new(
        scene: &'a ValidScene,
        settings: &'a BakeSettings,
        start: Start<'a>,
        observer: &'a dyn Observer,
    ) -> Self {
        Self {
            scene,
            settings,
            more_elements: 1.0,
            start,
            change: None,
            observer,
            stages: Vec::new(),
            work: Work::default(),
        }
    }

    /// The second half: from the light of elements to that of vertices.
    fn lit(
        mut self,
        solved: Solved,
        (cuts, cut_scene): (Cuts, Option<Arc<ValidScene>>),
        deadline: &Deadline,
    ) -> Result<(Bake, Stages), BakeError> {
        let surfaces = Surfaces::new(self.scene, &solved.pyramids);
        let elements = &*solved.elements;
        let lit_from_behind = self.lit_from_behind(elements, &solved.solution);
        let glaring = self.glaring(&solved);
        let mut gather = Gather {
            scene: self.scene,
            occluders: Occluders::new(&solved.hierarchy, &surfaces),
            elements,
            emitters: Emitters::at_samples(&solved.emitters, self.settings),
            reflectors: Emitters::glaring_at_samples(&glaring, self.settings),
            marks: [
                &Emitters::at_samples(&solved.emitters, self.settings).marks(elements),
                &Emitters::glaring_at_samples(&glaring, self.settings).marks(elements),
            ],
            lit_from_behind: &lit_from_behind,
            settings: self.settings,
            density: Density::default(),
            remember: self.start.remember,
            aids: Aids::new(self.scene),
        };
        let shining = Shining::new(
            elements,
            &solved.solution.reflected,
            (&self.scene.lights, self.scene.sky),
            (self.settings.contribution, self.settings.gather_rays),
        );
        let bake = |run: &Run, pass: &Pass| Bake {
            objects: pass.objects(&lit_from_behind),
            report: run.findings(&solved).report(Some(&VertexFindings {
                pass,
                lit_from_behind: &lit_from_behind,
            })),
        };
        let show = |run: &Run, pass: &Pass| run.observer.so_far(&bake(run, pass));
        let pass = self.passes(&mut gather, &shining, &solved, deadline, &show)?;
        let bake = bake(&self, &pass);
        let stages = Stages {
            plan: Plan {
                layout: solved.layout,
                density: pass.density,
                emitters: solved.emitters,
                glaring,
                lit_from_behind,
                cuts,
                refinement: pass.refinement,
                control: pass.control,
                stopped: pass.stopped,
                smoothing: pass.fitted.smoothing,
            },
            pyramids: solved.pyramids,
            elements: solved.elements,
            given: solved.given,
            receivers: pass.receivers,
            hierarchy: solved.hierarchy,
            traced: solved.traced,
            direct: solved.direct,
            arrived: solved.arrived,
            solution: solved.solution,
            error: solved.error,
            gathered: Arc::new(pass.inside.gathered()),
            cut_scene,
        };
        Ok((bake, stages))
    }

    /// The first half: from the scene to the light of its elements.
    fn solved(&mut self) -> Result<Solved, BakeError> {
        let (pyramids, elements, given, layout) = self.mesh()?;
        let surfaces = Surfaces::new(self.scene, &pyramids);
        let (hierarchy, emitters) = self.occlusion(&surfaces, &elements)?;
        let occluders = Occluders::new(&hierarchy, &surfaces);
        let (elements, layout, first) =
            self.first_look(elements, layout, (&surfaces, occluders), &emitters)?;
        let sampled = Emitters::at_elements(&emitters, self.settings);
        let view = View {
            scene: self.scene,
            occluders,
            elements: &elements,
            emitters: sampled,
            marks: &sampled.marks(&elements),
            settings: self.settings,
            remember: self.start.remember,
        };
        let traced = self.form_factors(&view)?;
        let (direct, arrived) = self.direct(&view, &traced)?;
        let solution = self.solve(&elements, &traced, &arrived, &given)?;
        let error = self.error(&view, &traced, &solution, first.as_ref())?;
        Ok(Solved {
            pyramids,
            elements,
            given,
            hierarchy,
            emitters,
            traced,
            direct,
            arrived,
            solution,
            error,
            layout,
        })
    }

    fn findings<'s>(&'s self, solved: &'s Solved) -> Findings<'s> {
        let contribution = self.settings.contribution;
        let (arriving, direct) = (&solved.solution.arriving, &solved.arrived);
        Findings {
            scene: self.scene,
            settings: self.settings,
            elements: &solved.elements,
            tree: &solved.emitters,
            traced: &solved.traced,
            arrived: &solved.arrived,
            solution: &solved.solution,
            error: solved.error,
            enlarged: contribution.enlarges(&solved.elements, arriving, direct),
            stages: &self.stages,
            work: self.work,
            occluder_bytes: solved.hierarchy.bytes(),
        }
    }

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
        let spent = since.elapsed();
        match self.stages.iter_mut().find(|s| s.0 == stage) {
            Some(known) => known.1 += spent,
            None => self.stages.push((stage, spent)),
        }
        self.observer.progress(stage, 1.0);
        if self.observer.cancelled() {
            return Err(BakeError::Cancelled);
        }
        Ok(made)
    }

    fn before(&self) -> Option<(&'a Stages, &Change)> {
        Some((self.start.before?.stages, self.change.as_ref()?))
    }
}

impl From<Cancelled> for BakeError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

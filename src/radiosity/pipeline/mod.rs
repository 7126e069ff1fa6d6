//! A bake from end to end, in two halves: the light of elements, and that of vertices.

mod elements;
mod first_look;
mod vertices;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;

use super::bake::BakeError;
use super::baked::Bake;
use super::change::Change;
use super::direct::Direct;
use super::element::Elements;
use super::element_light::ElementLight;
use super::emitter::Emitters;
use super::emitter_tree::EmitterTree;
use super::findings::{Findings, VertexFindings};
use super::form_factor::{Traced, View};
use super::gather::{Aids, Gather};
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
    receivers: Arc<ReceiverMeshes>,
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
    let mut run = Run::new(scene, settings, start, observer);
    let solved = run.solved()?;
    let surfaces = Surfaces::new(scene, &solved.pyramids);
    let elements = &*solved.elements;
    let lit_from_behind = run.lit_from_behind(elements, &solved.solution);
    let bright = run.bright(elements, &solved.solution);
    let density = run.density(&solved.receivers);
    let gather = Gather {
        scene,
        occluders: Occluders::new(&solved.hierarchy, &surfaces),
        elements,
        emitters: Emitters::at_samples(&solved.emitters, settings),
        reflectors: Emitters::bright_at_samples(&bright, settings),
        marks: [
            &Emitters::at_samples(&solved.emitters, settings).marks(elements),
            &Emitters::bright_at_samples(&bright, settings).marks(elements),
        ],
        lit_from_behind: &lit_from_behind,
        settings,
        density,
        remember: start.remember,
        aids: Aids::new(scene),
    };
    let (gathered, samples) = run.gather(&gather, &solved.receivers, &solved.solution)?;
    let fitted = run.fit(&samples, &solved.receivers)?;
    let bake = Bake {
        objects: solved.receivers.object_light(&fitted.light),
        report: run.findings(&solved).report(Some(&VertexFindings {
            receivers: &solved.receivers,
            lit_from_behind: &lit_from_behind,
            samples: &samples,
            fitted: &fitted,
        })),
    };
    let stages = Stages {
        plan: Plan {
            layout: solved.layout,
            density,
            emitters: solved.emitters,
            bright,
            lit_from_behind,
            smoothing: fitted.smoothing,
        },
        pyramids: solved.pyramids,
        elements: solved.elements,
        receivers: solved.receivers,
        hierarchy: solved.hierarchy,
        traced: solved.traced,
        direct: solved.direct,
        arrived: solved.arrived,
        solution: solved.solution,
        error: solved.error,
        gathered: Arc::new(gathered),
    };
    Ok((bake, stages))
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
            start,
            change: None,
            observer,
            stages: Vec::new(),
            work: Work::default(),
        }
    }

    /// The first half: from the scene to the light of its elements.
    fn solved(&mut self) -> Result<Solved, BakeError> {
        let (pyramids, elements, receivers, layout) = self.mesh()?;
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
        let solution = self.solve(&elements, &traced, &arrived, &receivers)?;
        let error = self.error(&view, &traced, &solution, first.as_ref())?;
        Ok(Solved {
            pyramids,
            elements,
            receivers,
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
        Findings {
            scene: self.scene,
            settings: self.settings,
            elements: &solved.elements,
            tree: &solved.emitters,
            traced: &solved.traced,
            arrived: &solved.arrived,
            solution: &solved.solution,
            error: solved.error,
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
}

impl From<Cancelled> for BakeError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

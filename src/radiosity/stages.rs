use std::sync::Arc;

use glam::Vec3;

use super::cut::Cuts;
use super::direct::Direct;
use super::element::Elements;
use super::emitter_tree::EmitterTree;
use super::fit::Smoothing;
use super::form_factor::Traced;
use super::gather::Density;
use super::gathered::Gathered;
use super::layout::Layout;
use super::occlusion::Hierarchy;
use super::receiver_mesh::ReceiverMeshes;
use super::receivers::Receivers;
use super::refine::{Control, Refinement};
use super::report::Stopped;
use super::sampling_error::SamplingError;
use super::settings::BakeSettings;
use super::solve::Solution;
use super::surface::Pyramids;
use super::validate::ValidScene;

/// What the stages of a bake made, to be taken up by the next.
#[derive(Clone)]
pub(crate) struct Stages {
    /// The scene with its surfaces cut where they touch, if any were.
    pub(crate) cut_scene: Option<Arc<ValidScene>>,
    pub(crate) pyramids: Arc<Pyramids>,
    pub(crate) elements: Arc<Elements>,
    /// The meshes before they were refined.
    pub(crate) given: Arc<ReceiverMeshes>,
    pub(crate) receivers: Receivers,
    pub(crate) hierarchy: Arc<Hierarchy>,
    pub(crate) traced: Arc<Traced>,
    pub(crate) direct: Arc<Direct>,
    /// Direct light at each element.
    pub(crate) arrived: Arc<Vec<Vec3>>,
    pub(crate) solution: Arc<Solution>,
    pub(crate) error: SamplingError,
    pub(crate) gathered: Arc<Gathered>,
    pub(crate) plan: Plan,
}

/// What a bake decides by looking at the whole scene, and a later bake of much the same scene does
/// not decide anew: else a small change would move every element and every sample. All estimates
/// stay unbiased with a plan that is not quite up to date.
#[derive(Clone)]
pub(crate) struct Plan {
    /// How surfaces are cut into elements.
    pub(crate) layout: Arc<Layout>,
    pub(crate) density: Density,
    /// Emissive triangles to sample.
    pub(crate) emitters: Arc<EmitterTree>,
    /// Elements to sample for the light they reflect.
    pub(crate) glaring: Arc<EmitterTree>,
    pub(crate) lit_from_behind: Vec<bool>,
    /// How objects are cut where they touch.
    pub(crate) cuts: Cuts,
    pub(crate) refinement: Arc<Refinement>,
    /// How far off the vertices' light was when they were placed, and why no better was looked for.
    pub(crate) control: Option<Control>,
    pub(crate) stopped: Stopped,
    pub(crate) smoothing: Smoothing,
}

/// An earlier bake: its scene and what it made.
#[derive(Clone, Copy)]
pub(crate) struct Before<'a> {
    pub(crate) scene: &'a ValidScene,
    pub(crate) settings: &'a BakeSettings,
    pub(crate) stages: &'a Stages,
}

/// Where a bake starts from.
#[derive(Clone, Copy, Default)]
pub(crate) struct Start<'a> {
    /// What is known already; nothing without it.
    pub(crate) before: Option<Before<'a>>,
    /// Decisions made already, for this very scene.
    pub(crate) plan: Option<&'a Plan>,
    /// Whether to note down what the next bake needs to resume.
    pub(crate) remember: bool,
}

impl<'a> Start<'a> {
    /// Start from an earlier bake as its stages saw it, with surfaces cut where they touch.
    pub(crate) fn in_cut_scene(self) -> Self {
        let before = self.before.map(|b| Before {
            scene: b.stages.cut_scene(b.scene),
            ..b
        });
        Self { before, ..self }
    }
}

impl Stages {
    /// Whether rays and shadow rays of all samples found the same.
    #[cfg(test)]
    pub(crate) fn same_gathered(&self, other: &Self) -> bool {
        let (a, b) = (&self.gathered, &other.gathered);
        let bundles = a.bundles.list.iter().zip(&b.bundles.list);
        let mut sharp = a.sharp.list.iter().zip(&b.sharp.list);
        a.bundles.list.len() == b.bundles.list.len()
            && a.sharp.list.len() == b.sharp.list.len()
            && bundles
                .into_iter()
                .all(|(a, b)| a.ids == b.ids && a.reaches == b.reaches)
            && sharp.all(|(a, b)| a.same(b))
            && self.direct.same(&other.direct)
    }

    /// The scene that was baked, as it was cut.
    pub(crate) fn cut_scene<'a>(&'a self, scene: &'a ValidScene) -> &'a ValidScene {
        self.cut_scene.as_deref().unwrap_or(scene)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.pyramids.bytes()
            + self.elements.bytes()
            + self.given.bytes()
            + self.receivers.bytes()
            + self.hierarchy.bytes()
            + self.traced.bytes()
            + self.direct.bytes()
            + size_of_val(&**self.arrived) as u64
            + size_of_val(&*self.solution.arriving) as u64
            + size_of_val(&*self.solution.reflected) as u64
            + self.gathered.bytes()
            + self.plan.layout.bytes()
            + self.plan.emitters.bytes()
            + self.plan.glaring.bytes()
    }
}

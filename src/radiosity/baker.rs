use glam::Vec3;

use super::bake::{BakeError, check};
use super::baked::{Bake, ObjectLight};
use super::cut::{self, ContactLine};
use super::element_light::ElementLight;
use super::observer::Observer;
use super::pipeline::run;
use super::report::Work;
use super::scene::Scene;
use super::settings::BakeSettings;
use super::stages::{Before, Stages, Start};
use super::validate::{SceneError, ValidScene};

/// Keeps what a bake found and redoes only what a change made stale.
///
/// | what changed | what is redone |
/// |---|---|
/// | nothing | nothing |
/// | colour or power of a light, the sky | the solution, without a ray |
/// | reflectance, emission | the solution, without a ray |
/// | a light's place or shape | its shadow rays |
/// | what emits at all | shadow rays to emitters, rays that meet them |
/// | an object, in place or shape | rays that start on it, met it, or pass where it is or was |
/// | [`contribution`](BakeSettings::contribution), [`vertex_quality`](BakeSettings::vertex_quality) | the fit of vertices, without a ray |
/// | other settings | everything, but for those of the solver |
///
/// Objects and lights are told apart by their `key`, and whether they changed by comparing them: a
/// scene may be handed over at any time, and one that is as it was costs no more than a look.
///
/// The result is that of a bake from nothing, within the noise of sampling: what a bake decides by
/// looking at the whole scene (the size of elements, which emitters are worth sampling) stays until
/// the scene is clearly another, so that what did not change stays the same to the last bit.
///
/// A bake that is cancelled leaves everything as it was.
#[derive(Debug)]
pub struct Baker {
    settings: BakeSettings,
    kept: Option<Box<Kept>>,
}

struct Kept {
    scene: ValidScene,
    settings: BakeSettings,
    stages: Stages,
    bake: Bake,
}

impl std::fmt::Debug for Kept {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Kept")
            .field("bytes", &self.stages.bytes())
            .finish_non_exhaustive()
    }
}

/// A scene is another when its elements would be this much larger or smaller.
const OUTDATED: f32 = 2.0;

impl Baker {
    /// A baker that has baked nothing yet.
    pub fn new(settings: BakeSettings) -> Self {
        Self {
            settings,
            kept: None,
        }
    }

    /// What bakes are done with.
    pub fn settings(&self) -> &BakeSettings {
        &self.settings
    }

    /// Changes the settings; the next bake redoes what they change.
    pub fn set_settings(&mut self, settings: BakeSettings) {
        self.settings = settings;
    }

    /// Bakes `scene`, redoing only what differs from the last scene baked.
    ///
    /// A scene where nothing shines is not an error here: its light is black. Nor is an empty one.
    ///
    /// # Errors
    ///
    /// As [`bake`](super::bake), and [`BakeError::Scene`] for a scene that cannot be baked.
    pub fn bake(&mut self, scene: Scene, observer: &dyn Observer) -> Result<Bake, BakeError> {
        self.settings.check()?;
        let frame = self.kept.as_ref().map(|k| k.scene.frame());
        let black: Vec<ObjectLight> = scene.objects.iter().map(black).collect();
        let scene = match scene.validate_in(frame) {
            Ok(scene) => scene,
            Err(SceneError::Empty) => {
                return Ok(Bake {
                    objects: black,
                    ..Bake::default()
                });
            }
            Err(error) => return Err(error.into()),
        };
        check(&scene, &self.settings)?;
        let kept = self
            .kept
            .as_ref()
            .filter(|k| k.resumes(&scene, &self.settings));
        if let Some(kept) = kept.filter(|k| k.scene == scene && k.settings == self.settings) {
            return Ok(kept.unchanged());
        }
        let start = Start {
            before: kept.map(|k| Before {
                scene: &k.scene,
                settings: &k.settings,
                stages: &k.stages,
            }),
            plan: None,
            remember: true,
        };
        let (bake, stages) = run(&scene, &self.settings, start, observer)?;
        self.kept = Some(Box::new(Kept {
            scene,
            settings: self.settings.clone(),
            stages,
            bake: bake.clone(),
        }));
        Ok(bake)
    }

    /// The light of the elements that the last bake solved for, with its report; `None` before the first.
    pub fn elements(&self) -> Option<ElementLight> {
        let kept = self.kept.as_ref()?;
        let stages = &kept.stages;
        Some(ElementLight::new(
            stages.cut_scene(&kept.scene),
            &stages.elements,
            stages.traced.clone(),
            &stages.arrived,
            &stages.solution,
            kept.bake.report.clone(),
        ))
    }

    /// The lines along which the last bake cut surfaces where others touch or cross them.
    pub fn contacts(&self) -> Vec<ContactLine> {
        let kept = self.kept.as_ref();
        kept.map_or_else(Vec::new, |kept| {
            cut::lines(kept.stages.cut_scene(&kept.scene))
        })
    }

    /// Bytes kept for the next bake.
    pub fn bytes(&self) -> u64 {
        self.kept.as_ref().map_or(0, |k| k.stages.bytes())
    }

    #[cfg(test)]
    pub(crate) fn stages(&self) -> Option<&Stages> {
        self.kept.as_ref().map(|k| &k.stages)
    }

    /// The scene baked last once more, from nothing but the plan.
    #[cfg(test)]
    pub(crate) fn scratch(&self) -> Option<(Bake, Stages)> {
        let kept = self.kept.as_ref()?;
        let start = Start {
            before: None,
            plan: Some(&kept.stages.plan),
            remember: true,
        };
        run(&kept.scene, &self.settings, start, &()).ok()
    }

    /// Drops what is kept: the next bake starts from nothing.
    pub fn forget(&mut self) {
        self.kept = None;
    }
}

impl Kept {
    /// Whether a bake of `scene` is worth starting from this one.
    fn resumes(&self, scene: &ValidScene, settings: &BakeSettings) -> bool {
        let solver = BakeSettings {
            solver: settings.solver,
            solver_tolerance: settings.solver_tolerance,
            max_sweeps: settings.max_sweeps,
            max_memory: settings.max_memory,
            contribution: settings.contribution,
            vertex_quality: settings.vertex_quality,
            ..self.settings.clone()
        };
        let area = self.stages.plan.layout.outgrown(scene, settings);
        solver == *settings
            && scene.frame() == self.scene.frame()
            && (1.0 / OUTDATED..OUTDATED).contains(&area)
    }

    fn unchanged(&self) -> Bake {
        let mut bake = self.bake.clone();
        bake.report.stages.clear();
        bake.report.work = Work::default();
        bake
    }
}

/// The light of an object in an empty scene.
fn black(object: &super::scene::Object) -> ObjectLight {
    let receiving = if object.receives {
        object.positions.len()
    } else {
        0
    };
    ObjectLight {
        mesh: None,
        light: vec![Vec3::ZERO; receiving],
        gradient: Vec::new(),
        quality: Vec::new(),
    }
}

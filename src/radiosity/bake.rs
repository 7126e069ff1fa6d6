use std::time::Instant;

use super::baked::{Bake, ObjectLight};
use super::bvh::BvhQuality;
use super::direct::direct;
use super::element::Elements;
use super::emitter::Emitters;
use super::emitter_tree::EmitterTree;
use super::findings::Findings;
use super::fit::{Fit, fit};
use super::form_factor::trace;
use super::gather::Gather;
use super::observer::{Observer, Stage};
use super::occlusion::{Hierarchy, Holds, NO_TRIANGLE, Occluders};
use super::parallel::Cancelled;
use super::receiver_mesh::ReceiverMeshes;
use super::settings::{BakeSettings, InvalidSetting};
use super::solve::{Solution, gauss_seidel};
use super::surface::Surfaces;
use super::validate::{SceneError, ValidScene};
use crate::mesh::SplitError;

/// Why a bake ended without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The observer asked for it.
    #[error("the bake was cancelled")]
    Cancelled,
    /// A setting lies outside its limits.
    #[error(transparent)]
    Setting(#[from] InvalidSetting),
    /// The scene cannot be baked.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Edges cannot be split as asked.
    #[error(transparent)]
    Split(#[from] SplitError),
}

impl From<Cancelled> for BakeError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Bakes the diffuse light of a scene into its vertices.
///
/// ```text
///  scene ─► receiving meshes ────────────────────────────────────────┐
///     └───► elements + occluders ─► form factors ─► direct ─► solve ─► gather ─► fit ─► Bake
/// ```
///
/// The result depends on the scene and the settings alone: the same bytes for any number of
/// threads.
///
/// # Errors
///
/// [`BakeError::Cancelled`] if the observer said so, else what is wrong with a setting.
pub fn bake(
    scene: &ValidScene,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<Bake, BakeError> {
    settings.check()?;
    let mut clock = Clock::default();

    clock.start(Stage::Mesh, observer);
    let surfaces = Surfaces::new(scene);
    let receivers = ReceiverMeshes::new(scene, settings.max_edge)?;
    let elements = Elements::new(
        scene,
        &surfaces,
        settings.elements,
        settings.max_reflectance,
    );
    clock.next(Stage::Occlusion, observer)?;
    let hierarchy = Hierarchy::new(scene, &surfaces, Holds::Casting, BvhQuality::Best);
    let occluders = Occluders::new(&hierarchy, &surfaces);
    let tree = EmitterTree::new(scene, &elements, &occluders, settings.seed, observer)?;
    clock.next(Stage::FormFactors, observer)?;
    let emitters = Emitters::at_elements(&tree, settings);
    let traced = trace(
        scene,
        &occluders,
        &elements,
        &emitters,
        settings.element_rays,
        settings.seed,
        observer,
    )?;
    clock.next(Stage::Direct, observer)?;
    let arrived = direct(
        scene,
        &occluders,
        &elements,
        &emitters,
        &traced.found,
        settings.seed,
        observer,
    )?;
    clock.next(Stage::Solve, observer)?;
    let solution = gauss_seidel(
        &elements,
        &traced.rows,
        &arrived,
        settings.solver_tolerance,
        settings.max_sweeps,
        || !observer.cancelled(),
    );
    clock.next(Stage::Gather, observer)?;
    let lit_from_behind = lit_from_behind(scene, &elements, &solution);
    let bright = EmitterTree::bright(scene, &elements, &solution.reflected);
    let samples = Gather {
        scene,
        occluders: &occluders,
        elements: &elements,
        emitters: Emitters::at_samples(&tree, settings),
        reflectors: Emitters::bright_at_samples(&bright, &solution.reflected, settings),
        lit_from_behind: &lit_from_behind,
        live: &live_by_object(scene),
        settings,
    }
    .run(&receivers, observer)?;
    clock.next(Stage::Fit, observer)?;
    let fitted = fit(&samples, receivers.unknowns, &receivers.seams);
    let stages = clock.finish(observer)?;

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
        work: super::report::Work::default(),
    };
    let report = findings.report(stages, hierarchy.bytes());
    Ok(Bake {
        objects: object_light(receivers, &fitted),
        report,
    })
}

/// Times the stages and asks between them whether to go on.
#[derive(Default)]
struct Clock {
    stages: Vec<(Stage, std::time::Duration)>,
    running: Option<(Stage, Instant)>,
}

impl Clock {
    fn start(&mut self, stage: Stage, observer: &dyn Observer) {
        observer.progress(stage, 0.0);
        self.running = Some((stage, Instant::now()));
    }

    fn stop(&mut self, observer: &dyn Observer) -> Result<(), Cancelled> {
        if let Some((stage, since)) = self.running.take() {
            self.stages.push((stage, since.elapsed()));
            observer.progress(stage, 1.0);
        }
        if observer.cancelled() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }

    fn next(&mut self, stage: Stage, observer: &dyn Observer) -> Result<(), Cancelled> {
        self.stop(observer)?;
        self.start(stage, observer);
        Ok(())
    }

    fn finish(
        mut self,
        observer: &dyn Observer,
    ) -> Result<Vec<(Stage, std::time::Duration)>, Cancelled> {
        self.stop(observer)?;
        Ok(self.stages)
    }
}

/// For each object, the live index of each of its triangles.
fn live_by_object(scene: &ValidScene) -> Vec<Vec<u32>> {
    let mut live: Vec<Vec<u32>> = scene
        .objects
        .iter()
        .map(|o| vec![NO_TRIANGLE; o.triangles.len()])
        .collect();
    for (i, key) in scene.triangles.iter().enumerate() {
        live[key.object as usize][key.triangle as usize] = i as u32;
    }
    live
}

/// Which objects are seen from behind: double-sided ones whose front gets next to no light, beside
/// their back and beside the scene.
///
/// A vertex has one value, and a room modelled inside out would otherwise be black.
fn lit_from_behind(scene: &ValidScene, elements: &Elements, solution: &Solution) -> Vec<bool> {
    // Light and area of each object's front and back.
    let mut sums = vec![[(0.0_f64, 0.0_f64); 2]; scene.objects.len()];
    for (e, light) in solution.arriving.iter().enumerate() {
        let side = &mut sums[elements.object(scene, e)][usize::from(elements.is_back(e))];
        side.0 += f64::from(light.element_sum() * elements.area[e]);
        side.1 += f64::from(elements.area[e]);
    }
    let mean = |(light, area): (f64, f64)| if area > 0.0 { light / area } else { 0.0 };
    let all = sums
        .iter()
        .flatten()
        .fold((0.0, 0.0), |a, s| (a.0 + s.0, a.1 + s.1));
    sums.iter()
        .map(|&[front, back]| mean(front) < 0.02 * mean(back).min(mean(all)))
        .collect()
}

fn object_light(receivers: ReceiverMeshes, fitted: &Fit) -> Vec<ObjectLight> {
    receivers
        .meshes
        .into_iter()
        .map(|mesh| ObjectLight {
            light: mesh
                .unknown
                .iter()
                .map(|&u| fitted.light[u as usize])
                .collect(),
            mesh: mesh.refined,
        })
        .collect()
}

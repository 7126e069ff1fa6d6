use std::time::Instant;

use glam::{DVec3, Vec3};

use super::baked::{Bake, ObjectLight};
use super::direct::direct;
use super::element::Elements;
use super::emitter::{EmitterTree, Emitters};
use super::fit::{Fit, fit};
use super::form_factor::{HitList, trace};
use super::gather::{Gather, TriangleSamples};
use super::observer::{Observer, Stage};
use super::occlusion::{NO_TRIANGLE, Occluders};
use super::parallel::Cancelled;
use super::receiver_mesh::ReceiverMeshes;
use super::report::{Counts, EnergyBalance, Report};
use super::settings::{BakeSettings, InvalidSetting};
use super::solve::{Solution, gauss_seidel};
use super::surface::Surfaces;
use super::validate::ValidScene;
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
    let occluders = Occluders::new(scene, &surfaces);
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
    let samples = Gather {
        scene,
        occluders: &occluders,
        elements: &elements,
        emitters: Emitters::at_samples(&tree, settings),
        reflected: &solution.reflected,
        lit_from_behind: &lit_from_behind,
        live: &live_by_object(scene),
        settings,
    }
    .run(&receivers, observer)?;
    clock.next(Stage::Fit, observer)?;
    let fitted = fit(&samples, receivers.unknowns, &receivers.seams);
    let stages = clock.finish(observer)?;

    let mut report = Report {
        stages,
        counts: counts(
            scene, settings, &receivers, &elements, &tree, &samples, &fitted,
        ),
        bytes: occluders.bytes()
            + elements.bytes()
            + traced.rows.bytes()
            + (samples.len() * size_of::<TriangleSamples>()) as u64,
        energy: energy(&elements, &traced.rows, &arrived, &solution),
        solver: solution.report,
        sampling_error: fitted.sampling_error,
        mean_light: fitted.mean,
        notes: scene.notes.clone(),
    };
    note_findings(&mut report, scene, &elements, &lit_from_behind, settings);
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

/// Which objects are seen from behind: double-sided ones whose front gets next to no light.
///
/// A vertex has one value, and a room modelled inside out would otherwise be black.
fn lit_from_behind(scene: &ValidScene, elements: &Elements, solution: &Solution) -> Vec<bool> {
    let mut sums = vec![[0.0_f64; 2]; scene.objects.len()];
    for (e, light) in solution.arriving.iter().enumerate() {
        let side = usize::from(elements.is_back(e));
        sums[elements.object(scene, e)][side] += f64::from(light.element_sum() * elements.area[e]);
    }
    sums.into_iter()
        .map(|[front, back]| front < 0.02 * back)
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

fn counts(
    scene: &ValidScene,
    settings: &BakeSettings,
    receivers: &ReceiverMeshes,
    elements: &Elements,
    tree: &EmitterTree,
    samples: &[TriangleSamples],
    fitted: &Fit,
) -> Counts {
    let taken: u64 = samples.iter().map(|s| u64::from(s.taken)).sum();
    let invalid = samples.iter().map(|s| u64::from(s.invalid)).sum();
    let unknowns = || receivers.meshes.iter().flat_map(|m| &m.unknown);
    let per_place =
        u64::from(settings.emitter_rays) * u64::from(tree.len() > 0) + scene.lights.len() as u64;
    Counts {
        objects: scene.objects.len() as u64,
        triangles: scene.triangles.len() as u64,
        vertices: receivers.vertex_count() as u64,
        elements: elements.len() as u64,
        emitters: elements.emissive_triangles().count() as u64,
        lights: scene.lights.len() as u64,
        rays: elements.len() as u64 * u64::from(settings.element_rays)
            + taken * u64::from(settings.gather_rays),
        shadow_rays: (elements.len() as u64 + taken) * per_place,
        samples: taken,
        invalid_samples: invalid,
        filled_vertices: unknowns().filter(|&&u| fitted.filled[u as usize]).count() as u64,
        dark_vertices: unknowns().filter(|&&u| fitted.dark[u as usize]).count() as u64,
    }
}

/// Adds up where the light went, over the elements.
fn energy(
    elements: &Elements,
    rows: &HitList,
    arrived: &[Vec3],
    solution: &Solution,
) -> EnergyBalance {
    let mut balance = EnergyBalance::default();
    for e in 0..elements.len() {
        let area = f64::from(elements.area[e]);
        let reflected = solution.reflected[e].as_dvec3();
        balance.arrived += arrived[e].as_dvec3() * area;
        balance.absorbed += (solution.arriving[e].as_dvec3() - reflected) * area;
        balance.escaped += reflected * area * (1.0 - rows.row_sum(e));
    }
    balance
}

fn note_findings(
    report: &mut Report,
    scene: &ValidScene,
    elements: &Elements,
    behind: &[bool],
    settings: &BakeSettings,
) {
    let notes = &mut report.notes;
    if elements.clamped > 0 {
        notes.push(format!(
            "{} elements reflect more than {} of the light and were clamped to it",
            elements.clamped, settings.max_reflectance
        ));
    }
    for (object, _) in scene
        .objects
        .iter()
        .zip(behind)
        .filter(|(_, behind)| **behind)
    {
        notes.push(format!(
            "object \"{}\" is double-sided and lit from behind: its vertices carry the light of the back",
            object.name
        ));
    }
    if !report.solver.converged {
        notes.push(format!(
            "the solver stopped after {} sweeps with an error of at most {:.2e}: raise max_sweeps or the tolerance",
            report.solver.sweeps, report.solver.error_bound
        ));
    }
    if report.counts.dark_vertices > 0 {
        notes.push(format!(
            "{} vertices belong to pieces of mesh that lie wholly inside other geometry and stay black",
            report.counts.dark_vertices
        ));
    }
    let unlit = report.energy.arrived == DVec3::ZERO;
    if unlit {
        notes.push("no light reaches any surface, the result is black: check where lights are, and which way one-sided emitters face".into());
    }
}

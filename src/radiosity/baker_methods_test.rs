//! Bakes that resume, with every form-factor method and solver: what is kept is kept whatever found
//! it, and what is found anew is what a bake from nothing finds.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec3, Vec4};

use super::baker::Baker;
use super::baker_test::{difference, moved, room};
use super::form_factor::Traced;
use super::{
    Bake, BakeError, BakeSettings, FormFactors, Observer, Report, Scene, Solver, Stage, Work, bake,
};

const SETTINGS: BakeSettings = BakeSettings {
    elements: 300,
    element_rays: 16,
    gather_rays: 8,
    samples_per_vertex: 2.0,
    emitter_rays: 4,
    solver_tolerance: 1e-4,
    max_sweeps: 1000,
    refine: false,
    ..BakeSettings::DRAFT
};

const FORM_FACTORS: [FormFactors; 4] = [
    FormFactors::HitList,
    FormFactors::Hemicube { resolution: 32 },
    FormFactors::Analytic { visibility_rays: 2 },
    FormFactors::AreaSampling { samples: 2 },
];

/// Each form-factor method with the default solver, and each solver with hit lists.
fn methods() -> impl Iterator<Item = BakeSettings> {
    let of_form_factors = FORM_FACTORS.map(|form_factors| BakeSettings {
        form_factors,
        ..SETTINGS
    });
    let of_solver = Solver::ALL.map(|solver| BakeSettings { solver, ..SETTINGS });
    of_form_factors.into_iter().chain(of_solver)
}

fn name(settings: &BakeSettings) -> String {
    format!("{:?}, {:?}", settings.form_factors, settings.solver)
}

/// A baker that baked the room.
fn baked(settings: &BakeSettings) -> (Baker, Bake) {
    let mut baker = Baker::new(settings.clone());
    let bake = baker.bake(room(), &()).unwrap();
    (baker, bake)
}

fn kept(baker: &Baker) -> Arc<Traced> {
    baker.stages().unwrap().traced.clone()
}

fn stages(report: &Report) -> Vec<Stage> {
    report.stages.iter().map(|s| s.0).collect()
}

fn light(bake: &Bake) -> Vec<Vec3> {
    bake.objects.iter().flat_map(|o| o.light.clone()).collect()
}

/// All form factors.
fn rows(traced: &Traced) -> Vec<(usize, u32, f32)> {
    let mut found = Vec::new();
    for e in 0..traced.rows.len() {
        traced.rows.each(e, |j, weight| found.push((e, j, weight)));
    }
    found
}

/// Holds what the baker resumed to against a bake from nothing with the same plan: form factors must
/// be the same bits, and light agree within the solver's tolerance. A bake from nothing starts its
/// solver elsewhere; the factor is that of the tests of changes one by one.
fn check(baker: &Baker, resumed: &Bake, what: &str) {
    let (scratch, stages) = baker.scratch().unwrap();
    let same = rows(&kept(baker)) == rows(&stages.traced);
    assert!(same, "{what}: form factors differ");
    assert!(resumed.report.solver.converged, "{what}");
    let apart = difference(resumed, &scratch);
    let allowed = 20.0 * baker.settings().solver_tolerance;
    assert!(apart <= allowed, "{what}: {apart} apart");
}

fn repainted(mut scene: Scene) -> Scene {
    scene.materials[1].base_color = Vec4::new(0.2, 0.3, 0.8, 1.0);
    scene.lights[0].power = Vec3::new(10.0, 300.0, 20.0);
    scene.sky = Vec3::new(3.0, 2.0, 1.0);
    scene
}

fn with_a_cube_moved(mut scene: Scene) -> Scene {
    moved(&mut scene.objects[6], Vec3::new(0.2, 0.1, 0.4));
    scene
}

#[test]
fn no_change_does_nothing() {
    for settings in methods() {
        let (mut baker, first) = baked(&settings);
        let rows = kept(&baker);
        let again = baker.bake(room(), &()).unwrap();
        assert_eq!(again.report.work, Work::default(), "{}", name(&settings));
        assert!(again.report.stages.is_empty(), "{}", name(&settings));
        assert!(light(&again) == light(&first), "{}", name(&settings));
        assert!(Arc::ptr_eq(&kept(&baker), &rows), "{}", name(&settings));
    }
}

#[test]
fn colours_trace_nothing_and_keep_the_rows() {
    for settings in methods() {
        let (mut baker, _) = baked(&settings);
        let rows = kept(&baker);
        let resumed = baker.bake(repainted(room()), &()).unwrap();
        let what = name(&settings);
        assert_eq!(resumed.report.work.rays(), 0, "{what}");
        assert!(Arc::ptr_eq(&kept(&baker), &rows), "{what}");
        let expected = [
            Stage::Mesh,
            Stage::Solve,
            Stage::Gather,
            Stage::Shadows,
            Stage::Fit,
        ];
        assert_eq!(stages(&resumed.report), expected, "{what}");
        check(&baker, &resumed, &what);
    }
}

#[test]
fn a_moved_object_gives_the_light_of_a_bake_from_nothing() {
    for settings in methods() {
        let (mut baker, first) = baked(&settings);
        let resumed = baker.bake(with_a_cube_moved(room()), &()).unwrap();
        let what = name(&settings);
        check(&baker, &resumed, &what);
        assert!(difference(&resumed, &first) > 0.01, "{what}: as before");
    }
}

#[test]
fn another_solver_only_solves_again() {
    for form_factors in FORM_FACTORS {
        let mut settings = BakeSettings {
            form_factors,
            ..SETTINGS
        };
        let (mut baker, _) = baked(&settings);
        let rows = kept(&baker);
        for solver in Solver::ALL.into_iter().skip(1) {
            settings.solver = solver;
            baker.set_settings(settings.clone());
            let resumed = baker.bake(room(), &()).unwrap();
            let what = name(&settings);
            let expected = [Stage::Solve, Stage::Gather, Stage::Shadows, Stage::Fit];
            assert_eq!(stages(&resumed.report), expected, "{what}");
            assert_eq!(resumed.report.solver.solver, solver, "{what}");
            assert_eq!(resumed.report.work.rays(), 0, "{what}");
            assert!(Arc::ptr_eq(&kept(&baker), &rows), "{what}");
            check(&baker, &resumed, &what);
        }
    }
}

#[test]
fn other_form_factors_start_anew() {
    let (mut baker, _) = baked(&SETTINGS);
    for form_factors in FORM_FACTORS.into_iter().rev() {
        let settings = BakeSettings {
            form_factors,
            ..SETTINGS
        };
        baker.set_settings(settings.clone());
        let other = baker.bake(room(), &()).unwrap();
        // Vertices are kept as given: nothing is cut or refined.
        let mut all = Stage::ALL.to_vec();
        all.retain(|s| !matches!(s, Stage::Contacts | Stage::Refine));
        assert_eq!(stages(&other.report), all, "{form_factors:?}");
        let once = bake(&room().validate().unwrap(), &settings, &()).unwrap();
        assert!(light(&other) == light(&once), "{form_factors:?}");
    }
}

/// Says stop as soon as some form factors are found.
struct StopInFormFactors(AtomicBool);

impl Observer for StopInFormFactors {
    fn progress(&self, stage: Stage, done: f32) {
        if stage == Stage::FormFactors && done > 0.0 {
            self.0.store(true, Ordering::SeqCst);
        }
    }

    fn cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

#[test]
fn cancelled_among_form_factors_everything_is_as_it_was() {
    for settings in methods() {
        let what = name(&settings);
        let (mut undisturbed, _) = baked(&settings);
        let expected = undisturbed.bake(with_a_cube_moved(room()), &()).unwrap();
        let (mut baker, first) = baked(&settings);
        let rows = kept(&baker);
        let stop = StopInFormFactors(AtomicBool::new(false));
        let cancelled = baker.bake(with_a_cube_moved(room()), &stop);
        assert!(matches!(cancelled, Err(BakeError::Cancelled)), "{what}");
        assert!(Arc::ptr_eq(&kept(&baker), &rows), "{what}");
        let still = baker.bake(room(), &()).unwrap();
        assert_eq!(still.report.work, Work::default(), "{what}");
        assert!(light(&still) == light(&first), "{what}");
        let resumed = baker.bake(with_a_cube_moved(room()), &()).unwrap();
        assert!(light(&resumed) == light(&expected), "{what}");
    }
}

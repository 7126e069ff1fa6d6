//! A baker that resumes, as those who use it see it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy_fresco::radiosity::{
    Bake, BakeError, BakeSettings, Baker, Light, LightKind, Observer, Scene, Stage, Work, bake,
};
use common::{grey, quad, room, scene, values};
use glam::Vec3;

const SETTINGS: BakeSettings = BakeSettings {
    elements: 2_000,
    max_edge: Some(0.4),
    refine: false,
    ..BakeSettings::DRAFT
};

/// A room with a luminous lamp, a point light and a shelf.
fn lit_room() -> Scene {
    let mut objects = room(Vec3::ONE, 2, [0; 6]);
    let lamp = Vec3::new(0.4, 0.98, 0.4);
    objects.push(quad("lamp", lamp, Vec3::X * 0.2, Vec3::Z * 0.2, 1, 1));
    let shelf = Vec3::new(0.2, 0.5, 0.2);
    objects.push(quad("shelf", shelf, Vec3::Z * 0.42, Vec3::X * 0.42, 1, 2));
    for (key, object) in (1..).zip(&mut objects) {
        object.key = key;
    }
    let mut shelf = grey(0.6, 0.0);
    shelf.double_sided = true;
    let mut s = scene(objects, vec![grey(0.5, 0.0), grey(0.0, 8.0), shelf]);
    s.lights.push(Light {
        power: Vec3::splat(3.0),
        kind: LightKind::Point {
            position: Vec3::new(0.7, 0.6, 0.7),
            range: f32::INFINITY,
        },
        ..Light::default()
    });
    s
}

fn light(bake: &Bake) -> Vec<Vec3> {
    bake.objects.iter().flat_map(|o| o.light.clone()).collect()
}

fn stages(bake: &Bake) -> Vec<Stage> {
    bake.report.stages.iter().map(|s| s.0).collect()
}

/// Root mean square of the difference, relative to the mean.
fn noise(a: &Bake, b: &Bake) -> f32 {
    let (a, b) = (values(a), values(b));
    assert_eq!(a.len(), b.len());
    let mean = b.iter().sum::<f32>() / b.len() as f32;
    let square: f32 = a.iter().zip(&b).map(|(p, q)| (p - q).powi(2)).sum();
    (square / b.len() as f32).sqrt() / mean
}

#[test]
fn the_first_bake_is_that_of_one_shot() {
    let once = bake(&lit_room().validate().unwrap(), &SETTINGS, &()).unwrap();
    let mut baker = Baker::new(SETTINGS);
    let first = baker.bake(lit_room(), &()).unwrap();
    assert_eq!(light(&once), light(&first));
    let mut all = Stage::ALL.to_vec();
    all.retain(|s| !matches!(s, Stage::Contacts | Stage::Refine));
    assert_eq!(stages(&first), all);
    assert!(baker.bytes() > 100_000);
    baker.forget();
    assert_eq!(baker.bytes(), 0);
}

#[test]
fn nothing_changed_is_nothing_done() {
    let mut baker = Baker::new(SETTINGS);
    let first = baker.bake(lit_room(), &()).unwrap();
    let again = baker.bake(lit_room(), &()).unwrap();
    assert_eq!(light(&first), light(&again));
    assert_eq!(again.report.work, Work::default());
    assert!(again.report.stages.is_empty());
}

#[test]
fn only_stages_that_a_change_made_stale_run() {
    let mut baker = Baker::new(SETTINGS);
    let mut s = lit_room();
    baker.bake(s.clone(), &()).unwrap();
    s.lights[0].power = Vec3::new(1.0, 2.0, 3.0);
    let colored = baker.bake(s.clone(), &()).unwrap();
    assert_eq!(
        stages(&colored),
        [Stage::Solve, Stage::Gather, Stage::Shadows, Stage::Fit]
    );
    s.materials[0].base_color.x = 0.2;
    let painted = baker.bake(s.clone(), &()).unwrap();
    let with_mesh = [
        Stage::Mesh,
        Stage::Solve,
        Stage::Gather,
        Stage::Shadows,
        Stage::Fit,
    ];
    assert_eq!(stages(&painted), with_mesh);
    s.lights[0].kind = LightKind::Point {
        position: Vec3::new(0.6, 0.6, 0.7),
        range: f32::INFINITY,
    };
    let moved = baker.bake(s, &()).unwrap();
    let with_rays = [
        Stage::Direct,
        Stage::Solve,
        Stage::Error,
        Stage::Gather,
        Stage::Shadows,
        Stage::Fit,
    ];
    assert_eq!(stages(&moved), with_rays);
    assert!(moved.report.work.light_rays > 0 && moved.report.work.element_rays == 0);
}

#[test]
fn undo_gives_the_earlier_light() {
    let mut baker = Baker::new(SETTINGS);
    let first = baker.bake(lit_room(), &()).unwrap();
    let mut s = lit_room();
    s.materials[1].emissive = Vec3::ZERO;
    s.objects[7].positions.iter_mut().for_each(|p| p.y += 0.2);
    s.objects.remove(3);
    baker.bake(s, &()).unwrap();
    let back = baker.bake(lit_room(), &()).unwrap();
    assert!(noise(&back, &first) < 0.03, "{}", noise(&back, &first));
}

/// All light off, and back on: no glow is left over from before.
#[test]
fn switches_leave_nothing_behind() {
    let mut baker = Baker::new(SETTINGS);
    let first = baker.bake(lit_room(), &()).unwrap();
    let mut s = lit_room();
    s.lights[0].power = Vec3::ZERO;
    s.materials[1].emissive = Vec3::ZERO;
    let dark = baker.bake(s, &()).unwrap();
    assert!(light(&dark).iter().all(|l| *l == Vec3::ZERO));
    assert!(dark.report.solver.converged);
    let back = baker.bake(lit_room(), &()).unwrap();
    assert!(noise(&back, &first) < 0.03, "{}", noise(&back, &first));
}

#[test]
fn settings_redo_what_they_change() {
    let mut baker = Baker::new(SETTINGS);
    baker.bake(lit_room(), &()).unwrap();
    baker.set_settings(BakeSettings {
        solver_tolerance: 1e-5,
        ..SETTINGS
    });
    let finer = baker.bake(lit_room(), &()).unwrap();
    assert_eq!(
        stages(&finer),
        [Stage::Solve, Stage::Gather, Stage::Shadows, Stage::Fit]
    );
    assert!(finer.report.work.element_rays == 0 && finer.report.work.sweeps > 0);
    let seeded = BakeSettings {
        seed: 4,
        ..SETTINGS
    };
    baker.set_settings(seeded.clone());
    let other = baker.bake(lit_room(), &()).unwrap();
    let once = bake(&lit_room().validate().unwrap(), &seeded, &()).unwrap();
    assert_eq!(light(&other), light(&once));
    baker.set_settings(BakeSettings {
        element_rays: 0,
        ..SETTINGS
    });
    let error = baker.bake(lit_room(), &());
    assert!(matches!(error, Err(BakeError::Setting(_))));
}

#[test]
fn dark_and_empty_scenes_are_no_errors() {
    let mut baker = Baker::new(SETTINGS);
    let mut s = lit_room();
    s.lights[0].power = Vec3::ZERO;
    s.materials[1].emissive = Vec3::ZERO;
    let dark = baker.bake(s, &()).unwrap();
    assert!(light(&dark).iter().all(|l| *l == Vec3::ZERO));
    let notes = &dark.report.notes;
    assert!(
        notes
            .iter()
            .any(|n| n.contains("nothing in the scene emits"))
    );
    let lit = baker.bake(lit_room(), &()).unwrap();
    let once = bake(&lit_room().validate().unwrap(), &SETTINGS, &()).unwrap();
    assert!(noise(&lit, &once) < 0.05, "{}", noise(&lit, &once));
    assert!(
        baker
            .bake(Scene::default(), &())
            .unwrap()
            .objects
            .is_empty()
    );
    let mut broken = lit_room();
    broken.objects[0].positions[0].x = f32::NAN;
    assert!(matches!(baker.bake(broken, &()), Err(BakeError::Scene(_))));
}

#[test]
fn meshes_stay_the_same_arc() {
    let mut baker = Baker::new(SETTINGS);
    let first = baker.bake(lit_room(), &()).unwrap();
    let mut s = lit_room();
    s.objects[7].positions.iter_mut().for_each(|p| p.y += 0.125);
    let moved = baker.bake(s, &()).unwrap();
    for (a, b) in first.objects.iter().zip(&moved.objects) {
        if let (Some(a), Some(b)) = (&a.mesh, &b.mesh) {
            assert!(Arc::ptr_eq(a, b));
        }
    }
    assert!(first.objects[7].mesh.is_some() && moved.objects[7].mesh.is_some());
}

#[test]
fn what_does_not_receive_gets_no_light_and_what_does_not_cast_no_shadow() {
    let mut s = lit_room();
    s.objects[7].receives = false;
    let shelf = bake(&s.clone().validate().unwrap(), &SETTINGS, &()).unwrap();
    assert!(shelf.objects[7].light.is_empty() && shelf.objects[7].mesh.is_none());
    s.objects[7].casts = false;
    let ghost = bake(&s.clone().validate().unwrap(), &SETTINGS, &()).unwrap();
    s.objects.remove(7);
    let none = bake(&s.validate().unwrap(), &SETTINGS, &()).unwrap();
    assert!(noise(&shelf, &none) > 0.05);
    assert!(noise(&ghost, &none) < 0.03, "{}", noise(&ghost, &none));
}

#[test]
fn what_does_not_reflect_is_black_and_still_emits() {
    let mut s = lit_room();
    s.materials[1].base_color = glam::Vec4::ONE;
    for object in &mut s.objects {
        object.reflects = false;
    }
    s.lights.clear();
    let black = bake(&s.validate().unwrap(), &SETTINGS, &()).unwrap();
    assert!(values(&black).iter().any(|&v| v > 0.1));
    assert_eq!(black.report.energy.escaped, glam::DVec3::ZERO);
    let energy = black.report.energy;
    assert!((energy.arrived - energy.absorbed).abs().max_element() < 1e-6 * energy.arrived.x);
}

/// Says stop in a stage, at its start or as soon as some of it is done.
struct StopIn {
    stage: Stage,
    at: f32,
    stop: AtomicBool,
}

impl Observer for StopIn {
    fn progress(&self, stage: Stage, done: f32) {
        if stage == self.stage && done >= self.at {
            self.stop.store(true, Ordering::SeqCst);
        }
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }
}

#[test]
fn a_cancelled_bake_leaves_everything_as_it_was() {
    let mut changed = lit_room();
    let shelf = &mut changed.objects[7].positions;
    shelf.iter_mut().for_each(|p| p.y += 0.2);
    changed.lights[0].power.x = 9.0;
    let mut baker = Baker::new(SETTINGS);
    baker.bake(lit_room(), &()).unwrap();
    let resumed = baker.bake(changed.clone(), &()).unwrap();
    // A bake that resumes takes no first look, and this one keeps its vertices.
    let skipped = [Stage::Contacts, Stage::FirstLook, Stage::Refine];
    for stage in Stage::ALL.into_iter().filter(|s| !skipped.contains(s)) {
        for at in [0.0, 0.01, 1.0] {
            let mut baker = Baker::new(SETTINGS);
            let first = baker.bake(lit_room(), &()).unwrap();
            let stop = AtomicBool::new(false);
            let cancelled = baker.bake(changed.clone(), &StopIn { stage, at, stop });
            assert!(matches!(cancelled, Err(BakeError::Cancelled)), "{stage:?}");
            if at == 0.0 {
                let still = baker.bake(lit_room(), &()).unwrap();
                assert_eq!(light(&first), light(&still));
                assert_eq!(still.report.work, Work::default());
            }
            let again = baker.bake(changed.clone(), &()).unwrap();
            assert_eq!(light(&again), light(&resumed), "{stage:?}");
        }
    }
}

#[test]
fn resumed_bakes_do_not_depend_on_the_number_of_threads() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut baker = Baker::new(SETTINGS);
            let mut s = lit_room();
            baker.bake(s.clone(), &()).unwrap();
            s.objects[7].positions.iter_mut().for_each(|p| p.y += 0.2);
            s.materials[1].emissive.x = 3.0;
            light(&baker.bake(s, &()).unwrap())
        })
    };
    let one = on(1);
    assert!(on(2) == one && on(5) == one);
}

/// A world that grows beyond the frame of the first bake starts afresh.
#[test]
fn scenes_that_outgrow_the_plan_are_planned_anew() {
    let mut baker = Baker::new(SETTINGS);
    baker.bake(lit_room(), &()).unwrap();
    let mut s = lit_room();
    let far = Vec3::new(-20.0, -0.1, -20.0);
    s.objects
        .push(quad("ground", far, Vec3::Z * 40.0, Vec3::X * 40.0, 4, 0));
    let grown = baker.bake(s.clone(), &()).unwrap();
    let once = bake(&s.validate().unwrap(), &SETTINGS, &()).unwrap();
    assert_eq!(light(&grown), light(&once));
}

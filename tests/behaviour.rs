//! How a bake behaves: determinism, progress, cancelling, refinement.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use bevy_fresco::radiosity::{BakeError, BakeSettings, FormFactors, Observer, Solver, Stage, bake};
use common::{grey, room, scene, values};
use glam::Vec3;

fn lit_room(n: u32) -> bevy_fresco::radiosity::ValidScene {
    scene(
        room(Vec3::ONE, n, [0, 1, 0, 0, 0, 0]),
        vec![grey(0.5, 0.0), grey(0.5, 1.0)],
    )
    .validate()
    .unwrap()
}

#[test]
#[cfg(feature = "parallel")]
fn any_number_of_threads_gives_the_same_bits() {
    let s = lit_room(6);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            values(
                &bake(
                    &s,
                    &BakeSettings {
                        refine: false,
                        ..BakeSettings::DRAFT
                    },
                    &(),
                )
                .unwrap(),
            )
        })
    };
    let one = on(1);
    for threads in [1, 2, 8] {
        assert_eq!(on(threads), one, "{threads} threads");
    }
}

/// Each form-factor method with the default solver, and each solver with form factors that take
/// another way to the matrix than the default's.
#[test]
#[cfg(feature = "parallel")]
fn any_number_of_threads_gives_the_same_bits_by_every_method() {
    let mut open = room(Vec3::ONE, 4, [0, 1, 0, 0, 0, 0]);
    open.pop();
    let mut s = scene(open, vec![grey(0.7, 0.0), grey(0.5, 1.0)]);
    s.sky = Vec3::new(0.1, 0.2, 0.3);
    let s = s.validate().unwrap();
    let hemicube = FormFactors::Hemicube { resolution: 32 };
    let form_factors = [
        FormFactors::HitList,
        hemicube,
        FormFactors::Analytic { visibility_rays: 2 },
        FormFactors::AreaSampling { samples: 2 },
    ];
    let solvers = [
        Solver::GaussSeidel,
        Solver::Jacobi,
        Solver::Sor { omega: 1.2 },
        Solver::ProgressiveRefinement,
        Solver::ConjugateGradients,
    ];
    let of_form_factors = form_factors.map(|f| (f, Solver::GaussSeidelMeanField));
    let of_solvers = solvers.map(|solver| (hemicube, solver));
    for (form_factors, solver) in of_form_factors.into_iter().chain(of_solvers) {
        let settings = BakeSettings {
            elements: 300,
            form_factors,
            solver,
            refine: false,
            ..BakeSettings::DRAFT
        };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| {
                let bake = bake(&s, &settings, &()).unwrap();
                let light: Vec<Vec3> = bake.objects.into_iter().flat_map(|o| o.light).collect();
                (light, bake.report.sampling_error, bake.report.solver)
            })
        };
        let one = on(1);
        assert!(one.0.iter().any(|l| l.x > 0.0));
        for threads in [2, 5] {
            assert!(
                on(threads) == one,
                "{form_factors:?}, {solver:?}: {threads} threads"
            );
        }
    }
}

#[test]
fn seeds_change_the_noise_and_little_else() {
    let s = lit_room(6);
    let with = |seed| {
        values(
            &bake(
                &s,
                &BakeSettings {
                    seed,
                    refine: false,
                    ..BakeSettings::DRAFT
                },
                &(),
            )
            .unwrap(),
        )
    };
    let (a, b) = (with(0), with(1));
    assert_ne!(a, b);
    let mean = |v: &[f32]| v.iter().sum::<f32>() / v.len() as f32;
    assert!((mean(&a) / mean(&b) - 1.0).abs() < 0.02);
}

#[test]
fn the_sampling_error_is_about_the_difference_of_two_seeds() {
    let s = lit_room(10);
    let with = |seed| {
        bake(
            &s,
            &BakeSettings {
                seed,
                refine: false,
                ..BakeSettings::DRAFT
            },
            &(),
        )
        .unwrap()
    };
    let (a, b) = (with(0), with(1));
    let (x, y) = (values(&a), values(&b));
    let mean = x.iter().sum::<f32>() / x.len() as f32;
    let rms = (x.iter().zip(&y).map(|(p, q)| (p - q).powi(2)).sum::<f32>() / x.len() as f32).sqrt();
    // The difference of two results has √2 times the error of one.
    let error = rms / mean / std::f32::consts::SQRT_2;
    let ratio = a.report.sampling_error / error;
    assert!(
        (0.5..2.5).contains(&ratio),
        "estimated {}, found {error}",
        a.report.sampling_error
    );
}

struct Watcher {
    seen: Mutex<Vec<(Stage, f32)>>,
}

impl Observer for Watcher {
    fn progress(&self, stage: Stage, done: f32) {
        self.seen.lock().unwrap().push((stage, done));
    }
}

#[test]
fn progress_starts_and_ends_every_stage_in_order() {
    let watcher = Watcher {
        seen: Mutex::new(Vec::new()),
    };
    let result = bake(&lit_room(6), &BakeSettings::DRAFT, &watcher).unwrap();
    let seen = watcher.seen.into_inner().unwrap();
    for stage in Stage::ALL {
        let mine: Vec<f32> = seen
            .iter()
            .filter(|(s, _)| *s == stage)
            .map(|(_, d)| *d)
            .collect();
        assert_eq!(mine.first(), Some(&0.0), "{stage:?}");
        assert_eq!(mine.last(), Some(&1.0), "{stage:?}");
        assert!(mine.iter().all(|d| (0.0..=1.0).contains(d)));
    }
    assert_eq!(
        result.report.stages.iter().map(|s| s.0).collect::<Vec<_>>(),
        Stage::ALL
    );
}

/// Says stop some time into a stage.
struct Canceller {
    at: Stage,
    stop: AtomicBool,
    since: Mutex<Option<Instant>>,
    asked: AtomicU32,
}

impl Observer for Canceller {
    fn progress(&self, stage: Stage, done: f32) {
        if stage == self.at && done > 0.0 && !self.stop.swap(true, Ordering::SeqCst) {
            *self.since.lock().unwrap() = Some(Instant::now());
        }
    }

    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed);
        self.stop.load(Ordering::SeqCst)
    }
}

#[test]
fn cancelling_works_in_every_stage() {
    let s = lit_room(30);
    for at in Stage::ALL {
        let canceller = Canceller {
            at,
            stop: AtomicBool::new(false),
            since: Mutex::new(None),
            asked: AtomicU32::new(0),
        };
        let result = bake(&s, &BakeSettings::DRAFT, &canceller);
        assert!(matches!(result, Err(BakeError::Cancelled)), "{at:?}");
        // Far above the 100 ms it takes, so that a busy machine cannot fail this.
        let waited = canceller.since.into_inner().unwrap().unwrap().elapsed();
        assert!(waited < Duration::from_secs(2), "{at:?}: {waited:?}");
    }
}

#[test]
fn max_edge_gives_meshes_that_carry_light() {
    let s = lit_room(1);
    let settings = BakeSettings {
        max_edge: Some(0.2),
        refine: false,
        ..BakeSettings::DRAFT
    };
    let coarse = bake(
        &s,
        &BakeSettings {
            refine: false,
            ..BakeSettings::DRAFT
        },
        &(),
    )
    .unwrap();
    assert!(
        coarse
            .objects
            .iter()
            .all(|o| o.mesh.is_none() && o.light.len() == 4)
    );
    let fine = bake(&s, &settings, &()).unwrap();
    for object in &fine.objects {
        let mesh = object.mesh.as_ref().unwrap();
        assert_eq!(mesh.vertices.len(), object.light.len());
        assert!(mesh.vertices.len() > 36);
    }
}

/// Vertices of one place and one normal carry the same light, across objects; at a crease not.
#[test]
fn seams_are_welded_and_creases_are_not() {
    use common::quad;
    let left = quad("left", Vec3::ZERO, Vec3::Z, Vec3::X, 4, 0);
    let right = quad("right", Vec3::X, Vec3::Z, Vec3::X, 4, 0);
    let wall = quad("wall", Vec3::X * 2.0, Vec3::Z, Vec3::Y, 4, 0);
    let lamp = quad(
        "lamp",
        Vec3::new(1.5, 1.0, 0.2),
        Vec3::X * 0.3,
        Vec3::Z * 0.3,
        1,
        1,
    );
    let shapes = [left.clone(), right.clone(), wall.clone()];
    let s = scene(
        vec![left, right, wall, lamp],
        vec![grey(0.5, 0.0), grey(0.0, 10.0)],
    );
    let bake = bake(
        &s.validate().unwrap(),
        &BakeSettings {
            refine: false,
            ..BakeSettings::BALANCED
        },
        &(),
    )
    .unwrap();
    let light_at = |o: usize, p: Vec3| {
        let i = shapes[o].positions.iter().position(|q| *q == p).unwrap();
        bake.objects[o].light[i]
    };
    for z in 0..=4 {
        let z = Vec3::Z * (z as f32 / 4.0);
        assert_eq!(light_at(0, Vec3::X + z), light_at(1, Vec3::X + z));
        assert_ne!(
            light_at(1, Vec3::X * 2.0 + z),
            light_at(2, Vec3::X * 2.0 + z)
        );
    }
}

/// Objects without normals are flat-shaded: the corners of a cube get a value for each face.
#[test]
fn meshes_without_normals_are_flat() {
    let mut objects = room(Vec3::ONE, 1, [0, 1, 0, 0, 0, 0]);
    let mut cube = bevy_fresco::radiosity::Object {
        name: "cube".into(),
        ..Default::default()
    };
    for i in 0..8_u32 {
        let corner = Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        cube.positions.push(Vec3::splat(0.3) + corner * 0.3);
    }
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        cube.triangles.push([a, b, c]);
        cube.triangles.push([a, c, d]);
    }
    objects.push(cube);
    let s = scene(objects, vec![grey(0.5, 0.0), grey(0.5, 1.0)]);
    let bake = bake(
        &s.validate().unwrap(),
        &BakeSettings {
            refine: false,
            ..BakeSettings::DRAFT
        },
        &(),
    )
    .unwrap();
    assert_eq!(bake.objects[6].mesh.as_ref().unwrap().vertices.len(), 24);
    assert!(bake.objects[6].light.iter().all(|l| l.x > 0.0));
}

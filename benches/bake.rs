//! Where a bake spends its time.
//!
//! Each figure is the time of one stage as the bake itself reports it, so that a benchmark times
//! what users get. Run with `cargo bench --no-default-features --features gltf,parallel`.

#[path = "../tests/common/mod.rs"]
mod common;

use std::path::Path;
use std::time::Duration;

use bevy_fresco::gltf::load;
use bevy_fresco::radiosity::{Bake, BakeSettings, MaterialId, Object, Stage, ValidScene, bake};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;

/// The project's Cornell box: 7,072 triangles.
fn cornell() -> bevy_fresco::radiosity::Scene {
    load(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/scenes/cornell_box.glb"
    )))
    .expect("the scene is part of the project")
    .scene
}

/// The Cornell box with a rough ball of 32,768 triangles on its short block.
fn cluttered() -> ValidScene {
    let mut scene = cornell();
    scene.objects.push(rough_ball(64, MaterialId(0)));
    scene.validate().expect("a sound scene")
}

fn rough_ball(n: u32, material: MaterialId) -> Object {
    let mut ball = common::inward_sphere(n, 0);
    ball.name = "ball".into();
    ball.material = material;
    for t in &mut ball.triangles {
        t.swap(1, 2);
    }
    for (p, normal) in ball.positions.iter_mut().zip(&mut ball.normals) {
        let bumps = (p.x * 19.0).sin() * (p.y * 23.0).sin() * (p.z * 17.0).sin();
        *normal = *p;
        *p = Vec3::new(1.86, 2.4, 1.69) + *p * (0.7 + 0.08 * bumps);
    }
    ball
}

fn run(scene: &ValidScene, settings: &BakeSettings) -> Bake {
    bake(scene, settings, &()).expect("a sound scene bakes")
}

fn stage(bake: &Bake, stage: Stage) -> Duration {
    bake.report
        .stages
        .iter()
        .find(|s| s.0 == stage)
        .map_or(Duration::ZERO, |s| s.1)
}

/// Benchmarks one stage of a bake, optionally as a rate.
fn bench_stage(
    c: &mut Criterion,
    name: &str,
    scene: &ValidScene,
    settings: &BakeSettings,
    what: Stage,
    rate: impl Fn(&Bake) -> u64,
) {
    let mut group = c.benchmark_group(name);
    group.sample_size(10);
    group.throughput(Throughput::Elements(rate(&run(scene, settings))));
    group.bench_function(what.name(), |b| {
        b.iter_custom(|times| (0..times).map(|_| stage(&run(scene, settings), what)).sum());
    });
    group.finish();
}

/// Rays of the form-factor stage: closest hits of incoherent cosine-distributed rays.
fn rays(c: &mut Criterion) {
    let settings = BakeSettings {
        elements: 10_000,
        element_rays: 64,
        refine: false,
        ..BakeSettings::DRAFT
    };
    let element_rays = |b: &Bake| b.report.counts.elements * 64;
    let cornell = cornell().validate().expect("a sound scene");
    bench_stage(
        c,
        "rays, Cornell box",
        &cornell,
        &settings,
        Stage::FormFactors,
        element_rays,
    );
    bench_stage(
        c,
        "rays, 40k triangles",
        &cluttered(),
        &settings,
        Stage::FormFactors,
        element_rays,
    );
}

/// Sweeps of the solver at 10,000 elements of 256 rays, each with its residual.
fn sweeps(c: &mut Criterion) {
    let settings = BakeSettings {
        elements: 10_000,
        element_rays: 256,
        solver_tolerance: 1e-5,
        gather_rays: 1,
        samples_per_vertex: 1.0,
        refine: false,
        ..BakeSettings::DRAFT
    };
    let scene = cornell().validate().expect("a sound scene");
    bench_stage(
        c,
        "sweeps, 10k elements x 256 rays",
        &scene,
        &settings,
        Stage::Solve,
        |b| u64::from(b.report.solver.sweeps),
    );
}

/// Whole bakes by number of elements.
fn whole(c: &mut Criterion) {
    let scene = cornell().validate().expect("a sound scene");
    let mut group = c.benchmark_group("whole bake, Cornell box");
    group.sample_size(10);
    for elements in [1_000, 10_000] {
        let settings = BakeSettings {
            elements,
            refine: false,
            ..BakeSettings::BALANCED
        };
        group.bench_function(format!("{elements} elements"), |b| {
            b.iter(|| run(&scene, &settings));
        });
    }
    group.finish();
}

criterion_group!(benches, rays, sweeps, whole);
criterion_main!(benches);

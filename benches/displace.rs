//! What displacement takes: evenly at several resolutions, and adaptively at equal error.
//!
//! Run with `cargo bench --no-default-features --features parallel --bench displace`. Times divided by
//! triangles tell whether they grow with the result.

use std::f32::consts::TAU;

use bevy_fresco::displacement::{
    Base, Displaced, DisplacementSettings, Spacing, Tessellation, displace,
};
use bevy_fresco::height_map::{HeightMap, Wrap};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec2, Vec3};

const CORNERS: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
const UVS: [Vec2; 4] = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO];
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// A square of two triangles.
fn square() -> Base<'static> {
    Base {
        positions: &CORNERS,
        normals: &[Vec3::Z; 4],
        uvs: &UVS,
        triangles: &TRIANGLES,
    }
}

fn map(side: u32, height: impl Fn(Vec2) -> f32) -> HeightMap {
    let at = |i: u32| (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
    let heights = (0..side * side).map(|i| height(at(i)));
    HeightMap::new([side; 2], heights.collect(), [Wrap::Repeat; 2]).expect("finite heights")
}

/// Relief all over.
fn waves(at: Vec2) -> f32 {
    0.5 + 0.25 * (TAU * 9.0 * at.x).sin() + 0.25 * (TAU * (4.0 * at.x + 7.0 * at.y)).cos()
}

/// A hill on a twentieth of the map, the rest flat.
fn hill(at: Vec2) -> f32 {
    let r = at.distance(Vec2::new(0.6, 0.35)) / 0.126;
    match r < 1.0 {
        true => (1.0 - r * r).powi(2) * (0.6 + 0.4 * (40.0 * at.x).sin() * (40.0 * at.y).cos()),
        false => 0.0,
    }
}

fn run(map: &HeightMap, tessellation: Tessellation) -> Displaced {
    let settings = DisplacementSettings {
        tessellation,
        ..DisplacementSettings::default()
    };
    displace(&[square()], map, &settings, &()).expect("a sound mesh")
}

fn bench(c: &mut Criterion, name: &str, map: &HeightMap, tessellation: Tessellation) {
    let mut group = c.benchmark_group("displace");
    group.sample_size(10);
    group.throughput(Throughput::Elements(
        run(map, tessellation).report.triangles,
    ));
    group.bench_function(name, |b| b.iter(|| run(map, tessellation)));
    group.finish();
}

/// Up to 2.1 million triangles.
fn uniform(c: &mut Criterion) {
    for side in [256, 512, 1024] {
        let texels = Tessellation::Uniform(Spacing::Texels(1.0));
        bench(c, &format!("uniform_{side}"), &map(side, waves), texels);
    }
}

/// A thousandth and a ten-thousandth of a metre.
fn adaptive(c: &mut Criterion) {
    for (name, map) in [("waves", map(1024, waves)), ("hill", map(1024, hill))] {
        for tolerance in [1e-3, 1e-4] {
            let adaptive = Tessellation::Adaptive { tolerance };
            bench(c, &format!("{name}_to_{tolerance}"), &map, adaptive);
        }
    }
}

criterion_group!(benches, uniform, adaptive);
criterion_main!(benches);

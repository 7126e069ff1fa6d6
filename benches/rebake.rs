//! What a change costs beside a whole bake.
//!
//! A room of some 10,000 elements with 256 rays each, blocks in it, a small lamp, a point light and the
//! sun through an open side. Every change is timed several times between whole bakes of the same
//! run, so that shares hold on a busy machine too. Run with
//! `cargo bench --no-default-features --features gltf,parallel --bench rebake`.

#![allow(clippy::print_stdout, reason = "a table is what this is for")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy_fresco::radiosity::{
    BakeSettings, Baker, Light, LightKind, Object, Observer, Report, Scene, Stage,
};
use common::{grey, quad, room};
use glam::Vec3;

const SETTINGS: BakeSettings = BakeSettings {
    elements: 11_500,
    element_rays: 256,
    refine: false,
    ..BakeSettings::BALANCED
};

/// Times that each change is made.
const ROUNDS: usize = 5;

/// A block of six faces with a vertex grid on each.
fn block(key: u64, low: Vec3, size: Vec3) -> Object {
    let mut block = Object {
        name: format!("block {key}"),
        ..Object::default()
    };
    for mut face in room(size, 6, [0; 6]) {
        let first = block.positions.len() as u32;
        block
            .positions
            .extend(face.positions.iter().map(|p| low + *p));
        block.normals.extend(face.normals.iter().map(|n| -*n));
        for t in &mut face.triangles {
            block.triangles.push([t[0], t[2], t[1]].map(|v| first + v));
        }
    }
    block.key = key;
    block
}

fn scene() -> Scene {
    let mut objects = room(Vec3::new(8.0, 3.0, 6.0), 24, [0; 6]);
    objects.remove(2);
    for (i, object) in objects.iter_mut().enumerate() {
        object.key = i as u64;
    }
    for i in 0..6_u8 {
        let (x, z) = (f32::from(i % 3), f32::from(i / 3));
        let low = Vec3::new(1.2 + 2.2 * x, 0.0, 1.0 + 2.6 * z);
        let size = Vec3::new(0.8, 0.5 + 0.25 * x, 0.9);
        objects.push(block(10 + u64::from(i), low, size));
    }
    let lamp = [Vec3::new(4.0, 2.8, 3.0), Vec3::X * 0.3, Vec3::Z * 0.3];
    objects.push(quad("lamp", lamp[0], lamp[1], lamp[2], 1, 1));
    objects.push(Object {
        key: 20,
        material: bevy_fresco::radiosity::MaterialId(2),
        ..block(20, Vec3::new(3.0, 0.0, 2.4), Vec3::new(0.5, 0.5, 0.5))
    });
    let light = |key, power, kind| Light {
        power: Vec3::splat(power),
        kind,
        key,
        ..Light::default()
    };
    Scene {
        objects,
        materials: vec![grey(0.7, 0.0), grey(0.0, 400.0), grey(0.5, 0.0)],
        lights: vec![
            light(
                0,
                800.0,
                LightKind::Point {
                    position: Vec3::new(6.5, 2.0, 1.5),
                    range: 30.0,
                },
            ),
            light(
                1,
                60.0,
                LightKind::Directional {
                    direction: Vec3::new(1.0, -0.6, 0.2),
                },
            ),
        ],
        ..Scene::default()
    }
}

type Edit = fn(&mut Scene, f32);

const EDITS: [(&str, Edit); 7] = [
    ("null", |_, _| ()),
    ("light colour", |s, x| {
        s.lights[0].power.x = 500.0 + 100.0 * x;
    }),
    ("reflectance", |s, x| {
        s.materials[2].base_color.x = 0.2 + 0.1 * x;
    }),
    ("light moved", |s, x| {
        s.lights[0].kind = LightKind::Point {
            position: Vec3::new(6.5, 2.0, 1.5 + 0.3 * x),
            range: 30.0,
        };
    }),
    ("sun turned", |s, x| {
        s.lights[1].kind = LightKind::Directional {
            direction: Vec3::new(1.0, -0.6, 0.2 - 0.05 * x),
        };
    }),
    ("object moved", |s, _| {
        let i = s.objects.len() - 1;
        s.objects[i].positions.iter_mut().for_each(|p| p.z += 0.1);
    }),
    ("lamp moved", |s, _| {
        let i = s.objects.len() - 2;
        s.objects[i].positions.iter_mut().for_each(|p| p.x += 0.1);
    }),
];

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[times.len() / 2]
}

fn timed(baker: &mut Baker, scene: &Scene) -> (Duration, Report) {
    let scene = scene.clone();
    let started = Instant::now();
    let bake = baker.bake(scene, &()).expect("a sound scene bakes");
    (started.elapsed(), bake.report)
}

fn stages(report: &Report) -> String {
    let each = report.stages.iter();
    each.map(|(stage, time)| format!("{} {:.1}", stage.name(), time.as_secs_f64() * 1e3))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Cancels so long after the start.
struct Stop {
    started: Instant,
    after: Duration,
    stopped: AtomicBool,
    since: Mutex<Option<Instant>>,
}

impl Observer for Stop {
    fn progress(&self, _: Stage, _: f32) {}

    fn cancelled(&self) -> bool {
        self.started.elapsed() >= self.after
            && (self.stopped.swap(true, Ordering::SeqCst) || {
                if let Ok(mut since) = self.since.lock() {
                    *since = Some(self.started + self.after);
                }
                true
            })
    }
}

/// The longest wait for a bake of a time of `whole` to stop.
fn cancel_latency(baker: &mut Baker, scene: &Scene, whole: Duration) -> Duration {
    let mut worst = Duration::ZERO;
    for i in 0..20 {
        let stop = Stop {
            started: Instant::now(),
            after: whole * i / 20,
            stopped: AtomicBool::new(false),
            since: Mutex::new(None),
        };
        if baker.bake(scene.clone(), &stop).is_err() {
            worst = worst.max(stop.started.elapsed().saturating_sub(stop.after));
        }
    }
    worst
}

fn main() {
    let mut scene = scene();
    let mut baker = Baker::new(SETTINGS);
    let mut whole = Vec::new();
    let mut times = vec![Vec::new(); EDITS.len()];
    let mut reports = vec![Report::default(); EDITS.len()];
    let mut first = Report::default();
    for round in 0..ROUNDS {
        baker.forget();
        let (time, report) = timed(&mut baker, &scene);
        whole.push(time);
        first = report;
        for (i, (_, edit)) in EDITS.iter().enumerate() {
            edit(&mut scene, round as f32);
            let (time, report) = timed(&mut baker, &scene);
            times[i].push(time);
            reports[i] = report;
        }
    }
    let counts = first.counts;
    println!(
        "{} elements, {} vertices, {} triangles, {} samples; {:.1} MiB kept",
        counts.elements,
        counts.vertices,
        counts.triangles,
        counts.samples,
        baker.bytes() as f64 / f64::from(1 << 20)
    );
    let whole = median(whole);
    println!(
        "whole bake    {:8.1} ms  ({})",
        whole.as_secs_f64() * 1e3,
        stages(&first)
    );
    for ((name, _), (times, report)) in EDITS.iter().zip(times.into_iter().zip(&reports)) {
        let time = median(times);
        let share = 100.0 * time.as_secs_f64() / whole.as_secs_f64();
        println!(
            "{name:13} {:8.1} ms {share:6.1} %  ({})\n    {:?}",
            time.as_secs_f64() * 1e3,
            stages(report),
            report.work
        );
    }
    let last = scene.objects.len() - 1;
    let latency = cancel_latency(&mut Baker::new(SETTINGS), &scene, whole);
    scene.objects[last]
        .positions
        .iter_mut()
        .for_each(|p| p.y += 0.2);
    let again = cancel_latency(&mut baker, &scene, whole / 3);
    println!("cancelled: whole bake {latency:.1?}, object moved {again:.1?} at worst");
}

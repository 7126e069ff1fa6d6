//! Light that is baked again while things change: a lamp swings, a wall is painted, a block slides. The panel tells
//! what each bake did and how long it took: paint takes no ray, the lamp its shadows, the block a part of all.
//!
//! L, P and B stop and start the lamp, the paint and the block; F1 hides the panel. `--screenshot FILE` saves a
//! picture without a window, of the room at rest. `--soak SECONDS` changes all of it at random without a window and
//! then tells how much memory and main thread that took, and whether the light is right.

#![expect(clippy::print_stdout, reason = "it says what it measured")]

mod common;

use std::time::{Duration, Instant};

use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use bevy_fresco::panel::FrescoPanelPlugin;
use bevy_fresco::plugin::FrescoPlugins;
use bevy_fresco::plugin::radiosity::{
    LightBaking, RadiosityDiagnostics, RadiositySettings, RadiosityStatus, Rebake, StaticLighting,
};
use bevy_fresco::radiosity::BakeSettings;

/// Metres of the room from wall to wall.
const ROOM: f32 = 4.0;
const PAINTS: [Color; 3] = [
    Color::srgb(0.75, 0.12, 0.1),
    Color::srgb(0.12, 0.3, 0.75),
    Color::srgb(0.8, 0.65, 0.15),
];

/// What moves.
#[derive(Resource)]
struct Moving {
    lamp: bool,
    paint: bool,
    block: bool,
}

#[derive(Component)]
struct Lamp;

#[derive(Component)]
struct Block;

/// The paint of the wall on the left.
#[derive(Resource)]
struct Paint(Handle<StandardMaterial>);

fn main() -> AppExit {
    let soak = common::argument("--soak").map(|text| {
        let seconds = text.parse().ok().filter(|s: &f32| *s > 0.0);
        Duration::from_secs_f32(seconds.expect("--soak needs seconds: --soak 600"))
    });
    let at_rest = common::argument("--screenshot").is_some() || soak.is_some();
    let mut app = App::new();
    app.add_plugins((
        match soak {
            Some(_) => common::without_window(),
            None => common::default_plugins("Rebake on change"),
        },
        FrescoPlugins,
        FrescoPanelPlugin,
    ))
    .insert_resource(RadiositySettings {
        bake: BakeSettings::DRAFT,
        ..default()
    })
    .insert_resource(GlobalAmbientLight::NONE)
    .insert_resource(Moving {
        lamp: !at_rest,
        paint: !at_rest,
        block: !at_rest,
    })
    .add_systems(Startup, setup)
    .add_systems(Update, (keys, swing, paint, slide));
    if let Some(duration) = soak {
        app.insert_resource(Soak::new(duration))
            .add_systems(Update, (edit, watch).chain());
    }
    app.run()
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut matt = |color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })
    };
    let white = matt(Color::srgb(0.8, 0.8, 0.8));
    let paint = matt(PAINTS[0]);
    commands.insert_resource(Paint(paint.clone()));
    let half = 0.5 * ROOM;
    let wall = meshes.add(Plane3d::default().mesh().size(ROOM, ROOM));
    // The front is open.
    for (name, up, material) in [
        ("Floor", Vec3::Y, &white),
        ("Ceiling", Vec3::NEG_Y, &white),
        ("Back", Vec3::Z, &white),
        ("Painted wall", Vec3::X, &paint),
        ("Right wall", Vec3::NEG_X, &white),
    ] {
        commands.spawn((
            Name::new(name),
            Mesh3d(wall.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(-half * up)
                .with_rotation(Quat::from_rotation_arc(Vec3::Y, up)),
            StaticLighting::default(),
        ));
    }
    commands.spawn((
        Block,
        Name::new("Block"),
        Mesh3d(meshes.add(Cuboid::new(1.0, 1.4, 1.0))),
        MeshMaterial3d(white),
        Transform::from_xyz(0.6, 0.7 - half, -0.4),
        StaticLighting::default(),
    ));
    commands.spawn((
        Lamp,
        Name::new("Lamp"),
        PointLight {
            intensity: 60_000.0,
            color: Color::srgb(1.0, 0.93, 0.82),
            ..default()
        },
        LightBaking::Full,
        Transform::from_xyz(0.0, 1.2, 0.3),
    ));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 0.0, 6.4).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn keys(keys: Res<ButtonInput<KeyCode>>, mut moving: ResMut<Moving>) {
    let Moving { lamp, paint, block } = &mut *moving;
    for (key, moves) in [
        (KeyCode::KeyL, lamp),
        (KeyCode::KeyP, paint),
        (KeyCode::KeyB, block),
    ] {
        if keys.just_pressed(key) {
            *moves = !*moves;
        }
    }
}

fn swing(time: Res<Time>, moving: Res<Moving>, mut lamps: Query<&mut Transform, With<Lamp>>) {
    if moving.lamp {
        for mut lamp in &mut lamps {
            lamp.translation.x = 1.2 * (0.7 * time.elapsed_secs()).sin();
        }
    }
}

fn paint(
    time: Res<Time>,
    moving: Res<Moving>,
    paint: Res<Paint>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut shown: Local<usize>,
) {
    // Another every three seconds.
    let now = (time.elapsed_secs() / 3.0) as usize % PAINTS.len();
    if moving.paint
        && now != *shown
        && let Some(mut material) = materials.get_mut(&paint.0)
    {
        material.base_color = PAINTS[now];
        *shown = now;
    }
}

fn slide(time: Res<Time>, moving: Res<Moving>, mut blocks: Query<&mut Transform, With<Block>>) {
    if moving.block {
        for mut block in &mut blocks {
            block.translation.x = (0.4 * time.elapsed_secs()).cos();
        }
    }
}

/// Changes at random, and what they cost.
#[derive(Resource)]
struct Soak {
    since: Instant,
    duration: Duration,
    /// State of the random numbers.
    random: u32,
    next_edit: Instant,
    edits: u32,
    /// Milliseconds a frame that baked light took of the main thread, at most.
    longest: f64,
    /// Bytes of the whole program when a tenth of the time was over.
    early_memory: Option<u64>,
    /// Mean light and vertices as they were when all was at rest, and how many bakes there were, while light is baked
    /// from scratch.
    last: Option<((f32, u64), u64)>,
}

impl Soak {
    fn new(duration: Duration) -> Self {
        let now = Instant::now();
        Self {
            since: now,
            duration,
            random: 1,
            next_edit: now,
            edits: 0,
            longest: 0.0,
            early_memory: None,
            last: None,
        }
    }

    /// From 0 to 1 (a linear congruential generator, Numerical Recipes' constants).
    fn number(&mut self) -> f32 {
        self.random = self
            .random
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        (self.random >> 8) as f32 / (1 << 24) as f32
    }
}

fn edit(
    mut soak: ResMut<Soak>,
    mut lamps: Query<(&mut Transform, &mut PointLight), (With<Lamp>, Without<Block>)>,
    mut blocks: Query<&mut Transform, With<Block>>,
    paint: Res<Paint>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if soak.since.elapsed() > soak.duration || Instant::now() < soak.next_edit {
        return;
    }
    let numbers = [(); 4].map(|()| soak.number());
    let [kind, a, b, wait] = numbers;
    soak.edits += 1;
    soak.next_edit = Instant::now() + Duration::from_secs_f32(wait);
    match (kind * 4.0) as u32 {
        0 => {
            for (mut lamp, _) in &mut lamps {
                lamp.translation = Vec3::new(3.0 * a - 1.5, 1.2, 2.0 * b - 1.0);
            }
        }
        1 => {
            for (_, mut lamp) in &mut lamps {
                lamp.intensity = 20_000.0 + 80_000.0 * a;
            }
        }
        2 => {
            for mut block in &mut blocks {
                block.translation.x = 2.4 * a - 1.2;
                block.translation.z = 2.4 * b - 1.2;
            }
        }
        _ => {
            if let Some(mut material) = materials.get_mut(&paint.0) {
                material.base_color = Color::srgb(a, b, 0.3);
            }
        }
    }
}

/// Measures, and tells when the time is over.
fn watch(
    mut soak: ResMut<Soak>,
    mut commands: Commands,
    diagnostics: Res<DiagnosticsStore>,
    status: Res<RadiosityStatus>,
    mut exit: MessageWriter<AppExit>,
) {
    let spent = diagnostics
        .get(&RadiosityDiagnostics::MAIN_THREAD)
        .and_then(bevy::diagnostic::Diagnostic::value);
    soak.longest = soak.longest.max(spent.unwrap_or(0.0));
    let over = soak.since.elapsed();
    if soak.early_memory.is_none() && over > soak.duration / 10 {
        soak.early_memory = memory();
    }
    if over < soak.duration || !status.is_up_to_date() {
        return;
    }
    // Over all surfaces: vertices lie elsewhere in a bake from scratch.
    let Some(report) = status.report.as_deref() else {
        return;
    };
    let now = (report.mean_light, report.counts.vertices);
    let Some((then, finished)) = soak.last else {
        soak.last = Some((now, status.finished));
        commands.trigger(Rebake { from_scratch: true });
        return;
    };
    if status.finished == finished {
        return;
    }
    println!(
        "{} changes, {finished} bakes in {:.0} s",
        soak.edits,
        soak.duration.as_secs_f32()
    );
    println!(
        "baked light took {:.1} ms of a frame's main thread at most",
        soak.longest
    );
    if let (Some(early), Some(late)) = (soak.early_memory, memory()) {
        let [early, late] = [early, late].map(|bytes| bytes as f64 / 1e6);
        println!("memory {early:.0} MB after a tenth of the time, {late:.0} MB at the end");
    }
    println!(
        "mean light {:.3} cd/m² in {} vertices; baked from scratch {:.3} in {}",
        then.0, then.1, now.0, now.1
    );
    exit.write(AppExit::Success);
}

/// Bytes that the program has in memory, where the system tells.
fn memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kilobytes)
}

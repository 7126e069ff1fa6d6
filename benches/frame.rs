//! What baked light costs the main thread a frame, in an app without a renderer and with 10,000 lit
//! vertices.
//!
//! ```text
//! cargo bench --all-features --profile test --bench frame
//! ```
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a benchmark prints, and may stop"
)]

use std::time::Duration;

use bevy::diagnostic::{Diagnostic, DiagnosticsPlugin, DiagnosticsStore};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_fresco::plugin::FrescoPlugins;
use bevy_fresco::plugin::radiosity::{
    RadiosityDiagnostics, RadiositySettings, RadiosityStatus, StaticLighting,
};
use bevy_fresco::radiosity::BakeSettings;

/// Blocks on a floor, `SIDE × SIDE` of them.
const SIDE: u32 = 10;

fn main() {
    let without = Frames::of(&mut app(false), 400, |_, _| {});
    let mut lit = app(true);
    let first = Frames::until_lit(&mut lit);
    let idle = Frames::of(&mut lit, 400, |_, _| {});
    let sun = lit
        .world_mut()
        .query_filtered::<Entity, With<PointLight>>()
        .single(lit.world())
        .unwrap();
    let moving = Frames::of(&mut lit, 400, |app, frame| {
        let mut light = app.world_mut().get_mut::<PointLight>(sun).unwrap();
        light.intensity = 1e5 * (1.0 + 0.5 * (frame as f32 * 0.05).sin());
    });
    let report = lit.world().resource::<RadiosityStatus>();
    let vertices = report.report.as_ref().unwrap().counts.vertices;
    println!("{vertices} lit vertices, {} meshes", SIDE * SIDE + 1);
    println!("{} bakes while the lamp changed", report.finished - 1);
    println!("memory kept: {:.1} MB", report.bytes as f64 / 1e6);
    println!("ms a frame                median     99 %     most");
    without.print("without static meshes");
    first.print("while first baking");
    idle.print("nothing changes");
    moving.print("lamp changes each frame");
}

fn app(lit: bool) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins
            .build()
            .disable::<bevy::app::ScheduleRunnerPlugin>(),
        AssetPlugin::default(),
        TransformPlugin,
        MeshPlugin,
        DiagnosticsPlugin,
    ))
    .init_asset::<Image>()
    .init_asset::<StandardMaterial>()
    .insert_resource(RadiositySettings {
        bake: BakeSettings {
            refine: false,
            ..BakeSettings::DRAFT
        },
        ..default()
    })
    .add_plugins(FrescoPlugins)
    .add_systems(Startup, spawn);
    app.finish();
    app.cleanup();
    app.update();
    if lit {
        let roots: Vec<Entity> = app
            .world_mut()
            .query_filtered::<Entity, With<Children>>()
            .iter(app.world())
            .collect();
        for root in roots {
            app.world_mut()
                .entity_mut(root)
                .insert(StaticLighting::default());
        }
    }
    app
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let white = materials.add(StandardMaterial::from_color(Color::srgb(0.8, 0.8, 0.8)));
    let ball = meshes.add(Sphere::new(0.3).mesh().uv(12, 7));
    let floor = meshes.add(Plane3d::default().mesh().size(12.0, 12.0).subdivisions(18));
    let root = commands
        .spawn((Transform::default(), Visibility::default()))
        .id();
    commands.spawn((Mesh3d(floor), MeshMaterial3d(white.clone()), ChildOf(root)));
    for i in 0..SIDE * SIDE {
        let at = Vec3::new((i % SIDE) as f32 - 4.5, 0.5, (i / SIDE) as f32 - 4.5);
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(white.clone()),
            Transform::from_translation(at),
            ChildOf(root),
        ));
    }
    commands.spawn((
        PointLight {
            intensity: 1e5,
            affects_lightmapped_mesh_diffuse: false,
            ..default()
        },
        Transform::from_xyz(0.0, 4.0, 0.0),
    ));
}

/// Milliseconds of frames.
struct Frames(Vec<f64>);

impl Frames {
    fn of(app: &mut App, count: usize, mut change: impl FnMut(&mut App, usize)) -> Self {
        let frame = |i| {
            change(app, i);
            app.update();
            std::thread::sleep(Duration::from_millis(5));
            let measured = app.world().resource::<DiagnosticsStore>();
            let spent = measured.get(&RadiosityDiagnostics::MAIN_THREAD);
            spent.and_then(Diagnostic::value).unwrap_or(0.0)
        };
        Self((0..count).map(frame).collect())
    }

    fn until_lit(app: &mut App) -> Self {
        let mut frames = Vec::new();
        while !app.world().resource::<RadiosityStatus>().is_up_to_date() {
            frames.extend(Self::of(app, 1, |_, _| {}).0);
        }
        Self(frames)
    }

    fn print(mut self, what: &str) {
        self.0.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        println!("{what:24} {:8.3} {:8.3} {:8.3}", at(0.5), at(0.99), at(1.0));
    }
}

//! Triangles where the relief needs them, and nowhere else: the same wall of bricks displaced twice, above with
//! triangles by the error asked for, below with as many of them laid out evenly. Faces of bricks are flat and get few,
//! edges get many, so the lower wall is worse for the same price.
//!
//! The slider sets the error; triangles and the error reached are told beside it. `--screenshot FILE` saves a picture
//! without a window.

mod common;

use bevy::asset::RenderAssetUsages;
use bevy::camera::ScalingMode;
use bevy::mesh::PrimitiveTopology;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPlugin, EguiPrimaryContextPass, egui};
use bevy_fresco::displacement::{DisplacementReport, Spacing, Tessellation};
use bevy_fresco::plugin::FrescoPlugins;
use bevy_fresco::plugin::displacement::{Displacement, DisplacementStatus};

/// How far bricks stand out of their joints, and the sides of the walls, in metres.
const HEIGHT: f32 = 0.04;
const SIZE: Vec2 = Vec2::new(2.0, 1.0);
/// How far faces may be from the relief at first, and what the slider offers, in millimetres.
const ERROR: f32 = 5.0;
const ERRORS: std::ops::RangeInclusive<f32> = 0.3..=20.0;

/// The error asked for, in millimetres.
#[derive(Resource)]
struct Asked(f32);

/// By the error.
#[derive(Component)]
struct Adaptive;

/// Evenly.
#[derive(Component)]
struct Even;

/// The edges of a wall's triangles, a child of it.
#[derive(Component)]
struct Edges;

fn main() -> AppExit {
    App::new()
        .add_plugins((
            common::default_plugins("Adaptive tessellation"),
            FrescoPlugins,
            EguiPlugin::default(),
        ))
        .insert_resource(ClearColor(Color::srgb(0.16, 0.17, 0.2)))
        .insert_resource(Asked(ERROR))
        .add_systems(Startup, setup)
        .add_systems(Update, (ask, ask_for_as_many, draw_edges).chain())
        .add_systems(EguiPrimaryContextPass, slider)
        .run()
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let map = assets.load("textures/bricks.png");
    let wall = meshes.add(Rectangle::from_size(SIZE));
    let clay = materials.add(StandardMaterial {
        base_color: Color::srgb(0.75, 0.52, 0.42),
        perceptual_roughness: 0.9,
        ..default()
    });
    let lines = materials.add(StandardMaterial {
        base_color: Color::srgba(0.0, 0.0, 0.0, 0.6),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..default()
    });
    let displacement = Displacement {
        // The map is square.
        uv_transform: bevy::math::Affine2::from_scale(Vec2::new(2.0, 1.0)),
        ..Displacement::new(map, HEIGHT)
    };
    // In front of the faces that they belong to.
    let edges = || {
        (
            Edges,
            MeshMaterial3d(lines.clone()),
            Transform::from_xyz(0.0, 0.0, 0.001),
        )
    };
    let wall = |y: f32| {
        (
            Mesh3d(wall.clone()),
            MeshMaterial3d(clay.clone()),
            displacement.clone(),
            Transform::from_xyz(0.0, y, 0.0),
        )
    };
    commands.spawn((Adaptive, wall(0.53), children![edges()]));
    commands.spawn((Even, wall(-0.53), children![edges()]));
    commands.spawn((
        DirectionalLight {
            illuminance: 6000.0,
            ..default()
        },
        Transform::from_xyz(-2.0, 2.0, 1.6).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let projection = OrthographicProjection {
        scaling_mode: ScalingMode::AutoMin {
            min_width: 2.1,
            min_height: 2.5,
        },
        ..OrthographicProjection::default_3d()
    };
    commands.spawn((
        Camera3d::default(),
        Projection::from(projection),
        Transform::from_xyz(0.0, 0.15, 5.0),
    ));
}

fn ask(asked: Res<Asked>, mut walls: Query<&mut Displacement, With<Adaptive>>) {
    if asked.is_changed() {
        for mut wall in &mut walls {
            wall.settings.tessellation = Tessellation::Adaptive {
                tolerance: asked.0 / 1e3,
            };
        }
    }
}

/// Spaces the even wall's vertices so that it has as many triangles as the other.
fn ask_for_as_many(
    adaptive: Query<&DisplacementStatus, (With<Adaptive>, Changed<DisplacementStatus>)>,
    mut even: Query<&mut Displacement, With<Even>>,
) {
    for report in adaptive.iter().filter_map(DisplacementStatus::report) {
        // Each of the base's two triangles becomes n² if its longest side is cut into n.
        let sides = (report.triangles as f32 / 2.0).sqrt();
        let spacing = SIZE.length() / sides.floor().max(1.0);
        for mut even in &mut even {
            even.settings.tessellation = Tessellation::Uniform(Spacing::Metres(spacing));
        }
    }
}

/// Draws the edges of meshes that are new.
fn draw_edges(
    mut commands: Commands,
    walls: Query<(&Mesh3d, &DisplacementStatus, &Children), Changed<Mesh3d>>,
    edges: Query<(), With<Edges>>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    for (mesh, _, children) in &walls {
        let Some(lines) = meshes.get(&mesh.0).and_then(edges_of) else {
            continue;
        };
        let lines = meshes.add(lines);
        for child in children.iter().filter(|&child| edges.contains(child)) {
            commands.entity(child).insert(Mesh3d(lines.clone()));
        }
    }
}

fn edges_of(mesh: &Mesh) -> Option<Mesh> {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION)?.as_float3()?;
    let corners: Vec<usize> = mesh.indices()?.iter().collect();
    let triangles = corners.chunks_exact(3);
    let sides = triangles.flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let edges: HashSet<[usize; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    let ends: Vec<[f32; 3]> = (edges.into_iter().flatten())
        .map(|vertex| positions[vertex])
        .collect();
    let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::RENDER_WORLD);
    Some(lines.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, ends))
}

fn slider(
    mut contexts: EguiContexts,
    mut asked: ResMut<Asked>,
    adaptive: Query<&DisplacementStatus, With<Adaptive>>,
    even: Query<&DisplacementStatus, With<Even>>,
) -> Result {
    egui::Window::new("Error against triangles").show(contexts.ctx_mut()?, |ui| {
        let mut error = asked.0;
        ui.add(
            egui::Slider::new(&mut error, ERRORS)
                .logarithmic(true)
                .suffix(" mm off"),
        );
        if error != asked.0 {
            asked.0 = error;
        }
        for (name, status) in adaptive
            .iter()
            .map(|s| ("above", s))
            .chain(even.iter().map(|s| ("below", s)))
        {
            let told = status.report().map_or("…".into(), told);
            ui.label(format!("{name}: {told}"));
        }
    });
    Ok(())
}

fn told(report: &DisplacementReport) -> String {
    let error = report.error.map_or_else(String::new, |error| {
        format!(", {:.2} mm off at most", 1e3 * error)
    });
    format!("{} triangles{error}", report.triangles)
}

//! Colour bleeding and soft shadows: the Cornell box, lit by its lamp and by what bounces.
//!
//! Space takes the baked light away and gives it back, 1 to 3 bake as draft, balanced and final, F finds form factors
//! by the next method, S takes the next solver, R paints the red wall blue and back. The title says what was baked and
//! how long it took. `--screenshot FILE` saves a picture without a window.

mod common;

use bevy::gltf::GltfAssetLabel;
use bevy::prelude::*;
use bevy::world_serialization::WorldAssetRoot;
use bevy_fresco::plugin::FrescoPlugins;
use bevy_fresco::plugin::radiosity::{
    BakeFinished, OriginalMaterial, RadiositySettings, StaticLighting,
};
use bevy_fresco::radiosity::{BakeSettings, FormFactors, Solver};

/// What F goes through.
const METHODS: [FormFactors; 4] = [
    FormFactors::HitList,
    FormFactors::Hemicube { resolution: 64 },
    FormFactors::Analytic { visibility_rays: 4 },
    FormFactors::AreaSampling { samples: 16 },
];

/// Elements at most where all of them are looked at from each: more keep one waiting.
const FEW_ELEMENTS: u32 = 1000;

fn main() -> AppExit {
    App::new()
        .add_plugins((common::default_plugins("Cornell box"), FrescoPlugins))
        // All light in the picture is the lamp's.
        .insert_resource(GlobalAmbientLight::NONE)
        .add_systems(Startup, setup)
        .add_systems(Update, keys)
        .add_observer(tell)
        .run()
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    let room = assets.load(GltfAssetLabel::Scene(0).from_asset("scenes/cornell_box.glb"));
    commands.spawn((WorldAssetRoot(room), StaticLighting::default()));
}

fn keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    root: Single<(Entity, Has<StaticLighting>), With<WorldAssetRoot>>,
    walls: Query<(&Name, &OriginalMaterial)>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut settings: ResMut<RadiositySettings>,
) {
    let (root, lit) = *root;
    if keys.just_pressed(KeyCode::Space) {
        if lit {
            commands.entity(root).remove::<StaticLighting>();
        } else {
            commands.entity(root).insert(StaticLighting::default());
        }
    }
    let presets = [
        (KeyCode::Digit1, BakeSettings::DRAFT),
        (KeyCode::Digit2, BakeSettings::BALANCED),
        (KeyCode::Digit3, BakeSettings::FINAL),
    ];
    for (key, preset) in presets {
        if keys.just_pressed(key) {
            settings.bake = BakeSettings {
                form_factors: settings.bake.form_factors,
                elements: elements(settings.bake.form_factors, &preset),
                solver: settings.bake.solver,
                ..preset
            };
        }
    }
    if keys.just_pressed(KeyCode::KeyF) {
        let next = after(&METHODS, settings.bake.form_factors);
        settings.bake.form_factors = next;
        settings.bake.elements = elements(next, &BakeSettings::BALANCED);
    }
    if keys.just_pressed(KeyCode::KeyS) {
        settings.bake.solver = after(&Solver::ALL, settings.bake.solver);
    }
    if keys.just_pressed(KeyCode::KeyR) {
        let red = walls.iter().find(|(name, _)| name.starts_with("Red wall"));
        if let Some(mut paint) = red.and_then(|(_, wall)| materials.get_mut(&wall.handle)) {
            let c = paint.base_color.to_linear();
            paint.base_color = LinearRgba::rgb(c.blue, c.green, c.red).into();
        }
    }
}

/// How many elements there are with a preset.
fn elements(form_factors: FormFactors, preset: &BakeSettings) -> u32 {
    match form_factors {
        FormFactors::HitList => preset.elements,
        _ => FEW_ELEMENTS,
    }
}

/// The next of all, and the first after the last.
fn after<T: Copy + PartialEq>(all: &[T], now: T) -> T {
    let next = all.iter().skip_while(|one| **one != now).nth(1);
    *next.unwrap_or(&all[0])
}

fn tell(
    finished: On<BakeFinished>,
    settings: Res<RadiositySettings>,
    mut window: Option<Single<&mut Window>>,
) {
    let report = &finished.report;
    let milliseconds: f64 = report
        .stages
        .iter()
        .map(|(_, t)| t.as_secs_f64() * 1e3)
        .sum();
    let told = format!(
        "{}, {}: {} elements, {} vertices in {milliseconds:.0} ms, sampling error {:.1} %",
        settings.bake.form_factors.name(),
        settings.bake.solver.name(),
        report.counts.elements,
        report.counts.vertices,
        100.0 * report.sampling_error
    );
    info!("{told}");
    if let Some(window) = &mut window {
        window.title = format!("Cornell box by {told}");
    }
}

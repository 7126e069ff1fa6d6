use std::time::Duration;

use bevy::prelude::*;
use bevy_egui::egui;

use crate::plugin::radiosity::RadiositySettings;
use crate::radiosity::{BakeSettings, FormFactors, Solver};

/// A preset and its name.
const PRESETS: [(&str, BakeSettings); 3] = [
    ("Draft", BakeSettings::DRAFT),
    ("Balanced", BakeSettings::BALANCED),
    ("Final", BakeSettings::FINAL),
];

/// Edits a copy, and writes it back if it is another.
pub(super) fn show(ui: &mut egui::Ui, settings: &mut ResMut<RadiositySettings>) {
    let mut edited = (**settings).clone();
    edit(ui, &mut edited);
    settings.set_if_neq(edited);
}

fn edit(ui: &mut egui::Ui, settings: &mut RadiositySettings) {
    ui.checkbox(&mut settings.automatic, "Bake when something changes");
    ui.horizontal(|ui| {
        for (name, preset) in PRESETS {
            if ui.selectable_label(settings.bake == preset, name).clicked() {
                settings.bake = preset;
            }
        }
    });
    let bake = &mut settings.bake;
    egui::Grid::new("bake settings")
        .num_columns(2)
        .show(ui, |ui| {
            row(ui, "Places vertices by the light", |ui| {
                ui.checkbox(&mut bake.refine, "")
            });
            let mut percent = 100.0 * bake.error;
            let slider = egui::Slider::new(&mut percent, 0.5..=20.0)
                .logarithmic(true)
                .suffix(" %");
            if row(ui, "Error", |ui| ui.add_enabled(bake.refine, slider)).changed() {
                bake.error = percent / 100.0;
            }
            whole(
                ui,
                "Vertices at most",
                &mut bake.max_vertices,
                100..=2_000_000,
            );
            whole(ui, "Elements", &mut bake.elements, 100..=200_000);
            row(ui, "Places elements by the light", |ui| {
                ui.checkbox(&mut bake.adapt, "")
            });
            form_factors(ui, &mut bake.form_factors);
            whole(ui, "Rays of an element", &mut bake.element_rays, 1..=4096);
            whole(ui, "Rays of a sample", &mut bake.gather_rays, 1..=4096);
            whole(
                ui,
                "Shadow rays to emitters",
                &mut bake.emitter_rays,
                1..=4096,
            );
            solver(ui, &mut bake.solver);
            row(ui, "Light answers to bumps", |ui| {
                ui.checkbox(&mut bake.directional, "")
            });
            whole(ui, "Seed", &mut bake.seed, 0..=u32::MAX);
            let sky = &mut settings.sky;
            let mut rgb = [sky.red, sky.green, sky.blue];
            row(ui, "Sky (cd/m²)", |ui| {
                ui.horizontal(|ui| {
                    for channel in &mut rgb {
                        let speed = 0.01 * channel.max(1.0);
                        ui.add(
                            egui::DragValue::new(channel)
                                .range(0.0..=f32::MAX)
                                .speed(speed),
                        );
                    }
                })
                .response
            });
            (sky.red, sky.green, sky.blue) = (rgb[0], rgb[1], rgb[2]);
            let mut wait = settings.debounce.as_secs_f32() * 1e3;
            let drag = egui::DragValue::new(&mut wait)
                .range(0.0..=10_000.0)
                .suffix(" ms");
            if row(ui, "Waits after a change", |ui| ui.add(drag)).changed() {
                settings.debounce = Duration::from_secs_f32(wait / 1e3);
            }
        });
}

fn form_factors(ui: &mut egui::Ui, chosen: &mut FormFactors) {
    let all = [
        ("Rays, hits remembered", FormFactors::HitList),
        ("Hemicube", FormFactors::Hemicube { resolution: 128 }),
        (
            "Closed form",
            FormFactors::Analytic {
                visibility_rays: 16,
            },
        ),
        ("Area sampling", FormFactors::AreaSampling { samples: 64 }),
    ];
    choose(ui, "Form factors", chosen, &all);
    match chosen {
        FormFactors::HitList => {}
        // Half a face has whole pixels.
        FormFactors::Hemicube { resolution } => {
            let mut half = *resolution / 2;
            whole(ui, "Half of its resolution", &mut half, 8..=256);
            *resolution = 2 * half;
        }
        FormFactors::Analytic { visibility_rays } => {
            whole(ui, "Rays between two", visibility_rays, 1..=16_384);
        }
        FormFactors::AreaSampling { samples } => whole(ui, "Samples", samples, 1..=16_384),
    }
}

fn solver(ui: &mut egui::Ui, chosen: &mut Solver) {
    let name = |solver| match solver {
        Solver::GaussSeidelMeanField => "Gauss–Seidel with a mean field",
        Solver::GaussSeidel => "Gauss–Seidel",
        Solver::Jacobi => "Jacobi",
        Solver::Sor { .. } => "Over-relaxation",
        Solver::ProgressiveRefinement => "Progressive refinement",
        Solver::ConjugateGradients => "Conjugate gradients",
    };
    choose(
        ui,
        "Solver",
        chosen,
        &Solver::ALL.map(|solver| (name(solver), solver)),
    );
    if let Solver::Sor { omega } = chosen {
        row(ui, "Omega", |ui| {
            ui.add(egui::Slider::new(omega, 0.1..=1.9))
        });
    }
}

/// One of several kinds; what is chosen within a kind stays.
fn choose<T: Copy>(ui: &mut egui::Ui, label: &str, chosen: &mut T, all: &[(&str, T)]) {
    let kind = |value: &T| std::mem::discriminant(value);
    let name = all.iter().find(|(_, value)| kind(value) == kind(chosen));
    row(ui, label, |ui| {
        egui::ComboBox::from_id_salt(label)
            .selected_text(name.map_or("", |(name, _)| name))
            .show_ui(ui, |ui| {
                for (name, value) in all {
                    let is_it = kind(value) == kind(chosen);
                    if ui.selectable_label(is_it, *name).clicked() && !is_it {
                        *chosen = *value;
                    }
                }
            })
            .response
    });
}

fn whole(ui: &mut egui::Ui, label: &str, value: &mut u32, range: std::ops::RangeInclusive<u32>) {
    let speed = (0.01 * f64::from(*value)).max(0.2);
    row(ui, label, |ui| {
        ui.add(egui::DragValue::new(value).range(range).speed(speed))
    });
}

fn row(
    ui: &mut egui::Ui,
    label: &str,
    widget: impl FnOnce(&mut egui::Ui) -> egui::Response,
) -> egui::Response {
    ui.label(label);
    let response = widget(ui);
    ui.end_row();
    response
}

use bevy_egui::egui;
use egui_plot::{Line, Plot};

use crate::radiosity::{Report, Stopped};
use crate::text::{bytes, count, percent, seconds, short};

/// Height of the plot, in points.
const PLOT: f32 = 90.0;

/// Times, errors, the solver's residuals, memory.
pub(super) fn show(ui: &mut egui::Ui, report: &Report, kept: u64) {
    let error = &report.error;
    let line = |ui: &mut egui::Ui, label: &str, value: String| {
        ui.label(label);
        ui.label(value);
        ui.end_row();
    };
    egui::Grid::new("result")
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            line(ui, "Vertices", count(report.counts.vertices));
            line(ui, "Elements", count(report.counts.elements));
            line(ui, "Rays", count(report.work.rays()));
            line(
                ui,
                "Mean light",
                format!("{} cd/m²", short(report.mean_light.into())),
            );
            line(ui, "Error, estimated", percent(error.total.into()));
            for (part, share) in [
                ("of meshes", error.meshing),
                ("of chance", error.sampling),
                ("of elements", error.elements),
                ("of the solver", error.solver),
            ] {
                line(ui, &format!("    {part}"), percent(share.into()));
            }
            line(ui, "Stopped", stopped(report.stopped).into());
            line(
                ui,
                "Energy unaccounted for",
                percent(report.energy.relative_error()),
            );
            line(ui, "Memory of the bake", bytes(report.bytes));
            line(ui, "kept for the next", bytes(kept));
            for (stage, time) in &report.stages {
                line(ui, stage.name(), seconds(*time));
            }
            line(
                ui,
                "In all",
                seconds(report.stages.iter().map(|s| s.1).sum()),
            );
        });
    residuals(ui, &report.solver.residuals);
}

fn stopped(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::AsGiven => "vertices as given",
        Stopped::Error => "the error asked for is met",
        Stopped::Vertices => "vertices at most",
        Stopped::Memory => "memory at most",
        Stopped::Seconds => "time at most",
        Stopped::Limit => "more did not help",
    }
}

/// The residual by sweep, as a power of ten.
fn residuals(ui: &mut egui::Ui, residuals: &[f64]) {
    let points: Vec<[f64; 2]> = (residuals.iter().enumerate())
        .filter(|(_, residual)| **residual > 0.0)
        .map(|(sweep, residual)| [sweep as f64, residual.log10()])
        .collect();
    if points.len() < 2 {
        return;
    }
    ui.label("Residual by sweep (cd/m², power of ten)");
    Plot::new("residuals")
        .height(PLOT)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show(ui, |plot| plot.line(Line::new("residual", points)));
}

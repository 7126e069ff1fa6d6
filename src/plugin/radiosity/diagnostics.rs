use std::time::{Duration, Instant};

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::prelude::*;

use super::status::BakeFinished;
use crate::radiosity::Stage;

/// Names of the measurements that the plugin gives to Bevy's
/// [`DiagnosticsStore`](bevy::diagnostic::DiagnosticsStore), most of them when a bake ends.
#[derive(Clone, Copy, Debug)]
pub struct RadiosityDiagnostics;

impl RadiosityDiagnostics {
    /// Milliseconds of the whole bake.
    pub const TOTAL: DiagnosticPath = DiagnosticPath::const_new("radiosity/total");
    /// Vertices that carry light.
    pub const VERTICES: DiagnosticPath = DiagnosticPath::const_new("radiosity/vertices");
    /// Milliseconds that a frame's main thread spent on baked light; measured every frame.
    pub const MAIN_THREAD: DiagnosticPath = DiagnosticPath::const_new("radiosity/main_thread");
    /// Rays traced, of all kinds.
    pub const RAYS: DiagnosticPath = DiagnosticPath::const_new("radiosity/rays");

    /// Milliseconds of a stage; 0 if the bake did not need it.
    pub const fn stage(stage: Stage) -> DiagnosticPath {
        DiagnosticPath::const_new(match stage {
            Stage::Contacts => "radiosity/contacts",
            Stage::Mesh => "radiosity/mesh",
            Stage::Occlusion => "radiosity/occlusion",
            Stage::FirstLook => "radiosity/first_look",
            Stage::FormFactors => "radiosity/form_factors",
            Stage::Direct => "radiosity/direct",
            Stage::Solve => "radiosity/solve",
            Stage::Error => "radiosity/sampling_error",
            Stage::Refine => "radiosity/refine",
            Stage::Gather => "radiosity/gather",
            Stage::Shadows => "radiosity/shadows",
            Stage::Fit => "radiosity/fit",
            Stage::Preview => "radiosity/preview",
        })
    }
}

pub(super) fn register(app: &mut App) {
    for stage in Stage::ALL {
        let path = RadiosityDiagnostics::stage(stage);
        app.register_diagnostic(Diagnostic::new(path).with_suffix(" ms"));
    }
    app.register_diagnostic(Diagnostic::new(RadiosityDiagnostics::TOTAL).with_suffix(" ms"))
        .register_diagnostic(Diagnostic::new(RadiosityDiagnostics::VERTICES))
        .register_diagnostic(Diagnostic::new(RadiosityDiagnostics::RAYS))
        .register_diagnostic(Diagnostic::new(RadiosityDiagnostics::MAIN_THREAD).with_suffix(" ms"))
        .init_resource::<MainThread>()
        .add_observer(measure);
}

/// Time that the plugin's systems have taken in this frame.
#[derive(Resource, Default)]
pub(super) struct MainThread {
    since: Option<Instant>,
    spent: Duration,
}

/// Before the systems of a schedule.
pub(super) fn start_clock(mut clock: ResMut<MainThread>) {
    clock.since = Some(Instant::now());
}

/// After them.
pub(super) fn stop_clock(mut clock: ResMut<MainThread>) {
    let spent = clock.since.take().map_or(Duration::ZERO, |s| s.elapsed());
    clock.spent += spent;
}

/// At the frame's end.
pub(super) fn read_clock(mut clock: ResMut<MainThread>, mut diagnostics: Diagnostics) {
    let spent = std::mem::take(&mut clock.spent);
    diagnostics.add_measurement(&RadiosityDiagnostics::MAIN_THREAD, || {
        spent.as_secs_f64() * 1e3
    });
}

fn measure(finished: On<BakeFinished>, mut diagnostics: Diagnostics) {
    let report = &finished.report;
    let milliseconds = |stage: Stage| -> f64 {
        let times = report.stages.iter().filter(|(s, _)| *s == stage);
        times.map(|(_, t)| t.as_secs_f64() * 1e3).sum()
    };
    for stage in Stage::ALL {
        let path = RadiosityDiagnostics::stage(stage);
        diagnostics.add_measurement(&path, || milliseconds(stage));
    }
    diagnostics.add_measurement(&RadiosityDiagnostics::TOTAL, || {
        Stage::ALL.map(milliseconds).iter().sum()
    });
    diagnostics.add_measurement(&RadiosityDiagnostics::VERTICES, || {
        report.counts.vertices as f64
    });
    let work = &report.work;
    diagnostics.add_measurement(&RadiosityDiagnostics::RAYS, || work.rays() as f64);
}

use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

use super::bake::Made;
use super::outputs::Outputs;
use crate::radiosity::Stopped;
use crate::text::{bytes, count, counted, percent, seconds, short};

/// Notes shown before the rest is left to the report.
const NOTES: usize = 8;

/// What a bake did, for the terminal.
pub(super) fn summary(scene: &Path, outputs: &Outputs, made: &Made) -> String {
    let mut text = String::new();
    let counts = &made.bake.report.counts;
    let read = [
        counted(counts.objects, "object"),
        counted(counts.triangles, "triangle"),
        counted(counts.lights, "light"),
        counted(counts.emitters, "emissive triangle"),
    ];
    line(
        &mut text,
        &format!("{}: {}", scene.display(), read.join(", ")),
    );
    text.push('\n');
    times(&mut text, made);
    text.push('\n');
    quality(&mut text, made);
    notes(&mut text, &made.notes);
    text.push('\n');
    let mut wrote = |path: &Path, size: usize| {
        line(
            &mut text,
            &format!("wrote {} ({})", path.display(), bytes(size as u64)),
        );
    };
    wrote(&outputs.glb, made.glb.len());
    if let (Some(path), Some(png)) = (&outputs.preview, &made.png) {
        wrote(path, png.len());
    }
    if let Some(path) = &outputs.report {
        line(&mut text, &format!("wrote {}", path.display()));
    }
    text
}

fn line(text: &mut String, content: &str) {
    text.push_str(content);
    text.push('\n');
}

fn row(text: &mut String, name: &str, value: &str) {
    // Writing to a string cannot fail.
    writeln!(text, "  {name:<14} {value}").ok();
}

fn times(text: &mut String, made: &Made) {
    let total: Duration = made.times.iter().map(|(_, time)| *time).sum();
    for &(name, time) in &made.times {
        row(text, name, &format!("{:>10}", seconds(time)));
    }
    let threads = counted(made.threads as u64, "thread");
    row(
        text,
        "total",
        &format!("{:>10} on {threads}", seconds(total)),
    );
}

fn quality(text: &mut String, made: &Made) {
    let report = &made.bake.report;
    let counts = &report.counts;
    row(
        text,
        "vertices",
        &format!(
            "{}, fitted to {}",
            count(counts.vertices),
            counted(counts.samples, "sample")
        ),
    );
    let method = made.settings.form_factors.name();
    row(
        text,
        "elements",
        &format!("{}, form factors by {method}", count(counts.elements)),
    );
    row(
        text,
        "rays",
        &format!(
            "{} and {}",
            count(counts.rays),
            counted(counts.shadow_rays, "shadow ray")
        ),
    );
    let mean = format!("{} cd/m² (irradiance / π)", short(report.mean_light.into()));
    row(text, "mean light", &mean);
    let (error, of) = (&report.error, |e: f32| percent(e.into()));
    row(
        text,
        "error",
        &format!(
            "about {} of the mean: meshing {}, sampling {}, elements {}, solver {}{}",
            of(error.total),
            of(error.meshing),
            of(error.sampling),
            of(error.elements),
            of(error.solver),
            stopped(report.stopped, made)
        ),
    );
    let sampling = percent(report.sampling_error.into());
    row(
        text,
        "sampling error",
        &format!(
            "{sampling} of the mean, and {} at elements",
            percent(report.element_error.into())
        ),
    );
    let solver = &report.solver;
    row(
        text,
        "solver error",
        &format!(
            "at most {} cd/m² after {} of {}",
            short(solver.error_bound),
            counted(solver.sweeps.into(), "sweep"),
            solver.solver.name(),
        ),
    );
    row(
        text,
        "energy",
        &format!("balances to {}", percent(report.energy.relative_error())),
    );
    if let Some(exposure) = made.exposure {
        row(text, "exposure", &format!("{exposure:.4e}"));
    }
}

fn notes(text: &mut String, notes: &[String]) {
    if notes.is_empty() {
        return;
    }
    text.push_str("\nnotes\n");
    for note in notes.iter().take(NOTES) {
        line(text, &format!("  - {note}"));
    }
    if notes.len() > NOTES {
        line(
            text,
            &format!("  - and {} more, see --report", notes.len() - NOTES),
        );
    }
}

/// Why no better result was looked for.
fn stopped(stopped: Stopped, made: &Made) -> String {
    let asked = percent(made.settings.error.into());
    match stopped {
        Stopped::AsGiven => String::new(),
        Stopped::Error => format!("; {asked} was asked"),
        Stopped::Vertices => format!(
            "; stopped at {} of {} vertices allowed, {asked} was asked",
            count(made.bake.report.counts.vertices),
            count(made.settings.max_vertices.into())
        ),
        Stopped::Memory => format!("; stopped at the memory allowed, {asked} was asked"),
        Stopped::Seconds => format!("; stopped when the time was over, {asked} was asked"),
        Stopped::Limit => match made.bake.report.error {
            error if error.elements > made.settings.error / 2.0 => {
                format!("; {asked} was asked, which takes more elements")
            }
            _ => format!("; no way to come nearer to the {asked} asked"),
        },
    }
}

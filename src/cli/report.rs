use std::path::Path;
use std::time::Duration;

use serde_json::{Map, Value, json};

use super::args::BakeArgs;
use super::bake::Made;
use super::outputs::Outputs;
use crate::radiosity::{BakeSettings, Counts, DirectLight, FormFactors, Report, Solver, Stopped};

/// The report as JSON. `docs/file_formats.md` documents the keys; they stay as they are.
pub(super) fn report_json(args: &BakeArgs, outputs: &Outputs, made: &Made) -> String {
    let report = &made.bake.report;
    let name = |path: Option<&Path>| path.map(|path| path.display().to_string());
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "input": name(Some(&args.scene)),
        "output": name(Some(&outputs.glb)),
        "preview": name(outputs.preview.as_deref()),
        "preset": args.settings.preset.name(),
        "settings": settings(&made.settings, args),
        "threads": made.threads,
        "exposure": made.exposure,
        "seconds": seconds(&made.times),
        "counts": counts(&report.counts),
        "bytes": {
            "tables": report.bytes,
            "output": made.glb.len(),
            "preview": made.png.as_ref().map(Vec::len),
        },
        "energy": {
            "arrived": report.energy.arrived.to_array(),
            "absorbed": report.energy.absorbed.to_array(),
            "escaped": report.energy.escaped.to_array(),
            "relative_error": report.energy.relative_error(),
        },
        "form_factors": {
            "largest_row_sum": report.form_factors.largest_row_sum,
            "scaled_rows": report.form_factors.scaled_rows,
            "near_pairs": report.form_factors.near_pairs,
        },
        "solver": solver(report),
        "error": {
            "total": report.error.total,
            "meshing": report.error.meshing,
            "sampling": report.error.sampling,
            "elements": report.error.elements,
            "solver": report.error.solver,
        },
        "stopped": stopped(report.stopped),
        "element_error": report.element_error,
        "sampling_error": report.sampling_error,
        "mean_light": report.mean_light,
        "notes": made.notes,
    });
    format!("{json:#}\n")
}

fn settings(settings: &BakeSettings, args: &BakeArgs) -> Value {
    json!({
        "max_edge": settings.max_edge,
        "refine": settings.refine,
        "error": settings.error,
        "max_vertices": settings.max_vertices,
        "max_seconds": settings.max_seconds,
        "elements": settings.elements,
        "form_factors": form_factors(settings.form_factors),
        "element_rays": settings.element_rays,
        "gather_rays": settings.gather_rays,
        "samples_per_vertex": settings.samples_per_vertex,
        "emitter_rays": settings.emitter_rays,
        "adapt": settings.adapt,
        "sample_emitters": settings.sample_emitters,
        "directional": settings.directional,
        "solver": settings.solver.name(),
        "solver_tolerance": settings.solver_tolerance,
        "max_sweeps": settings.max_sweeps,
        "max_reflectance": settings.max_reflectance,
        "seed": settings.seed,
        "direct": match args.settings.direct() {
            DirectLight::Baked => "baked",
            DirectLight::Realtime => "realtime",
        },
        "contribution": format!("{:?}", settings.contribution).to_lowercase(),
        "encoding": if args.results.vertex_colors { "vertex_colors" } else { "attribute" },
        "sky": args.settings.sky.unwrap_or_default().to_array(),
    })
}

fn form_factors(method: FormFactors) -> Value {
    let name = method.name().replace(' ', "_");
    match method {
        FormFactors::HitList => json!({ "method": name }),
        FormFactors::Hemicube { resolution } => json!({ "method": name, "resolution": resolution }),
        FormFactors::Analytic {
            visibility_rays: rays,
        }
        | FormFactors::AreaSampling { samples: rays } => {
            json!({ "method": name, "pair_rays": rays })
        }
    }
}

fn seconds(times: &[(&'static str, Duration)]) -> Value {
    let mut map: Map<String, Value> = times
        .iter()
        .map(|(name, time)| (name.replace(' ', "_"), time.as_secs_f64().into()))
        .collect();
    let total: Duration = times.iter().map(|(_, time)| *time).sum();
    map.insert("total".into(), total.as_secs_f64().into());
    map.into()
}

fn counts(counts: &Counts) -> Value {
    json!({
        "objects": counts.objects,
        "triangles": counts.triangles,
        "vertices": counts.vertices,
        "elements": counts.elements,
        "emitters": counts.emitters,
        "lights": counts.lights,
        "rays": counts.rays,
        "shadow_rays": counts.shadow_rays,
        "samples": counts.samples,
        "invalid_samples": counts.invalid_samples,
        "filled_vertices": counts.filled_vertices,
        "dark_vertices": counts.dark_vertices,
    })
}

fn solver(report: &Report) -> Value {
    json!({
        "solver": report.solver.solver.name(),
        "fell_back_from": report.solver.fell_back.map(Solver::name),
        "shots": report.solver.shots,
        "residuals": report.solver.residuals,
        "asymmetry": report.solver.asymmetry,
        "sweeps": report.solver.sweeps,
        "converged": report.solver.converged,
        "residual": report.solver.residual,
        "error_bound": report.solver.error_bound,
    })
}

const fn stopped(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::AsGiven => "as given",
        Stopped::Error => "error",
        Stopped::Vertices => "vertices",
        Stopped::Memory => "memory",
        Stopped::Seconds => "seconds",
        Stopped::Limit => "limit",
    }
}

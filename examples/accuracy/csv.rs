//! Results as tables for other programs. Empty cells are unknown.

use std::fmt::Display;

use crate::metrics::Metrics;
use crate::results::Results;
use crate::studies::{AtVertices, Refined, Solved};
use crate::sweep::{Measured, Outcome, Point};

const COLUMNS: &str = "scene,method,knob,budget,elements_asked,elements,vertices,lamps,lamp_rays,\
    solver,tolerance,threads,runs,seeds,status,t_wall,t_cpu,t_build,t_form_factors,t_direct,\
    t_solve,bytes,peak_resident,sweeps,rays,cert_solver,est_sampling,floor";

/// Cells of a row, by the names of their columns.
type Cells = Vec<(String, String)>;

/// Every point of every sweep, and the bakes to vertices.
pub(crate) fn accuracy(results: &Results) -> String {
    let parts = ["bounced", "direct", "total"];
    let errors = parts
        .iter()
        .flat_map(|part| Metrics::NAMES.map(|name| format!("{part}_{name}")));
    let header: Vec<String> = COLUMNS.split(',').map(String::from).chain(errors).collect();
    let points = results.points.iter().map(point);
    let rows = points.chain(results.at_vertices.iter().map(at_vertices));
    let in_order = |cells: Cells| {
        let find = |name: &String| cells.iter().find(|c| c.0 == *name);
        let row = header.iter().map(|name| find(name).map_or("", |c| &c.1));
        row.collect::<Vec<_>>().join(",")
    };
    let lines = std::iter::once(header.join(",")).chain(rows.map(in_order));
    lines.map(|line| line + "\n").collect()
}

pub(crate) fn threads() -> usize {
    rayon::current_num_threads()
}

fn named(name: &str, value: impl Display) -> (String, String) {
    (name.into(), cell(value))
}

fn at_vertices(v: &AtVertices) -> Cells {
    vec![
        named("scene", "S3"),
        named("method", format!("{}, gathered at vertices", v.method)),
        named("budget", v.budget),
        named("vertices", v.vertices),
        named("threads", threads()),
        named("status", "measured"),
        named("runs", 1),
        named("t_wall", v.seconds),
        named("est_sampling", v.estimate),
        named("total_l2", v.error),
    ]
}

fn point(point: &Point) -> Cells {
    let mut cells = vec![
        named("scene", point.subject.id),
        named("method", point.family.name),
        named("knob", point.family.knob),
        named("budget", point.budget),
        named("elements_asked", point.size),
        named("elements", point.elements),
    ];
    match &point.outcome {
        Outcome::Measured(m) => {
            cells.push(named("status", "measured"));
            cells.extend(settings(m));
            cells.extend(figures(m));
        }
        Outcome::TooSlow(seconds) => {
            let status = format!("skipped: too slow, {seconds:.1} s expected");
            cells.push(named("status", status));
        }
    }
    cells
}

fn settings(m: &Measured) -> Cells {
    let s = &m.settings;
    let seeds: Vec<String> = (1..=m.runs).map(|seed| seed.to_string()).collect();
    let (lamps, rays) = if s.sample_emitters {
        ("sampled", s.emitter_rays)
    } else {
        ("found by form factors", 0)
    };
    vec![
        named("lamps", lamps),
        named("lamp_rays", rays),
        named("solver", s.solver.name()),
        named("tolerance", s.solver_tolerance),
        named("threads", threads()),
        named("runs", m.runs),
        named("seeds", seeds.join(" ")),
    ]
}

fn figures(m: &Measured) -> Cells {
    let cost = &m.cost;
    let mut cells = vec![
        named("t_wall", cost.wall),
        named("t_build", cost.build),
        named("t_form_factors", cost.form_factors),
        named("t_direct", cost.direct),
        named("t_solve", cost.solve),
        named("bytes", cost.bytes),
        named("sweeps", m.sweeps),
        named("rays", m.rays),
        named("cert_solver", m.bound),
        named("floor", m.floor),
    ];
    cells.extend(cost.cpu.map(|seconds| named("t_cpu", seconds)));
    cells.extend(cost.resident.map(|bytes| named("peak_resident", bytes)));
    let errors = &m.errors;
    for (part, metrics) in [
        ("bounced", errors.bounced),
        ("direct", errors.direct),
        ("total", errors.total),
    ] {
        let parts = Metrics::NAMES.iter().zip(metrics.values());
        cells.extend(parts.map(|(name, value)| named(&format!("{part}_{name}"), value)));
    }
    cells
}

pub(crate) fn table<T>(header: &str, items: &[T], cells: impl Fn(&T) -> Vec<String>) -> String {
    let rows = items.iter().map(|item| cells(item).join(",") + "\n");
    std::iter::once(format!("{header}\n")).chain(rows).collect()
}

pub(crate) fn cell(value: impl Display) -> String {
    // Some names hold commas.
    value.to_string().replace(',', ";")
}

pub(crate) fn solvers(solved: &[Solved]) -> String {
    let header = "solver,reflectance,sweeps,converged,seconds,bound_by_mean,error_by_mean";
    table(header, solved, |s| {
        let figures = [s.seconds, s.bound, s.error].map(cell);
        let what = [
            cell(s.solver),
            cell(s.reflectance),
            cell(s.sweeps),
            cell(s.converged),
        ];
        what.into_iter().chain(figures).collect()
    })
}

pub(crate) fn elements(refined: &[Refined]) -> String {
    table("series,elements,error", refined, |r| {
        vec![cell(r.series), cell(r.elements), cell(r.error)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::FAMILIES;
    use crate::reference::Errors;
    use crate::scenes::SUBJECTS;

    #[test]
    fn all_rows_have_all_columns() {
        let point = |outcome| Point {
            subject: &SUBJECTS[0],
            size: 1000,
            elements: 998,
            family: &FAMILIES[0],
            budget: 64,
            outcome,
        };
        let measured = Measured {
            settings: FAMILIES[0].settings(64, 1000),
            runs: 5,
            cost: Default::default(),
            errors: Errors::default(),
            floor: 0.0,
            sweeps: 7.0,
            rays: 1.0,
            bound: 0.0,
        };
        let results = Results {
            points: vec![
                point(Outcome::Measured(Box::new(measured))),
                point(Outcome::TooSlow(9.0)),
            ],
            at_vertices: vec![AtVertices {
                method: "hit list",
                budget: 64,
                vertices: 100,
                error: 0.125,
                estimate: 0.25,
                seconds: 1.0,
            }],
            ..Results::default()
        };
        let csv = accuracy(&results);
        let rows: Vec<Vec<&str>> = csv.lines().map(|l| l.split(',').collect()).collect();
        assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
        let column = |name: &str| rows[0].iter().position(|c| *c == name).unwrap();
        assert_eq!(rows[1][column("sweeps")], "7");
        assert!(rows[2][column("status")].starts_with("skipped"));
        assert_eq!(rows[3][column("vertices")], "100");
        assert_eq!(rows[3][column("est_sampling")], "0.25");
        assert_eq!(rows[3][column("total_l2")], "0.125");
    }
}

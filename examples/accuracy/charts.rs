//! Which charts are drawn.

use crate::chart::{Axis, Chart, Dot, Guide, STYLES, Series};
use crate::measure::Cost;
use crate::methods::{FAMILIES, Family, LAMPS, SOLVERS};
use crate::metrics::pareto;
use crate::results::Results;
use crate::scenes::Subject;
use crate::studies::{AT_POINTS, BY_RAYS, CONTINUUM, REFLECTANCES};
use crate::text::{bytes, count, percent, seconds};

/// A chart by the name of its file.
pub(crate) type Named = (String, Chart);

pub(crate) fn all(results: &Results) -> Vec<Named> {
    let mut charts = Vec::new();
    for stage @ (subject, size, _) in results.stages() {
        if results
            .of((subject.id, size), &FAMILIES[1])
            .next()
            .is_some()
        {
            charts.push((file(subject, size), methods(results, stage)));
        }
        if results.of((subject.id, size), &LAMPS[0]).next().is_some() {
            let name = format!("lamps_{}.svg", subject.id.to_lowercase());
            charts.push((name, lamps(results, stage)));
        }
        if subject.id == "S3" && size == 1000 {
            charts.push(("memory.svg".into(), memory(results, stage)));
        }
    }
    if !results.solved.is_empty() {
        charts.push(("solvers.svg".into(), solvers(results)));
    }
    if !results.refined.is_empty() {
        charts.push(("elements.svg".into(), elements(results)));
    }
    charts
}

/// The file of a scene's chart.
pub(crate) fn file(subject: &Subject, size: u32) -> String {
    format!("{}_{size}.svg", subject.id.to_lowercase())
}

pub(crate) fn axis(label: &str, format: fn(f64) -> String) -> Axis {
    Axis {
        label: label.into(),
        format,
        ticks: Vec::new(),
    }
}

pub(crate) fn styled(i: usize, name: &str, points: Vec<Dot>) -> Series {
    let (color, marker) = STYLES[i % STYLES.len()];
    Series {
        name: name.into(),
        color,
        marker,
        points,
    }
}

/// Values of knobs are written at the first, the last and every second point between.
fn labelled(points: Vec<((f64, f64), u32)>) -> Vec<Dot> {
    let last = points.len().saturating_sub(1);
    let dot = |(i, (at, budget)): (usize, ((f64, f64), u32))| Dot {
        at,
        label: if i % 2 == 0 || i == last {
            budget.to_string()
        } else {
            String::new()
        },
    };
    points.into_iter().enumerate().map(dot).collect()
}

const FINE: &str = "2 5";
const COARSE: &str = "9 5";

fn monte_carlo() -> Vec<Guide> {
    vec![
        Guide {
            slope: -0.5,
            name: "slope −1/2: chance",
            dashes: FINE,
        },
        Guide {
            slope: -0.75,
            name: "slope −3/4: stratified",
            dashes: COARSE,
        },
    ]
}

/// The front of some series, errors below the floor lifted to it.
pub(crate) fn front(series: &[Series], floor: f64) -> Vec<(f64, f64)> {
    let dots = series.iter().flat_map(|s| &s.points);
    pareto(
        &dots
            .map(|d| (d.at.0, d.at.1.max(floor)))
            .collect::<Vec<_>>(),
    )
}

/// A line for each method of finding form factors: its error by a cost.
fn families(results: &Results, stage: (&str, u32), by: impl Fn(&Cost) -> f64) -> Vec<Series> {
    let line = |(i, family): (usize, &Family)| {
        let points = results.of(stage, family);
        let at = points.map(|(p, m)| ((by(&m.cost), p.error(&m.errors)), p.budget));
        styled(
            i,
            &format!("{} ({})", family.name, family.knob),
            labelled(at.collect()),
        )
    };
    let lines = FAMILIES.iter().enumerate().map(line);
    lines.filter(|s| !s.points.is_empty()).collect()
}

/// Methods of finding form factors on a scene.
fn methods(results: &Results, (subject, size, elements): (&Subject, u32, usize)) -> Chart {
    let series = families(results, (subject.id, size), Cost::bounces);
    let floor = results
        .reference(subject.id, elements)
        .map_or(0.0, |r| r.floor);
    Chart {
        title: format!(
            "{} {}, {} elements",
            subject.id,
            subject.name,
            count(elements as u64)
        ),
        subtitle: subject.about.into(),
        x: axis("time for form factors and solving (wall clock)", seconds),
        y: axis(
            &format!("error of {} (relative L2)", subject.judged.name()),
            percent,
        ),
        front: front(&series, floor),
        series,
        guides: monte_carlo(),
        floor: Some(floor).filter(|&f| f > 0.0),
    }
}

/// Lamps sampled, and lamps left to form factors.
fn lamps(results: &Results, (subject, size, elements): (&Subject, u32, usize)) -> Chart {
    let series = LAMPS.iter().enumerate().map(|(i, family)| {
        let points = results.of((subject.id, size), family);
        let at = points.map(|(p, m)| ((m.cost.light(), m.errors.total.l2), p.budget));
        styled(i, family.name, labelled(at.collect()))
    });
    let series: Vec<Series> = series.filter(|s| !s.points.is_empty()).collect();
    Chart {
        title: format!(
            "Lamps of {} {}, {} elements",
            subject.id,
            subject.name,
            count(elements as u64)
        ),
        subtitle: "Lamps sampled, and lamps left to form factors".into(),
        x: axis(
            "time for direct light, form factors and solving (wall clock)",
            seconds,
        ),
        y: axis("error of all light (relative L2)", percent),
        front: front(&series, 0.0),
        series,
        guides: monte_carlo(),
        floor: None,
    }
}

fn memory(results: &Results, (subject, size, elements): (&Subject, u32, usize)) -> Chart {
    let series = families(results, (subject.id, size), |cost| cost.bytes);
    let floor = results
        .reference(subject.id, elements)
        .map_or(0.0, |r| r.floor);
    Chart {
        title: format!(
            "Memory: {} {}, {} elements",
            subject.id,
            subject.name,
            count(elements as u64)
        ),
        subtitle: "Hit lists grow with their rays, rows of pairs do not".into(),
        x: axis("bytes of form factors, elements and hierarchy", bytes),
        y: axis("error of bounced light (relative L2)", percent),
        front: front(&series, floor),
        series,
        guides: Vec::new(),
        floor: Some(floor).filter(|&f| f > 0.0),
    }
}

fn solvers(results: &Results) -> Chart {
    let darkness = |reflectance: f32| f64::from(1.0 / (1.0 - reflectance));
    let series = SOLVERS.iter().enumerate().map(|(i, (name, _))| {
        let of = results
            .solved
            .iter()
            .filter(|s| s.solver == *name && s.converged);
        let dot = |s: &crate::studies::Solved| Dot {
            at: (darkness(s.reflectance), f64::from(s.sweeps.max(1))),
            label: String::new(),
        };
        styled(i, name, of.map(dot).collect())
    });
    let ticks = REFLECTANCES.iter().map(|&r| (darkness(r), r.to_string()));
    Chart {
        title: "Solvers: sweeps to an error below 1e-4".into(),
        subtitle: "Closed room with a column; runs that did not come there are left out".into(),
        x: Axis {
            ticks: ticks.collect(),
            ..axis(
                "reflectance ρ of all walls, spaced by 1 / (1 − ρ)",
                |v| v.to_string(),
            )
        },
        y: axis("sweeps over all elements", |v| count(v as u64)),
        series: series.collect(),
        front: Vec::new(),
        guides: Vec::new(),
        floor: None,
    }
}

fn elements(results: &Results) -> Chart {
    let series = [CONTINUUM, BY_RAYS, AT_POINTS]
        .into_iter()
        .enumerate()
        .map(|(i, name)| {
            let of = results.refined.iter().filter(|r| r.series == name);
            let dot = |r: &crate::studies::Refined| Dot {
                at: (r.elements as f64, r.error),
                label: String::new(),
            };
            styled(i, name, of.map(dot).collect())
        });
    Chart {
        title: "More elements: S1 unit cube against the continuum".into(),
        subtitle: "Mean radiosity of faces; light of vertices at centres, edges and a corner"
            .into(),
        x: axis("elements", |v| count(v as u64)),
        y: axis("relative error (root mean square)", percent),
        series: series.collect(),
        front: Vec::new(),
        guides: vec![
            Guide {
                slope: -0.5,
                name: "slope −1/2: first order",
                dashes: FINE,
            },
            Guide {
                slope: -1.0,
                name: "slope −1: second order",
                dashes: COARSE,
            },
        ],
        floor: None,
    }
}

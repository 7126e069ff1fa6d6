//! Vertices used against vertices spread evenly, at equal error: what it is worth to put them where
//! the light needs them, and what an error costs that is asked for.

use std::time::Instant;

use bevy_fresco::radiosity::{Bake, BakeError, BakeSettings, bake};

use crate::chart::{Axis, Chart, Dot, Series};
use crate::charts::{Named, axis, front, styled};
use crate::csv::{cell, table};
use crate::known::error::measure;
use crate::known::layout::Layout;
use crate::known::scenes::{CARE, cornell_box, court, gallery, room_with_panel};
use crate::known::truth::Truth;
use crate::markdown;
use crate::metrics::{cost_of, median};
use crate::plan::Plan;
use crate::results::GOALS;
use crate::text::{count, percent, seconds};

/// How vertices come to be where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// Edges are at most so long, in metres.
    Uniform(f32),
    /// Placed by the light until an error is reached.
    ToError(f32),
    /// Placed by the light until there are so many.
    ToVertices(u32),
}

/// What is done again and again.
const UNIFORM: [f32; 8] = [3.2, 1.6, 0.8, 0.4, 0.2, 0.1, 0.05, 0.025];
/// From 20 % to 0.5 %, ten steps a factor of ten.
const ERRORS: [f32; 17] = [
    0.2, 0.158, 0.126, 0.1, 0.0794, 0.0631, 0.0501, 0.0398, 0.0316, 0.0251, 0.02, 0.0158, 0.0126,
    0.01, 0.0079, 0.0063, 0.005,
];
const VERTICES: [u32; 9] = [250, 500, 1000, 2000, 4000, 8000, 16_000, 32_000, 64_000];

/// Below what can be reached: only vertices end the bake.
const LEAST_ERROR: f32 = 0.001;

/// Points at which a bake is compared with the truth.
const POINTS: usize = 40_000;

impl Way {
    pub(crate) const NAMES: [&str; 3] = ["uniform", "used, to an error", "used, to vertices"];

    fn kind(self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::ToError(_) => 1,
            Self::ToVertices(_) => 2,
        }
    }

    fn name(self) -> &'static str {
        Self::NAMES[self.kind()]
    }

    fn step(self) -> String {
        match self {
            Self::Uniform(edge) => format!("{edge} m"),
            Self::ToError(error) => percent(f64::from(error)),
            Self::ToVertices(vertices) => count(vertices.into()),
        }
    }

    fn settings(self, seed: u32) -> BakeSettings {
        let plain = BakeSettings {
            seed,
            ..BakeSettings::BALANCED
        };
        match self {
            Self::Uniform(edge) => BakeSettings {
                max_edge: Some(edge),
                ..plain
            },
            Self::ToError(error) => BakeSettings {
                refine: true,
                error,
                ..plain
            },
            Self::ToVertices(max_vertices) => BakeSettings {
                refine: true,
                error: LEAST_ERROR,
                max_vertices,
                ..plain
            },
        }
    }
}

/// What a bake came to; figures are medians of several seeds.
pub(crate) struct Used {
    pub(crate) scene: &'static str,
    pub(crate) way: Way,
    pub(crate) vertices: f64,
    pub(crate) triangles: f64,
    pub(crate) rays: f64,
    pub(crate) seconds: f64,
    /// Relative RMSE over all that is seen.
    pub(crate) error: f64,
    /// What the bake says of it.
    pub(crate) estimate: f64,
    pub(crate) stopped: String,
}

/// All ways on all scenes.
pub(crate) fn study(plan: &Plan, say: impl Fn(&str)) -> Result<Vec<Used>, BakeError> {
    let mut all = Vec::new();
    for layout in [cornell_box(), court(), room_with_panel(), gallery()] {
        say(&format!("refinement: {}", layout.name));
        let truth = Truth::find(&layout, CARE)?;
        let uniform = plan.some(&UNIFORM).map(|&edge| Way::Uniform(edge));
        let errors = plan.some(&ERRORS).map(|&error| Way::ToError(error));
        let vertices = plan.some(&VERTICES).map(|&most| Way::ToVertices(most));
        all.extend(line(&layout, &truth, plan, uniform)?);
        all.extend(line(&layout, &truth, plan, errors)?);
        all.extend(line(&layout, &truth, plan, vertices)?);
    }
    Ok(all)
}

/// Step after step, until one takes longer than there is time for.
fn line(
    layout: &Layout,
    truth: &Truth,
    plan: &Plan,
    ways: impl Iterator<Item = Way>,
) -> Result<Vec<Used>, BakeError> {
    // Bakes to vertices take some tens of times as long as the solutions the limit is made for.
    let limit = 20.0 * plan.limit;
    let mut line: Vec<Used> = Vec::new();
    for way in ways {
        let used = point(layout, truth, way, plan.runs.min(3))?;
        let last = used.seconds > limit;
        line.push(used);
        if last {
            break;
        }
    }
    Ok(line)
}

fn point(layout: &Layout, truth: &Truth, way: Way, runs: u32) -> Result<Used, BakeError> {
    let scene = layout.scene().validate()?;
    let mut baked: Vec<(Bake, f64)> = Vec::new();
    for seed in 1..=runs {
        let start = Instant::now();
        let run = bake(&scene, &way.settings(seed), &())?;
        baked.push((run, start.elapsed().as_secs_f64()));
    }
    let of = |figure: &dyn Fn(&(Bake, f64)) -> f64| median(baked.iter().map(figure));
    Ok(Used {
        scene: layout.name,
        way,
        vertices: of(&|(b, _)| b.report.counts.vertices as f64),
        triangles: of(&|(b, _)| triangles(layout, b) as f64),
        rays: of(&|(b, _)| b.report.work.rays() as f64),
        seconds: of(&|(_, seconds)| *seconds),
        error: of(&|(b, _)| measure(layout, truth, b, POINTS).rmse),
        estimate: of(&|(b, _)| b.report.error.total.into()),
        stopped: baked
            .first()
            .map_or_else(String::new, |(b, _)| format!("{:?}", b.report.stopped)),
    })
}

fn triangles(layout: &Layout, baked: &Bake) -> usize {
    let parts = layout.parts.iter().zip(&baked.objects);
    let of = parts
        .map(|(part, o)| (o.mesh.as_ref()).map_or(2 * part.faces.len(), |m| m.triangles.len()));
    of.sum()
}

/// The table for other programs.
pub(crate) fn csv(all: &[Used]) -> String {
    let header = "scene,way,step,vertices,triangles,rays,seconds,error,estimated_error,stopped";
    table(header, all, |u| {
        let what = [cell(u.scene), cell(u.way.name()), cell(u.way.step())];
        let figures = [
            u.vertices,
            u.triangles,
            u.rays,
            u.seconds,
            u.error,
            u.estimate,
        ]
        .map(cell);
        what.into_iter()
            .chain(figures)
            .chain([cell(&u.stopped)])
            .collect()
    })
}

/// The names of the scenes, in their order.
fn scenes(all: &[Used]) -> Vec<&'static str> {
    let mut names: Vec<&str> = all.iter().map(|u| u.scene).collect();
    names.dedup();
    names
}

fn file(scene: &str, what: &str) -> String {
    format!(
        "refinement_{}_{what}.svg",
        scene.to_lowercase().replace(' ', "_")
    )
}

/// Error by a cost, a line for each way.
fn lines(all: &[Used], scene: &str, cost: fn(&Used) -> f64) -> Vec<Series> {
    let line = |(kind, name): (usize, &&str)| {
        let of = all
            .iter()
            .filter(|u| u.scene == scene && u.way.kind() == kind);
        let dots = of.enumerate().map(|(i, u)| Dot {
            at: (cost(u), u.error),
            label: if i % 4 == 0 {
                u.way.step()
            } else {
                String::new()
            },
        });
        styled(kind, name, dots.collect())
    };
    Way::NAMES.iter().enumerate().map(line).collect()
}

pub(crate) fn charts(all: &[Used]) -> Vec<Named> {
    let mut charts = Vec::new();
    for scene in scenes(all) {
        let vertices = axis("vertices", |v| count(v as u64));
        let by_vertices = lines(all, scene, |u| u.vertices);
        charts.push((
            file(scene, "vertices"),
            against(scene, "vertices", vertices, by_vertices),
        ));
        let time = axis("time of the whole bake (wall clock)", seconds);
        let by_seconds = lines(all, scene, |u| u.seconds);
        charts.push((
            file(scene, "seconds"),
            against(scene, "seconds", time, by_seconds),
        ));
    }
    if !all.is_empty() {
        charts.push(("refinement_asked.svg".into(), asked(all)));
        charts.push(("refinement_cost.svg".into(), cost(all)));
    }
    charts
}

fn against(scene: &str, what: &str, x: Axis, series: Vec<Series>) -> Chart {
    Chart {
        title: format!("{what} used and spread evenly: {scene}"),
        subtitle: "Bare faces; vertices placed by the light, and by the length of edges".into(),
        x,
        y: axis("relative RMSE of the light of vertices", percent),
        front: front(&series, 0.0),
        series,
        guides: Vec::new(),
        floor: None,
    }
}

/// A line for each scene: a figure by the error that was asked for.
fn by_asked(all: &[Used], figure: fn(&Used) -> f64) -> Vec<Series> {
    let line = |(i, scene): (usize, &'static str)| {
        let of = all.iter().filter(|u| u.scene == scene);
        let dots = of.filter_map(|u| match u.way {
            Way::ToError(error) => Some(Dot {
                at: (error.into(), figure(u)),
                label: String::new(),
            }),
            _ => None,
        });
        styled(i, scene, dots.collect())
    };
    scenes(all).into_iter().enumerate().map(line).collect()
}

fn asked(all: &[Used]) -> Chart {
    Chart {
        title: "Errors asked for, and errors there are".into(),
        subtitle: "What lies above the line is more than was asked for".into(),
        x: axis("error asked for (relative RMSE)", percent),
        y: axis("error against the truth (relative RMSE)", percent),
        series: [by_asked(all, |u| u.error), vec![promised(all)]]
            .into_iter()
            .flatten()
            .collect(),
        front: Vec::new(),
        guides: Vec::new(),
        floor: None,
    }
}

/// As much error as was asked for.
fn promised(all: &[Used]) -> Series {
    let errors = all.iter().filter_map(|u| match u.way {
        Way::ToError(error) => Some(f64::from(error)),
        _ => None,
    });
    let mut errors: Vec<f64> = errors.collect();
    errors.sort_by(f64::total_cmp);
    errors.dedup();
    let dot = |error: f64| Dot {
        at: (error, error),
        label: String::new(),
    };
    styled(4, "as asked for", errors.into_iter().map(dot).collect())
}

fn cost(all: &[Used]) -> Chart {
    Chart {
        title: "What an error costs".into(),
        subtitle: "A little less error should cost a little more time".into(),
        x: axis("error asked for (relative RMSE)", percent),
        y: axis("time of the whole bake (wall clock)", seconds),
        series: by_asked(all, |u| u.seconds),
        front: Vec::new(),
        guides: Vec::new(),
        floor: None,
    }
}

/// The chapter of the report: what even spreading takes, and what use takes, to the same errors.
pub(crate) fn chapter(all: &[Used], folder: &str) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "Scenes of bare faces, with no vertices but their corners: edges split evenly, against \
         vertices placed by the light. The truth is exact direct light and a fine bake of the rest. \
         – where an error was not reached.\n\n",
    );
    let header = [
        "scene",
        "error",
        "vertices, uniform",
        "used",
        "time, uniform",
        "used",
    ];
    let rows = scenes(all)
        .into_iter()
        .flat_map(|scene| GOALS.map(|goal| row(all, scene, goal)));
    text += &markdown::table(&markdown::strings(&header), rows);
    for (name, chart) in charts(all) {
        text += &format!("\n![{}]({folder}/{name})\n", chart.title);
    }
    text
}

fn row(all: &[Used], scene: &str, goal: f64) -> Vec<String> {
    let least = |kinds: &[usize], cost: fn(&Used) -> f64, tell: fn(f64) -> String| {
        let of = all
            .iter()
            .filter(|u| u.scene == scene && kinds.contains(&u.way.kind()));
        let points: Vec<(f64, f64)> = of.map(|u| (cost(u), u.error)).collect();
        cost_of(goal, &points).map_or_else(|| "–".into(), tell)
    };
    let vertices = |kinds: &[usize]| least(kinds, |u| u.vertices, |v| count(v as u64));
    let time = |kinds: &[usize]| least(kinds, |u| u.seconds, seconds);
    vec![
        scene.into(),
        percent(goal),
        vertices(&[0]),
        vertices(&[1, 2]),
        time(&[0]),
        time(&[1, 2]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn used(way: Way, vertices: f64, error: f64) -> Used {
        Used {
            scene: "court",
            way,
            vertices,
            triangles: 2.0 * vertices,
            rays: 64.0 * vertices,
            seconds: 1e-3 * vertices,
            error,
            estimate: error,
            stopped: "Error".into(),
        }
    }

    #[test]
    fn goals_are_read_off_the_lines() {
        let all = [
            used(Way::Uniform(0.4), 1000.0, 0.05),
            used(Way::Uniform(0.2), 4000.0, 0.025),
            used(Way::ToError(0.05), 100.0, 0.05),
            used(Way::ToError(0.02), 400.0, 0.02),
        ];
        assert_eq!(
            row(&all, "court", 0.05)[2..],
            ["1,000", "100", "1 s", "100 ms"]
        );
        assert_eq!(row(&all, "court", 0.02)[2..4], ["–", "400"]);
        let table = csv(&all);
        assert!(table.lines().all(|l| l.split(',').count() == 10), "{table}");
        assert_eq!(charts(&all).len(), 4);
        assert!(chapter(&all, "accuracy").contains("refinement_court_vertices.svg"));
        assert!(chapter(&[], "accuracy").is_empty());
    }
}

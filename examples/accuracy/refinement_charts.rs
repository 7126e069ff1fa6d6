//! What charts and the report say of vertices used.

use crate::chart::{Axis, Chart, Dot, Series};
use crate::charts::{Named, axis, front, styled};
use crate::markdown;
use crate::metrics::cost_of;
use crate::refinement::{Used, Way};
use crate::results::GOALS;
use crate::text::{count, percent, seconds};

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
    use crate::refinement::csv;

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

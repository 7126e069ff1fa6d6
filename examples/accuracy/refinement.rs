//! Vertices used against vertices spread evenly, at equal error: what it is worth to put them where
//! the light needs them, and what an error costs that is asked for.

use std::time::Instant;

use bevy_fresco::radiosity::{Bake, BakeError, BakeSettings, bake};

use crate::csv::{cell, table};
use crate::known::error::measure;
use crate::known::layout::Layout;
use crate::known::scenes::{CARE, cornell_box, court, gallery, room_with_panel};
use crate::known::truth::Truth;
use crate::metrics::median;
use crate::plan::Plan;
use crate::text::{count, percent};

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
const LEAST_ERROR: f32 = 0.004;

/// More than any step has.
const MOST_VERTICES: u32 = 10_000_000;

/// Points at which a bake is compared with the truth.
const POINTS: usize = 40_000;

impl Way {
    pub(crate) const NAMES: [&str; 3] = ["uniform", "used, to an error", "used, to vertices"];

    pub(crate) fn kind(self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::ToError(_) => 1,
            Self::ToVertices(_) => 2,
        }
    }

    fn name(self) -> &'static str {
        Self::NAMES[self.kind()]
    }

    pub(crate) fn step(self) -> String {
        match self {
            Self::Uniform(edge) => format!("{edge} m"),
            Self::ToError(error) => percent(f64::from(error)),
            Self::ToVertices(vertices) => count(vertices.into()),
        }
    }

    /// For other programs.
    fn value(self) -> String {
        match self {
            Self::Uniform(edge) => edge.to_string(),
            Self::ToError(error) => error.to_string(),
            Self::ToVertices(vertices) => vertices.to_string(),
        }
    }

    /// How many times the vertices of an earlier step.
    fn growth(self, before: Self) -> f64 {
        match (self, before) {
            (Self::Uniform(edge), Self::Uniform(longer)) => f64::from(longer / edge).powi(2),
            (Self::ToError(error), Self::ToError(larger)) => f64::from(larger / error),
            (Self::ToVertices(most), Self::ToVertices(fewer)) => f64::from(most) / f64::from(fewer),
            _ => 1.0,
        }
    }

    fn settings(self, seed: u32) -> BakeSettings {
        let plain = BakeSettings {
            seed,
            ..BakeSettings::BALANCED
        };
        match self {
            // Time ends the line, not how many there may be.
            Self::Uniform(edge) => BakeSettings {
                refine: false,
                max_edge: Some(edge),
                max_vertices: MOST_VERTICES,
                ..plain
            },
            Self::ToError(error) => BakeSettings { error, ..plain },
            Self::ToVertices(max_vertices) => BakeSettings {
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

/// Step after step, until there is no time for the next one.
fn line(
    layout: &Layout,
    truth: &Truth,
    plan: &Plan,
    ways: impl Iterator<Item = Way>,
) -> Result<Vec<Used>, BakeError> {
    // Bakes to vertices take some tens of times as long as the solutions the limit is made for.
    let limit = 40.0 * plan.limit;
    let runs = if plan.quick { 1 } else { 3 };
    let mut line: Vec<Used> = Vec::new();
    for way in ways {
        let expected = (line.last()).map_or(0.0, |before| before.seconds * way.growth(before.way));
        if expected > limit {
            break;
        }
        line.push(point(layout, truth, way, runs)?);
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
        let what = [cell(u.scene), cell(u.way.name()), u.way.value()];
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

//! Vertices where relief needs them against vertices spread evenly: triangles and time to an error.

use std::error::Error;
use std::f32::consts::TAU;
use std::time::Instant;

use bevy_fresco::displacement::{
    Base, Displaced, DisplacementSettings, Spacing, Tessellation, displace,
};
use bevy_fresco::height_map::{HeightMap, Wrap};
use glam::{Vec2, Vec3};

use crate::chart::{Chart, Dot, Series};
use crate::charts::{Named, axis, styled};
use crate::csv::{cell, table};
use crate::displaced_error::error_of_plane;
use crate::plan::Plan;
use crate::text::{count, seconds};

/// Texels a side of the maps.
const TEXELS: u32 = 1024;

/// Points a side at which results are compared with their maps; no multiple of the texels.
const POINTS: u32 = 1500;

/// Texels between vertices.
const SPACINGS: [f32; 7] = [64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0];

/// In metres, on a square of 1 m with relief of 5 cm.
const TOLERANCES: [f32; 9] = [1e-2, 3e-3, 1e-3, 5e-4, 3e-4, 1e-4, 5e-5, 2e-5, 1e-5];

/// A line ends with a run that takes longer than this, in seconds.
const PATIENCE: f64 = 1.5;

/// Maps that are displaced, and what they are called.
const RELIEFS: [(&str, fn(Vec2) -> f32); 3] = [
    ("a hill on a twentieth", hill),
    ("tiles with joints", tiles),
    ("waves all over", waves),
];

/// The methods.
const WAYS: [&str; 2] = ["uniform", "adaptive"];

/// One run.
pub(crate) struct Raised {
    relief: &'static str,
    way: usize,
    /// Texels or metres.
    step: f32,
    triangles: f64,
    bytes: f64,
    /// The least of several runs: whatever else a machine does only adds.
    seconds: f64,
    /// The largest distance from the relief to the mesh, in metres.
    error: f64,
}

fn hill(at: Vec2) -> f32 {
    let r = at.distance(Vec2::new(0.6, 0.35)) / 0.126;
    match r < 1.0 {
        true => (1.0 - r * r).powi(2) * (0.6 + 0.4 * (40.0 * at.x).sin() * (40.0 * at.y).cos()),
        false => 0.0,
    }
}

/// Flat tiles, their joints a twentieth of them, with round edges.
fn tiles(at: Vec2) -> f32 {
    let to_joint = (4.0 * at)
        .fract()
        .min(1.0 - (4.0 * at).fract())
        .min_element();
    let t = ((to_joint - 0.02) / 0.04).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn waves(at: Vec2) -> f32 {
    0.5 + 0.25 * (TAU * 9.0 * at.x).sin() + 0.25 * (TAU * (4.0 * at.x + 7.0 * at.y)).cos()
}

/// Displaces a square of 1 m by every map, with both methods at all steps.
pub(crate) fn study(plan: &Plan, say: impl Fn(&str)) -> Result<Vec<Raised>, Box<dyn Error>> {
    let mut all = Vec::new();
    for (relief, height) in RELIEFS {
        say(relief);
        let at =
            |i: u32| (Vec2::new((i % TEXELS) as f32, (i / TEXELS) as f32) + 0.5) / TEXELS as f32;
        let heights = (0..TEXELS * TEXELS).map(|i| height(at(i)));
        let map = HeightMap::new([TEXELS; 2], heights.collect(), [Wrap::Repeat; 2])?;
        for &spacing in plan.some(&SPACINGS) {
            let uniform = Tessellation::Uniform(Spacing::Texels(spacing));
            all.push(run(plan, (relief, 0, spacing), &map, uniform)?);
        }
        for &tolerance in plan.some(&TOLERANCES) {
            let adaptive = Tessellation::Adaptive { tolerance };
            let raised = run(plan, (relief, 1, tolerance), &map, adaptive)?;
            let late = raised.seconds > PATIENCE;
            all.push(raised);
            if late {
                break;
            }
        }
    }
    Ok(all)
}

fn run(
    plan: &Plan,
    (relief, way, step): (&'static str, usize, f32),
    map: &HeightMap,
    tessellation: Tessellation,
) -> Result<Raised, Box<dyn Error>> {
    let settings = DisplacementSettings {
        tessellation,
        ..DisplacementSettings::default()
    };
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let square = Base {
        positions: &corners,
        normals: &[Vec3::Z; 4],
        uvs: &[Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
        triangles: &[[0, 1, 2], [0, 2, 3]],
    };
    let mut least = f64::INFINITY;
    let mut displaced = Displaced::default();
    for _ in 0..plan.runs {
        let start = Instant::now();
        displaced = displace(&[square], map, &settings, &())?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    let error = error_of_plane(&displaced, map, &settings, POINTS);
    Ok(Raised {
        relief,
        way,
        step,
        triangles: displaced.report.triangles as f64,
        bytes: displaced.report.bytes as f64,
        seconds: least,
        error: error.into(),
    })
}

pub(crate) fn csv(all: &[Raised]) -> String {
    let header = "relief,way,step,triangles,bytes,seconds,error";
    table(header, all, |r| {
        let what = [cell(r.relief), cell(WAYS[r.way]), r.step.to_string()];
        let figures = [r.triangles, r.bytes, r.seconds, r.error].map(cell);
        what.into_iter().chain(figures).collect()
    })
}

/// Error by triangles and by time, for each map.
pub(crate) fn charts(all: &[Raised]) -> Vec<Named> {
    let mut charts = Vec::new();
    for (relief, _) in RELIEFS {
        for (what, x, cost) in [
            (
                "triangles",
                axis("triangles", |v| count(v as u64)),
                (|r| r.triangles) as fn(&Raised) -> f64,
            ),
            ("seconds", axis("time (wall clock)", seconds), |r| r.seconds),
        ] {
            let file = format!("displacement_{}_{what}.svg", relief.replace(' ', "_"));
            let chart = Chart {
                title: format!("Error by {what}: {relief}"),
                subtitle: format!("1 m × 1 m, relief of 5 cm, a map of {TEXELS}² texels"),
                x,
                y: axis("largest distance from the relief", millimetres),
                series: lines(all, relief, cost),
                front: Vec::new(),
                guides: Vec::new(),
                floor: None,
            };
            charts.push((file, chart));
        }
    }
    charts
}

fn lines(all: &[Raised], relief: &str, cost: fn(&Raised) -> f64) -> Vec<Series> {
    let line = |(way, name): (usize, &&str)| {
        let of = all.iter().filter(|r| r.relief == relief && r.way == way);
        let dots = of.map(|r| Dot {
            at: (cost(r), r.error),
            label: match way {
                0 => format!("{} texels", r.step),
                _ => String::new(),
            },
        });
        styled(way, name, dots.collect())
    };
    WAYS.iter().enumerate().map(line).collect()
}

fn millimetres(metres: f64) -> String {
    format!("{} mm", (1e3 * metres * 1e6).round() / 1e6)
}

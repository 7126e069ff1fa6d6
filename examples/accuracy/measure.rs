//! A run, what it took, and the median of several.

use std::time::{Duration, Instant};

use bevy_fresco::radiosity::{
    BakeError, BakeSettings, ElementLight, Report, Stage, ValidScene, solve_elements,
};
use glam::Vec3;

use crate::metrics::median;

/// Time in seconds and memory in bytes. Absent where the system does not tell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cost {
    pub(crate) wall: f64,
    /// Of all threads together.
    pub(crate) cpu: Option<f64>,
    /// Meshing and the ray hierarchy.
    pub(crate) build: f64,
    pub(crate) form_factors: f64,
    pub(crate) direct: f64,
    pub(crate) solve: f64,
    /// The bake's own tables.
    pub(crate) bytes: f64,
    /// Most memory that the process held.
    pub(crate) resident: Option<f64>,
}

impl Cost {
    /// Seconds that a method of finding form factors answers for.
    pub(crate) fn bounces(&self) -> f64 {
        self.form_factors + self.solve
    }

    /// Seconds from geometry to light, without building the ray hierarchy.
    pub(crate) fn light(&self) -> f64 {
        self.bounces() + self.direct
    }

    /// The median of each figure.
    pub(crate) fn median(runs: &[Self]) -> Self {
        let of = |figure: fn(&Self) -> f64| median(runs.iter().map(figure));
        let maybe = |figure: fn(&Self) -> Option<f64>| {
            let known: Option<Vec<f64>> = runs.iter().map(figure).collect();
            known.map(median)
        };
        Self {
            wall: of(|c| c.wall),
            cpu: maybe(|c| c.cpu),
            build: of(|c| c.build),
            form_factors: of(|c| c.form_factors),
            direct: of(|c| c.direct),
            solve: of(|c| c.solve),
            bytes: of(|c| c.bytes),
            resident: maybe(|c| c.resident),
        }
    }
}

/// Solves for the light of elements and says what that took.
pub(crate) fn solve(
    scene: &ValidScene,
    settings: &BakeSettings,
) -> Result<(ElementLight, Cost), BakeError> {
    forget_peak_memory();
    let (start, used) = (Instant::now(), cpu_seconds());
    let light = solve_elements(scene, settings, &())?;
    let wall = start.elapsed().as_secs_f64();
    let cpu = cpu_seconds().zip(used).map(|(now, before)| now - before);
    let stages = |wanted: &[Stage]| stage_seconds(&light.report, wanted);
    let cost = Cost {
        wall,
        cpu,
        build: stages(&[Stage::Mesh, Stage::Occlusion]),
        form_factors: stages(&[Stage::FormFactors]),
        direct: stages(&[Stage::Direct]),
        solve: stages(&[Stage::Solve]),
        bytes: light.report.bytes as f64,
        resident: peak_memory(),
    };
    Ok((light, cost))
}

fn stage_seconds(report: &Report, wanted: &[Stage]) -> f64 {
    let times = report.stages.iter().filter(|s| wanted.contains(&s.0));
    times.map(|s| s.1).sum::<Duration>().as_secs_f64()
}

/// What the eye makes of linear sRGB.
pub(crate) fn luminance(color: Vec3) -> f64 {
    f64::from(color.dot(Vec3::new(0.2126, 0.7152, 0.0722)))
}

/// Seconds that all threads of the process have run, where Linux tells.
fn cpu_seconds() -> Option<f64> {
    let mut total = 0.0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        let told = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        total += told.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    Some(total * 1e-9)
}

/// Lets the system count the peak anew. Where it cannot, the peak is of all runs so far.
fn forget_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024.0)
}

use std::time::Duration;

use crate::displacement::{DisplacementReport, Stop};
use crate::gltf::MeshSurface;
use crate::text::{counted, percent, seconds, short};

/// What was done, and what to know about it.
#[derive(Debug, Default)]
pub(super) struct Done {
    pub(super) lines: Vec<String>,
    pub(super) notes: Vec<String>,
}

impl Done {
    /// A mesh, or part of it; `tolerance` was asked for, in its units as the report is.
    pub(super) fn add(
        &mut self,
        mesh: &MeshSurface,
        tolerance: f32,
        report: &DisplacementReport,
        time: Duration,
    ) {
        let before = mesh
            .primitives
            .iter()
            .map(|p| p.triangles.len() as u64)
            .sum();
        let mut line = format!(
            "{}: {} became {} with {}, in {}",
            mesh.name,
            counted(before, "triangle"),
            counted(report.triangles, "triangle"),
            counted(report.vertices, "vertex"),
            seconds(time)
        );
        if let Some(error) = report.error {
            let metres = f64::from(error) * mesh.scale;
            line.push_str(&format!("; error at most {} mm", short(1e3 * metres)));
        }
        self.lines.push(line);
        self.note_stop(mesh, tolerance, report);
        self.note_mended(mesh, tolerance, report);
    }

    fn note_stop(&mut self, mesh: &MeshSurface, tolerance: f32, report: &DisplacementReport) {
        let limit = match report.stop {
            Stop::Reached => return,
            Stop::Triangles => "--max-triangles",
            Stop::Memory => "--max-memory",
            Stop::Finest => {
                self.notes.push(format!(
                    "{}: faces are as small as they get, a sixteenth of a texel, and the error is above \
                     the tolerance: raise --tolerance, or smooth the map",
                    mesh.name
                ));
                return;
            }
        };
        let name = &mesh.name;
        self.notes.push(match report.density {
            Some(density) => format!(
                "{name}: there was room for {} of the density asked for: raise {limit}, or ask for less",
                percent(density)
            ),
            None => format!(
                "{name}: there was no room to reach {} mm: raise {limit} or --tolerance",
                short(1e3 * f64::from(tolerance) * mesh.scale)
            ),
        });
    }

    fn note_mended(&mut self, mesh: &MeshSurface, tolerance: f32, report: &DisplacementReport) {
        let mut note = |number: u64, noun: &str, what: &str| {
            if number > 0 {
                self.notes
                    .push(format!("{}: {} {what}", mesh.name, counted(number, noun)));
            }
        };
        note(
            report.folded,
            "vertex",
            "at which the surface folds through itself: lower --scale, or --clamp-folds",
        );
        note(
            report.clamped,
            "vertex",
            "kept below where the surface would fold",
        );
        note(
            report.zero_area,
            "triangle",
            "without area, which only moved with the others",
        );
        note(
            report.mended_normals,
            "normal",
            "without direction, made from the faces",
        );
        note(
            report.undirected,
            "place",
            "whose normals cancel out, and which stayed: sheets back to back have no outside",
        );
        if report.seam_gap > tolerance {
            let gap = f64::from(report.seam_gap) * mesh.scale;
            self.notes.push(format!(
                "{}: the map does not fit at texture seams, heights differ by up to {} mm there and the \
                 mean was taken",
                mesh.name,
                short(1e3 * gap)
            ));
        }
    }
}

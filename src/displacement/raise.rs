//! From the tessellated base to the displaced mesh.

use glam::Vec3;

use super::frame::folds;
use super::heights::Heights;
use super::report::{DisplacementReport, Stop};
use super::settings::{DisplacementSettings, result_bytes};
use super::surface::{Sheet, Surface};
use super::tessellated::{Tessellated, Twins};
use super::{Bounds, Displaced, DisplacedPart, DisplacementError, Watch};
use crate::height_map::Relief;
use crate::mesh::SurfacePoint;
use crate::parallel::fill;

/// Vertices a thread takes at a time.
const CHUNK: usize = 4096;

/// Vertices of all parts, numbered through.
struct Vertices<'a> {
    surface: &'a Surface<'a>,
    tessellated: &'a Tessellated,
    first: Vec<u32>,
}

impl<'a> Vertices<'a> {
    fn count(&self) -> usize {
        self.tessellated.vertex_count()
    }

    fn get(&self, vertex: usize) -> (&Sheet<'a>, SurfacePoint) {
        let part = self.first.partition_point(|&f| f as usize <= vertex) - 1;
        // Parts without vertices begin where the next one does.
        let point = self.tessellated.parts[part].vertices[vertex - self.first[part] as usize];
        (&self.surface.sheets[part], point)
    }
}

/// Raises all vertices: heights, then positions, then normals, each the same for all vertices at one place.
pub(super) fn raise(
    surface: &Surface,
    heights: &Heights,
    tessellated: Tessellated,
    settings: &DisplacementSettings,
    watch: &dyn Watch,
) -> Result<Displaced, DisplacementError> {
    let vertices = Vertices {
        surface,
        first: tessellated.first_vertices(),
        tessellated: &tessellated,
    };
    let mut report = DisplacementReport {
        vertices: vertices.count() as u64,
        triangles: tessellated.triangle_count() as u64,
        zero_area: surface.zero_area,
        mended_normals: surface.mended_normals,
        undirected: surface.undirected,
        ..DisplacementReport::default()
    };
    report.bytes = result_bytes(report.vertices, report.triangles);

    let mut reliefs = vec![Relief::default(); vertices.count()];
    fill(&mut reliefs, CHUNK, |v| {
        let (sheet, point) = vertices.get(v);
        heights.at(sheet.uv(point))
    });
    go_on(watch, 0.3)?;
    report.seam_gap = join_heights(&mut reliefs, &tessellated.twins);
    if settings.clamp_folds {
        report.clamped = clamp_folds(&vertices, &mut reliefs);
    }
    let mut positions = vec![Vec3::ZERO; vertices.count()];
    fill(&mut positions, CHUNK, |v| {
        let (sheet, point) = vertices.get(v);
        let [base, direction] = sheet.rail(point);
        base + reliefs[v].height * direction
    });
    join_positions(&mut positions, &tessellated.twins);
    go_on(watch, 0.6)?;
    // Normals, and whether the surface folds there.
    let mut normals = vec![(Vec3::ZERO, false); vertices.count()];
    fill(&mut normals, CHUNK, |v| {
        let (sheet, point) = vertices.get(v);
        let (normal, frame) = sheet.frame(point);
        let [_, direction] = sheet.rail(point);
        let folded = folds(frame.curvatures(normal), reliefs[v].height);
        (frame.raised_normal(normal, direction, reliefs[v]), folded)
    });
    report.folded = normals.iter().filter(|(_, folded)| *folded).count() as u64;
    let mut normals: Vec<Vec3> = normals.into_iter().map(|(normal, _)| normal).collect();
    join_normals(&vertices, &mut normals, settings.crease_angle);
    go_on(watch, 1.0)?;

    report.stop = Stop::Reached;
    Ok(assemble(tessellated, &positions, &normals, report))
}

fn go_on(watch: &dyn Watch, done: f32) -> Result<(), DisplacementError> {
    match watch.goes_on("displace", done) {
        true => Ok(()),
        false => Err(DisplacementError::Cancelled),
    }
}

/// Makes the mean of the heights at a place the height of all; the largest difference there was.
fn join_heights(reliefs: &mut [Relief], twins: &Twins) -> f32 {
    let mut gap = 0.0_f32;
    for group in twins.groups() {
        let of = |&v: &u32| reliefs[v as usize].height;
        let sum: f64 = group.iter().map(|v| f64::from(of(v))).sum();
        let lowest = group.iter().map(of).fold(f32::INFINITY, f32::min);
        let highest = group.iter().map(of).fold(f32::NEG_INFINITY, f32::max);
        gap = gap.max(highest - lowest);
        // Where all agree their height goes through bit by bit.
        let mean = match lowest == highest {
            true => lowest,
            false => (sum / group.len() as f64) as f32,
        };
        group
            .iter()
            .for_each(|&v| reliefs[v as usize].height = mean);
    }
    gap
}

/// Keeps heights below where the surface folds; at how many vertices it had to.
fn clamp_folds(vertices: &Vertices, reliefs: &mut [Relief]) -> u64 {
    let mut kept = vec![0.0_f32; reliefs.len()];
    fill(&mut kept, CHUNK, |v| {
        let (sheet, point) = vertices.get(v);
        let (normal, frame) = sheet.frame(point);
        frame.unfolded(normal, reliefs[v].height)
    });
    for group in vertices.tessellated.twins.groups() {
        let of = |&v: &u32| kept[v as usize];
        let least = group
            .iter()
            .map(of)
            .min_by(|a, b| a.abs().total_cmp(&b.abs()));
        let least = least.unwrap_or_default();
        group.iter().for_each(|&v| kept[v as usize] = least);
    }
    let mut clamped = 0;
    for (relief, kept) in reliefs.iter_mut().zip(kept) {
        clamped += u64::from(relief.height != kept);
        relief.height = kept;
    }
    clamped
}

/// Roundings of what is interpolated must not open seams.
fn join_positions(positions: &mut [Vec3], twins: &Twins) {
    for group in twins.groups() {
        let one = positions[group[0] as usize];
        group.iter().for_each(|&v| positions[v as usize] = one);
    }
}

/// Where vertices at a place have normals of the base within the crease angle of each other, all of them get
/// the mean of their normals. Others keep a hard edge between them.
fn join_normals(vertices: &Vertices, normals: &mut [Vec3], crease_angle: f32) {
    let cosine = crease_angle.cos() - 1e-6;
    for group in vertices.tessellated.twins.groups() {
        let base: Vec<Vec3> = (group.iter())
            .map(|&v| {
                let (sheet, point) = vertices.get(v as usize);
                sheet.frame(point).0
            })
            .collect();
        let raised: Vec<Vec3> = group.iter().map(|&v| normals[v as usize]).collect();
        for (&vertex, own) in group.iter().zip(&base) {
            let near = base.iter().zip(&raised);
            let sum: Vec3 = near
                .filter(|(other, _)| own.dot(**other) >= cosine)
                .map(|(_, raised)| *raised)
                .sum();
            if let Some(mean) = sum.try_normalize() {
                normals[vertex as usize] = mean;
            }
        }
    }
}

fn assemble(
    tessellated: Tessellated,
    positions: &[Vec3],
    normals: &[Vec3],
    mut report: DisplacementReport,
) -> Displaced {
    let first = tessellated.first_vertices();
    let parts = tessellated
        .parts
        .into_iter()
        .zip(first)
        .map(|(mesh, first)| {
            let range = first as usize..first as usize + mesh.vertices.len();
            DisplacedPart {
                bounds: Bounds::of(&positions[range.clone()]),
                positions: positions[range.clone()].to_vec(),
                normals: normals[range].to_vec(),
                mesh,
            }
        });
    let parts: Vec<DisplacedPart> = parts.collect();
    report.bounds = (parts.iter()).fold(Bounds::default(), |all, part| all.with(part.bounds));
    Displaced { parts, report }
}

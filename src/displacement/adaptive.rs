use glam::{Vec2, Vec3};

use super::deviation::{Deviation, Face};
use super::heights::Heights;
use super::settings::{Budget, result_bytes};
use super::sides::seams;
use super::surface::Surface;
use super::tessellated::{Tessellated, Twins};
use super::{DisplacementError, Stop, Watch};
use crate::height_map::PlanePyramid;
use crate::mesh::{Bisected, Bisection, Conforming, Limits, Part, SurfacePoint};
use crate::parallel::map_chunks;

/// What came of it.
pub(super) struct Adapted {
    pub(super) tessellated: Tessellated,
    /// The largest distance found, in metres.
    pub(super) error: f32,
    pub(super) stop: Stop,
}

/// Faces this small, in texels, are not cut.
const FINEST: f32 = 1.0 / 16.0;

/// Faces a thread judges at a time.
const CHUNK: usize = 64;

/// Most bytes that one more face takes, with a vertex of its own.
const FACE_BYTES: u64 = result_bytes(1, 1);

/// Bisects faces while the raised surface is further than `tolerance` from them.
///
/// If there is too little room for all that are, the worst come first: this begins anew, with half the relief
/// for a limit, which is halved once no face is beyond it.
///
/// ```text
///   limit ──► faces beyond it ──► bisect them, and who shares the edge ─┐
///     ▲              ▲   │ none         heights of new vertices ◄────────┘
///     │ halve it     └───┼──────────────────────┘
///     └──────────────────┴──► it is the tolerance: done
/// ```
pub(super) fn tessellate(
    surface: &Surface,
    heights: Heights,
    tolerance: f32,
    budget: Budget,
    watch: &dyn Watch,
) -> Result<Adapted, DisplacementError> {
    let bounds = PlanePyramid::new(heights.map, heights.kernel);
    let begin = || Work::new(surface, heights, &bounds);
    let mut work = begin();
    let mut full = work.cut_beyond(tolerance, budget, watch)?;
    if full.is_some() {
        work = begin();
        let mut limit = 0.5 * heights.range();
        loop {
            limit = limit.max(tolerance);
            full = work.cut_beyond(limit, budget, watch)?;
            if full.is_some() || limit <= tolerance {
                break;
            }
            limit *= 0.5;
        }
    }
    Ok(work.finish(full, tolerance))
}

/// What is known of a vertex.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    /// On the base.
    position: Vec3,
    direction: Vec3,
    uv: Vec2,
    /// By the map.
    height: f32,
}

struct Work<'a> {
    surface: &'a Surface<'a>,
    deviation: Deviation<'a>,
    heights: Heights<'a>,
    conforming: Conforming,
    /// Which sides of each face lie on seams.
    seams: Vec<[bool; 3]>,
    /// A distance from each face that is beyond the limit, if any is.
    errors: Vec<f32>,
    /// Faces that are not to be cut further.
    stuck: Vec<bool>,
    /// Of each part.
    vertices: Vec<Vec<Vertex>>,
    /// Of each node: sum and number of what its vertices say.
    nodes: Vec<(f64, u32)>,
}

impl<'a> Work<'a> {
    fn new(surface: &'a Surface<'a>, heights: Heights<'a>, bounds: &'a PlanePyramid) -> Self {
        let part = |sheet: &'a super::surface::Sheet<'a>| Part {
            positions: &sheet.positions,
            triangles: sheet.triangles,
            refine: true,
        };
        let parts: Vec<Part> = surface.sheets.iter().map(part).collect();
        let conforming = Conforming::new(&parts, surface.tolerance);
        let faces = conforming.faces() as usize;
        let mut work = Self {
            surface,
            deviation: Deviation::new(heights, bounds),
            heights,
            conforming,
            seams: seams(surface).concat(),
            errors: vec![0.0; faces],
            stuck: vec![false; faces],
            vertices: vec![Vec::new(); surface.sheets.len()],
            nodes: Vec::new(),
        };
        work.know_new_vertices();
        work
    }

    /// Looks up what is to be known of vertices that are new.
    fn know_new_vertices(&mut self) {
        let parts = self.vertices.iter_mut().zip(&self.surface.sheets);
        for (part, (vertices, sheet)) in (0..).zip(parts) {
            let known = vertices.len();
            let points = &self.conforming.points(part)[known..];
            let chunks = map_chunks(points.len(), 16 * CHUNK, |range| {
                let vertex = |&point: &SurfacePoint| {
                    let ([position, direction], uv) = (sheet.rail(point), sheet.uv(point));
                    Vertex {
                        position,
                        direction,
                        uv,
                        height: self.heights.height(uv),
                    }
                };
                points[range].iter().map(vertex).collect::<Vec<_>>()
            });
            vertices.extend(chunks.into_iter().flatten());
            let nodes = self.conforming.nodes(part);
            for (&node, vertex) in nodes.iter().zip(&*vertices).skip(known) {
                if self.nodes.len() <= node as usize {
                    self.nodes.resize(node as usize + 1, (0.0, 0));
                }
                let (sum, count) = &mut self.nodes[node as usize];
                *sum += f64::from(vertex.height);
                *count += 1;
            }
        }
    }

    /// Bisects faces until none is off by more than `limit`; says if there is no room for that.
    fn cut_beyond(
        &mut self,
        limit: f32,
        budget: Budget,
        watch: &dyn Watch,
    ) -> Result<Option<Stop>, DisplacementError> {
        let mut stale: Vec<u32> = (0..self.conforming.faces()).collect();
        let whole = self.area(&stale);
        while !stale.is_empty() {
            let done = 1.0 - self.area(&stale) / whole.max(f32::MIN_POSITIVE);
            if !watch.goes_on("tessellate", done.clamp(0.0, 1.0)) {
                return Err(DisplacementError::Cancelled);
            }
            self.judge(&stale, |deviation, face| deviation.beyond(face, limit));
            stale.retain(|&face| self.errors[face as usize] > limit && !self.stuck[face as usize]);
            let error = |&face: &u32| self.errors[face as usize];
            stale.sort_by(|a, b| error(b).total_cmp(&error(a)).then(a.cmp(b)));
            let full;
            (stale, full) = self.cut(&stale, budget);
            self.know_new_vertices();
            if full.is_some() {
                self.judge(&stale, |deviation, face| deviation.beyond(face, limit));
                return Ok(full);
            }
        }
        Ok(None)
    }

    /// Of faces, on the base.
    fn area(&self, faces: &[u32]) -> f32 {
        let area = |&face: &u32| {
            let [a, b, c] = self.conforming.corners(face);
            0.5 * (b - a).cross(c - a).length()
        };
        faces.iter().map(area).sum()
    }

    fn judge(&mut self, faces: &[u32], error: impl Fn(&Deviation, &Face) -> f32 + Sync) {
        let judged = map_chunks(faces.len(), CHUNK, |range| {
            let error = |&face: &u32| error(&self.deviation, &self.face(face));
            faces[range].iter().map(error).collect::<Vec<_>>()
        });
        for (&face, error) in faces.iter().zip(judged.into_iter().flatten()) {
            self.errors[face as usize] = error;
        }
    }

    /// A face as it is raised now.
    fn face(&self, face: u32) -> Face {
        let part = self.conforming.part(face);
        let corners = self.conforming.vertices(face);
        let nodes = self.conforming.nodes(part);
        let [a, b, c] = corners.map(|v| &self.vertices[part as usize][v as usize]);
        let own = [a.height, b.height, c.height];
        let heights = [0, 1, 2].map(|i| match self.nodes[nodes[corners[i] as usize] as usize] {
            (_, 1) => own[i],
            (sum, count) => (sum / f64::from(count)) as f32,
        });
        Face {
            base: [a.position, b.position, c.position],
            directions: [a.direction, b.direction, c.direction],
            uvs: [a.uv, b.uv, c.uv],
            heights,
            gaps: [0, 1, 2].map(|i| own[i] - heights[i]),
            seams: self.seams[face as usize],
        }
    }

    /// Bisects faces, in this order; which are others now, and whether there was no room for all.
    fn cut(&mut self, asked: &[u32], budget: Budget) -> (Vec<u32>, Option<Stop>) {
        let mut changed: Vec<u32> = Vec::new();
        let mut full = None;
        for &face in asked {
            // What was cut for another is judged before it is cut again.
            if self.errors[face as usize] == 0.0 {
                continue;
            }
            match self.bisect(face, budget, &mut changed) {
                Bisected::Done => {}
                Bisected::Refused => self.stuck[face as usize] = true,
                Bisected::Full => {
                    full = Some(self.what_is_full(budget));
                    break;
                }
            }
        }
        changed.sort_unstable();
        changed.dedup();
        (changed, full)
    }

    fn bisect(&mut self, face: u32, budget: Budget, changed: &mut Vec<u32>) -> Bisected {
        if self.deviation.texels(self.face(face).uvs) < FINEST {
            return Bisected::Refused;
        }
        let faces = u64::from(self.conforming.faces());
        let left = budget.bytes.saturating_sub(self.bytes()) / FACE_BYTES;
        let limits = Limits {
            max_vertices: u32::MAX as usize,
            max_faces: budget.triangles.min(faces + left) as usize,
            min_edge: 0.0,
        };
        let (seams, errors, stuck) = (&mut self.seams, &mut self.errors, &mut self.stuck);
        self.conforming.bisect(face, &limits, &mut |cut| {
            let half = split_seams(&mut seams[cut.face as usize], cut);
            seams.push(half);
            errors.push(0.0);
            errors[cut.face as usize] = 0.0;
            stuck.push(false);
            stuck[cut.face as usize] = false;
            changed.extend([cut.face, cut.half]);
        })
    }

    fn bytes(&self) -> u64 {
        let faces = u64::from(self.conforming.faces());
        result_bytes(self.conforming.vertex_count() as u64, faces)
    }

    fn what_is_full(&self, budget: Budget) -> Stop {
        match budget.bytes.saturating_sub(self.bytes()) < 64 * FACE_BYTES {
            true => Stop::Memory,
            false => Stop::Triangles,
        }
    }

    fn finish(mut self, full: Option<Stop>, tolerance: f32) -> Adapted {
        // Of faces that were left only something beyond the limit is known.
        let beyond = (0..self.conforming.faces()).filter(|&f| self.errors[f as usize] > tolerance);
        let beyond: Vec<u32> = beyond.collect();
        self.judge(&beyond, |deviation, face| {
            deviation.largest(face, tolerance)
        });
        let error = self.errors.iter().copied().fold(0.0, f32::max);
        let stop = full.unwrap_or(match error <= tolerance {
            true => Stop::Reached,
            false => Stop::Finest,
        });
        let mut at_nodes = Vec::new();
        let mut first = 0;
        for part in 0..self.vertices.len() as u32 {
            let nodes = self.conforming.nodes(part);
            let shared = (0..)
                .zip(nodes)
                .filter(|(_, node)| self.nodes[**node as usize].1 > 1);
            at_nodes.extend(shared.map(|(vertex, &node): (u32, _)| (node, first + vertex)));
            first += nodes.len() as u32;
        }
        let parts = self.conforming.into_parts();
        Adapted {
            tessellated: Tessellated {
                parts: parts.into_iter().map(|part| part.mesh).collect(),
                twins: Twins::of_places(at_nodes),
            },
            error,
            stop,
        }
    }
}

/// Splits what is known of a face's sides when it is cut; gives that of the other half.
fn split_seams(face: &mut [bool; 3], cut: Bisection) -> [bool; 3] {
    let edge = usize::from(cut.edge);
    let (next, last) = ((edge + 1) % 3, (edge + 2) % 3);
    let mut half = *face;
    // The cut itself is no seam.
    face[next] = false;
    half[last] = false;
    half
}

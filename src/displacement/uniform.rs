use std::ops::Range;

use glam::Vec3;

use super::Stop;
use super::lattice::Lattice;
use super::settings::{Budget, Spacing, result_bytes};
use super::sides::{goes_up, sides};
use super::surface::{Sheet, Surface};
use super::tessellated::{Tessellated, Twins};
use crate::mesh::{RefinedMesh, SurfacePoint};

/// Into how many pieces all edges are cut.
pub(super) struct Plan {
    edges: Vec<Edge>,
    /// The edge at each side of each triangle of each part.
    of: Vec<Vec<[u32; 3]>>,
    base_vertices: u64,
    /// Share of the density asked for that there was room for.
    pub(super) share: f64,
    /// What there was no room for.
    pub(super) stop: Stop,
}

/// Two vertices of a part that triangles have in common, once for each part and pair of vertices: on texture
/// seams two edges lie on each other, and are cut alike.
struct Edge {
    part: u32,
    /// A triangle that has it, and which of its sides it is.
    triangle: u32,
    side: u8,
    /// The same for edges between the same two places.
    places: u32,
    pieces: u32,
}

/// Steps in which the share of the density is looked for.
const HALVINGS: u32 = 24;

/// What rounding adds to a number of pieces.
const ROUNDING: f64 = 1e-4;

/// Pieces of an edge at most.
const MOST_PIECES: f64 = 16_777_216.0;

impl Plan {
    /// Cuts edges into as many pieces as `wanted` says for the triangles at them, `(part, triangle, side)`; where
    /// these differ, the most. So a triangle matches its neighbours, whatever these were to have. All fewer by
    /// one share if the budget is less than that takes.
    pub(super) fn new(
        surface: &Surface,
        wanted: impl Fn(usize, usize, usize) -> f64,
        budget: Budget,
    ) -> Self {
        let sides = sides(surface);
        let mut of: Vec<Vec<[u32; 3]>> = (surface.sheets.iter())
            .map(|sheet| vec![[0; 3]; sheet.triangles.len()])
            .collect();
        let mut edges: Vec<Edge> = Vec::new();
        let mut asked: Vec<f64> = Vec::new();
        for (number, same_places) in sides.chunk_by(|a, b| a.0 == b.0).enumerate() {
            let mut most = 1.0_f64;
            for same in same_places.chunk_by(|a, b| (a.1, a.2) == (b.1, b.2)) {
                for &(_, part, _, triangle, side) in same {
                    let (part, triangle, side) = (part as usize, triangle as usize, side as usize);
                    of[part][triangle][side] = edges.len() as u32;
                    most = most.max(wanted(part, triangle, side));
                }
                let (places, part, _, triangle, side) = same[0];
                // Where both ends are at one place there is nothing between them.
                let places = if places[0] == places[1] {
                    u32::MAX
                } else {
                    number as u32
                };
                edges.push(Edge {
                    part,
                    triangle,
                    side,
                    places,
                    pieces: 1,
                });
            }
            asked.push(most.min(MOST_PIECES));
        }
        let mut plan = Self {
            edges,
            of,
            base_vertices: surface
                .sheets
                .iter()
                .map(|s| s.positions.len() as u64)
                .sum(),
            share: 1.0,
            stop: Stop::Reached,
        };
        plan.fit(&asked, budget);
        plan
    }

    /// The largest share of the density asked for that there is room for.
    fn fit(&mut self, asked: &[f64], budget: Budget) {
        let stop = |plan: &Self| {
            let (vertices, triangles) = plan.count();
            if triangles > budget.triangles || vertices > u64::from(u32::MAX) {
                Stop::Triangles
            } else if result_bytes(vertices, triangles) > budget.bytes {
                Stop::Memory
            } else {
                Stop::Reached
            }
        };
        self.cut_edges(asked, 1.0);
        self.stop = stop(self);
        if self.stop == Stop::Reached {
            return;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            self.cut_edges(asked, middle);
            match stop(self) {
                Stop::Reached => low = middle,
                // The last of these is what keeps it from being finer.
                full => (high, self.stop) = (middle, full),
            }
        }
        self.cut_edges(asked, low);
        self.share = low;
    }

    fn cut_edges(&mut self, asked: &[f64], share: f64) {
        for edge in &mut self.edges {
            edge.pieces = match edge.places {
                u32::MAX => 1,
                places => ((asked[places as usize] * share - ROUNDING).ceil() as u32).max(1),
            };
        }
    }

    fn lattice(&self, part: usize, triangle: usize) -> Lattice {
        Lattice::new(self.of[part][triangle].map(|e| self.edges[e as usize].pieces))
    }

    /// How many vertices and triangles there will be; vertices that nothing uses are counted, too.
    fn count(&self) -> (u64, u64) {
        let on_edges: u64 = self.edges.iter().map(|e| u64::from(e.pieces) - 1).sum();
        let mut count = (self.base_vertices + on_edges, 0);
        for (part, of) in self.of.iter().enumerate() {
            for triangle in 0..of.len() {
                let lattice = self.lattice(part, triangle);
                count.0 += lattice.inner_vertices();
                count.1 += lattice.triangles();
            }
        }
        count
    }
}

/// Pieces of a side for vertices so far apart. Along texture coordinates it is the one that changes more that
/// counts: a square of `n × n` texels gets `n` pieces a side, and its diagonal as many.
pub(super) fn wanted<'a>(
    surface: &'a Surface,
    spacing: Spacing,
    texels: [u32; 2],
) -> impl Fn(usize, usize, usize) -> f64 + 'a {
    move |part, triangle, side| {
        let sheet = &surface.sheets[part];
        let corners = sheet.triangles[triangle];
        let [a, b] = [corners[side], corners[(side + 1) % 3]].map(|v| v as usize);
        match spacing {
            Spacing::Texels(spacing) => {
                let [u, v] = (sheet.uvs[b] - sheet.uvs[a])
                    .abs()
                    .to_array()
                    .map(f64::from);
                let [width, height] = texels.map(f64::from);
                (u * width).max(v * height) / f64::from(spacing)
            }
            Spacing::Metres(spacing) => {
                let [a, b] = [a, b].map(|v| sheet.positions[v].as_dvec3());
                a.distance(b) / f64::from(spacing)
            }
        }
    }
}

impl Edge {
    /// The points between its ends, from the lower place on.
    fn points(&self, sheet: &Sheet) -> impl Iterator<Item = SurfacePoint> + use<> {
        let (triangle, n) = (self.triangle, self.pieces);
        let side = usize::from(self.side);
        let (low, high) = match goes_up(sheet, triangle as usize, side) {
            true => (side, (side + 1) % 3),
            false => ((side + 1) % 3, side),
        };
        let share = move |i: u32| i as f32 / n as f32;
        (1..n).map(move |i| SurfacePoint {
            triangle,
            barycentrics: Vec3::AXES[low] * share(n - i) + Vec3::AXES[high] * share(i),
        })
    }
}

/// Cuts all triangles as planned. Vertices of a part are those of its base that are used, in their order, then
/// those on edges, then those inside of triangles.
pub(super) fn tessellate(surface: &Surface, plan: &Plan) -> Tessellated {
    let mut edges_of = vec![Vec::new(); surface.sheets.len()];
    for (number, edge) in plan.edges.iter().enumerate() {
        edges_of[edge.part as usize].push(number);
    }
    let mut result = Tessellated::default();
    let mut at_places: Vec<(u32, u32)> = Vec::new();
    // The first vertex on each edge, numbered within its part, and of each part.
    let mut on_edges: Vec<u32> = vec![0; plan.edges.len()];
    let mut first_of_parts = Vec::new();
    let mut first = 0;
    for (part, sheet) in surface.sheets.iter().enumerate() {
        let (mut mesh, new_index) =
            RefinedMesh::with_used_vertices(sheet.positions.len(), sheet.triangles);
        let used = sheet.places.iter().zip(&new_index);
        at_places.extend(used.filter_map(|(&place, new)| new.map(|new| (place, first + new))));
        for &number in &edges_of[part] {
            on_edges[number] = mesh.vertices.len() as u32;
            mesh.vertices.extend(plan.edges[number].points(sheet));
        }
        for triangle in 0..sheet.triangles.len() {
            let corners = sheet.triangles[triangle].map(|v| new_index[v as usize]);
            let corners = corners.map(Option::unwrap_or_default);
            let outer = [0, 1, 2].map(|side| {
                let edge = plan.of[part][triangle][side] as usize;
                let between = on_edges[edge]..on_edges[edge] + plan.edges[edge].pieces - 1;
                let ends = [corners[side], corners[(side + 1) % 3]];
                along(ends, between, goes_up(sheet, triangle, side))
            });
            cut_triangle(
                &mut mesh,
                plan.lattice(part, triangle),
                triangle as u32,
                &outer,
            );
        }
        first_of_parts.push(first);
        first += mesh.vertices.len() as u32;
        result.parts.push(mesh);
    }
    result.twins = Twins::of_places(at_places);
    plan.add_twins(&mut result.twins, &on_edges, &first_of_parts);
    result
}

/// The vertices along a side, both ends among them.
fn along([a, b]: [u32; 2], between: Range<u32>, goes_up: bool) -> Vec<u32> {
    let mut ids = vec![a];
    match goes_up {
        true => ids.extend(between),
        false => ids.extend(between.rev()),
    }
    ids.push(b);
    ids
}

fn cut_triangle(mesh: &mut RefinedMesh, lattice: Lattice, source: u32, outer: &[Vec<u32>; 3]) {
    let first = mesh.vertices.len() as u32;
    let point = |barycentrics| SurfacePoint {
        triangle: source,
        barycentrics,
    };
    mesh.vertices.extend(lattice.inner().map(point));
    let [a, b, c] = outer;
    lattice.cut([a, b, c], first, &mut |corners| {
        mesh.push_triangle(source, corners);
    });
}

impl Plan {
    /// Points of edges that lie on each other.
    fn add_twins(&self, twins: &mut Twins, on_edges: &[u32], first_of_parts: &[u32]) {
        let mut number = 0;
        for group in self.edges.chunk_by(|a, b| a.places == b.places) {
            let edges = number..number + group.len();
            number = edges.end;
            let pieces = group[0].pieces;
            for i in 0..pieces - 1 {
                twins.push(edges.clone().map(|edge| {
                    first_of_parts[self.edges[edge].part as usize] + on_edges[edge] + i
                }));
            }
        }
    }
}

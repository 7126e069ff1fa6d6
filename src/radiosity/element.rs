use std::ops::Range;

use glam::{DVec3, Vec3, Vec3A};

use super::bounds::{Bounds, Sphere};
use super::grouping::{Group, merge};
use super::identity::object_seeds;
use super::occlusion::Hit;
use super::sampling::{hash, sobol, triangle as triangle_point};
use super::surface::Surfaces;
use super::triangle::{area, face_normal};
use super::validate::ValidScene;

/// Index of a radiosity element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ElementId(pub(crate) u32);

/// The pieces of surface that radiosity is solved on, each of constant reflectance and radiosity.
///
/// A triangle much larger than an element is cut into `n²` equal cells; smaller triangles are
/// merged with neighbours across shared edges while the surface stays smooth. So elements have a
/// size of their own, coarser or finer than the mesh, and the element of a ray's hit follows from
/// the triangle and the barycentrics alone. A double-sided surface has an element on each side.
pub(crate) struct Elements {
    /// Reflectance, at most [`BakeSettings::max_reflectance`](super::BakeSettings).
    pub(crate) reflectance: Vec<Vec3>,
    /// Emitted radiance.
    pub(crate) emission: Vec<Vec3>,
    /// Area that stops light, in squared internal units.
    pub(crate) area: Vec<f32>,
    /// Share of the whole area that stops light.
    pub(crate) coverage: Vec<f32>,
    /// How many elements had their reflectance clamped.
    pub(crate) clamped: u32,
    /// First piece of each element, and one past the last.
    first_piece: Vec<u32>,
    pieces: Vec<Piece>,
    cells: Vec<Cells>,
    /// Unit normal of the front of each live triangle.
    normals: Vec<Vec3>,
    /// Where the random numbers of each element start: by its object and its place in it, so that
    /// they stay when other objects come and go.
    seeds: Vec<u32>,
    /// First element of each object, and one past the last.
    first_of_object: Vec<u32>,
}

/// A live triangle or one cell of it, on one side, as part of an element.
#[derive(Clone, Copy)]
struct Piece {
    triangle: u32,
    cell: u32,
    back: bool,
    /// Share of the element's area up to and including this piece.
    cumulative: f32,
}

/// How a live triangle is cut into elements.
#[derive(Clone, Copy, Default)]
struct Cells {
    /// Cells along an edge.
    n: u16,
    /// Element of cell 0 on the front and on the back; the other cells follow.
    front: u32,
    back: Option<u32>,
}

/// A point on an element, from which rays start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ElementPoint {
    pub(crate) triangle: u32,
    pub(crate) position: Vec3,
    /// Unit normal of the element's side.
    pub(crate) normal: Vec3,
}

/// A surface whose front gets less than this share of the light of its back is seen from behind.
pub(crate) const SEEN_FROM_BEHIND: f64 = 0.02;

/// Points at which the reflectance of a cell is read.
const TEXTURE_POINTS: usize = 16;

impl Elements {
    /// Cuts and merges the live triangles into elements of about the area `target`.
    pub(crate) fn new(
        scene: &ValidScene,
        surfaces: &Surfaces,
        target: f32,
        max_reflectance: f32,
    ) -> Self {
        let areas: Vec<f32> = scene
            .triangles
            .iter()
            .map(|&t| area(scene.corners(t)) * f32::from(u8::from(scene.casts(t))))
            .collect();
        let normals: Vec<Vec3> = (scene.triangles.iter())
            .map(|&t| face_normal(scene.corners(t)))
            .collect();
        let groups: Vec<Group> = merge(scene, &areas, &normals, target);
        let mut builder = Builder::new(scene, surfaces, normals, max_reflectance);
        // Light passes what does not cast: no ray finds it.
        for group in groups
            .iter()
            .filter(|g| scene.casts(scene.triangles[g[0] as usize]))
        {
            builder.add(group, &areas, target);
        }
        builder.finish()
    }

    /// Elements without a shape, for tests of the solver.
    #[cfg(test)]
    pub(crate) fn for_test(reflectance: Vec<Vec3>, area: Vec<f32>) -> Self {
        let count = area.len();
        Self {
            reflectance,
            emission: vec![Vec3::ZERO; count],
            area,
            coverage: vec![1.0; count],
            clamped: 0,
            first_piece: vec![0; count + 1],
            pieces: Vec::new(),
            cells: Vec::new(),
            normals: Vec::new(),
            seeds: vec![0; count],
            first_of_object: Vec::new(),
        }
    }

    /// The area of an element for about `count` of them, in squared internal units.
    pub(crate) fn target(scene: &ValidScene, count: u32) -> f32 {
        let casting = scene.triangles.iter().filter(|&&t| scene.casts(t));
        let total: f64 = casting.map(|&t| f64::from(area(scene.corners(t)))).sum();
        (total / f64::from(count.max(1))) as f32
    }

    /// The elements of an object.
    pub(crate) fn of_object(&self, object: usize) -> Range<usize> {
        self.first_of_object[object] as usize..self.first_of_object[object + 1] as usize
    }

    /// A seed for the rays of an element, apart from those of samples and of other elements.
    pub(crate) fn seed(&self, element: ElementId, seed: u32) -> u32 {
        hash(self.seeds[element.0 as usize], hash(seed, 0xE1E3))
    }

    /// A sphere around an element.
    pub(crate) fn sphere(&self, scene: &ValidScene, element: ElementId) -> Sphere {
        Bounds::of(self.shape(scene, element).flat_map(|s| s.1)).sphere()
    }

    /// Whether object `o` has the elements that object `p` has in `other`, but for reflectance and
    /// emission.
    pub(crate) fn same_shapes(&self, o: usize, other: &Self, p: usize) -> bool {
        let (a, b) = (self.of_object(o), other.of_object(p));
        self.area[a.clone()] == other.area[b.clone()]
            && self.coverage[a.clone()] == other.coverage[b.clone()]
            && self.seeds[a.clone()] == other.seeds[b.clone()]
            && a.zip(b).all(|(e, f)| {
                self.pieces_of(ElementId(e as u32)).len()
                    == other.pieces_of(ElementId(f as u32)).len()
                    && self.is_back(e) == other.is_back(f)
            })
    }

    pub(crate) fn len(&self) -> usize {
        self.area.len()
    }

    /// Light that arrives at an object's front and back, times area, and their areas.
    pub(crate) fn light_of_sides(&self, object: usize, arriving: &[Vec3]) -> [(f64, f64); 2] {
        let mut sums = [(0.0, 0.0); 2];
        for e in self.of_object(object) {
            let side = &mut sums[usize::from(self.is_back(e))];
            side.0 += f64::from(arriving[e].element_sum() * self.area[e]);
            side.1 += f64::from(self.area[e]);
        }
        sums
    }

    /// Areas of all elements.
    pub(crate) fn iter_area(&self) -> impl Iterator<Item = f64> + '_ {
        self.area.iter().map(|&a| f64::from(a))
    }

    /// Area-weighted mean of a value.
    pub(crate) fn mean(&self, values: &[Vec3A]) -> DVec3 {
        let sum: DVec3 = values
            .iter()
            .zip(self.iter_area())
            .map(|(v, a)| v.as_dvec3() * a)
            .sum();
        sum / self.iter_area().sum::<f64>().max(f64::MIN_POSITIVE)
    }

    /// Area-weighted mean of light, and mean over channels.
    pub(crate) fn mean_of(&self, light: &[Vec3]) -> f64 {
        let sum: f64 = (self.iter_area().zip(light))
            .map(|(a, l)| a * f64::from(l.element_sum()))
            .sum();
        sum / (3.0 * self.iter_area().sum::<f64>()).max(f64::MIN_POSITIVE)
    }

    /// The element that a ray hit; `None` for the black back of a one-sided surface.
    #[inline]
    pub(crate) fn at(&self, hit: &Hit) -> Option<ElementId> {
        let cells = self.cells[hit.triangle as usize];
        let base = if hit.back { cells.back? } else { cells.front };
        Some(ElementId(base + cell_of(hit.uv, cells.n)))
    }

    fn pieces_of(&self, element: ElementId) -> &[Piece] {
        let e = element.0 as usize;
        &self.pieces[self.first_piece[e] as usize..self.first_piece[e + 1] as usize]
    }

    /// Point `u`, `v` (each 0..1) of an element, area-uniform.
    pub(crate) fn point(
        &self,
        scene: &ValidScene,
        element: ElementId,
        u: f32,
        v: f32,
    ) -> ElementPoint {
        let pieces = self.pieces_of(element);
        let i = pieces
            .partition_point(|p| p.cumulative <= u)
            .min(pieces.len() - 1);
        let below = if i == 0 {
            0.0
        } else {
            pieces[i - 1].cumulative
        };
        // What is left of u after choosing the piece is uniform again.
        let u =
            ((u - below) / (pieces[i].cumulative - below).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let piece = pieces[i];
        let n = self.cells[piece.triangle as usize].n;
        let barycentrics = in_cell(triangle_point(u, v), piece.cell, n);
        let [a, b, c] = scene.corners(scene.triangles[piece.triangle as usize]);
        let normal = self.normals[piece.triangle as usize];
        ElementPoint {
            triangle: piece.triangle,
            position: a * barycentrics.x + b * barycentrics.y + c * barycentrics.z,
            normal: if piece.back { -normal } else { normal },
        }
    }

    /// Live triangles that emit on some side, with whether they emit on both.
    pub(crate) fn emissive_triangles(&self) -> impl Iterator<Item = (u32, bool)> + '_ {
        self.cells.iter().enumerate().filter_map(|(t, cells)| {
            let count = u32::from(cells.n).pow(2);
            let shines =
                (cells.front..cells.front + count).any(|e| self.emission[e as usize] != Vec3::ZERO);
            shines.then_some((t as u32, cells.back.is_some()))
        })
    }

    /// The element of the same surface as a ray's hit would find it.
    #[inline]
    pub(crate) fn side_at(&self, triangle: u32, uv: [f32; 2], back: bool) -> Option<ElementId> {
        self.at(&Hit {
            triangle,
            distance: 0.0,
            uv,
            back,
        })
    }

    /// All elements on a live triangle, of both sides.
    pub(crate) fn of_triangle(&self, triangle: u32) -> impl Iterator<Item = u32> {
        let cells = self.cells[triangle as usize];
        let count = u32::from(cells.n).pow(2);
        let sides = [Some(cells.front), cells.back].into_iter().flatten();
        sides.flat_map(move |first| first..first + count)
    }

    /// Radiance emitted at a point of a live triangle's side.
    pub(crate) fn emission_at(&self, triangle: u32, uv: [f32; 2], back: bool) -> Vec3 {
        self.side_at(triangle, uv, back)
            .map_or(Vec3::ZERO, |e| self.emission[e.0 as usize])
    }

    /// The triangles that an element is made of, each with its live triangle, its corners and the
    /// unit normal of the element's side.
    pub(crate) fn shape<'a>(
        &'a self,
        scene: &'a ValidScene,
        element: ElementId,
    ) -> impl Iterator<Item = (u32, [Vec3; 3], Vec3)> + 'a {
        let pieces = self.pieces_of(element);
        pieces.iter().map(|piece| {
            let n = self.cells[piece.triangle as usize].n;
            let whole = scene.corners(scene.triangles[piece.triangle as usize]);
            let corners = Vec3::AXES.map(|corner| {
                let b = in_cell(corner, piece.cell, n);
                whole[0] * b.x + whole[1] * b.y + whole[2] * b.z
            });
            let side = if piece.back { -1.0 } else { 1.0 };
            (
                piece.triangle,
                corners,
                self.normals[piece.triangle as usize] * side,
            )
        })
    }

    /// Centre of area and mean unit normal of an element.
    pub(crate) fn middle(&self, scene: &ValidScene, element: ElementId) -> (Vec3, Vec3) {
        let (mut center, mut normal, mut total) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for (_, corners, side) in self.shape(scene, element) {
            let area = area(corners);
            center += corners.into_iter().sum::<Vec3>() * (area / 3.0);
            normal += side * area;
            total += area;
        }
        (center / total, normal.normalize_or_zero())
    }

    /// Whether an element is the back of its surface.
    pub(crate) fn is_back(&self, element: usize) -> bool {
        self.pieces[self.first_piece[element] as usize].back
    }

    pub(crate) fn bytes(&self) -> u64 {
        (self.len() * (12 + 12 + 4 + 4 + 4 + 4)
            + self.pieces.len() * 16
            + self.cells.len() * (16 + 12)) as u64
    }
}

struct Builder<'a> {
    scene: &'a ValidScene,
    surfaces: &'a Surfaces<'a>,
    max_reflectance: f32,
    seeds: Vec<u32>,
    elements: Elements,
}

impl<'a> Builder<'a> {
    fn new(
        scene: &'a ValidScene,
        surfaces: &'a Surfaces<'a>,
        normals: Vec<Vec3>,
        max_reflectance: f32,
    ) -> Self {
        Self {
            scene,
            surfaces,
            max_reflectance,
            seeds: object_seeds(scene),
            elements: Elements {
                reflectance: Vec::new(),
                emission: Vec::new(),
                area: Vec::new(),
                coverage: Vec::new(),
                clamped: 0,
                first_piece: vec![0],
                pieces: Vec::new(),
                cells: vec![Cells::default(); scene.triangles.len()],
                normals,
                seeds: Vec::new(),
                first_of_object: vec![0; scene.objects.len() + 1],
            },
        }
    }

    /// Adds the elements of a group: its cells if it is one triangle, else one for all.
    fn add(&mut self, group: &[u32], areas: &[f32], target: f32) {
        let n = match group {
            [one] => (areas[*one as usize] / target)
                .sqrt()
                .round()
                .clamp(1.0, 1000.0) as u16,
            _ => 1,
        };
        let sides = if self.two_sided(group[0]) { 2 } else { 1 };
        for side in 0..sides {
            let base = self.elements.len() as u32;
            for &t in group {
                let cells = &mut self.elements.cells[t as usize];
                cells.n = n;
                if side == 0 {
                    cells.front = base;
                } else {
                    cells.back = Some(base);
                }
            }
            for cell in 0..u32::from(n).pow(2) {
                self.add_element(group, cell, n, side == 1, areas);
            }
        }
    }

    fn two_sided(&self, triangle: u32) -> bool {
        self.scene
            .material(self.scene.triangles[triangle as usize])
            .double_sided
    }

    fn add_element(&mut self, group: &[u32], cell: u32, n: u16, back: bool, areas: &[f32]) {
        let share = 1.0 / f32::from(n).powi(2);
        let whole: f64 = group
            .iter()
            .map(|&t| f64::from(areas[t as usize] * share))
            .sum();
        let (mut reflectance, mut emission, mut covered) = (Vec3::ZERO, Vec3::ZERO, 0.0_f64);
        let mut cumulative = 0.0;
        for &t in group {
            let key = self.scene.triangles[t as usize];
            let seed = hash(key.triangle, cell);
            let points: [Vec3; TEXTURE_POINTS] = std::array::from_fn(|i| {
                let [u, v, ..] = sobol(i as u32, 0, seed);
                in_cell(triangle_point(u, v), cell, n)
            });
            let diffuse = self.surfaces.average(t, &points, share);
            let area = areas[t as usize] * share;
            cumulative += f64::from(area) / whole;
            let weight = area * diffuse.coverage;
            reflectance += diffuse.reflectance * weight;
            emission += diffuse.emission * weight;
            covered += f64::from(weight);
            self.elements.pieces.push(Piece {
                triangle: t,
                cell,
                back,
                cumulative: cumulative as f32,
            });
        }
        let inverse = if covered > 0.0 {
            (1.0 / covered) as f32
        } else {
            0.0
        };
        let object = self.scene.triangles[group[0] as usize].object as usize;
        if !self.scene.objects[object].reflects {
            reflectance = Vec3::ZERO;
        }
        let clamped = (reflectance * inverse).min(Vec3::splat(self.max_reflectance));
        let e = &mut self.elements;
        e.clamped += u32::from(clamped != reflectance * inverse);
        e.reflectance.push(clamped);
        e.emission.push(emission * inverse);
        e.area.push(covered as f32);
        e.coverage.push((covered / whole) as f32);
        e.first_piece.push(e.pieces.len() as u32);
        // Objects follow each other: count here, add up in the end.
        e.seeds
            .push(hash(e.first_of_object[object + 1], self.seeds[object]));
        e.first_of_object[object + 1] += 1;
    }

    fn finish(mut self) -> Elements {
        for o in 1..self.elements.first_of_object.len() {
            self.elements.first_of_object[o] += self.elements.first_of_object[o - 1];
        }
        self.elements
    }
}

/// Which of a triangle's `n²` cells a point lies in.
///
/// ```text
///   v        row i holds 2(n − i) − 1 cells, upright (▲) and
///   |\       inverted (▼) by turns, so rows 0..i hold i(2n − i),
///   |▲\      and cell = i(2n − i) + 2j + (1 if inverted).
///   |▼▲\
///   +---\ u
/// ```
#[inline]
fn cell_of(uv: [f32; 2], n: u16) -> u32 {
    if n <= 1 {
        return 0;
    }
    let n = u32::from(n);
    let [x, y] = uv.map(|c| (c * n as f32).max(0.0));
    let i = (x as u32).min(n - 1);
    let j = (y as u32).min(n - 1 - i);
    let inverted = (x - i as f32) + (y - j as f32) > 1.0 && j + 1 < n - i;
    i * (2 * n - i) + 2 * j + u32::from(inverted)
}

/// The triangle's barycentrics of a point given by its barycentrics in one of `n²` cells.
fn in_cell(point: Vec3, cell: u32, n: u16) -> Vec3 {
    if n <= 1 {
        return point;
    }
    let n = u32::from(n);
    // Rows from i on hold (n − i)² cells: the row is the largest i with n² − cell ≤ (n − i)².
    let left = n * n - cell;
    let mut rows = left.isqrt();
    if rows * rows < left {
        rows += 1;
    }
    let i = n - rows;
    let within = cell - i * (2 * n - i);
    let (j, inverted) = (within / 2, within % 2 == 1);
    let (u, v) = if inverted {
        (1.0 - point.y, 1.0 - point.z)
    } else {
        (point.y, point.z)
    };
    let (u, v) = ((i as f32 + u) / n as f32, (j as f32 + v) / n as f32);
    Vec3::new(1.0 - u - v, u, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_points_are_inverse() {
        for n in [1_u16, 2, 3, 7, 50] {
            let count = u32::from(n).pow(2);
            for cell in 0..count {
                for b in [
                    Vec3::splat(1.0 / 3.0),
                    Vec3::new(0.9, 0.05, 0.05),
                    Vec3::new(0.1, 0.8, 0.1),
                ] {
                    let p = in_cell(b, cell, n);
                    assert!((p.element_sum() - 1.0).abs() < 1e-5 && p.min_element() > -1e-6);
                    assert_eq!(cell_of([p.y, p.z], n), cell, "n {n} point {p}");
                }
            }
        }
    }

    #[test]
    fn every_corner_lies_in_a_cell() {
        for n in [2_u16, 5, 1000] {
            for uv in [
                [0.0, 0.0],
                [1.0, 0.0],
                [0.0, 1.0],
                [0.5, 0.5],
                [-1e-7, 1.0],
                [1.0, 1e-7],
            ] {
                assert!(cell_of(uv, n) < u32::from(n).pow(2));
            }
        }
    }
}

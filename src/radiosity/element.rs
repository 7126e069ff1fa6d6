use std::ops::Range;

use glam::{DVec3, Vec3, Vec3A};

use super::bounds::{Bounds, Sphere};
use super::cells::{CellCut, Cells, Part};
use super::color::luminance;
use super::element_builder::Builder;
use super::layout::Layout;
use super::level::Level;
use super::occlusion::Hit;
use super::sampling::{hash, triangle as triangle_point};
use super::spot::Spot;
use super::surface::Surfaces;
use super::triangle::area;
use super::validate::ValidScene;

/// Index of a radiosity element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ElementId(pub(crate) u32);

/// The pieces of surface that radiosity is solved on, each of constant reflectance and radiosity.
///
/// A triangle much larger than an element is cut into equal cells, and these into parts where the
/// light asks for it; smaller triangles are merged with neighbours across shared edges while the
/// surface stays smooth. So elements have a size of their own, coarser or finer than the mesh, and
/// the element of a ray's hit follows from the triangle and the barycentrics alone. A double-sided
/// surface has an element on each side.
pub(crate) struct Elements {
    /// Reflectance, at most [`BakeSettings::max_reflectance`](super::BakeSettings).
    pub(crate) reflectance: Vec<Vec3>,
    /// Emitted radiance.
    pub(crate) emission: Vec<Vec3>,
    /// Area that stops light, in squared internal units.
    pub(crate) area: Vec<f32>,
    /// Share of the whole area that stops light.
    pub(crate) coverage: Vec<f32>,
    /// How many rays each element casts, where form factors are made of rays.
    pub(crate) rays: Vec<u16>,
    /// Which patch of its object each element is part of.
    pub(crate) patch: Vec<u32>,
    /// How many elements had their reflectance clamped.
    pub(crate) clamped: u32,
    /// First piece of each element, and one past the last.
    pub(super) first_piece: Vec<u32>,
    pub(super) pieces: Vec<Piece>,
    pub(super) cells: Vec<Cells>,
    pub(super) cuts: Vec<CellCut>,
    /// Unit normal of the front of each live triangle.
    pub(super) normals: Vec<Vec3>,
    /// Where the random numbers of each element start: by its object and its place in it, so that
    /// they stay when other objects come and go.
    pub(super) seeds: Vec<u32>,
    /// First element of each object, and one past the last.
    pub(super) first_of_object: Vec<u32>,
}

/// A live triangle or a part of it, on one side, as part of an element.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub(super) triangle: u32,
    pub(super) cell: u32,
    pub(super) sub: u8,
    pub(super) m: u8,
    pub(super) back: bool,
    /// Share of the element's area up to and including this piece.
    pub(super) cumulative: f32,
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

impl Elements {
    /// Cuts and merges the live triangles into the elements that `layout` asks for.
    pub(crate) fn new(
        scene: &ValidScene,
        surfaces: &Surfaces,
        layout: &Layout,
        max_reflectance: f32,
    ) -> Self {
        Builder::new(scene, surfaces, layout, max_reflectance).build()
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
            rays: vec![1; count],
            patch: vec![0; count],
            clamped: 0,
            first_piece: vec![0; count + 1],
            pieces: Vec::new(),
            cells: Vec::new(),
            cuts: Vec::new(),
            normals: Vec::new(),
            seeds: vec![0; count],
            first_of_object: Vec::new(),
        }
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
            && self.rays[a.clone()] == other.rays[b.clone()]
            && a.zip(b).all(|(e, f)| {
                let pieces = [(self, e), (other, f)].map(|(of, e)| of.pieces_of(e));
                let place = |p: &Piece| (p.cell, p.sub, p.m, p.back);
                (pieces[0].iter().map(place)).eq(pieces[1].iter().map(place))
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

    /// How many elements a patch, now one, becomes if it is cut into `m` along an edge.
    pub(crate) fn parts(&self, e: usize, patch: f32, m: f64) -> f64 {
        let whole = f64::from(self.area[e] / self.coverage[e].max(f32::MIN_POSITIVE));
        let times = m * (whole / f64::from(patch)).sqrt();
        let along = match self.pieces_of(e) {
            [one] if self.cells[one.triangle as usize].n > 1 => m,
            [_] => times.round(),
            _ => times,
        };
        along.powi(2).max(1.0)
    }

    /// Areas of all elements.
    pub(crate) fn iter_area(&self) -> impl Iterator<Item = f64> + Clone {
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

    /// How bright it is, by what arrives at each.
    pub(crate) fn level(&self, arriving: &[Vec3]) -> Level {
        let light = arriving.iter().map(|&light| f64::from(luminance(light)));
        Level::of(self.iter_area().zip(light))
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
        Some(ElementId(base + cells.at(hit.uv, &self.cuts)))
    }

    /// The spot that a ray hit; `None` for the black back of a one-sided surface.
    #[inline]
    pub(crate) fn spot_at(&self, hit: &Hit) -> Option<Spot> {
        let cells = self.cells[hit.triangle as usize];
        let base = if hit.back { cells.back? } else { cells.front };
        let (element, within) = cells.within(hit.uv, &self.cuts);
        Some(Spot::new(base + element, within))
    }

    pub(super) fn pieces_of(&self, e: usize) -> &[Piece] {
        &self.pieces[self.first_piece[e] as usize..self.first_piece[e + 1] as usize]
    }

    pub(super) fn part(&self, piece: &Piece) -> Part {
        Part {
            n: self.cells[piece.triangle as usize].n,
            m: piece.m.into(),
            cell: piece.cell,
            sub: piece.sub.into(),
        }
    }

    /// Point `u`, `v` (each 0..1) of an element, area-uniform.
    pub(crate) fn point(
        &self,
        scene: &ValidScene,
        element: ElementId,
        u: f32,
        v: f32,
    ) -> ElementPoint {
        let pieces = self.pieces_of(element.0 as usize);
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
        let barycentrics = self.part(&piece).point(triangle_point(u, v));
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
            let mut front = cells.front..cells.front + cells.count;
            let shines = front.any(|e| self.emission[e as usize] != Vec3::ZERO);
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
        self.sides_of_triangle(triangle).flatten()
    }

    /// The same side by side.
    pub(crate) fn sides_of_triangle(&self, triangle: u32) -> impl Iterator<Item = Range<u32>> {
        let cells = self.cells[triangle as usize];
        let sides = [Some(cells.front), cells.back].into_iter().flatten();
        sides.map(move |first| first..first + cells.count)
    }

    /// Whether each side of a live triangle emits as much everywhere.
    pub(crate) fn shines_evenly(&self, triangle: u32) -> bool {
        let light = |e: u32| (self.emission[e as usize], self.coverage[e as usize]);
        self.sides_of_triangle(triangle)
            .all(|side| side.clone().all(|e| light(e) == light(side.start)))
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
        let pieces = self.pieces_of(element.0 as usize);
        pieces.iter().map(|piece| {
            let part = self.part(piece);
            let whole = scene.corners(scene.triangles[piece.triangle as usize]);
            let corners = Vec3::AXES.map(|corner| {
                let b = part.point(corner);
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
        (self.len() * (12 + 12 + 4 + 4 + 4 + 4 + 2 + 4)
            + size_of_val(&*self.pieces)
            + size_of_val(&*self.cells)
            + size_of_val(&*self.cuts)
            + size_of_val(&*self.normals)) as u64
    }
}

use glam::Vec3;

use super::cells::{CellCut, Cells, Part};
use super::element::{Elements, Piece};
use super::grouping::{Group, Merger};
use super::identity::object_seeds;
use super::layout::{Cut, Layout};
use super::sampling::{hash, sobol, triangle as triangle_point};
use super::surface::Surfaces;
use super::triangle::{area, face_normal};
use super::validate::ValidScene;

/// Points at which the reflectance of an element's piece is read.
const TEXTURE_POINTS: usize = 16;

/// Cells along an edge of a triangle, at most.
const MOST_CELLS: f32 = 1000.0;

/// Makes elements in two steps: even patches first, cells of large triangles and groups of small
/// ones; then each patch is cut as the layout says.
pub(super) struct Builder<'a> {
    scene: &'a ValidScene,
    surfaces: &'a Surfaces<'a>,
    layout: &'a Layout,
    max_reflectance: f32,
    seeds: Vec<u32>,
    /// Areas of live triangles; none of what lets light pass.
    areas: Vec<f32>,
    /// Patches of the object at work, and which it is.
    patches: u32,
    object: u32,
    elements: Elements,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        scene: &'a ValidScene,
        surfaces: &'a Surfaces<'a>,
        layout: &'a Layout,
        max_reflectance: f32,
    ) -> Self {
        let triangles = scene.triangles.iter();
        let casts = |t| f32::from(u8::from(scene.casts(t)));
        Self {
            scene,
            surfaces,
            layout,
            max_reflectance,
            seeds: object_seeds(scene),
            areas: (triangles.clone())
                .map(|&t| area(scene.corners(t)) * casts(t))
                .collect(),
            patches: 0,
            object: 0,
            elements: Elements {
                reflectance: Vec::new(),
                emission: Vec::new(),
                area: Vec::new(),
                coverage: Vec::new(),
                rays: Vec::new(),
                patch: Vec::new(),
                clamped: 0,
                first_piece: vec![0],
                pieces: Vec::new(),
                cells: vec![Cells::default(); scene.triangles.len()],
                cuts: Vec::new(),
                normals: triangles.map(|&t| face_normal(scene.corners(t))).collect(),
                seeds: Vec::new(),
                first_of_object: vec![0; scene.objects.len() + 1],
            },
        }
    }

    pub(super) fn build(mut self) -> Elements {
        let all: Vec<u32> = (0..self.scene.triangles.len() as u32).collect();
        let areas = self.areas.clone();
        let normals = self.elements.normals.clone();
        let mut merger = Merger::new(self.scene, &areas, &normals);
        let groups = if self.layout.adapted {
            merger.whole_groups(&all, self.layout.patch)
        } else {
            merger.groups(&all, self.layout.patch)
        };
        for group in groups {
            // Light passes what does not cast: no ray finds it.
            if self.scene.casts(self.scene.triangles[group[0] as usize]) {
                self.add_patches(group, &mut merger);
            }
        }
        let first = &mut self.elements.first_of_object;
        for o in 1..first.len() {
            first[o] += first[o - 1];
        }
        self.elements
    }

    /// The cells of one large triangle are patches each, other groups are one.
    fn add_patches(&mut self, group: Group, merger: &mut Merger) {
        let n = self.cells_along(&group, self.layout.patch);
        if n > 1 {
            return self.add_cells(group[0], n);
        }
        let cut = self.next_cut(group[0]);
        let target = self.layout.patch / f32::from(cut.m).powi(2);
        let parts = if cut.m == 1 {
            vec![group]
        } else {
            merger.whole_groups(&group, target)
        };
        for part in parts {
            let n = self.cells_along(&part, target);
            self.add_group(&part, n, cut);
        }
        self.patches += 1;
    }

    fn cells_along(&self, group: &[u32], target: f32) -> u16 {
        match group {
            [one] => (self.areas[*one as usize] / target)
                .sqrt()
                .round()
                .clamp(1.0, MOST_CELLS) as u16,
            _ => 1,
        }
    }

    /// The cut of the next patch. Objects follow each other.
    fn next_cut(&mut self, triangle: u32) -> Cut {
        let object = self.scene.triangles[triangle as usize].object;
        if object != self.object {
            (self.object, self.patches) = (object, 0);
        }
        self.layout.cut(object as usize, self.patches as usize)
    }

    /// Adds elements of one cut: the cells of one triangle, or one element of several.
    fn add_group(&mut self, group: &[u32], n: u16, cut: Cut) {
        for &back in self.sides(group[0]) {
            let count = u32::from(n).pow(2);
            for &t in group {
                self.start_side(t, back, n);
                self.elements.cells[t as usize].count = count;
            }
            for cell in 0..count {
                let part = Part {
                    n,
                    m: 1,
                    cell,
                    sub: 0,
                };
                self.add_element(group, part, back, cut.rays, cell);
            }
        }
    }

    /// Adds the elements of a triangle each of whose `n²` cells has a cut of its own.
    fn add_cells(&mut self, triangle: u32, n: u16) {
        let cuts: Vec<Cut> = (0..u32::from(n).pow(2))
            .map(|_| {
                let cut = self.next_cut(triangle);
                self.patches += 1;
                cut
            })
            .collect();
        let first_patch = self.patches - cuts.len() as u32;
        if cuts.iter().any(|cut| cut.m > 1) {
            self.elements.cells[triangle as usize].cuts = self.elements.cuts.len() as u32;
            let mut first = 0;
            for cut in &cuts {
                let m = cut.m.into();
                self.elements.cuts.push(CellCut { first, m });
                first += u32::from(m).pow(2);
            }
        }
        for &back in self.sides(triangle) {
            self.start_side(triangle, back, n);
            let mut number = 0;
            for (cell, cut) in (0..).zip(&cuts) {
                self.patches = first_patch + cell;
                for sub in 0..u32::from(cut.m).pow(2) {
                    let m = cut.m.into();
                    let part = Part { n, m, cell, sub };
                    self.add_element(&[triangle], part, back, cut.rays, number);
                    number += 1;
                }
            }
            self.elements.cells[triangle as usize].count = number;
        }
        self.patches = first_patch + cuts.len() as u32;
    }

    /// Which sides of a surface have elements: the front, and perhaps the back.
    fn sides(&self, triangle: u32) -> &'static [bool] {
        let key = self.scene.triangles[triangle as usize];
        let two_sided = self.scene.material(key).double_sided;
        if two_sided { &[false, true] } else { &[false] }
    }

    fn start_side(&mut self, triangle: u32, back: bool, n: u16) {
        let base = self.elements.len() as u32;
        let cells = &mut self.elements.cells[triangle as usize];
        cells.n = n;
        if back {
            cells.back = Some(base);
        } else {
            cells.front = base;
        }
    }

    /// Adds an element of the same part of each triangle of a group, the `number`th of its side.
    fn add_element(&mut self, group: &[u32], part: Part, back: bool, rays: u16, number: u32) {
        let share = part.share();
        let whole: f64 = group
            .iter()
            .map(|&t| f64::from(self.areas[t as usize] * share))
            .sum();
        let (mut reflectance, mut emission, mut covered) = (Vec3::ZERO, Vec3::ZERO, 0.0_f64);
        let mut cumulative = 0.0;
        for &t in group {
            let key = self.scene.triangles[t as usize];
            let seed = hash(key.triangle, number);
            let mut points = [Vec3::splat(1.0 / 3.0); TEXTURE_POINTS];
            if !self.surfaces.uniform(t) {
                points = std::array::from_fn(|i| {
                    let [u, v, ..] = sobol(i as u32, 0, seed);
                    part.point(triangle_point(u, v))
                });
            }
            let diffuse = self.surfaces.average(t, &points, share);
            let area = self.areas[t as usize] * share;
            cumulative += f64::from(area) / whole;
            let weight = area * diffuse.coverage;
            reflectance += diffuse.reflectance * weight;
            emission += diffuse.emission * weight;
            covered += f64::from(weight);
            self.elements.pieces.push(Piece {
                triangle: t,
                cell: part.cell,
                sub: part.sub as u8,
                m: part.m as u8,
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
        e.rays.push(rays);
        e.patch.push(self.patches);
        e.first_piece.push(e.pieces.len() as u32);
        // Objects follow each other: count here, add up in the end.
        e.seeds
            .push(hash(e.first_of_object[object + 1], self.seeds[object]));
        e.first_of_object[object + 1] += 1;
    }
}

use bevy_fresco::radiosity::{Bake, Object, ObjectLight, Scene};
use glam::{DVec2, DVec3};

use super::layout::Layout;

/// A triangle of a baked mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lit {
    /// The triangle of the object that it lies on.
    pub(crate) source: usize,
    pub(crate) corners: [DVec3; 3],
    pub(crate) light: [DVec3; 3],
}

impl Lit {
    pub(crate) fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Position and light by the weights of the corners.
    pub(crate) fn at(&self, weights: DVec3) -> (DVec3, DVec3) {
        let blend = |[a, b, c]: [DVec3; 3]| a * weights.x + b * weights.y + c * weights.z;
        (blend(self.corners), blend(self.light))
    }
}

/// The triangles that an object's light is shown on: its own or those it was refined to.
pub(crate) fn lit(object: &Object, light: &ObjectLight) -> Vec<Lit> {
    let (positions, triangles) = match &light.mesh {
        Some(mesh) => (
            mesh.positions(&object.positions, &object.triangles),
            &mesh.triangles,
        ),
        None => (object.positions.clone(), &object.triangles),
    };
    let source = |t: usize| light.mesh.as_ref().map_or(t, |m| m.sources[t] as usize);
    let lit = |(t, corners): (usize, &[u32; 3])| Lit {
        source: source(t),
        corners: corners.map(|v| positions[v as usize].as_dvec3()),
        light: corners.map(|v| light.light[v as usize].as_dvec3()),
    };
    triangles.iter().enumerate().map(lit).collect()
}

/// What a bake of a layout's scene shows on each face.
pub(crate) fn by_face(layout: &Layout, scene: &Scene, baked: &Bake) -> Vec<Shown> {
    let mut faces: Vec<Vec<Lit>> = vec![Vec::new(); layout.faces().count()];
    for (part, (object, light)) in scene.objects.iter().zip(&baked.objects).enumerate() {
        let first = layout.first_face(part);
        for triangle in lit(object, light) {
            faces[first + triangle.source / 2].push(triangle);
        }
    }
    faces.into_iter().map(Shown::new).collect()
}

/// Triangles of one plane, found by place.
pub(crate) struct Shown {
    triangles: Vec<Lit>,
    origin: DVec3,
    /// Along the two sides of a cell, by the inverse of its length.
    axes: [DVec3; 2],
    across: usize,
    /// Triangles by cell.
    cells: Vec<Vec<u32>>,
}

impl Shown {
    pub(crate) fn new(triangles: Vec<Lit>) -> Self {
        let cross = |t: &Lit| (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]);
        let normal = triangles.iter().map(cross).sum::<DVec3>();
        let (u, v) = normal.normalize_or(DVec3::Y).any_orthonormal_pair();
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let origin = corners().next().unwrap_or_default();
        let flat = |p: DVec3| DVec2::new(u.dot(p - origin), v.dot(p - origin));
        let (low, high) = corners()
            .map(flat)
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        let across = (triangles.len() as f64).sqrt().ceil().clamp(1.0, 512.0) as usize;
        let size = (high - low).max(DVec2::splat(1e-9)) / across as f64;
        let mut shown = Self {
            origin: origin + u * low.x + v * low.y,
            axes: [u / size.x, v / size.y],
            across,
            cells: vec![Vec::new(); across * across],
            triangles,
        };
        for t in 0..shown.triangles.len() {
            let places = shown.triangles[t].corners.map(|c| shown.cell(c));
            let range = |axis: usize| {
                let along = places.map(|p| p[axis]);
                (along.into_iter().min(), along.into_iter().max())
            };
            let ((x0, x1), (y0, y1)) = (range(0), range(1));
            for y in y0.unwrap_or(0)..=y1.unwrap_or(0) {
                for x in x0.unwrap_or(0)..=x1.unwrap_or(0) {
                    shown.cells[y * across + x].push(t as u32);
                }
            }
        }
        shown
    }

    fn cell(&self, p: DVec3) -> [usize; 2] {
        let place = |axis: DVec3| axis.dot(p - self.origin).max(0.0) as usize;
        self.axes.map(|axis| place(axis).min(self.across - 1))
    }

    /// The light at a point: of the triangle that it lies in, or least outside of.
    pub(crate) fn at(&self, p: DVec3) -> Option<DVec3> {
        let [x, y] = self.cell(p);
        let inside = |&t: &u32| {
            let triangle = &self.triangles[t as usize];
            let weights = weights(triangle.corners, p)?;
            Some((weights.min_element(), triangle.at(weights).1))
        };
        let candidates = self.cells[y * self.across + x].iter().filter_map(inside);
        let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 > -1e-4).then_some(best.1)
    }
}

/// The weights of the corners at a point; `None` for a triangle that is hardly any.
fn weights([a, b, c]: [DVec3; 3], p: DVec3) -> Option<DVec3> {
    let normal = (b - a).cross(c - a);
    let twice = normal.length_squared();
    if twice < 1e-24 {
        return None;
    }
    let of = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) / twice;
    Some(DVec3::new(of(b, c), of(c, a), of(a, b)))
}

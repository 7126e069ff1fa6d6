use glam::{Vec2, Vec3};

use crate::mesh::RefinedMesh;
use crate::radiosity::baked::{Bake, ObjectLight};
use crate::radiosity::scene::Object;
use crate::radiosity::validate::{TriangleKey, ValidScene};

/// Finds the baked light of any point of the input triangles.
pub(super) struct LightLookup<'a> {
    objects: Vec<ObjectLookup<'a>>,
}

struct ObjectLookup<'a> {
    object: &'a Object,
    baked: &'a ObjectLight,
    /// For an object whose mesh was cut finer: its parts.
    parts: Option<Parts<'a>>,
}

impl<'a> LightLookup<'a> {
    pub(super) fn new(scene: &'a ValidScene, bake: &'a Bake) -> Self {
        let objects = scene.objects.iter().zip(&bake.objects);
        Self {
            objects: objects
                .map(|(object, baked)| ObjectLookup {
                    object,
                    baked,
                    parts: baked.mesh.as_ref().map(|mesh| Parts::new(object, mesh)),
                })
                .collect(),
        }
    }

    /// Light at a point of a triangle, given the weights of its second and third corner.
    pub(super) fn at(&self, key: TriangleKey, uv: [f32; 2]) -> Vec3 {
        let ObjectLookup {
            object,
            baked,
            parts,
        } = &self.objects[key.object as usize];
        if baked.light.is_empty() {
            return Vec3::ZERO;
        }
        let (corners, weights) = match parts {
            None => {
                let corners = object.triangles[key.triangle as usize];
                (corners, [1.0 - uv[0] - uv[1], uv[0], uv[1]])
            }
            Some(parts) => parts.at(key.triangle, uv.into()),
        };
        let values = corners.map(|v| baked.light[v as usize]);
        (0..3).map(|k| values[k] * weights[k]).sum()
    }
}

/// The triangles that each source triangle was cut into, in a grid over its barycentrics: as many
/// cells as parts, so that a point is compared with a few of them however many there are.
struct Parts<'a> {
    mesh: &'a RefinedMesh,
    /// Weights of the source's second and third corner at the corners of each part.
    corners: Vec<[Vec2; 3]>,
    grids: Vec<Grid>,
    /// Where the list of each cell starts in `members`, and one past the last.
    cells: Vec<u32>,
    members: Vec<u32>,
}

/// The grid of one source triangle: `n × n` cells over weights (0..1)² of corners two and three.
#[derive(Clone, Copy)]
struct Grid {
    first_cell: u32,
    n: u32,
}

impl Grid {
    fn cell(self, at: Vec2) -> [u32; 2] {
        let last = self.n - 1;
        at.to_array()
            .map(|x| ((x * self.n as f32).max(0.0) as u32).min(last))
    }

    /// All cells that a triangle's bounds touch.
    fn cells(self, [a, b, c]: [Vec2; 3]) -> impl Iterator<Item = u32> {
        // A little wider: a point on an edge must not fall between two cells' lists.
        let low = self.cell(a.min(b).min(c) - 1e-5);
        let high = self.cell(a.max(b).max(c) + 1e-5);
        (low[1]..=high[1])
            .flat_map(move |y| (low[0]..=high[0]).map(move |x| self.first_cell + y * self.n + x))
    }
}

impl<'a> Parts<'a> {
    fn new(object: &'a Object, mesh: &'a RefinedMesh) -> Self {
        let mut counts = vec![0_u32; object.triangles.len()];
        for &source in &mesh.sources {
            counts[source as usize] += 1;
        }
        let mut cell_count = 0;
        let grids: Vec<Grid> = counts
            .iter()
            .map(|&parts| {
                // Four parts or fewer are looked through one by one.
                let n = ((parts as f32 / 2.0).sqrt() as u32).max(1);
                let first_cell = cell_count;
                cell_count += n * n;
                Grid { first_cell, n }
            })
            .collect();
        let mut parts = Self {
            mesh,
            corners: corners(object, mesh),
            grids,
            cells: vec![0; cell_count as usize + 1],
            members: Vec::new(),
        };
        parts.fill();
        parts
    }

    /// Counting sort of the parts by cell.
    fn fill(&mut self) {
        let mut ends = vec![0_u32; self.cells.len()];
        self.each_membership(|cell, _| ends[cell as usize] += 1);
        let mut total = 0;
        for (cell, end) in self.cells.iter_mut().zip(&mut ends) {
            *cell = total;
            total += std::mem::replace(end, total);
        }
        let mut members = vec![0; total as usize];
        self.each_membership(|cell, part| {
            members[ends[cell as usize] as usize] = part;
            ends[cell as usize] += 1;
        });
        self.members = members;
    }

    fn each_membership(&self, mut visit: impl FnMut(u32, u32)) {
        for (part, &source) in self.mesh.sources.iter().enumerate() {
            for cell in self.grids[source as usize].cells(self.corners[part]) {
                visit(cell, part as u32);
            }
        }
    }

    /// The vertices around a point, and their weights.
    fn at(&self, source: u32, at: Vec2) -> ([u32; 3], [f32; 3]) {
        let grid = self.grids[source as usize];
        let [x, y] = grid.cell(at);
        let cell = (grid.first_cell + y * grid.n + x) as usize;
        let mut best = ([0; 3], [0.0; 3]);
        let mut deepest = f32::NEG_INFINITY;
        for &part in &self.members[self.cells[cell] as usize..self.cells[cell + 1] as usize] {
            let Some(weights) = weights(self.corners[part as usize], at) else {
                continue;
            };
            let depth = weights[0].min(weights[1]).min(weights[2]);
            if depth > deepest {
                deepest = depth;
                best = (self.mesh.triangles[part as usize], weights);
            }
            if depth >= 0.0 {
                break;
            }
        }
        best
    }
}

/// Weights of the source's second and third corner at the corners of each part.
fn corners(object: &Object, mesh: &RefinedMesh) -> Vec<[Vec2; 3]> {
    let parts = mesh.triangles.iter().zip(&mesh.sources);
    parts
        .map(|(part, &source)| {
            part.map(|v| {
                mesh.vertices[v as usize]
                    .barycentrics_on(source, &object.triangles)
                    // A part off its source has no area, and is never found.
                    .map_or(Vec2::ZERO, |weights| Vec2::new(weights.y, weights.z))
            })
        })
        .collect()
}

/// Barycentric weights of a point in a plane triangle; `None` if it has no area.
fn weights([a, b, c]: [Vec2; 3], at: Vec2) -> Option<[f32; 3]> {
    let (ab, ac, ap) = (b - a, c - a, at - a);
    let area = ab.perp_dot(ac);
    if area == 0.0 {
        return None;
    }
    let (v, w) = (ap.perp_dot(ac) / area, ab.perp_dot(ap) / area);
    Some([1.0 - v - w, v, w])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::split_long_edges;
    use crate::radiosity::{Light, LightKind, Material, MaterialId, Scene};

    /// Light that is linear in space is found again at every point, however the mesh was cut.
    #[test]
    fn finds_light_in_refined_triangles() {
        let positions = vec![Vec3::ZERO, Vec3::X * 3.0, Vec3::new(1.0, 2.0, 0.0)];
        let triangles = vec![[0, 1, 2]];
        let object = Object {
            positions: positions.clone(),
            normals: vec![Vec3::Z; 3],
            triangles: triangles.clone(),
            material: MaterialId(0),
            ..Object::default()
        };
        let scene = Scene {
            objects: vec![object],
            materials: vec![Material::default()],
            lights: vec![Light {
                name: String::new(),
                power: Vec3::ONE,
                kind: LightKind::Directional {
                    direction: Vec3::NEG_Z,
                },
                ..Light::default()
            }],
            ..Scene::default()
        };
        let scene = scene.validate().unwrap();
        for max_edge in [2.0, 0.7, 0.05] {
            let mesh = split_long_edges(&positions, &triangles, max_edge, 1_000_000).unwrap();
            let light = mesh.positions(&positions, &triangles);
            let bake = Bake {
                objects: vec![ObjectLight {
                    mesh: Some(mesh.into()),
                    light,
                    gradient: Vec::new(),
                    quality: Vec::new(),
                }],
                ..Bake::default()
            };
            let lookup = LightLookup::new(&scene, &bake);
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let (u, v) = (i as f32 / 40.0, j as f32 / 40.0);
                    let expected =
                        positions[0] * (1.0 - u - v) + positions[1] * u + positions[2] * v;
                    let found = lookup.at(scene.triangles[0], [u, v]);
                    assert!((found - expected).length() < 1e-4, "{found} {expected}");
                }
            }
        }
    }
}

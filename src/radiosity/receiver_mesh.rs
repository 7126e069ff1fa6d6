use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::baked::ObjectLight;
use super::occlusion::OFFSET;
use super::triangle::face_normal;
use super::validate::ValidScene;
use crate::mesh::{PositionClasses, RefinedMesh, SplitError, split_flat_corners, split_long_edges};

/// More vertices than this in one bake are taken for a mistake in the edge length.
const MAX_VERTICES: usize = 5_000_000;

/// The meshes that carry the light: the objects' own, or refinements of them.
pub(crate) struct ReceiverMeshes {
    /// One for each object of the scene.
    pub(crate) meshes: Vec<ReceiverMesh>,
    /// Number of unknowns of the vertex fit.
    pub(crate) unknowns: usize,
    /// Unknowns of different objects at one place with one normal.
    pub(crate) seams: Vec<Vec<u32>>,
}

/// The mesh of one object, in internal units; empty if the object does not receive light.
#[derive(Clone, Default)]
pub(crate) struct ReceiverMesh {
    pub(crate) positions: Vec<Vec3>,
    /// Unit normals that the surface is shaded with.
    pub(crate) normals: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Which unknown of the fit each vertex takes its light from.
    pub(crate) unknown: Vec<u32>,
    /// The refinement, if the mesh is not the object's own.
    pub(crate) refined: Option<Arc<RefinedMesh>>,
}

/// Vertices share an unknown if their normals agree within this cosine (1°).
const SAME_NORMAL: f32 = 0.999_85;

impl ReceiverMeshes {
    /// The light of all vertices, of that of the unknowns.
    pub(crate) fn object_light(&self, light: &[Vec3]) -> Vec<ObjectLight> {
        let of = |u: &u32| light[*u as usize];
        (self.meshes.iter())
            .map(|mesh| ObjectLight {
                light: mesh.unknown.iter().map(of).collect(),
                mesh: mesh.refined.clone(),
            })
            .collect()
    }

    /// Splits edges longer than `max_edge` metres, gives flat-shaded corners vertices of their own,
    /// and finds which vertices share their light: those of one place and one normal in an object,
    /// across texture seams but not across hard edges. Where objects meet, a wall may stand
    /// between them, so there each has its own and a seam joins them if the light agrees.
    ///
    /// `before` has the meshes that are still the same, and those whose refinement may be.
    pub(crate) fn new(
        scene: &ValidScene,
        max_edge: Option<f32>,
        before: Option<&MeshesBefore>,
    ) -> Result<Self, SplitError> {
        let mut meshes = Vec::with_capacity(scene.objects.len());
        let mut budget = MAX_VERTICES;
        for object in 0..scene.objects.len() {
            let mesh = match before.and_then(|b| b.mesh(object)) {
                Some(mesh) => mesh.clone(),
                None => ReceiverMesh::new(scene, object, max_edge, budget)?,
            };
            budget = budget.saturating_sub(mesh.positions.len());
            meshes.push(mesh);
        }
        let (unknowns, seams) = share_unknowns(&mut meshes);
        Ok(Self {
            meshes,
            unknowns,
            seams,
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        let mesh = |m: &ReceiverMesh| {
            let refined = m.refined.as_ref();
            28 * m.positions.len()
                + 12 * m.triangles.len()
                + refined.map_or(0, |r| 16 * r.vertices.len() + 16 * r.triangles.len())
        };
        self.meshes.iter().map(|m| mesh(m) as u64).sum()
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.meshes.iter().map(|m| m.positions.len()).sum()
    }
}

/// The meshes of an earlier bake.
pub(crate) struct MeshesBefore<'a> {
    pub(crate) meshes: &'a ReceiverMeshes,
    /// For each object, which it was, if its mesh is the same.
    pub(crate) same: &'a [Option<usize>],
    /// For each object, which it was.
    pub(crate) object: &'a [Option<usize>],
}

impl MeshesBefore<'_> {
    fn mesh(&self, object: usize) -> Option<&ReceiverMesh> {
        self.same[object].map(|p| &self.meshes.meshes[p])
    }

    /// Where a mesh was refined as it was before, makes the refinement the same one.
    pub(crate) fn share_refinements(&self, meshes: &mut ReceiverMeshes) {
        for (mesh, before) in meshes.meshes.iter_mut().zip(self.object) {
            let old = before.and_then(|p| self.meshes.meshes[p].refined.as_ref());
            if let Some(old) = old.filter(|old| mesh.refined.as_ref() == Some(old)) {
                mesh.refined = Some(old.clone());
            }
        }
    }
}

impl ReceiverMesh {
    /// The triangle of the object that a triangle lies on.
    pub(crate) fn source(&self, triangle: usize) -> usize {
        (self.refined.as_ref()).map_or(triangle, |r| r.sources[triangle] as usize)
    }

    fn new(
        scene: &ValidScene,
        index: usize,
        max_edge: Option<f32>,
        budget: usize,
    ) -> Result<Self, SplitError> {
        let object = &scene.objects[index];
        if !object.receives {
            return Ok(Self::default());
        }
        let flat = object.normals.is_empty();
        let mut refined: Option<RefinedMesh> = None;
        if flat && !object.triangles.is_empty() {
            refined = Some(split_flat_corners(&object.positions, &object.triangles));
        }
        if let Some(max_edge) = max_edge {
            let internal = max_edge / scene.scale;
            let split = match &refined {
                None => split_long_edges(&object.positions, &object.triangles, internal, budget)?,
                Some(corners) => {
                    let positions = corners.positions(&object.positions, &object.triangles);
                    let finer = split_long_edges(&positions, &corners.triangles, internal, budget)?;
                    corners.then(&object.triangles, &finer)
                }
            };
            refined = Some(split);
        }
        // A refinement that changes nothing is not worth another mesh in the result.
        let refined = refined.filter(|r| {
            r.triangles.len() != object.triangles.len()
                || r.vertices.len() != object.positions.len()
        });
        Ok(match refined {
            Some(refined) => Self::from_refined(object, refined),
            None => Self {
                positions: object.positions.clone(),
                normals: if flat {
                    vertex_face_normals(object)
                } else {
                    object.normals.clone()
                },
                triangles: object.triangles.clone(),
                unknown: Vec::new(),
                refined: None,
            },
        })
    }

    fn from_refined(object: &super::scene::Object, refined: RefinedMesh) -> Self {
        let normals = if object.normals.is_empty() {
            refined.interpolate(&object.triangles, |t, _| {
                face_normal(t.map(|v| object.positions[v as usize]))
            })
        } else {
            refined.interpolate(&object.triangles, |t, w| {
                let [a, b, c] = t.map(|v| object.normals[v as usize]);
                (a * w.x + b * w.y + c * w.z).try_normalize().unwrap_or(a)
            })
        };
        Self {
            positions: refined.positions(&object.positions, &object.triangles),
            normals,
            triangles: refined.triangles.clone(),
            unknown: Vec::new(),
            refined: Some(Arc::new(refined)),
        }
    }

    /// Corners of a triangle.
    pub(crate) fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }
}

/// Normals of a flat-shaded mesh whose vertices are not shared between faces of other directions.
fn vertex_face_normals(object: &super::scene::Object) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; object.positions.len()];
    for t in &object.triangles {
        let normal = face_normal(t.map(|v| object.positions[v as usize]));
        for &v in t {
            normals[v as usize] = normal;
        }
    }
    normals
}

/// Numbers the unknowns: one for each group of vertices of one place and one normal in an object.
/// Returns their number and the seams between objects.
fn share_unknowns(meshes: &mut [ReceiverMesh]) -> (usize, Vec<Vec<u32>>) {
    let positions: Vec<Vec3> = meshes
        .iter()
        .flat_map(|m| m.positions.iter().copied())
        .collect();
    let classes = PositionClasses::new(positions.iter().copied(), OFFSET);
    let mut at_place: HashMap<u32, Vec<Corner>> = HashMap::with_capacity(positions.len());
    let (mut next, mut i) = (0, 0);
    for (object, mesh) in meshes.iter_mut().enumerate() {
        mesh.unknown = Vec::with_capacity(mesh.positions.len());
        for &normal in &mesh.normals {
            let here = at_place.entry(classes.class[i]).or_default();
            let same = |c: &&Corner| c.object == object && c.normal.dot(normal) > SAME_NORMAL;
            let known = here.iter().find(same).map(|c| c.unknown);
            mesh.unknown.push(known.unwrap_or(next));
            if known.is_none() {
                here.push(Corner {
                    object,
                    normal,
                    unknown: next,
                });
                next += 1;
            }
            i += 1;
        }
    }
    (next as usize, seams(at_place))
}

/// An unknown by what tells it from others at the same place.
struct Corner {
    object: usize,
    normal: Vec3,
    unknown: u32,
}

fn seams(at_place: HashMap<u32, Vec<Corner>>) -> Vec<Vec<u32>> {
    let mut seams = Vec::new();
    for mut corners in at_place.into_values() {
        while let Some(first) = corners.pop() {
            let (same, others): (Vec<_>, Vec<_>) = corners
                .into_iter()
                .partition(|c| c.normal.dot(first.normal) > SAME_NORMAL);
            if !same.is_empty() {
                let mut seam: Vec<u32> = same
                    .iter()
                    .map(|c| c.unknown)
                    .chain([first.unknown])
                    .collect();
                seam.sort_unstable();
                seams.push(seam);
            }
            corners = others;
        }
    }
    // The map's order is not the same in every run.
    seams.sort_unstable();
    seams
}

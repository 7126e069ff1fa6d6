use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::baked::ObjectLight;
use super::cut::Cut;
use super::occlusion::OFFSET;
use super::settings::BakeSettings;
use super::triangle::face_normal;
use super::validate::ValidScene;
use crate::mesh::{
    Origin, PositionClasses, Refined, RefinedMesh, SplitError, split_flat_corners, split_long_edges,
};

/// More vertices than this in one bake are taken for a mistake in the edge length.
const MAX_VERTICES: usize = 5_000_000;

/// The meshes that carry the light: the objects' own, or refinements of them.
#[derive(Clone)]
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
    /// The refinement of the object's mesh in the scene, cut where others touch it; `None` if it is
    /// that mesh.
    pub(crate) refined: Option<Arc<RefinedMesh>>,
    /// The same of the object's mesh as it was given.
    pub(crate) result: Option<Arc<RefinedMesh>>,
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
                gradient: Vec::new(),
                quality: Vec::new(),
                mesh: mesh.result.clone(),
            })
            .collect()
    }

    /// Splits edges longer than `max_edge` of objects that are not refined by the light, gives flat-shaded
    /// corners vertices of their own, and finds which vertices share their light: those of one place and one normal in an object,
    /// across texture seams but not across hard edges. Where objects meet, a wall may stand
    /// between them, so there each has its own and a seam may join them.
    ///
    /// `before` has the meshes that are still the same, and those whose refinement may be.
    pub(crate) fn new(
        scene: &ValidScene,
        settings: &BakeSettings,
        before: Option<&MeshesBefore>,
    ) -> Result<Self, SplitError> {
        let mut meshes = Vec::with_capacity(scene.objects.len());
        let mut budget = MAX_VERTICES;
        for object in 0..scene.objects.len() {
            let mesh = match before.and_then(|b| b.mesh(object)) {
                Some(mesh) => mesh.clone(),
                None => ReceiverMesh::new(scene, object, settings, budget)?,
            };
            budget = budget.saturating_sub(mesh.positions.len());
            meshes.push(mesh);
        }
        let unknowns = share_unknowns(scene, &mut meshes);
        Ok(Self {
            seams: seams(&meshes),
            meshes,
            unknowns,
        })
    }

    /// These meshes refined: by object, where it is.
    ///
    /// A midpoint shares its unknown with those of edges between the same two unknowns: across texture
    /// seams, and not across hard edges or lines of contact, whose two sides have unknowns of their own.
    pub(crate) fn refined(&self, scene: &ValidScene, by: &[Option<Arc<Refined>>]) -> Self {
        let mut unknowns = self.unknowns;
        let meshes = (self.meshes.iter().zip(by).enumerate()).map(|(o, (mesh, by))| {
            by.as_ref().map_or_else(
                || mesh.clone(),
                |by| mesh.refined_by(scene, o, by, &mut unknowns),
            )
        });
        let meshes: Vec<ReceiverMesh> = meshes.collect();
        Self {
            seams: seams(&meshes),
            meshes,
            unknowns,
        }
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
            let old = before.and_then(|p| self.meshes.meshes[p].result.as_ref());
            if let Some(old) = old.filter(|old| mesh.result.as_ref() == Some(old)) {
                mesh.result = Some(old.clone());
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
        settings: &BakeSettings,
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
        // What is refined gets its edges cut then, with those of its neighbours.
        let by_light = settings.refine && object.refine;
        if let Some(max_edge) = settings.max_edge.filter(|_| !by_light) {
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
            Some(refined) => Self::from_refined(scene, index, refined),
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
                result: cut(scene, index).map(|cut| Arc::new(cut.mesh.mesh.clone())),
            },
        })
    }

    fn from_refined(scene: &ValidScene, index: usize, refined: RefinedMesh) -> Self {
        let object = &scene.objects[index];
        let refined = Arc::new(refined);
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
            result: Some(match cut(scene, index) {
                Some(cut) => Arc::new(cut.then(&refined)),
                None => refined.clone(),
            }),
            refined: Some(refined),
        }
    }

    /// This mesh refined; `unknowns` are numbered so far.
    fn refined_by(
        &self,
        scene: &ValidScene,
        index: usize,
        by: &Refined,
        unknowns: &mut usize,
    ) -> Self {
        let mesh = match &self.refined {
            Some(own) => own.then(&scene.objects[index].triangles, &by.mesh),
            None => by.mesh.clone(),
        };
        let mut between: HashMap<[u32; 2], u32> = HashMap::new();
        let mut unknown: Vec<u32> = Vec::with_capacity(by.origins.len());
        for origin in &by.origins {
            unknown.push(match *origin {
                Origin::Given(v) => self.unknown[v as usize],
                Origin::Between(ends) => {
                    let [a, b] = ends.map(|v| unknown[v as usize]);
                    *between.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                        *unknowns += 1;
                        (*unknowns - 1) as u32
                    })
                }
            });
        }
        Self {
            unknown,
            ..Self::from_refined(scene, index, mesh)
        }
    }

    /// Which side of a line of contact each vertex is on.
    fn sides(&self, scene: &ValidScene, index: usize) -> Vec<u32> {
        let Some(cut) = cut(scene, index) else {
            return vec![0; self.positions.len()];
        };
        let sides = &cut.mesh.sides;
        match &self.refined {
            None => sides.clone(),
            // All vertices are corners of what was cut.
            Some(refined) => refined.interpolate(&scene.objects[index].triangles, |corners, w| {
                sides[corners[w.max_position()] as usize]
            }),
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

/// How an object was cut where others touch it.
fn cut(scene: &ValidScene, index: usize) -> Option<&Cut> {
    scene.cuts.get(index)?.as_deref()
}

/// Numbers the unknowns: one for each group of vertices of one place, one normal and one side of lines
/// of contact in an object. Returns their number.
fn share_unknowns(scene: &ValidScene, meshes: &mut [ReceiverMesh]) -> usize {
    let mut next = 0;
    for (object, mesh) in meshes.iter_mut().enumerate() {
        let classes = PositionClasses::new(mesh.positions.iter().copied(), OFFSET);
        let sides = mesh.sides(scene, object);
        let mut at_place: HashMap<(u32, u32), Vec<Corner>> =
            HashMap::with_capacity(mesh.positions.len());
        mesh.unknown = Vec::with_capacity(mesh.positions.len());
        for ((&normal, class), side) in mesh.normals.iter().zip(classes.class).zip(sides) {
            let here = at_place.entry((class, side)).or_default();
            let known = here.iter().find(|c| c.agrees(normal)).map(|c| c.unknown);
            mesh.unknown.push(known.unwrap_or(next));
            if known.is_none() {
                here.push(Corner {
                    normal,
                    unknown: next,
                });
                next += 1;
            }
        }
    }
    next as usize
}

/// An unknown by what tells it from others at the same place.
struct Corner {
    normal: Vec3,
    unknown: u32,
}

impl Corner {
    fn agrees(&self, normal: Vec3) -> bool {
        self.normal.dot(normal) > SAME_NORMAL
    }
}

/// Unknowns of different objects at one place with one normal.
fn seams(meshes: &[ReceiverMesh]) -> Vec<Vec<u32>> {
    let positions = meshes.iter().flat_map(|m| m.positions.iter().copied());
    let classes = PositionClasses::new(positions, OFFSET).class;
    let mut at_place: HashMap<u32, Vec<(usize, Corner)>> = HashMap::with_capacity(classes.len());
    let vertices = (meshes.iter().enumerate())
        .flat_map(|(o, m)| m.normals.iter().zip(&m.unknown).map(move |v| (o, v)));
    for ((object, (&normal, &unknown)), class) in vertices.zip(classes) {
        at_place
            .entry(class)
            .or_default()
            .push((object, Corner { normal, unknown }));
    }
    let mut seams = Vec::new();
    for mut corners in at_place.into_values() {
        // The map's order is not the same in every run, that of the corners is.
        while let Some((object, first)) = corners.pop() {
            let (same, others): (Vec<_>, Vec<_>) = corners
                .into_iter()
                .partition(|(_, c)| c.agrees(first.normal));
            if same.iter().any(|(o, _)| *o != object) {
                let mut seam: Vec<u32> = same
                    .iter()
                    .map(|(_, c)| c.unknown)
                    .chain([first.unknown])
                    .collect();
                seam.sort_unstable();
                seam.dedup();
                seams.push(seam);
            }
            corners = others;
        }
    }
    seams.sort_unstable();
    seams
}

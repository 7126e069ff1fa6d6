use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;

use super::identity::{matches, object_identities};
use super::observer::Observer;
use super::parallel::Cancelled;
use super::scene::{AlphaMode, Object};
use super::stages::Start;
use super::triangle::area;
use super::validate::{HALF_EXTENT, TriangleKey, ValidScene};
use crate::mesh::{CutMesh, RefinedMesh, Surface, split_at_contacts};

/// Surfaces nearer than this count as touching, in internal units: a two-thousandth of the scene.
/// Light and shadow in a narrower gap are seen by nobody, and no mesh could follow them.
pub(crate) const TOUCHING: f32 = HALF_EXTENT / 1000.0;

/// How an object was cut where others touch or cross it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cut {
    pub(crate) mesh: CutMesh,
    /// The triangles it was cut out of.
    source: Vec<[u32; 3]>,
    /// Vertices it was cut out of.
    vertices: usize,
}

/// The cuts of a scene's objects, where there are any.
pub(crate) type Cuts = Vec<Option<Arc<Cut>>>;

impl Cut {
    /// A refinement of the cut mesh as one of the mesh that was cut.
    pub(crate) fn then(&self, finer: &RefinedMesh) -> RefinedMesh {
        self.mesh.mesh.then(&self.source, finer)
    }

    fn fits(&self, object: &Object) -> bool {
        self.vertices == object.positions.len() && self.source == object.triangles
    }
}

/// Finds where the surfaces of a scene touch or cross.
fn find_cuts(scene: &ValidScene, observer: &dyn Observer) -> Result<Cuts, Cancelled> {
    let surfaces: Vec<Surface> = (scene.objects.iter())
        .map(|object| {
            let material = &scene.materials[object.material.0 as usize];
            Surface {
                positions: &object.positions,
                triangles: &object.triangles,
                cut: object.refine,
                cuts: object.casts && material.alpha == AlphaMode::Opaque,
            }
        })
        .collect();
    let found = split_at_contacts(&surfaces, TOUCHING, &|| !observer.cancelled());
    let meshes = found.ok_or(Cancelled)?.meshes;
    let cut = |(mesh, object): (Option<CutMesh>, &Object)| {
        Some(Arc::new(Cut {
            mesh: mesh?,
            source: object.triangles.clone(),
            vertices: object.positions.len(),
        }))
    };
    Ok(meshes.into_iter().zip(&scene.objects).map(cut).collect())
}

/// The cuts of an earlier scene that fit the objects of this one: an object that only moved keeps its
/// own.
fn kept_cuts(old: &ValidScene, new: &ValidScene) -> Cuts {
    let before = matches(&object_identities(old), &object_identities(new));
    (before.iter().zip(&new.objects))
        .map(|(before, object)| {
            let cut = old.cuts.get((*before)?)?.as_ref()?;
            cut.fits(object).then(|| cut.clone())
        })
        .collect()
}

/// The cuts of a scene: those known, those of an earlier bake that still fit, or all anew.
pub(crate) fn cuts(
    scene: &ValidScene,
    start: &Start,
    observer: &dyn Observer,
) -> Result<Cuts, Cancelled> {
    match (start.plan, start.before) {
        (Some(plan), _) => Ok(plan.cuts.clone()),
        (None, Some(before)) => Ok(kept_cuts(before.stages.cut_scene(before.scene), scene)),
        (None, None) => find_cuts(scene, observer),
    }
}

/// A scene with its objects cut; `None` if nothing is.
pub(crate) fn apply(scene: &ValidScene, cuts: &Cuts) -> Option<ValidScene> {
    if cuts.iter().all(Option::is_none) {
        return None;
    }
    let live = scene.live_indices();
    let mut after = ValidScene {
        objects: Vec::with_capacity(scene.objects.len()),
        triangles: Vec::new(),
        cuts: cuts.clone(),
        ..scene.clone()
    };
    for (o, (object, cut)) in scene.objects.iter().zip(cuts).enumerate() {
        let object = cut
            .as_ref()
            .map_or_else(|| object.clone(), |cut| cut_object(object, cut));
        for (triangle, corners) in object.triangles.iter().enumerate() {
            let source = cut
                .as_ref()
                .map_or(triangle, |c| c.mesh.mesh.sources[triangle] as usize);
            let is_live = (live[o][source] as usize) < scene.triangles.len();
            if is_live && area(corners.map(|v| object.positions[v as usize])) > 0.0 {
                after.triangles.push(TriangleKey {
                    object: o as u32,
                    triangle: triangle as u32,
                });
            }
        }
        after.objects.push(object);
    }
    Some(after)
}

fn cut_object(object: &Object, cut: &Cut) -> Object {
    let mesh = &cut.mesh.mesh;
    fn blend<T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(
        mesh: &RefinedMesh,
        triangles: &[[u32; 3]],
        values: &[T],
    ) -> Vec<T> {
        if values.is_empty() {
            return Vec::new();
        }
        mesh.interpolate(triangles, |corners, w| {
            let [a, b, c] = corners.map(|v| values[v as usize]);
            a * w.x + b * w.y + c * w.z
        })
    }
    let source = &object.triangles;
    let unit = |n: Vec3| n.try_normalize().unwrap_or(n);
    Object {
        positions: mesh.positions(&object.positions, source),
        normals: blend(mesh, source, &object.normals)
            .into_iter()
            .map(unit)
            .collect(),
        uvs: object
            .uvs
            .iter()
            .map(|set| blend(mesh, source, set))
            .collect(),
        colors: blend(mesh, source, &object.colors),
        triangles: mesh.triangles.clone(),
        name: object.name.clone(),
        ..*object
    }
}

/// A piece of a line along which a face was cut because another touches or crosses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// In metres.
    pub ends: [Vec3; 2],
    /// Unit normal of the face on one side of it.
    pub normal: Vec3,
}

/// The lines along which surfaces of a cut scene were cut.
pub(crate) fn lines(scene: &ValidScene) -> Vec<ContactLine> {
    let mut lines = Vec::new();
    for (object, cut) in scene.objects.iter().zip(&scene.cuts) {
        let Some(cut) = cut else {
            continue;
        };
        // Vertices on a line are there once for each side of it: only their places tell.
        let mut sides: BTreeMap<[[u32; 3]; 2], ([u32; 2], bool, Vec3)> = BTreeMap::new();
        for triangle in &object.triangles {
            let corners = triangle.map(|v| object.positions[v as usize]);
            for k in 0..3 {
                let mut ends = [k, (k + 1) % 3].map(|k| {
                    let side = cut.mesh.sides[triangle[k] as usize];
                    (corners[k].to_array().map(f32::to_bits), side)
                });
                ends.sort_unstable();
                let own = ends.map(|(_, side)| side);
                let places = ends.map(|(place, _)| place);
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let (first, differs, _) = sides.entry(places).or_insert((own, false, normal));
                *differs |= *first != own;
            }
        }
        let metres = |end: [u32; 3]| {
            let point = Vec3::from(end.map(f32::from_bits)).as_dvec3();
            (point * f64::from(scene.scale) + scene.center).as_vec3()
        };
        let cut_along = sides.into_iter().filter(|(_, (_, differs, _))| *differs);
        lines.extend(cut_along.map(|(ends, (_, _, normal))| ContactLine {
            ends: ends.map(metres),
            normal: normal.normalize_or_zero(),
        }));
    }
    lines
}

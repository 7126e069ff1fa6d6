use std::time::Instant;

use super::bake::BakeError;
use super::bvh::BvhQuality;
use super::element::Elements;
use super::emitter::Emitters;
use super::emitter_tree::EmitterTree;
use super::form_factor::{FormFactors, View};
use super::layout::Layout;
use super::observer::Observer;
use super::occlusion::{Hierarchy, Holds, Occluders};
use super::pipeline::KEPT_RAYS;
use super::receiver_mesh::ReceiverMeshes;
use super::settings::BakeSettings;
use super::solve::Solver;
use super::speed::{seconds_of_rows, seconds_per_ray};
use super::surface::{Pyramids, Surfaces};
use super::triangle::area;
use super::validate::ValidScene;

/// What a bake would take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Vertices of the result.
    pub vertices: u64,
    /// Radiosity elements.
    pub elements: u64,
    /// Samples inside triangles.
    pub samples: u64,
    /// Closest-hit rays.
    pub rays: u64,
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Memory at the peak, in bytes, with the scene itself.
    pub bytes: u64,
    /// Wall time in seconds; 0 if it was not measured.
    pub seconds: f64,
}

/// Above this many vertices the split is estimated and not tried out.
const TRY_VERTICES: u64 = 2_000_000;

/// Triangles of a split mesh, by area in squares of the longest edge allowed: edges end between
/// half the limit and the limit, most of them near 0.7 of it.
const SPLIT_TRIANGLES: f64 = 5.0;

/// Time a bake spends beside its rays, as a share of the time for them.
const OVERHEAD: f64 = 1.15;

/// Counts what a bake would have, without doing any of it: fast, and rough where edges are split.
pub fn estimate_counts(scene: &ValidScene, settings: &BakeSettings) -> Estimate {
    let (vertices, triangles) = mesh_size(scene, settings);
    let two_sided = scene
        .triangles
        .iter()
        .any(|&t| scene.material(t).double_sided);
    let elements = u64::from(settings.elements) * if two_sided { 2 } else { 1 };
    let mut estimate = Estimate {
        vertices,
        elements,
        ..Estimate::default()
    };
    estimate.count_rays(scene, settings, triangles);
    estimate
}

/// Estimates what a bake would take, splitting the mesh and measuring the speed of rays, and of
/// form factors that are not made of rays.
///
/// # Errors
///
/// As [`bake`](super::bake).
pub fn estimate(
    scene: &ValidScene,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<Estimate, BakeError> {
    settings.check()?;
    let mut estimate = estimate_counts(scene, settings);
    let mut split = None;
    if estimate.vertices < TRY_VERTICES {
        let receivers = ReceiverMeshes::new(scene, settings, None)?;
        estimate.vertices = receivers.vertex_count() as u64;
        let triangles = receivers.meshes.iter().map(|m| m.triangles.len() as u64);
        let triangles: u64 = triangles.sum();
        drop(receivers);
        split = Some(triangles);
    }
    let started = Instant::now();
    let pyramids = Pyramids::new(scene, None);
    let surfaces = Surfaces::new(scene, &pyramids);
    let elements = Elements::new(
        scene,
        &surfaces,
        &Layout::even(scene, settings),
        settings.max_reflectance,
    );
    let hierarchy = Hierarchy::new(scene, &surfaces, Holds::Casting, BvhQuality::Best);
    let occluders = Occluders::new(&hierarchy, &surfaces);
    let tree = EmitterTree::new(scene, &elements, &occluders, settings, observer)?;
    let set_up = started.elapsed().as_secs_f64();
    estimate.elements = elements.len() as u64;
    let triangles = split.unwrap_or_else(|| mesh_size(scene, settings).1);
    estimate.count_rays(scene, settings, triangles);
    let emitters = Emitters::at_elements(&tree, settings);
    let view = View {
        scene,
        occluders,
        elements: &elements,
        emitters,
        marks: &emitters.marks(&elements),
        settings,
        remember: false,
    };
    let rays = estimate.rays as f64 + estimate.shadow_rays as f64;
    let tracing = OVERHEAD * seconds_per_ray(&view, observer)? * rays;
    estimate.seconds = set_up + tracing + seconds_of_rows(&view, observer)?;
    Ok(estimate)
}

impl Estimate {
    fn count_rays(&mut self, scene: &ValidScene, settings: &BakeSettings, triangles: u64) {
        let wanted = f64::from(settings.samples_per_vertex) * self.vertices as f64;
        // At least two samples a triangle, whatever is asked.
        self.samples = (wanted as u64).clamp(2 * triangles, 256 * triangles.max(1));
        self.rays = self.elements * u64::from(settings.rays_of_element())
            + self.samples * u64::from(settings.gather_rays);
        let emits = (scene.triangles.iter())
            .any(|&t| scene.material(t).emissive.max_element() > 0.0 && !scene.material(t).unlit);
        let shadow_rays =
            u64::from(settings.emitter_rays) * u64::from(emits) + scene.lights.len() as u64;
        self.shadow_rays = (self.elements + self.samples) * shadow_rays;
        self.bytes = bytes(scene, settings, self, triangles);
    }
}

/// Vertices and triangles after splitting.
fn mesh_size(scene: &ValidScene, settings: &BakeSettings) -> (u64, u64) {
    let (mut vertices, mut triangles) = (0.0_f64, 0.0_f64);
    for object in &scene.objects {
        let given = object.triangles.len() as f64;
        // Without normals every corner gets a vertex of its own, at worst.
        let mut own = object.positions.len() as f64;
        if object.normals.is_empty() {
            own = own.max(3.0 * given);
        }
        let Some(max_edge) = settings.max_edge else {
            vertices += own;
            triangles += given;
            continue;
        };
        let square = (f64::from(max_edge) / f64::from(scene.scale)).powi(2);
        let split: f64 = object
            .triangles
            .iter()
            .map(|t| {
                let corners = t.map(|v| object.positions[v as usize]);
                (SPLIT_TRIANGLES * f64::from(area(corners)) / square).max(1.0)
            })
            .sum();
        triangles += split;
        // A large mesh has half as many vertices as triangles.
        vertices += own + 0.5 * (split - given);
    }
    // More than any machine holds; sums of products of it still fit their type.
    const MANY: f64 = 1e11;
    (vertices.min(MANY) as u64, triangles.min(MANY) as u64)
}

/// Bytes at the peak: measured on scenes with many triangles, vertices or elements, and rounded up.
fn bytes(scene: &ValidScene, settings: &BakeSettings, counts: &Estimate, triangles: u64) -> u64 {
    const FIXED: u64 = 16 << 20;
    const PER_INPUT_TRIANGLE: u64 = 900;
    const PER_VERTEX: u64 = 350;
    const PER_TRIANGLE: u64 = 500;
    const PER_ELEMENT: u64 = 330;
    // Gradients: at vertices of both meshes as they are fitted, and samples of both kinds of light.
    const GRADIENT_PER_VERTEX: u64 = 100;
    const GRADIENT_PER_TRIANGLE: u64 = 320;
    // Eight-bit texels, and their pyramid in four floats.
    const PER_TEXEL: u64 = 4 + 22;
    let (of_vertex, of_triangle) = match settings.directional {
        true => (GRADIENT_PER_VERTEX, GRADIENT_PER_TRIANGLE),
        false => (0, 0),
    };
    let texels: usize = scene.textures.iter().map(|t| t.texels.len()).sum();
    FIXED
        + PER_INPUT_TRIANGLE * scene.triangles.len() as u64
        + (PER_VERTEX + of_vertex) * counts.vertices
        + (PER_TRIANGLE + of_triangle) * triangles
        + PER_ELEMENT * counts.elements
        + matrix_bytes(settings, counts.elements)
        + PER_TEXEL * texels as u64
}

/// Vertices that fit into the memory allowed, beside everything else; `given` are there in any case.
pub(crate) fn vertices_within(scene: &ValidScene, settings: &BakeSettings, given: u64) -> usize {
    // Two triangles a vertex, and all that is kept of samples on them.
    const PER_VERTEX: u64 = 1600;
    const GRADIENT: u64 = 800;
    let fixed = estimate_counts(scene, settings).bytes;
    let kept = settings.max_memory / KEPT_RAYS * 2;
    let spare = (settings.max_memory - kept).saturating_sub(fixed);
    let per_vertex = PER_VERTEX + if settings.directional { GRADIENT } else { 0 };
    (given + spare / per_vertex).min(u32::MAX.into()) as usize
}

/// Bytes of the form-factor matrix and of what the solver makes of it, at the peak.
fn matrix_bytes(settings: &BakeSettings, elements: u64) -> u64 {
    const ROW_HEAD: u64 = 64;
    let pairs = elements * elements;
    // Sparse or dense, whichever is smaller.
    let rows = |entries: u64| (8 * entries).min(4 * pairs) + ROW_HEAD * elements;
    // Bytes while it is made, and entries. What is freed then, in many parts, does not come back for
    // what the solver makes.
    let (made, entries) = match settings.form_factors {
        // Chunks of it, and the list they are joined to.
        FormFactors::HitList => {
            let rays = u64::from(settings.element_rays) * elements;
            (8 * rays, rays)
        }
        // Rows are kept as they are found.
        FormFactors::Hemicube { resolution } => {
            let entries = elements * shown(elements, resolution);
            (rows(entries), entries)
        }
        // Each pair once, and the rows they are put into.
        FormFactors::Analytic { .. } | FormFactors::AreaSampling { .. } => {
            (rows(pairs) + 2 * pairs, pairs)
        }
    };
    made + match settings.solver {
        // Columns beside the rows.
        Solver::ProgressiveRefinement => rows(entries),
        // Columns, and the mean of rows and columns: twice the entries at most.
        Solver::ConjugateGradients => rows(entries) + 8 * (2 * entries).min(pairs),
        _ => 0,
    }
}

/// Elements that a hemicube shows, at most: as many as pixels that fall at random on elements of one
/// size would find. Some look larger than others, and those take pixels from them. The most open of
/// rooms, a cube seen from its walls, shows 0.7 of it.
fn shown(elements: u64, resolution: u32) -> u64 {
    let (elements, pixels) = (elements as f64, 3.0 * f64::from(resolution).powi(2));
    (elements * -(-pixels / elements.max(1.0)).exp_m1()).ceil() as u64
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::radiosity::baker_test::{quad, room};
    use crate::radiosity::pipeline::run;
    use crate::radiosity::stages::Start;
    use crate::radiosity::{Light, LightKind, Material, MaterialId, Object, Scene};

    fn floor() -> ValidScene {
        let scene = Scene {
            objects: vec![Object {
                positions: vec![
                    Vec3::ZERO,
                    Vec3::Z * 7.0,
                    Vec3::new(10.0, 0.0, 7.0),
                    Vec3::X * 10.0,
                ],
                normals: vec![Vec3::Y; 4],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material: MaterialId(0),
                ..Object::default()
            }],
            materials: vec![Material::default()],
            sky: Vec3::ONE,
            ..Scene::default()
        };
        scene.validate().unwrap()
    }

    #[test]
    fn counts_are_near_what_a_bake_has() {
        for max_edge in [None, Some(3.0), Some(1.0), Some(0.3), Some(0.1)] {
            let settings = BakeSettings {
                max_edge,
                refine: false,
                ..BakeSettings::DRAFT
            };
            let rough = estimate_counts(&floor(), &settings);
            let exact = estimate(&floor(), &settings, &()).unwrap();
            let ratio = rough.vertices as f64 / exact.vertices as f64;
            assert!((0.5..2.0).contains(&ratio), "{max_edge:?}: {ratio}");
            assert!(exact.seconds > 0.0);
        }
    }

    #[test]
    fn absurd_edges_are_counted_without_overflow() {
        let settings = BakeSettings {
            max_edge: Some(1e-30),
            element_rays: 4096,
            gather_rays: 4096,
            emitter_rays: 4096,
            samples_per_vertex: 1e4,
            elements: 4_000_000,
            refine: false,
            ..BakeSettings::FINAL
        };
        assert!(estimate_counts(&floor(), &settings).bytes > 1 << 40);
    }

    /// A cube seen from inside, which has no corner that is hidden from another.
    fn cube() -> ValidScene {
        let [x, y, z] = Vec3::AXES;
        let lamp = LightKind::Point {
            position: Vec3::splat(0.4),
            range: f32::INFINITY,
        };
        let faces = [
            [Vec3::ZERO, z, x],
            [y, x, z],
            [Vec3::ZERO, y, z],
            [x, z, y],
            [Vec3::ZERO, x, y],
            [z, y, x],
        ];
        let scene = Scene {
            objects: (1..).zip(faces).map(|(k, f)| quad(k, f, 1, 0)).collect(),
            materials: vec![Material::default()],
            lights: vec![Light {
                kind: lamp,
                power: Vec3::ONE,
                ..Light::default()
            }],
            ..Scene::default()
        };
        scene.validate().unwrap()
    }

    /// Nothing a bake holds of the matrix is beyond the estimate, and of a scene where all elements
    /// see each other the estimate is not far above it either.
    #[test]
    fn matrices_hold_no_more_than_estimated() {
        let form_factors = [
            FormFactors::HitList,
            FormFactors::Hemicube { resolution: 16 },
            FormFactors::Hemicube { resolution: 64 },
            FormFactors::Analytic { visibility_rays: 1 },
            FormFactors::AreaSampling { samples: 1 },
        ];
        let solvers = [
            Solver::GaussSeidelMeanField,
            Solver::ProgressiveRefinement,
            Solver::ConjugateGradients,
        ];
        let scenes = [(room().validate().unwrap(), 150), (cube(), 500)];
        for (scene, elements) in &scenes {
            for form_factors in form_factors {
                for solver in solvers {
                    let settings = BakeSettings {
                        elements: *elements,
                        form_factors,
                        solver,
                        gather_rays: 1,
                        refine: false,
                        ..BakeSettings::DRAFT
                    };
                    let (bake, stages) = run(scene, &settings, Start::default(), &()).unwrap();
                    let held = stages.traced.rows.bytes() + bake.report.solver.bytes;
                    let estimated = matrix_bytes(&settings, stages.elements.len() as u64);
                    let what = format!("{form_factors:?}, {solver:?}: {held} of {estimated}");
                    assert!(held <= estimated, "{what}");
                    // A hit list is held twice while it is made, and pairs half again. Conjugate
                    // gradients hold columns only while they make their rows.
                    let times = if solver == Solver::ConjugateGradients {
                        4
                    } else {
                        3
                    };
                    let all_seen = *elements == 500;
                    assert!(!all_seen || estimated <= times * held, "{what}");
                }
            }
        }
    }
}

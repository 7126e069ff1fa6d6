//! What is asked beside the methods: how many sweeps solvers take, what more elements are worth,
//! and what is left of a method's error at vertices.

use bevy_fresco::radiosity::{
    Bake, BakeError, BakeSettings, Element, ElementLight, FormFactors, ObjectId, Scene, Solver,
    bake,
};
use glam::Vec3;

use crate::measure::{luminance, solve};
use crate::methods::{FAMILIES, SOLVERS, base};
use crate::metrics::compare;
use crate::plan::Plan;
use crate::scenes::{SUBJECTS, bright_room, unit_cube};

/// How a solver did in the bright room.
pub(crate) struct Solved {
    pub(crate) solver: &'static str,
    pub(crate) reflectance: f32,
    pub(crate) sweeps: u32,
    pub(crate) converged: bool,
    pub(crate) seconds: f64,
    /// Its bound on its error, and the largest error it has, by the mean.
    pub(crate) bound: f64,
    pub(crate) error: f64,
}

pub(crate) const REFLECTANCES: [f32; 8] = [0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.98, 0.99];

/// What the solver's bound must come below.
pub(crate) const SOLVED_TO: f32 = 1e-4;

/// Sweeps of every solver in a closed room of any reflectance.
pub(crate) fn solvers(plan: &Plan) -> Result<Vec<Solved>, BakeError> {
    let mut results = Vec::new();
    for &reflectance in plan.some(&REFLECTANCES) {
        let scene = bright_room(reflectance).validate()?;
        let settings = |solver, tolerance| BakeSettings {
            solver,
            solver_tolerance: tolerance,
            max_sweeps: 2000,
            element_rays: 64,
            emitter_rays: 16,
            ..base(1000)
        };
        for (name, solver) in SOLVERS {
            // The symmetrised system is another one.
            let best = match solver {
                Solver::ConjugateGradients => solver,
                _ => Solver::GaussSeidelMeanField,
            };
            let (exact, _) = solve(&scene, &settings(best, 1e-6))?;
            let (light, cost) = solve(&scene, &settings(solver, SOLVED_TO))?;
            let report = &light.report.solver;
            let (error, mean) = largest_difference(&light, &exact);
            results.push(Solved {
                solver: name,
                reflectance,
                sweeps: report.sweeps,
                converged: report.converged,
                seconds: cost.solve,
                bound: report.error_bound / mean,
                error: error / mean,
            });
        }
    }
    Ok(results)
}

/// The largest difference of reflected light, and the mean of it.
fn largest_difference(light: &ElementLight, exact: &ElementLight) -> (f64, f64) {
    let (mut largest, mut sum, mut area) = (0.0_f64, 0.0, 0.0);
    for (a, b) in light.elements.iter().zip(&exact.elements) {
        let reflected = |e: &Element| luminance(e.radiosity - e.emission);
        largest = largest.max((reflected(a) - reflected(b)).abs());
        sum += f64::from(b.area) * reflected(b);
        area += f64::from(b.area);
    }
    (largest, sum / area)
}

/// The error on so many elements against the continuum, by a series' name.
pub(crate) struct Refined {
    pub(crate) series: &'static str,
    pub(crate) elements: usize,
    pub(crate) error: f64,
}

pub(crate) const CONTINUUM: &str = "faces, exact form factors";
pub(crate) const BY_RAYS: &str = "faces, hit list of 1,024 rays";
pub(crate) const AT_POINTS: &str = "vertices at seven points";

/// Mean radiosity of floor, ceiling and walls of the unit cube, ρ = 0.5, ceiling at 1 (element
/// solutions on graded meshes, extrapolated; good to 5 digits).
const FACES: [f64; 3] = [0.171_216, 1.104_361, 0.181_105_6];

/// Radiosity at points of it: centre, quarter, middle of an edge and corner of the floor, centre,
/// foot and upright edge of a wall.
const POINTS: [(usize, Vec3, f64); 7] = [
    (0, Vec3::new(0.5, 0.0, 0.5), 0.197_605),
    (0, Vec3::new(0.25, 0.0, 0.25), 0.177_533),
    (0, Vec3::new(0.5, 0.0, 0.0), 0.155_737),
    (0, Vec3::new(0.0, 0.0, 0.0), 0.108_542),
    (2, Vec3::new(0.0, 0.5, 0.5), 0.177_647_6),
    (2, Vec3::new(0.0, 0.0, 0.5), 0.111_30),
    (2, Vec3::new(0.0, 0.5, 0.0), 0.135_996),
];
const REFLECTANCE: f32 = 0.5;

/// The unit cube on more and more elements.
pub(crate) fn elements(plan: &Plan) -> Result<Vec<Refined>, BakeError> {
    let cube = unit_cube(REFLECTANCE);
    let scene = cube.clone().validate()?;
    let mut results = Vec::new();
    // Elements along an edge: each face is two triangles of n² elements.
    let along = [1_u32, 2, 4, 6, 9, 12, 18, 24, 36];
    let largest = if plan.quick { 1000 } else { u32::MAX };
    for &n in along.iter().filter(|&n| 12 * n * n <= largest) {
        let count = 12 * n * n;
        let exact = BakeSettings {
            form_factors: FormFactors::Analytic { visibility_rays: 1 },
            sample_emitters: false,
            ..base(count)
        };
        let rays = BakeSettings {
            element_rays: 1024,
            sample_emitters: false,
            ..base(count)
        };
        let pairs_fit = count <= 4000;
        for (series, settings) in [
            (CONTINUUM, pairs_fit.then_some(exact)),
            (BY_RAYS, Some(rays)),
        ] {
            if let Some(settings) = settings {
                let (light, _) = solve(&scene, &settings)?;
                results.push(Refined {
                    series,
                    elements: light.elements.len(),
                    error: error_of_faces(&light),
                });
            }
        }
        results.push(at_points(&cube, count, n)?);
    }
    Ok(results)
}

/// Root mean square of the relative errors of the three kinds of faces.
fn error_of_faces(light: &ElementLight) -> f64 {
    let mut sums = [(0.0, 0.0); 3];
    for element in &light.elements {
        let (ObjectId(face), area) = (element.object, f64::from(element.area));
        let sum = &mut sums[face as usize];
        sum.0 += area * luminance(element.radiosity);
        sum.1 += area;
    }
    let off = |((light, area), truth): ((f64, f64), f64)| (light / area / truth - 1.0).powi(2);
    let squares: f64 = sums.into_iter().zip(FACES).map(off).sum();
    (squares / 3.0).sqrt()
}

/// Vertices as dense as the elements, gathered by many rays.
fn at_points(scene: &Scene, elements: u32, along: u32) -> Result<Refined, BakeError> {
    let settings = BakeSettings {
        // Edges are halved, so the points are vertices from quarters on.
        max_edge: Some(1.5 / along.next_power_of_two().clamp(4, 16) as f32),
        element_rays: 512,
        gather_rays: 256,
        samples_per_vertex: 12.0,
        ..base(elements)
    };
    let baked = bake(&scene.clone().validate()?, &settings, &())?;
    let squares: f64 = POINTS
        .iter()
        .map(|&(object, point, truth)| {
            let found = light_at(scene, &baked, object, point) * f64::from(REFLECTANCE);
            (found / truth - 1.0).powi(2)
        })
        .sum();
    Ok(Refined {
        series: AT_POINTS,
        elements: baked.report.counts.elements as usize,
        error: (squares / POINTS.len() as f64).sqrt(),
    })
}

/// The light of the vertex nearest to a point.
fn light_at(scene: &Scene, baked: &Bake, object: usize, point: Vec3) -> f64 {
    let given = &scene.objects[object];
    let object = &baked.objects[object];
    let positions = (object.mesh.as_ref()).map_or_else(
        || given.positions.clone(),
        |mesh| mesh.positions(&given.positions, &given.triangles),
    );
    let nearest = (positions.iter().zip(&object.light))
        .min_by(|a, b| a.0.distance(point).total_cmp(&b.0.distance(point)));
    nearest.map_or(0.0, |(_, &light)| luminance(light))
}

/// The error of a method at elements, and what is left of it at vertices.
pub(crate) struct AtVertices {
    pub(crate) method: &'static str,
    pub(crate) budget: u32,
    pub(crate) vertices: usize,
    pub(crate) error: f64,
    /// The sampling error that the bake reports itself.
    pub(crate) estimate: f64,
    pub(crate) seconds: f64,
}

/// The Cornell box baked by every method, against a long bake.
pub(crate) fn vertices(plan: &Plan) -> Result<Vec<AtVertices>, BakeError> {
    let Some(subject) = SUBJECTS.iter().find(|s| s.id == "S3") else {
        return Ok(Vec::new());
    };
    let scene = (subject.build)(1000).validate()?;
    let shared = |settings: BakeSettings| BakeSettings {
        max_edge: Some(0.5),
        gather_rays: 128,
        samples_per_vertex: 10.0,
        ..settings
    };
    let long = BakeSettings {
        element_rays: if plan.quick { 256 } else { 4096 },
        gather_rays: if plan.quick { 256 } else { 2048 },
        emitter_rays: 256,
        seed: 1000,
        ..shared(base(4000))
    };
    let truth = values(&bake(&scene, &long, &())?);
    let mut results = Vec::new();
    for family in &FAMILIES {
        for &budget in family.budgets.iter().take(3).step_by(2) {
            let baked = bake(&scene, &shared(family.settings(budget, 1000)), &())?;
            let samples: Vec<[f64; 3]> = (values(&baked).into_iter().zip(&truth))
                .map(|(found, &truth)| [1.0, found, truth])
                .collect();
            results.push(AtVertices {
                method: family.name,
                budget,
                vertices: samples.len(),
                error: compare(&samples).l2,
                estimate: f64::from(baked.report.sampling_error),
                seconds: baked.report.stages.iter().map(|s| s.1.as_secs_f64()).sum(),
            });
        }
    }
    Ok(results)
}

fn values(baked: &Bake) -> Vec<f64> {
    let light = baked.objects.iter().flat_map(|o| &o.light);
    light.map(|&l| luminance(l)).collect()
}

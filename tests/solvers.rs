//! The solvers against a dense elimination, against each other, and how many sweeps they take.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use std::sync::Mutex;

use bevy_fresco::radiosity::{
    Bake, BakeSettings, ElementLight, Material, ObjectLight, Observer, PartialLight,
    PreviewSettings, Solver, ValidScene, bake, preview, solve_elements,
};
use common::{grey, quad, room, scene};
use glam::{Vec3, Vec4};

/// A closed box with a shining ceiling, everything of one reflectance.
fn closed_box(rho: f32) -> ValidScene {
    let objects = room(Vec3::new(2.0, 1.5, 3.0), 1, [0, 1, 0, 0, 0, 0]);
    let materials = vec![grey(rho, 0.0), grey(rho, 1.0)];
    scene(objects, materials).validate().unwrap()
}

/// White floor, ceiling and back, a red and a green wall, a lamp, a block; open in front.
fn open_room() -> ValidScene {
    let color = |r, g, b| Material {
        base_color: Vec4::new(r, g, b, 1.0),
        ..Material::default()
    };
    let lamp = Material {
        emissive: Vec3::new(17.0, 12.0, 4.0),
        ..color(0.73, 0.73, 0.73)
    };
    let mut objects = room(Vec3::ONE, 1, [0, 0, 1, 2, 0, 0]);
    objects.pop();
    let (x, z) = (Vec3::X * 0.25, Vec3::Z * 0.2);
    objects.push(quad("lamp", Vec3::new(0.38, 0.99, 0.4), x, z, 1, 3));
    let at = Vec3::new(0.2, 0.0, 0.3);
    let (x, y, z) = (Vec3::X * 0.3, Vec3::Y * 0.4, Vec3::Z * 0.3);
    for (a, u, v) in [
        (at + y, z, x),
        (at, y, x),
        (at + z, x, y),
        (at, z, y),
        (at + x, y, z),
    ] {
        objects.push(quad("block", a, u, v, 1, 0));
    }
    let materials = vec![
        color(0.73, 0.73, 0.73),
        color(0.63, 0.065, 0.05),
        color(0.14, 0.45, 0.091),
        lamp,
    ];
    scene(objects, materials).validate().unwrap()
}

fn settings(solver: Solver, elements: u32) -> BakeSettings {
    BakeSettings {
        solver,
        elements,
        element_rays: 256,
        solver_tolerance: 1e-4,
        max_sweeps: 2000,
        refine: false,
        adapt: false,
        ..BakeSettings::BALANCED
    }
}

/// Reflected light `R = ρ (D + F R)` of one channel by Gaussian elimination, in f64. Rows are
/// dominated by their diagonal: no pivoting is needed.
fn eliminated(light: &ElementLight, channel: usize) -> Vec<f64> {
    let n = light.elements.len();
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let element = &light.elements[i];
            let rho = f64::from(element.reflectance[channel]);
            let mut row: Vec<f64> = light.row(i).into_iter().map(|f| -rho * f).collect();
            row[i] += 1.0;
            row.push(rho * f64::from(element.direct[channel]));
            row
        })
        .collect();
    for k in 0..n {
        let (above, below) = rows.split_at_mut(k + 1);
        let pivot = &above[k];
        for row in below {
            let factor = row[k] / pivot[k];
            for (x, p) in row[k..].iter_mut().zip(&pivot[k..]) {
                *x -= factor * p;
            }
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[i][j] * x[j]).sum();
        x[i] = (rows[i][n] - known) / rows[i][i];
    }
    x
}

fn reflected(light: &ElementLight, channel: usize) -> Vec<f64> {
    let of = |e: &bevy_fresco::radiosity::Element| {
        f64::from(e.reflectance[channel]) * f64::from(e.irradiance[channel])
    };
    light.elements.iter().map(of).collect()
}

/// Error relative to the truth, both as roots of squares summed over area.
fn relative_error(light: &ElementLight, found: &[f64], truth: &[f64]) -> f64 {
    let area = |i: usize| f64::from(light.elements[i].area);
    let squares = |of: &dyn Fn(usize) -> f64| -> f64 {
        (0..truth.len()).map(|i| area(i) * of(i).powi(2)).sum()
    };
    (squares(&|i| found[i] - truth[i]) / squares(&|i| truth[i])).sqrt()
}

/// ρ · row sum at most: by how much errors shrink in a bounce.
fn contraction(light: &ElementLight) -> f64 {
    let one = |i: usize| f64::from(light.elements[i].reflectance.max_element()) * light.row_sum(i);
    (0..light.elements.len()).map(one).fold(0.0, f64::max)
}

#[test]
fn all_solvers_agree_with_elimination_within_their_bounds() {
    let scene = open_room();
    let reference = solve_elements(&scene, &settings(Solver::GaussSeidel, 600), &()).unwrap();
    let count = reference.elements.len();
    assert!((400..900).contains(&count), "{count} elements");
    let truth: Vec<Vec<f64>> = (0..3).map(|c| eliminated(&reference, c)).collect();
    for solver in Solver::ALL {
        let light = solve_elements(&scene, &settings(solver, 600), &()).unwrap();
        let report = &light.report.solver;
        assert!(report.converged, "{solver:?}: {report:?}");
        assert_eq!((report.solver, report.fell_back), (solver, None));
        // What the report allows; for conjugate gradients also the other matrix.
        let area: f64 = light.elements.iter().map(|e| f64::from(e.area)).sum();
        let mean = |c: usize| -> f64 {
            let sum = light.elements.iter().zip(reflected(&light, c));
            sum.map(|(e, r)| f64::from(e.area) * r).sum::<f64>() / area
        };
        let mean = mean(0).max(mean(1)).max(mean(2));
        // f32 keeps seven digits.
        let allowed = report.error_bound
            + report.asymmetry * mean / (1.0 - contraction(&light))
            + 1e-6 * mean;
        for (c, truth) in truth.iter().enumerate() {
            let found = reflected(&light, c);
            let worst = (found.iter().zip(truth)).fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
            assert!(
                worst <= allowed,
                "{solver:?}: {worst:e} off, {allowed:e} allowed"
            );
            let error = relative_error(&light, &found, truth);
            // Another estimate of the same light: within the noise of 256 rays.
            let limit = if solver == Solver::ConjugateGradients {
                0.02
            } else {
                1e-4
            };
            assert!(error < limit, "{solver:?}: {error:e}");
        }
    }
}

#[test]
fn light_does_not_depend_on_the_number_of_threads() {
    let scene = open_room();
    for solver in Solver::ALL {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let settings = settings(solver, 3000);
            let light = pool
                .unwrap()
                .install(|| solve_elements(&scene, &settings, &()));
            light.unwrap()
        };
        let (one, three) = (on(1), on(3));
        assert_eq!(one.elements, three.elements, "{solver:?}");
        assert_eq!(one.report.solver, three.report.solver);
    }
}

/// Sweeps until the error is below 1e-4, by bisection over `max_sweeps`.
fn sweeps_to_four_digits(scene: &ValidScene, solver: Solver, most: u32) -> u32 {
    let after = |sweeps: u32| {
        let settings = BakeSettings {
            max_sweeps: sweeps,
            solver_tolerance: 1e-12,
            ..settings(solver, 1000)
        };
        solve_elements(scene, &settings, &()).unwrap()
    };
    // Conjugate gradients have a system, and so a solution, of their own.
    let truth = if solver == Solver::ConjugateGradients {
        reflected(&after(60), 0)
    } else {
        eliminated(&after(0), 0)
    };
    let good = |sweeps: u32| {
        let light = after(sweeps);
        relative_error(&light, &reflected(&light, 0), &truth) < 1e-4
    };
    let (mut bad, mut enough) = (0, most);
    assert!(good(most), "{solver:?}: more than {most} sweeps");
    while enough - bad > 1 {
        let middle = bad.midpoint(enough);
        if good(middle) {
            enough = middle;
        } else {
            bad = middle;
        }
    }
    enough
}

#[test]
fn solvers_take_as_many_sweeps_as_theory_says() {
    let bright = closed_box(0.95);
    let sweeps = |solver, most| sweeps_to_four_digits(&bright, solver, most);
    let gauss_seidel = sweeps(Solver::GaussSeidel, 200);
    let jacobi = sweeps(Solver::Jacobi, 400);
    let sor = sweeps(Solver::Sor { omega: 1.2 }, 200);
    let mean_field = sweeps(Solver::GaussSeidelMeanField, 50);
    let gradients = sweeps(Solver::ConjugateGradients, 50);
    let found = (gauss_seidel, jacobi, sor, mean_field, gradients);
    // Errors shrink by ρ a bounce: 1e-4 from the start takes ln(1e-4) / ln(0.95) = 180 at most.
    assert!((140..=185).contains(&jacobi), "{found:?}");
    // Two bounces a sweep where all see all alike.
    assert!((75..=95).contains(&gauss_seidel), "{found:?}");
    // (2 − ω) / ω of that.
    assert!((45..=65).contains(&sor), "{found:?}");
    assert!(mean_field <= 12, "{found:?}");
    assert!(gradients <= 14, "{found:?}");
}

#[test]
fn a_mean_field_and_gradients_do_not_mind_bright_walls() {
    for solver in [Solver::GaussSeidelMeanField, Solver::ConjugateGradients] {
        let sweeps = sweeps_to_four_digits(&closed_box(0.99), solver, 50);
        assert!(sweeps <= 14, "{solver:?}: {sweeps}");
        if solver == Solver::GaussSeidelMeanField {
            assert!(sweeps <= 12, "{sweeps}");
        }
    }
    let open = sweeps_to_four_digits(&open_room(), Solver::GaussSeidelMeanField, 50);
    assert!(open <= 8, "{open}");
}

#[test]
fn gradients_find_their_way_through_a_row_of_rooms() {
    let mut objects = room(Vec3::new(6.0, 2.0, 2.0), 1, [0, 0, 1, 0, 0, 0]);
    for x in [2.0, 4.0] {
        let (y, z) = (Vec3::Y * 2.0, Vec3::Z * 1.8);
        objects.push(quad("wall with a gap", Vec3::X * x, y, z, 1, 2));
    }
    let sheet = Material {
        double_sided: true,
        ..grey(0.95, 0.0)
    };
    let materials = vec![grey(0.95, 0.0), grey(0.95, 1.0), sheet];
    let rooms = scene(objects, materials).validate().unwrap();
    let gradients = sweeps_to_four_digits(&rooms, Solver::ConjugateGradients, 50);
    let mean_field = sweeps_to_four_digits(&rooms, Solver::GaussSeidelMeanField, 100);
    let gauss_seidel = sweeps_to_four_digits(&rooms, Solver::GaussSeidel, 200);
    let found = (gradients, mean_field, gauss_seidel);
    assert!(gradients <= 14, "{found:?}");
    assert!(
        3 * gradients < mean_field && mean_field < gauss_seidel,
        "{found:?}"
    );
}

/// Looks at all partial light there is.
#[derive(Default)]
struct Looking(Mutex<Vec<(u64, f64, Vec<ObjectLight>)>>);

impl Observer for Looking {
    fn partial(&self, light: &PartialLight) {
        let seen = (light.shots(), light.unshot(), light.objects());
        self.0.lock().unwrap().push(seen);
    }
}

fn vertex_values(objects: &[ObjectLight]) -> Vec<Vec3> {
    objects
        .iter()
        .flat_map(|o| o.light.iter().copied())
        .collect()
}

#[test]
fn partial_light_nears_the_final_light() {
    let scene = open_room();
    let looking = Looking::default();
    let settings = settings(Solver::ProgressiveRefinement, 600);
    let light = solve_elements(&scene, &settings, &looking).unwrap();
    let seen = looking.0.into_inner().unwrap();
    let last = vertex_values(&seen.last().unwrap().2);
    assert_eq!(seen.last().unwrap().0, light.report.solver.shots);
    assert!(seen.len() > 10);
    // Vertices belong to the objects' own meshes, in order.
    assert_eq!(seen[0].2.len(), 11);
    // The final light of a vertex is that of elements around it.
    let brightest = light
        .elements
        .iter()
        .map(|e| e.irradiance.x)
        .fold(0.0, f32::max);
    assert!(last.iter().all(|l| l.x > 0.0 && l.x <= brightest * 1.001));
    let error = |objects: &[ObjectLight]| {
        let sums = vertex_values(objects)
            .into_iter()
            .zip(&last)
            .fold((0.0, 0.0), |s, (a, b)| {
                (s.0 + (a - *b).length_squared(), s.1 + b.length_squared())
            });
        (sums.0 / sums.1).sqrt()
    };
    let errors: Vec<f32> = seen.iter().map(|s| error(&s.2)).collect();
    // Never much worse than before, and a tenth of it gone with each sweep or so.
    for pair in errors.windows(2) {
        assert!(pair[1] <= 1.3 * pair[0] + 1e-4, "{errors:?}");
    }
    assert!(errors[errors.len() / 2] < 0.5 * errors[0], "{errors:?}");
    assert!(seen.windows(2).all(|s| s[1].1 <= s[0].1 + 1e-3));
    // The ambient term makes the first look as bright as the last.
    let mean = |values: &[Vec3]| values.iter().sum::<Vec3>() / values.len() as f32;
    let ratio = mean(&vertex_values(&seen[0].2)) / mean(&last);
    assert!(
        ratio.min_element() > 0.6 && ratio.max_element() < 1.6,
        "{ratio}"
    );
}

#[test]
fn partial_light_ends_near_that_of_a_bake() {
    let mut objects = room(Vec3::new(2.0, 1.5, 3.0), 1, [0, 1, 0, 2, 0, 0]);
    // One wall is lit from behind, and a sheet in the middle has no elements.
    for t in &mut objects[3].triangles {
        t.swap(1, 2);
    }
    let middle = Vec3::new(0.8, 0.7, 1.0);
    let mut sheet = quad("sheet", middle, Vec3::Z, Vec3::X * 0.4, 1, 0);
    sheet.casts = false;
    objects.push(sheet);
    let double_sided = Material {
        double_sided: true,
        ..grey(0.5, 0.0)
    };
    let materials = vec![grey(0.5, 0.0), grey(0.5, 1.0), double_sided];
    let scene = scene(objects, materials).validate().unwrap();
    let looking = Looking::default();
    let settings = BakeSettings {
        max_edge: Some(0.3),
        ..settings(Solver::ProgressiveRefinement, 2000)
    };
    let bake = bake(&scene, &settings, &looking).unwrap();
    let seen = looking.0.into_inner().unwrap();
    let last = &seen.last().unwrap().2;
    assert_eq!(last.len(), bake.objects.len());
    for (o, (rough, fitted)) in last.iter().zip(&bake.objects).enumerate() {
        assert_eq!(rough.mesh, fitted.mesh);
        assert!(rough.mesh.is_some() && rough.light.len() == fitted.light.len());
        if o == 6 {
            // It gets the mean of the vertices.
            assert!(
                rough
                    .light
                    .iter()
                    .all(|l| *l == rough.light[0] && l.x > 0.1)
            );
            continue;
        }
        let pairs = || rough.light.iter().zip(&fitted.light);
        let squares: f32 = pairs().map(|(a, b)| (a.x - b.x).powi(2)).sum();
        let size: f32 = pairs().map(|(_, b)| b.x.powi(2)).sum();
        // Elements are as large as triangles are, and edges between walls bend.
        assert!(
            (squares / size).sqrt() < 0.12,
            "object {o}: {}",
            (squares / size).sqrt()
        );
    }
}

#[test]
fn partial_light_can_be_drawn() {
    let scene = open_room();
    let looking = Looking::default();
    let settings = settings(Solver::ProgressiveRefinement, 300);
    solve_elements(&scene, &settings, &looking).unwrap();
    let seen = looking.0.into_inner().unwrap();
    let draw = |objects: &[ObjectLight]| {
        let bake = Bake {
            objects: objects.to_vec(),
            ..Bake::default()
        };
        let settings = PreviewSettings {
            width: 40,
            height: 30,
            ..PreviewSettings::default()
        };
        let picture = preview(&scene, &bake, &settings, &()).unwrap();
        let sum = |p: &[u8; 3]| p.iter().map(|&c| u64::from(c)).sum::<u64>();
        picture.pixels.iter().map(sum).sum::<u64>() as f64 / (3.0 * 40.0 * 30.0)
    };
    let (first, last) = (draw(&seen[0].2), draw(&seen.last().unwrap().2));
    assert!(first > 20.0 && last > 20.0, "{first} {last}");
}

#[test]
fn every_solver_shows_its_sweeps() {
    for solver in Solver::ALL {
        let looking = Looking::default();
        let light = solve_elements(&closed_box(0.5), &settings(solver, 200), &looking).unwrap();
        let seen = looking.0.into_inner().unwrap();
        let report = &light.report.solver;
        assert!(seen.len() > report.sweeps as usize, "{solver:?}");
        assert!(seen.last().unwrap().1 < 1e-3, "{solver:?}");
        assert_eq!(report.residuals.len(), report.sweeps as usize + 1);
        assert_eq!(
            report.bytes > 0,
            matches!(
                solver,
                Solver::ProgressiveRefinement | Solver::ConjugateGradients
            )
        );
    }
}

#[test]
fn falling_back_is_told() {
    // ω near 2 swings: errors of a closed room hardly shrink, and grow at times.
    let solver = Solver::Sor { omega: 1.98 };
    let light = solve_elements(&closed_box(0.95), &settings(solver, 300), &()).unwrap();
    let report = &light.report;
    assert!(report.solver.converged);
    assert_eq!(report.solver.fell_back, Some(solver));
    assert_eq!(report.solver.solver, Solver::GaussSeidelMeanField);
    let told = |n: &String| n.contains("over-relaxation") && n.contains("omega");
    assert!(report.notes.iter().any(told), "{:?}", report.notes);
}

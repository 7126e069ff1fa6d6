use glam::{Vec3, Vec3A};

use super::enclosure::{ALONE, Enclosure, facing_plates, ring};
use super::*;
use crate::radiosity::element::Elements;
use crate::radiosity::form_factor::{HitList, Matrix};
use crate::radiosity::sampling::hash;
use crate::radiosity::settings::BakeSettings;

const SOLVERS: [Solver; 7] = [
    Solver::GaussSeidelMeanField,
    Solver::GaussSeidel,
    Solver::Jacobi,
    Solver::Sor { omega: 1.2 },
    Solver::Sor { omega: 1.9 },
    Solver::ProgressiveRefinement,
    Solver::ConjugateGradients,
];

#[test]
fn the_bound_covers_the_error_of_random_enclosures() {
    for solver in SOLVERS {
        let mut looseness = Vec::new();
        for seed in 0..120 {
            let given = Enclosure::random(seed);
            for sweeps in [0, 1, 3, 100] {
                let solution = given.solved(solver, 1e-4, sweeps);
                let report = &solution.report;
                // Conjugate gradients answer for the system they solved.
                let symmetric = report.solver == Solver::ConjugateGradients;
                let enclosure = if symmetric {
                    &given.symmetrized()
                } else {
                    &given
                };
                let error = enclosure.largest_error(&solution);
                let (bound, storage) = (report.error_bound, enclosure.storage());
                assert!(
                    error <= bound + storage,
                    "{solver:?}, seed {seed}, {sweeps} sweeps: error {error:e}, bound {bound:e}"
                );
                assert!(report.sweeps <= sweeps);
                assert!(report.residuals.contains(&report.residual));
                if report.shots == 0 {
                    assert_eq!(report.residuals.len(), report.sweeps as usize + 1);
                } else {
                    let n = given.direct.len() as u64;
                    assert_eq!(u64::from(report.sweeps), report.shots.div_ceil(n));
                    // A step that ended early is looked at, too.
                    assert!(report.residuals.len() > report.sweeps as usize);
                }
                if sweeps == 3 {
                    looseness.push(bound / error.max(storage));
                }
            }
        }
        looseness.sort_by(f64::total_cmp);
        assert!(looseness[60] < 30.0, "{solver:?}: {}", looseness[60]);
    }
}

#[test]
fn all_solvers_find_the_same_light() {
    for seed in 0..30 {
        let enclosure = Enclosure::random(seed);
        let reference = enclosure.solved(Solver::GaussSeidelMeanField, 1e-4, 2000);
        assert!(reference.report.converged);
        for solver in SOLVERS {
            let solution = enclosure.solved(solver, 1e-4, 2000);
            let report = &solution.report;
            assert!(report.converged, "{solver:?}, seed {seed}: {report:?}");
            let mut allowed =
                report.error_bound + reference.report.error_bound + enclosure.storage();
            if report.solver == Solver::ConjugateGradients {
                // The residual in the given system bounds the distance to its solution as well.
                let mean = enclosure.elements.mean(&solution.reflected).max_element();
                allowed += report.asymmetry * mean / (1.0 - enclosure.system().contraction());
                assert!(report.asymmetry > 0.0);
            } else {
                assert_eq!(report.asymmetry, 0.0);
            }
            for (a, b) in solution.reflected.iter().zip(&reference.reflected) {
                let apart = f64::from((*a - *b).abs().max_element());
                assert!(
                    apart <= allowed,
                    "{solver:?}, seed {seed}: {apart:e} > {allowed:e}"
                );
            }
            assert_eq!(report.shots > 0, solver == Solver::ProgressiveRefinement);
        }
    }
}

#[test]
fn symmetrized_rows_obey_reciprocity_and_sum_up_as_given() {
    for seed in 0..30 {
        let given = Enclosure::random(seed);
        let symmetric = given.symmetrized();
        let area = |e: usize| f64::from(given.elements.area[e]);
        for i in 0..given.direct.len() {
            let (sum, was) = (symmetric.rows.row_sum(i), given.rows.row_sum(i));
            assert!(
                (sum - was).abs() < 1e-5,
                "seed {seed}: row {i} sums to {sum}, not {was}"
            );
            for j in 0..i {
                let (there, back) = (
                    symmetric.matrix[i][j] * area(i),
                    symmetric.matrix[j][i] * area(j),
                );
                assert!((there - back).abs() <= 1e-6 * there, "{there} {back}");
            }
        }
    }
}

#[test]
fn facing_plates_converge_or_fall_back() {
    for rho in [0.5, 0.9, 0.99] {
        let plates = facing_plates(16, rho);
        for solver in [
            Solver::Jacobi,
            Solver::Sor { omega: 0.5 },
            Solver::Sor { omega: 1.5 },
            Solver::Sor { omega: 1.9 },
            Solver::Sor { omega: 1.99 },
            Solver::ProgressiveRefinement,
            Solver::ConjugateGradients,
        ] {
            let solution = plates.solved(solver, 1e-3, 2000);
            let report = &solution.report;
            assert!(report.converged, "{solver:?}, rho {rho}: {report:?}");
            assert_eq!(report.fell_back.is_some(), report.solver != solver);
            assert!(report.fell_back.is_none_or(|s| s == solver));
            let error = plates.largest_error(&solution);
            assert!(
                error <= report.error_bound + plates.storage(),
                "{solver:?}: {error}"
            );
        }
    }
}

#[test]
fn a_growing_residual_hands_over() {
    let ring = ring(30, 0.95);
    let solver = Solver::Sor { omega: 1.9 };
    let solution = ring.solved(solver, 1e-3, 500);
    let report = &solution.report;
    assert_eq!(report.fell_back, Some(solver));
    assert_eq!(report.solver, Solver::GaussSeidelMeanField);
    assert!(report.converged, "{report:?}");
    assert_eq!(report.residuals.len(), report.sweeps as usize + 1);
    assert!(ring.largest_error(&solution) <= report.error_bound + ring.storage());
    // Without sweeps left, the best light there was.
    let short = ring.solved(solver, 1e-3, 2).report;
    let least = short
        .residuals
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    assert!(!short.converged && short.fell_back.is_none());
    assert_eq!(short.residual, least);
}

#[test]
fn bright_closed_rooms_take_few_sweeps() {
    // Rows that see everything alike: plain Gauss–Seidel needs hundreds of sweeps at ρ = 0.99.
    let n = 64;
    let ids: Vec<Vec<Option<u32>>> = (0..n)
        .map(|e| (0..128).map(|i| Some(hash(e, i) % n)).collect())
        .collect();
    let enclosure = Enclosure {
        elements: Elements::for_test(vec![Vec3::splat(0.99); n as usize], vec![1.0; n as usize]),
        rows: Matrix::Hits(HitList::from_rows(&ids)),
        direct: (0..n)
            .map(|e| Vec3::splat(f32::from(u8::from(e < 4))))
            .collect(),
        matrix: Vec::new(),
    };
    for solver in [Solver::GaussSeidelMeanField, Solver::ConjugateGradients] {
        let report = enclosure.solved(solver, 1e-3, 100).report;
        assert!(report.converged && report.sweeps <= 20, "{report:?}");
    }
    let plain = enclosure.solved(Solver::GaussSeidel, 1e-3, 1000).report;
    assert!(plain.converged && plain.sweeps > 100, "{plain:?}");
}

#[test]
fn stopping_early_is_reported() {
    for solver in SOLVERS {
        let report = Enclosure::random(2).solved(solver, 1e-9, 2).report;
        assert!(!report.converged, "{solver:?}");
        assert_eq!(report.sweeps, 2, "{solver:?}");
        if solver == Solver::GaussSeidel {
            assert!(report.residuals.is_sorted_by(|a, b| a >= b), "{report:?}");
        }
    }
}

#[test]
fn a_start_at_the_solution_is_enough() {
    for solver in SOLVERS {
        let enclosure = Enclosure::random(5);
        let first = enclosure.solved(solver, 1e-3, 2000);
        let settings = BakeSettings {
            solver: first.report.solver,
            solver_tolerance: 2e-3,
            refine: false,
            ..BakeSettings::DRAFT
        };
        let start = Some(first.reflected);
        let again = solve(&enclosure.system(), &settings, start, &ALONE).unwrap();
        assert_eq!(again.report.sweeps, 0, "{solver:?}");
        // Too bright a start: shooting takes light back.
        let bright = again.reflected.iter().map(|r| *r * 3.0 + 1.0).collect();
        let again = solve(&enclosure.system(), &settings, Some(bright), &ALONE).unwrap();
        assert!(again.report.converged, "{solver:?}");
    }
}

#[test]
fn giving_up_is_asked_for_often() {
    let enclosure = Enclosure::random(8);
    for solver in SOLVERS {
        let settings = BakeSettings {
            solver,
            solver_tolerance: 1e-5,
            refine: false,
            ..BakeSettings::DRAFT
        };
        // How often it asks to the end, and that each of these is heard.
        let asked = std::cell::Cell::new(0);
        let watch_until = |last: u32| {
            asked.set(0);
            let go_on = || {
                asked.set(asked.get() + 1);
                asked.get() <= last
            };
            let watch = Watch {
                go_on: &go_on,
                show: &|_| {},
            };
            solve(&enclosure.system(), &settings, None, &watch).map(|s| s.report.sweeps)
        };
        let sweeps = watch_until(u32::MAX).unwrap();
        let all = asked.get();
        assert!(
            all > sweeps,
            "{solver:?} asks {all} times in {sweeps} sweeps"
        );
        for last in 0..all {
            assert!(
                watch_until(last).is_err(),
                "{solver:?} goes on after question {last}"
            );
        }
    }
}

#[test]
fn the_ambient_term_is_what_is_missing_where_all_are_alike() {
    // Everything sees everything, itself too: before any shot the ambient term is the answer.
    let n = 8;
    let rho = Vec3::new(0.5, 0.9, 0.0);
    let row: Vec<Option<u32>> = (0..n).map(Some).chain(vec![None; 2]).collect();
    let rows = Matrix::Hits(HitList::from_rows(&vec![row; n as usize]));
    let elements = Elements::for_test(vec![rho; n as usize], vec![2.0; n as usize]);
    let direct = vec![Vec3::splat(3.0); n as usize];
    let system = System {
        elements: &elements,
        rows: &rows,
        direct: &direct,
    };
    let glimpse = Glimpse {
        system,
        sweeps: 0,
        shots: 0,
        arriving: &direct,
        reflected: &vec![Vec3A::ZERO; n as usize],
    };
    let truth = Vec3::splat(3.0) / (Vec3::ONE - rho * 0.8);
    let shown = direct[0] + glimpse.ambient();
    assert!(
        (shown - truth).abs().max_element() < 1e-5,
        "{shown}, {truth}"
    );
    assert_eq!(glimpse.unshot_share(), 1.0);
}

#[test]
fn light_is_shown_after_powers_of_two_and_often_after_that() {
    let enclosure = Enclosure::random(5);
    let n = enclosure.direct.len() as u64;
    let shown = std::cell::RefCell::new(Vec::new());
    let watch = Watch {
        go_on: &|| true,
        show: &|g| shown.borrow_mut().push((g.shots, g.unshot_share())),
    };
    let settings = BakeSettings {
        solver: Solver::ProgressiveRefinement,
        solver_tolerance: 1e-3,
        refine: false,
        ..BakeSettings::DRAFT
    };
    let report = solve(&enclosure.system(), &settings, None, &watch)
        .unwrap()
        .report;
    let shown = shown.into_inner();
    assert_eq!(shown[0], (0, 1.0));
    assert_eq!(shown[1].0, 1);
    assert_eq!(shown[2].0, 2);
    assert_eq!(shown.last().unwrap().0, report.shots);
    assert!(shown.is_sorted_by_key(|s| s.0), "{shown:?}");
    assert!(
        shown.len() as u64 <= 6 + 10 * (report.shots / n + 1),
        "{}",
        shown.len()
    );
    assert!(shown.last().unwrap().1 < 1e-3, "{shown:?}");
}

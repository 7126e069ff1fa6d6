//! Systems of which the exact solution is known, for tests.

use glam::Vec3;

use super::symmetric::symmetrized;
use super::{Solution, Solver, System, Watch, solve};
use crate::radiosity::element::Elements;
use crate::radiosity::form_factor::{HitList, Matrix};
use crate::radiosity::sampling::{hash, unit_float};
use crate::radiosity::settings::BakeSettings;

/// Nobody watches.
pub(super) const ALONE: Watch = Watch {
    go_on: &|| true,
    show: &|_| {},
};

/// A random enclosure: `n` elements, rows of hits at random, some open, reflectances up to `brightest`.
pub(super) struct Enclosure {
    pub(super) elements: Elements,
    pub(super) rows: Matrix,
    pub(super) direct: Vec<Vec3>,
    pub(super) matrix: Vec<Vec<f64>>,
}

impl Enclosure {
    pub(super) fn random(seed: u32) -> Self {
        let random = |a: u32, b: u32| unit_float(hash(hash(seed, a), b));
        let n = 4 + hash(seed, 1) as usize % 60;
        let rays = 16 << (hash(seed, 2) % 3);
        let brightest = [0.5, 0.9, 0.99][seed as usize % 3];
        let open = [0.0, 0.2][hash(seed, 3) as usize % 2];
        let reflectance: Vec<Vec3> = (0..n as u32)
            .map(|e| {
                Vec3::new(random(e, 10), random(e, 11), brightest)
                    * Vec3::new(1.0, 0.5, 1.0).min(Vec3::splat(brightest))
            })
            .collect();
        let ids: Vec<Vec<Option<u32>>> = (0..n as u32)
            .map(|e| {
                let hit = |i: u32| {
                    (random(e, 100 + i) >= open).then(|| hash(hash(seed, e), 5000 + i) % n as u32)
                };
                (0..rays).map(hit).collect()
            })
            .collect();
        let mut matrix = vec![vec![0.0; n]; n];
        for (e, row) in ids.iter().enumerate() {
            for &id in row.iter().flatten() {
                matrix[e][id as usize] += 1.0 / f64::from(rays);
            }
        }
        Self {
            direct: (0..n as u32)
                .map(|e| Vec3::new(random(e, 20), random(e, 21).powi(8), f32::from(e == 0)))
                .collect(),
            elements: Elements::for_test(
                reflectance,
                (0..n as u32).map(|e| 0.1 + random(e, 30)).collect(),
            ),
            rows: Matrix::Hits(HitList::from_rows(&ids)),
            matrix,
        }
    }

    /// Reflected light by Gaussian elimination with partial pivoting, one channel.
    pub(super) fn exact(&self, channel: usize) -> Vec<f64> {
        let n = self.direct.len();
        let rho = |i: usize| f64::from(self.elements.reflectance[i][channel]);
        let mut a: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let mut row: Vec<f64> = (0..n)
                    .map(|j| f64::from(u8::from(i == j)) - rho(i) * self.matrix[i][j])
                    .collect();
                row.push(rho(i) * f64::from(self.direct[i][channel]));
                row
            })
            .collect();
        for k in 0..n {
            let pivot = (k..n)
                .max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))
                .unwrap();
            a.swap(k, pivot);
            for i in k + 1..n {
                let factor = a[i][k] / a[k][k];
                let pivot = a[k].clone();
                for (x, p) in a[i].iter_mut().zip(&pivot).skip(k) {
                    *x -= factor * p;
                }
            }
        }
        let mut x = vec![0.0; n];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| a[i][j] * x[j]).sum();
            x[i] = (a[i][n] - known) / a[i][i];
        }
        x
    }

    /// The enclosure whose matrix is what conjugate gradients make of this one's.
    pub(super) fn symmetrized(&self) -> Self {
        let rows = symmetrized(&self.system(), &ALONE).unwrap();
        let n = self.direct.len();
        let mut matrix = vec![vec![0.0; n]; n];
        for (e, row) in matrix.iter_mut().enumerate() {
            rows.each(e, |j, w| row[j as usize] += f64::from(w));
        }
        Self {
            elements: Elements::for_test(
                self.elements.reflectance.clone(),
                self.elements.area.clone(),
            ),
            direct: self.direct.clone(),
            rows,
            matrix,
        }
    }

    pub(super) fn system(&self) -> System<'_> {
        System {
            elements: &self.elements,
            rows: &self.rows,
            direct: &self.direct,
        }
    }

    pub(super) fn solved(&self, solver: Solver, tolerance: f32, sweeps: u32) -> Solution {
        let settings = BakeSettings {
            solver,
            solver_tolerance: tolerance,
            max_sweeps: sweeps,
            refine: false,
            ..BakeSettings::DRAFT
        };
        solve(&self.system(), &settings, None, &ALONE).unwrap()
    }

    pub(super) fn largest_error(&self, solution: &Solution) -> f64 {
        let channel = |c: usize| {
            let found = solution.reflected.iter().map(move |r| f64::from(r[c]));
            let exact = self.exact(c).into_iter();
            exact.zip(found).map(|(x, r)| (x - r).abs())
        };
        (0..3).flat_map(channel).fold(0.0, f64::max)
    }

    /// Radiances are stored as f32: half a unit in the last place is not the solver's.
    pub(super) fn storage(&self) -> f64 {
        1e-6 * self.exact(2).into_iter().fold(1.0, f64::max)
    }
}

/// Two plates that see nothing but each other, `n` elements each: an eigenvalue −ρ beside ρ.
pub(super) fn facing_plates(n: u32, rho: f32) -> Enclosure {
    let row = |e: u32| {
        (0..n)
            .map(|j| Some(j + if e < n { n } else { 0 }))
            .collect()
    };
    let ids: Vec<Vec<Option<u32>>> = (0..2 * n).map(row).collect();
    let count = 2 * n as usize;
    let mut matrix = vec![vec![0.0; count]; count];
    for (row, ids) in matrix.iter_mut().zip(&ids) {
        ids.iter()
            .flatten()
            .for_each(|&j| row[j as usize] = 1.0 / f64::from(n));
    }
    Enclosure {
        elements: Elements::for_test(vec![Vec3::splat(rho); count], vec![1.0; count]),
        rows: Matrix::Hits(HitList::from_rows(&ids)),
        direct: (0..2 * n)
            .map(|e| Vec3::splat(f32::from(u8::from(e < n))) * unit_float(hash(e, 7)))
            .collect(),
        matrix,
    }
}

/// A room where every element sees the next more than itself, all in a ring: over-relaxation
/// diverges where eigenvalues are far from real.
pub(super) fn ring(n: u32, rho: f32) -> Enclosure {
    let ids: Vec<Vec<Option<u32>>> = (0..n).map(|e| vec![Some((e + n - 1) % n); 4]).collect();
    let mut matrix = vec![vec![0.0; n as usize]; n as usize];
    for (e, row) in ids.iter().enumerate() {
        row.iter()
            .flatten()
            .for_each(|&j| matrix[e][j as usize] += 0.25);
    }
    Enclosure {
        elements: Elements::for_test(vec![Vec3::splat(rho); n as usize], vec![1.0; n as usize]),
        rows: Matrix::Hits(HitList::from_rows(&ids)),
        direct: (0..n)
            .map(|e| Vec3::splat(unit_float(hash(e, 3))))
            .collect(),
        matrix,
    }
}

use glam::{DVec3, Vec3, Vec3A};

use super::element::Elements;
use super::form_factor::HitList;
use super::report::SolverReport;

/// A solution of the radiosity system.
pub(crate) struct Solution {
    /// Light that arrives at each element (irradiance / π).
    pub(crate) arriving: Vec<Vec3>,
    /// Light that leaves each element by reflection (radiosity / π without emission).
    pub(crate) reflected: Vec<Vec3A>,
    pub(crate) report: SolverReport,
}

/// Solves for the reflected light `R = ρ (D + F R)`, `D` the direct light at each element.
///
/// Gauss–Seidel: every element in turn gathers from the newest values (Cohen and Greenberg 1985).
/// A row of the hit list sums to at most 1 and ρ < 1, so it always converges, but slowly where light
/// bounces often. So each sweep is followed by a *mean-field* correction: the multiple `c` of ρ
/// that, added everywhere, makes the area-weighted sum of the residual `r` vanish,
///
/// ```text
///   R ← R + c ρ     Σ A r = c Σ A ρ (1 − F ρ)     (one channel at a time)
///   ┌─────────────────────────────────────┐
///   │  c = Σ A r / Σ A ρ (1 − F ρ)        │
///   └─────────────────────────────────────┘
/// ```
///
/// which removes the slowest mode, light that is everywhere too low by the same factor.
pub(crate) fn gauss_seidel(
    elements: &Elements,
    rows: &HitList,
    direct: &[Vec3],
    tolerance: f32,
    max_sweeps: u32,
    mut progress: impl FnMut(u32) -> bool,
) -> Solution {
    let system = System {
        elements,
        rows,
        direct,
    };
    let contraction = system.contraction();
    let mean_field = system.mean_field_gain();
    let mut reflected: Vec<Vec3A> = (0..direct.len())
        .map(|e| (direct[e] * elements.reflectance[e]).into())
        .collect();
    let mut report = SolverReport::default();
    loop {
        // The residual of the state as it is: what the bound and the correction are made of.
        let residual = system.residual(&reflected);
        let scale = system.mean(&reflected).max_element().max(f64::MIN_POSITIVE);
        report.residual = residual.largest;
        report.error_bound = report.residual / (1.0 - contraction);
        report.converged =
            report.error_bound <= f64::from(tolerance) * scale || report.residual == 0.0;
        if report.converged || report.sweeps >= max_sweeps || !progress(report.sweeps) {
            break;
        }
        let correction = (residual.weighted_sum / mean_field).as_vec3();
        if correction.is_finite() {
            for (r, rho) in reflected.iter_mut().zip(&elements.reflectance) {
                *r = (*r + Vec3A::from(correction * *rho)).max(Vec3A::ZERO);
            }
        }
        for e in 0..reflected.len() {
            reflected[e] = system.reflect(e, &reflected).as_vec3a();
        }
        report.sweeps += 1;
    }
    Solution {
        arriving: (0..reflected.len())
            .map(|e| system.arriving(e, &reflected).as_vec3())
            .collect(),
        reflected,
        report,
    }
}

struct System<'a> {
    elements: &'a Elements,
    rows: &'a HitList,
    direct: &'a [Vec3],
}

struct Residual {
    largest: f64,
    weighted_sum: DVec3,
}

impl System<'_> {
    fn arriving(&self, e: usize, reflected: &[Vec3A]) -> DVec3 {
        self.direct[e].as_dvec3() + self.rows.gather(e, reflected)
    }

    fn reflect(&self, e: usize, reflected: &[Vec3A]) -> DVec3 {
        self.elements.reflectance[e].as_dvec3() * self.arriving(e, reflected)
    }

    fn residual(&self, reflected: &[Vec3A]) -> Residual {
        let mut residual = Residual {
            largest: 0.0,
            weighted_sum: DVec3::ZERO,
        };
        for (e, &current) in reflected.iter().enumerate() {
            let r = self.reflect(e, reflected) - current.as_dvec3();
            residual.largest = residual.largest.max(r.abs().max_element());
            residual.weighted_sum += r * f64::from(self.elements.area[e]);
        }
        residual
    }

    /// Largest ρ · row sum: the factor by which an error shrinks in one bounce, at worst.
    fn contraction(&self) -> f64 {
        let worst = (0..self.direct.len())
            .map(|e| f64::from(self.elements.reflectance[e].max_element()) * self.rows.row_sum(e));
        worst.fold(0.0, f64::max)
    }

    /// Σ A ρ (1 − F ρ).
    fn mean_field_gain(&self) -> DVec3 {
        let rho: Vec<Vec3A> = self
            .elements
            .reflectance
            .iter()
            .map(|&r| r.into())
            .collect();
        (0..self.direct.len())
            .map(|e| {
                let lost = DVec3::ONE - self.rows.gather(e, &rho);
                rho[e].as_dvec3() * lost * f64::from(self.elements.area[e])
            })
            .sum()
    }

    fn mean(&self, values: &[Vec3A]) -> DVec3 {
        let areas = &self.elements.area;
        let total: f64 = areas.iter().map(|&a| f64::from(a)).sum();
        let sum: DVec3 = values
            .iter()
            .zip(areas)
            .map(|(v, &a)| v.as_dvec3() * f64::from(a))
            .sum();
        sum / total.max(f64::MIN_POSITIVE)
    }
}

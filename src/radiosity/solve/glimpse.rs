use glam::{DVec3, Vec3, Vec3A};

use crate::radiosity::parallel::Cancelled;

use super::system::System;

/// Who watches a solver at work.
pub(crate) struct Watch<'a> {
    /// Asked often; `false` ends the work.
    pub(crate) go_on: &'a dyn Fn() -> bool,
    /// Shown the light there is, after each sweep and at the start; by progressive refinement also
    /// in between.
    pub(crate) show: &'a dyn Fn(&Glimpse),
}

impl Watch<'_> {
    pub(super) fn ask(&self) -> Result<(), Cancelled> {
        if (self.go_on)() {
            Ok(())
        } else {
            Err(Cancelled)
        }
    }
}

/// Light on its way to the solution.
pub(crate) struct Glimpse<'a> {
    pub(crate) system: System<'a>,
    pub(crate) sweeps: u32,
    pub(crate) shots: u64,
    /// `D + F R` at each element.
    pub(crate) arriving: &'a [Vec3],
    /// `R`.
    pub(crate) reflected: &'a [Vec3A],
}

impl Glimpse<'_> {
    /// `r = ρ (D + F R) − R`: light that arrived and was not passed on yet.
    fn unshot(&self, e: usize) -> DVec3 {
        let reflects = self.system.reflectance(e) * self.arriving[e].as_dvec3();
        reflects - self.reflected[e].as_dvec3()
    }

    /// Σ A of a value.
    fn total(&self, value: impl Fn(usize) -> DVec3) -> DVec3 {
        let area = &self.system.elements.area;
        (0..self.system.len())
            .map(|e| value(e) * f64::from(area[e]))
            .sum()
    }

    /// How much of the light that surfaces reflect was not passed on yet, 0..=1.
    pub(crate) fn unshot_share(&self) -> f64 {
        let unshot = self.total(|e| self.unshot(e).abs()).element_sum();
        let shot = self.total(|e| self.reflected[e].as_dvec3().abs());
        unshot / (unshot + shot.element_sum()).max(f64::MIN_POSITIVE)
    }

    /// What unshot light will bring to an element, were all alike: the ambient term of Cohen, Chen,
    /// Wallace and Greenberg (1988). Of the light `u` that waits, the share `s` that does not
    /// escape arrives; of that ρ̄ is reflected and the same share of it arrives again, and so on.
    /// With means over area,
    ///
    /// ```text
    ///   ┌──────────────────────────────────────────────────────┐
    ///   │  ambient = mean(s u) / (1 − mean(s ρ))               │
    ///   └──────────────────────────────────────────────────────┘
    /// ```
    ///
    /// In a closed room `s = 1`, which is theirs. For display: the solution never contains it.
    pub(crate) fn ambient(&self) -> Vec3 {
        let area: f64 = (self.system.elements.area.iter())
            .map(|&a| f64::from(a))
            .sum();
        let kept = |e: usize| self.system.rows.row_sum(e);
        let arrives = self.total(|e| self.unshot(e) * kept(e));
        let again = self.total(|e| self.system.reflectance(e) * kept(e));
        let lost = (DVec3::splat(area) - again).max(DVec3::splat(f64::MIN_POSITIVE));
        (arrives / lost).as_vec3()
    }
}

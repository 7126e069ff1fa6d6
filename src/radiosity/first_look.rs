use std::sync::Arc;

use glam::{Vec3, Vec3A};

use super::color::luminance;
use super::element::{ElementId, Elements};
use super::form_factor::Traced;
use super::importance::Importance;
use super::layout::{Cut, Layout, USUAL};
use super::settings::BakeSettings;
use super::surroundings::Surroundings;
use super::validate::ValidScene;

/// Parts along the edge of a patch, at most.
const MOST_PARTS: f64 = 8.0;

/// Rays of an element, at least, and times the usual number at most.
const LEAST_RAYS: f64 = 8.0;
const MOST_RAYS: f64 = 8.0;

/// Steps to the right scale, each of which halves the digits it may be off by: enough for one part in
/// a thousand of it. Wishes further below the largest than this are as good as none.
const HALVINGS: u32 = 20;
const SMALLEST: f64 = 1e-30;

/// What a first look at a scene found: the light of its patches.
pub(crate) struct FirstLook {
    pub(crate) elements: Arc<Elements>,
    /// What leaves each and form factors find.
    pub(crate) seen: Vec<Vec3A>,
    /// What arrives at each (irradiance / π).
    pub(crate) arriving: Vec<Vec3>,
    /// The same by spot, as each half of their rays tells it.
    pub(crate) halves: [Vec<Vec3A>; 2],
}

/// What is known of a patch.
#[derive(Clone, Copy, Debug, Default)]
struct Need {
    /// An element on it, and how many there are: one, or one on each side.
    element: usize,
    sides: f64,
    /// Area times the difference of what is sent, of both sides, as it matters.
    uneven: f64,
    /// Area times the standard deviation that one ray leaves in what is sent, as it matters.
    noisy: f64,
}

impl FirstLook {
    /// How finely each patch should be cut, and how many rays its elements should cast.
    ///
    /// A patch of area `A` whose light differs by `δ` from one end to the other, cut into `m²`
    /// elements, leaves out `δ/m` in each of them; `S` rays leave `σ/√S` to chance. The sum of squares
    /// is least, for so many elements and rays, where each leaves out as much as any other:
    ///
    /// ```text
    ///   min Σ m² (A/m² · δ/m)²  with  Σ m² = N          min Σ (ρ A σ)²/S  with  Σ S = N S̄
    ///   ┌─────────────┐                                 ┌─────────────┐
    ///   │  m³ ∝ A δ   │                                 │  S ∝ ρ A σ  │
    ///   └─────────────┘                                 └─────────────┘
    /// ```
    ///
    /// (What is sent counts, as in the brightness-weighted refinement of Hanrahan, Salzman and
    /// Aupperle 1991, and by its [`Importance`].)
    pub(crate) fn layout(
        &self,
        scene: &ValidScene,
        traced: &Traced,
        layout: &Layout,
        settings: &BakeSettings,
    ) -> Layout {
        let elements = &self.elements;
        // In the dark nothing tells where light will be.
        if self.seen.iter().all(|&light| light == Vec3A::ZERO) {
            return layout.looked_at(Vec::new(), settings);
        }
        let objects = self.needs(scene, traced, layout.patch);
        let needs: Vec<&Need> = objects.iter().flatten().collect();
        let count = |i: usize, m| {
            let need: &Need = needs[i];
            need.sides * elements.parts(need.element, layout.patch, m)
        };
        let patches = elements.iter_area().sum::<f64>() / f64::from(layout.patch);
        let parts = share_out(
            &(needs.iter())
                .map(|need| need.uneven.cbrt())
                .collect::<Vec<_>>(),
            (1.0, USUAL.into(), MOST_PARTS),
            count,
            patches * f64::from(USUAL).powi(2),
        );
        let count = |i: usize| count(i, parts[i]);
        let usual = f64::from(settings.element_rays);
        // The first look took some already.
        let spent: f64 = elements.rays.iter().map(|&rays| f64::from(rays)).sum();
        let rays = share_out(
            &(needs.iter().enumerate())
                .map(|(i, need)| need.noisy / count(i))
                .collect::<Vec<_>>(),
            (LEAST_RAYS.min(usual), usual, MOST_RAYS * usual),
            |i, rays| count(i) * rays,
            usual * (0..needs.len()).map(count).sum::<f64>() - spent,
        );
        let mut cuts = parts.iter().zip(&rays).map(|(&m, &rays)| Cut {
            m: m as u8,
            rays: rays as u16,
        });
        let of_object = objects
            .iter()
            .map(|o| cuts.by_ref().take(o.len()).collect());
        layout.looked_at(of_object.collect(), settings)
    }

    /// The needs of the patches of each object.
    fn needs(&self, scene: &ValidScene, traced: &Traced, patch: f32) -> Vec<Vec<Need>> {
        let elements = &self.elements;
        let places: Vec<_> = (0..elements.len())
            .map(|e| elements.middle(scene, ElementId(e as u32)))
            .collect();
        let mut surroundings = Surroundings::new(patch.sqrt());
        for (e, &place) in places.iter().enumerate() {
            let halves = traced.halves(e, elements, &self.seen, scene.sky);
            let noise = halves.map_or(0.0, |[a, b]| {
                f64::from(luminance((a - b) * 0.5 * elements.reflectance[e]))
            });
            let light = f64::from(luminance(self.seen[e].into()));
            let area = f64::from(elements.area[e] / patch);
            surroundings.add(place, area, light, noise * noise);
        }
        let importance = Importance::new(elements, traced, &self.arriving);
        let of_object = |o| {
            let mut needs: Vec<Need> = Vec::new();
            for e in elements.of_object(o) {
                let p = elements.patch[e] as usize;
                if needs.len() <= p {
                    needs.resize(p + 1, Need::default());
                }
                let around = surroundings.around(places[e]);
                let area = f64::from(elements.area[e] / patch * importance.of(e));
                let need = &mut needs[p];
                need.element = e;
                need.sides += 1.0;
                need.uneven += area * around.difference();
                need.noisy += area * (around.noise() * f64::from(elements.rays[e])).sqrt();
            }
            needs
        };
        (0..scene.objects.len()).map(of_object).collect()
    }
}

/// Whole numbers in proportion to `wishes`, within limits, that cost no more than the budget, or all
/// the least where even these cost more. Where nothing is wished for, all get what is usual.
fn share_out(
    wishes: &[f64],
    (least, usual, most): (f64, f64, f64),
    cost: impl Fn(usize, f64) -> f64,
    budget: f64,
) -> Vec<f64> {
    let (smallest, largest) = (wishes.iter().filter(|w| **w > 0.0))
        .fold((f64::INFINITY, 0.0), |(lo, hi), &w| (w.min(lo), w.max(hi)));
    if largest == 0.0 {
        return vec![usual; wishes.len()];
    }
    let share = |wish: f64, scale: f64| (scale * (wish / largest)).round().clamp(least, most);
    // Between all at the least and all at the most.
    let (mut low, mut high) = (0.5 * least, most / (smallest / largest).max(SMALLEST));
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        let each = wishes.iter().enumerate();
        let total: f64 = each.map(|(i, &w)| cost(i, share(w, middle))).sum();
        if total <= budget {
            low = middle;
        } else {
            high = middle;
        }
    }
    wishes.iter().map(|&w| share(w, low)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_shared_out_in_proportion_and_kept() {
        let limits = (1.0, 4.0, 100.0);
        let each = |wishes: &[f64], budget| share_out(wishes, limits, |_, x| x, budget);
        assert_eq!(each(&[1.0, 2.0, 4.0], 70.0), [10.0, 20.0, 40.0]);
        // Limits hold, and what one cannot take others get.
        assert_eq!(each(&[0.0, 1.0, 1e9], 151.0), [1.0, 50.0, 100.0]);
        assert_eq!(each(&[1.0, 1.0], 1.0), [1.0, 1.0]);
        assert_eq!(each(&[0.0, 0.0], 100.0), [4.0, 4.0]);
        let costs = share_out(&[1.0, 1.0], limits, |i, x| (i + 1) as f64 * x, 30.0);
        assert_eq!(costs, [10.0, 10.0]);
        // Of the smallest and the largest numbers nothing but numbers come.
        for wish in [f64::MIN_POSITIVE, 1e-300, 1e300, f64::MAX] {
            let shares = each(&[0.0, wish, 2.0 * (wish / 4.0)], 30.0);
            assert!(
                shares.iter().all(|x| (1.0..=100.0).contains(x)),
                "{shares:?}"
            );
        }
    }
}

use std::sync::Arc;

use glam::Vec3A;

use super::color::luminance;
use super::element::{ElementId, Elements};
use super::form_factor::Traced;
use super::layout::{Cut, Layout, USUAL};
use super::settings::BakeSettings;
use super::surroundings::Surroundings;
use super::validate::ValidScene;

/// Parts along the edge of a patch, at most.
const MOST_PARTS: f64 = 8.0;

/// Rays of an element, at least, and times the usual number at most.
const LEAST_RAYS: f64 = 8.0;
const MOST_RAYS: f64 = 8.0;

/// Steps to the right scale: of factors up to 10³⁰⁰ enough for a thousandth.
const HALVINGS: u32 = 20;

/// What a first look at a scene found: the light of its patches.
pub(crate) struct FirstLook {
    pub(crate) elements: Arc<Elements>,
    /// What leaves each and form factors find.
    pub(crate) seen: Vec<Vec3A>,
}

/// What is known of a patch.
#[derive(Clone, Copy, Debug, Default)]
struct Need {
    /// An element on it, and how many there are: one, or one on each side.
    element: usize,
    sides: f64,
    /// Area times the difference of what is sent, of both sides.
    uneven: f64,
    /// Area times the standard deviation that one ray leaves in what is sent.
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
    /// Aupperle 1991.)
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
            needs.iter().map(|need| need.uneven.cbrt()).collect(),
            (1.0, MOST_PARTS),
            count,
            patches * f64::from(USUAL).powi(2),
        );
        let count = |i: usize| count(i, parts[i]);
        let usual = f64::from(settings.element_rays);
        // The first look took some already.
        let spent: f64 = elements.rays.iter().map(|&rays| f64::from(rays)).sum();
        let rays = share_out(
            (needs.iter().enumerate())
                .map(|(i, need)| need.noisy / count(i))
                .collect(),
            (LEAST_RAYS.min(usual), MOST_RAYS * usual),
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
        let of_object = |o| {
            let mut needs: Vec<Need> = Vec::new();
            for e in elements.of_object(o) {
                let p = elements.patch[e] as usize;
                if needs.len() <= p {
                    needs.resize(p + 1, Need::default());
                }
                let around = surroundings.around(places[e]);
                let area = f64::from(elements.area[e] / patch);
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

/// Whole numbers in proportion to `wishes`, within limits, that cost no more than the budget, or as
/// little as the least do. Where nothing is wished for, all get the least.
fn share_out(
    wishes: Vec<f64>,
    (least, most): (f64, f64),
    cost: impl Fn(usize, f64) -> f64,
    budget: f64,
) -> Vec<f64> {
    let at = |scale: f64| {
        let wish = move |w: &f64| (scale * w).round().clamp(least, most);
        wishes.iter().map(wish)
    };
    let affordable = |scale| at(scale).enumerate().map(|(i, x)| cost(i, x)).sum::<f64>() <= budget;
    let positive = || wishes.iter().copied().filter(|&w| w > 0.0);
    // Between all at the least and all at the most.
    let mut low = 0.5 * least / positive().fold(f64::MIN_POSITIVE, f64::max);
    let mut high = most / positive().fold(f64::MAX, f64::min);
    for _ in 0..HALVINGS {
        let middle = low.sqrt() * high.sqrt();
        if affordable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(low).collect()
}

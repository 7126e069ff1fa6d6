use glam::{Vec3, Vec3A};

use super::color::luminance;
use super::element::Elements;
use super::form_factor::Traced;

/// How much it matters what elements send (importance: Smits, Arvo and Salesin 1992, "An Importance-Driven
/// Radiosity Algorithm"; here all receivers ask, each beside its own light).
///
/// A ray from receiver `j` meets element `e`, of area `A_e`, with the chance `F_je`. Where the element sends `δ` too
/// much, or is met by chance, that leaves `F_je δ²` in the mean square error of a ray's light, beside the square of
/// `E_j`, the light there, or of `E₀`, the [`Level`](super::level::Level) of the scene, if that is more. Over all receivers, `A_j F_je`
/// being `A_e F_ej`:
///
/// ```text
///   Σ_j A_j F_je δ² / max(E₀, E_j)²
///                                  ┌───────────────────────────────────────┐
///     = A_e (w_e δ / E₀)²          │  w_e² = Σ_j F_ej (E₀ / max(E₀, E_j))² │
///                                  └───────────────────────────────────────┘
/// ```
///
/// so that `w` is between 0 and 1. The ceiling right above a lamp that hangs below it matters little, bright as it
/// is: it shines on the back of the lamp alone, which is as bright.
pub(crate) struct Importance<'a> {
    traced: &'a Traced,
    /// By element that receives: (E₀ / max(E₀, E))².
    squares: Vec<Vec3A>,
    /// E₀: luminance of what arrives, / π.
    pub(crate) level: f32,
}

impl<'a> Importance<'a> {
    pub(crate) fn new(elements: &Elements, traced: &'a Traced, arriving: &[Vec3]) -> Self {
        let level = elements.level(arriving).least();
        let least = level.max(f64::MIN_POSITIVE);
        let square = |&light: &Vec3| {
            let light = f64::from(luminance(light));
            Vec3A::splat((least / light.max(least)).powi(2) as f32)
        };
        Self {
            traced,
            squares: arriving.iter().map(square).collect(),
            level: level as f32,
        }
    }

    /// Of what element `e` sends.
    pub(crate) fn of(&self, e: usize) -> f32 {
        (self.traced.rows.gather(e, &self.squares).x as f32).sqrt()
    }
}

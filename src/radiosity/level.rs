/// How bright a scene is, to hold errors of its light against.
///
/// Errors count beside the mean over the surface; where light is far brighter than that, beside the
/// light itself. Else the spot above a lamp, that no one can tell from a brighter one, would be all that
/// a scene's error tells of, and take all vertices.
///
/// ```text
///   ┌────────────────────────────────────────────────────────────┐
///   │  e² = mean (ΔE / max(E₀, E / HOT))²    E₀ = mean min(E, HOT Ē) │
///   └────────────────────────────────────────────────────────────┘
/// ```
///
/// with `Ē` the mean of `E`. Where no light is above `HOT Ē` it is the relative RMSE.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Level {
    mean: f64,
}

/// Above so many times the mean errors count beside the light itself.
const HOT: f64 = 4.0;

impl Level {
    /// Of pieces of surface, each with its area and the light there.
    pub(crate) fn of(pieces: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let area: f64 = pieces.clone().map(|(area, _)| area).sum();
        let mean = |most: f64| {
            let sum: f64 = pieces.clone().map(|(a, light)| a * light.min(most)).sum();
            sum / area.max(f64::MIN_POSITIVE)
        };
        Self {
            mean: mean(HOT * mean(f64::INFINITY)),
        }
    }

    /// What errors are held against where there is no light far above the mean: `E₀`.
    pub(crate) fn least(&self) -> f64 {
        self.mean
    }

    /// The square of an error beside the level, where there is so much light; 0 in a dark scene.
    pub(crate) fn relative(&self, square: f64, light: f64) -> f64 {
        if self.mean > 0.0 {
            square / self.mean.max(light / HOT).powi(2)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_light_is_held_against_the_mean_and_hot_spots_against_themselves() {
        let even = Level::of([(1.0, 1.0), (3.0, 2.0)].into_iter());
        assert_eq!(even.relative(1.75 * 1.75, 2.0), 1.0);
        // A hundredth of the surface a thousand times as bright: it would be nine tenths of the mean.
        let hot = Level::of([(0.99, 1.0), (0.01, 1000.0)].into_iter());
        assert!((hot.relative(1.0, 1.0).sqrt() - 1.0 / 1.43).abs() < 0.01);
        assert!((hot.relative(100.0 * 100.0, 1000.0).sqrt() - 0.4).abs() < 1e-9);
        assert_eq!(Level::of([(1.0, 0.0)].into_iter()).relative(1.0, 0.0), 0.0);
        assert_eq!(Level::of([].into_iter()).relative(1.0, 0.0), 0.0);
    }
}

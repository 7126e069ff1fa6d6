use glam::{Vec2, Vec3};

/// How much slopes of a map vary on a surface, in metres a metre, squared: both directions together.
///
/// `variance` is that of `F_u` and `F_v`, `gradients` those of `u` and `v`. Whether the two vary together is not
/// known; it counts where `u` and `v` are not at right angles on the surface.
pub fn slope_variance(variance: Vec2, gradients: [Vec3; 2]) -> f32 {
    variance.x * gradients[0].length_squared() + variance.y * gradients[1].length_squared()
}

/// Perceptual roughness (0..1) of a surface whose slopes vary by `variance` beside what its normal tells.
///
/// A surface of microfacets of roughness `α` has slopes of variance `α²/2` in each of two directions; variances
/// add up (M. Olano and D. Baker, "LEAN mapping", I3D 2010):
///
/// ```text
///   ┌─────────────────────────────┐
///   │  α'² = α² + σ_x² + σ_y²      │      α = perceptual²
///   └─────────────────────────────┘
/// ```
///
/// as both directions share one `α` here.
pub fn roughened(perceptual: f32, variance: f32) -> f32 {
    let squared = perceptual.max(0.0).powi(4) + variance.max(0.0);
    squared.min(1.0).sqrt().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_add_up() {
        for (perceptual, variance) in [(0.1_f32, 0.05_f32), (0.5, 0.2), (0.089, 0.0)] {
            let added = roughened(perceptual, variance).powi(4) - perceptual.powi(4);
            assert!((added - variance).abs() < 1e-6);
        }
        assert_eq!(roughened(0.9, 5.0), 1.0);
    }

    #[test]
    fn variance_is_by_metre() {
        // A map that is 2 m wide and 0.5 m high.
        let gradients = [Vec3::X / 2.0, Vec3::Y / 0.5];
        let found = slope_variance(Vec2::new(0.04, 0.01), gradients);
        assert!((found - (0.04 / 4.0 + 0.01 * 4.0)).abs() < 1e-7);
    }
}

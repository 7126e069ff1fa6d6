use glam::Vec3;

/// Less than this of the raised normal along the base's: too steep to go along it.
const UPRIGHT: f32 = 1e-3;

/// A tangent `t` of the base with the normal `base`, on the raised surface with the normal `raised`, both of
/// length one.
///
/// Who steps along it on the base goes up or down with the surface, along the base's normal:
///
/// ```text
///   ┌───────────────────────┐
///   │  t' ∝ t − N (t·n) / (N·n)  │      N: normal of the base, n: of the raised surface
///   └───────────────────────┘
/// ```
///
/// so that `t'` still is the way in which a texture coordinate grows, as a normal map needs it; to take from `t`
/// what points along `n` would turn it to the side on relief that slopes across it. Where the surface stands
/// upright on the base there is no such way, and that is done.
pub fn raised_tangent(tangent: Vec3, base: Vec3, raised: Vec3) -> Vec3 {
    let upright = base.dot(raised);
    let turned = match upright > UPRIGHT {
        true => tangent - base * (tangent.dot(raised) / upright),
        false => tangent.reject_from_normalized(raised),
    };
    (turned.try_normalize()).unwrap_or_else(|| raised.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a slope that goes up in neither of the map's directions, both are those of the surface.
    #[test]
    fn tangents_are_steps_on_the_surface() {
        let (fu, fv) = (0.7, -1.3);
        let normal = Vec3::new(-fu, -fv, 1.0).normalize();
        for (tangent, step) in [
            (Vec3::X, Vec3::new(1.0, 0.0, fu)),
            (Vec3::Y, Vec3::new(0.0, 1.0, fv)),
        ] {
            let raised = raised_tangent(tangent, Vec3::Z, normal);
            assert!(raised.distance(step.normalize()) < 1e-6, "{raised} {step}");
        }
    }

    #[test]
    fn upright_surfaces_have_tangents_of_length_one() {
        for raised in [Vec3::X, Vec3::Y, -Vec3::Z, Vec3::new(0.6, 0.0, -0.8)] {
            let tangent = raised_tangent(Vec3::X, Vec3::Z, raised);
            assert!((tangent.length() - 1.0).abs() < 1e-6 && tangent.dot(raised).abs() < 1e-6);
        }
    }
}

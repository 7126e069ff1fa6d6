use glam::{Vec2, Vec3};

/// Steeper relief counts as so steep (89.55°): steps of maps would else make normals that are all noise.
pub const MAX_SLOPE: f32 = 128.0;

/// Steps whose area is less than this share of a square of the longer one span nothing that `f32` could
/// tell.
const FLAT: f32 = 1e-6;

/// Two steps along a surface: edges of a triangle, or derivatives of the position to the next pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Unit normal there.
    pub normal: Vec3,
    /// In metres, of any length, not parallel.
    pub along: [Vec3; 2],
}

impl Steps {
    /// `(b × N, N × a) / (N · a × b)`: dual to the steps, and what all gradients are sums of. Nothing where
    /// they span no area.
    fn dual(self) -> [Vec3; 2] {
        // Triangles may be micrometres or kilometres large: products of their edges stay near 1.
        let longer = (self.along[0].abs().max(self.along[1].abs())).max_element();
        if !(longer > 0.0 && longer.is_finite()) {
            return [Vec3::ZERO; 2];
        }
        let [a, b] = self.along.map(|step| step / longer);
        let area = self.normal.dot(a.cross(b));
        let enough = area.abs() > FLAT * a.length_squared().max(b.length_squared());
        if !enough {
            return [Vec3::ZERO; 2];
        }
        [b.cross(self.normal), self.normal.cross(a)].map(|d| d / area / longer)
    }
}

/// Gradient of a height that changes by so much along the steps: metres a metre, in the surface.
///
/// Zero where the steps span no area, because nobody knows which way is up there.
pub fn surface_gradient(steps: Steps, changes: [f32; 2]) -> Vec3 {
    let [a, b] = steps.dual();
    changes[0] * a + changes[1] * b
}

/// Gradients of the texture coordinates `u` and `v` on a triangle, by metre. A map of slopes `Fu`, `Fv` has
/// the gradient `Fu ∇u + Fv ∇v` there.
///
/// `edges` are those from the first corner to the second and third, `uv_edges` the same in texture
/// coordinates. With `Pu` and `Pv` of the triangle, by the chain rule,
///
/// ```text
///   Pu = (v₂ e₁ − v₁ e₂) / M      Pv = (u₁ e₂ − u₂ e₁) / M      M = u₁ v₂ − u₂ v₁
///
///          ┌─────────────────────────────┐
///   ∇u =   │  Pv × N / (N · Pu × Pv)     │  =  (u₁ (e₂ × N) + u₂ (N × e₁)) / (N · e₁ × e₂)
///          └─────────────────────────────┘
/// ```
///
/// and `M` has dropped out: it may be 0.
pub fn uv_gradients(steps: Steps, uv_edges: [Vec2; 2]) -> [Vec3; 2] {
    let [a, b] = steps.dual();
    let [first, second] = uv_edges;
    [first.x * a + second.x * b, first.y * a + second.y * b]
}

/// Normal of a surface with the unit normal `normal`, raised along it by a height of this surface
/// gradient. Always a unit vector; gradients that are no numbers do nothing.
///
/// The side that is seen from behind has the opposite of the front's normal: turn `normal` to the front,
/// and turn the result back.
pub fn bumped_normal(normal: Vec3, gradient: Vec3) -> Vec3 {
    if !gradient.is_finite() {
        return normal;
    }
    (normal - gradient.clamp_length_max(MAX_SLOPE)).normalize()
}

/// Normal of a surface raised by `height`, with nothing left out: for relief that is not low beside the
/// radius of curvature. `normal_changes` are those of the unit normal along the steps, `changes` those of
/// the height. Where the raised surface has no normal, that of the base.
///
/// Blinn's formula is this with `normal_changes` of 0. On a sphere of radius `R` it takes slopes for
/// `1 + height/R` times what they are.
pub fn displaced_normal(
    steps: Steps,
    normal_changes: [Vec3; 2],
    height: f32,
    changes: [f32; 2],
) -> Vec3 {
    let Steps { normal, along } = steps;
    let raised = |i: usize| along[i] + normal_changes[i] * height + normal * changes[i];
    let (a, b) = (raised(0), raised(1));
    let longer = a.abs().max(b.abs()).max_element().max(f32::MIN_POSITIVE);
    let outwards = normal.dot(along[0].cross(along[1])).signum();
    let raised = (a / longer).cross(b / longer) * outwards;
    match raised.try_normalize() {
        Some(n) if n.is_finite() => n,
        _ => normal,
    }
}

//! How irradiance changes as the normal turns, so that baked light answers to bumps.

use glam::{DMat3, Vec3};

use super::color::luminance;

/// Light of vertices on a surface whose bumps turn its normal: `light` (irradiance / π) as it was
/// baked for the unit `normal`, at the unit `bumped` normal.
///
/// `gradient` is that of [`ObjectLight::gradient`](super::ObjectLight::gradient), interpolated as the
/// light is. With it the irradiance of a turned normal is
///
/// ```text
///   ┌────────────────────────────────────────────────────────────────────────┐
///   │  E(n′) = E(n) x        x = 1 + G · (n′ − n) / E(n),  F² / (2F − x) below F │
///   └────────────────────────────────────────────────────────────────────────┘
/// ```
///
/// in luminance, with `F = 0.4`; the colour stays. Where `n′ = n` it is the light itself, to the last bit. What goes
/// on in a straight line would be black on steep sides that are turned from a lamp, which see other light still: so
/// it bends below `F`, without a kink, and never gets to 0. The result is at most 16 times the light.
///
/// `G` is the rotational gradient of irradiance (Ward and Heckbert 1992, "Irradiance Gradients"), but
/// one that is as right as can be at a slope of 30°. The light that counts is what arrives
/// above the surface, weighted by the bumped normal:
///
/// ```text
///   E(n′) = ∫ L(ω) max(0, ω · n′) dω   over  ω · n > 0
/// ```
///
/// As of an engine's own lights, what the bump would see below the surface's horizon, which is the
/// surface itself, is dark. One lamp within 60° of the normal, and light that is the same from
/// everywhere, come out exactly down to `F` of the light; for anything else see `docs/directional_light.md`.
///
/// ```
/// use bevy_fresco::radiosity::reshade;
/// use glam::Vec3;
///
/// // One lamp, straight along (0, 0.6, 0.8) from a floor that faces +Z.
/// let to_lamp = Vec3::new(0.0, 0.6, 0.8);
/// let light = Vec3::splat(0.8);
/// assert_eq!(reshade(light, to_lamp, Vec3::Z, Vec3::Z), light);
/// let facing = reshade(light, to_lamp, Vec3::Z, to_lamp);
/// assert!((facing - 1.0).length() < 1e-6);
/// ```
pub fn reshade(light: Vec3, gradient: Vec3, normal: Vec3, bumped: Vec3) -> Vec3 {
    let level = luminance(light);
    if level <= 0.0 {
        return light;
    }
    let times = 1.0 + gradient.dot(bumped - normal) / level;
    let bent = FAINT * FAINT / (2.0 * FAINT - times.min(FAINT));
    light * times.max(bent).min(MOST)
}

/// Gradients in the space of a mesh, given the linear part `M` of its transform to the world.
///
/// They turn with a mesh that is turned after the bake, and so do mirrored ones, and keep their length
/// under uniform scale:
///
/// ```text
///   ┌──────────────────────────────────────────────┐
///   │  G_world = M G_mesh / ∛|det M|                │
///   └──────────────────────────────────────────────┘
/// ```
///
/// `None` if `M` flattens the mesh to a plane or less: there is no such `G_mesh` then.
pub fn local_gradients(world_from_mesh: DMat3, gradients: &[Vec3]) -> Option<Vec<Vec3>> {
    let scale = world_from_mesh.determinant().abs().cbrt();
    let to_mesh = world_from_mesh.inverse() * scale;
    let local = |g: &Vec3| (to_mesh * g.as_dvec3()).as_vec3();
    let local: Vec<Vec3> = gradients.iter().map(local).collect();
    let fits = scale > 0.0 && local.iter().all(|g| g.is_finite());
    fits.then_some(local)
}

/// Below this share of the light it gets no darker in a straight line. 0.3 to 0.5 foretell turned normals best:
/// `gradient_study_test.rs`.
const FAINT: f32 = 0.4;

/// A bump brightens light at most so many times: a sun that grazes the surface at 4° and shines full
/// on a bump.
const MOST: f32 = 16.0;

/// Longest gradient, beside the light: [`MOST`] is out of reach then for slopes up to 90°.
const STEEPEST: f32 = 10.0;

/// A gradient as it is stored: no longer than the bounds of [`reshade`] let it be of use.
pub(crate) fn bounded(gradient: Vec3, light: Vec3) -> Vec3 {
    gradient.clamp_length_max(STEEPEST * luminance(light).max(0.0))
}

/// Cosine and sine of the slope θ for which gradients are made.
const SLOPE: (f32, f32) = (0.866_025_4, 0.5);

/// Rays that graze the surface count as if they came from this cosine: they are rare and would count
/// so much that chance decided.
const GRAZING: f32 = 0.02;

/// The gradient that light from a unit `direction` brings, beside the irradiance that it brings to a
/// surface with this `normal`.
///
/// With `z = cos α = ω · n` and `s = sin α`, a normal that is turned by θ towards the azimuth φ, counted
/// from that of `ω`, gets
///
/// ```text
///   f(φ) = max(0, A + B cos φ)      A = z cos θ,  B = s sin θ
/// ```
///
/// which `z + G · (n′ − n) = z + g sin θ cos φ − c (1 − cos θ)` is to follow around the cone of all φ.
/// If `A ≥ B`, the light stays above the horizon of all these normals and `G = ω`, exactly. If not, it is
/// seen within `φ₀ = arccos(−A/B)`, and the least squares over φ are
///
/// ```text
///   ┌──────────────────────────────────────────────────────────────────┐
///   │  g = 2/sin θ ⟨f cos φ⟩        c = (z − ⟨f⟩) / (1 − cos θ)           │
///   │  ⟨f⟩ = (A φ₀ + B sin φ₀) / π                                       │
///   │  ⟨f cos φ⟩ = (2 A sin φ₀ + B (φ₀ + sin φ₀ cos φ₀)) / 2π            │
///   └──────────────────────────────────────────────────────────────────┘
/// ```
pub(crate) fn gradient_of(normal: Vec3, direction: Vec3) -> Vec3 {
    let z = direction.dot(normal);
    let [across, up] = gradient_at(z);
    (direction - normal * z) * across + normal * up
}

/// The same about +Z.
pub(crate) fn gradient_about_z(direction: Vec3) -> Vec3 {
    let [across, up] = gradient_at(direction.z);
    Vec3::new(direction.x * across, direction.y * across, up)
}

/// `g / s` and `c` for light at this cosine, beside it.
fn gradient_at(cosine: f32) -> [f32; 2] {
    let z = cosine.clamp(GRAZING, 1.0);
    let (cos, sin) = SLOPE;
    if z >= sin {
        return [1.0 / z, 1.0];
    }
    let s = (1.0 - z * z).sqrt();
    let (a, b) = (z * cos, s * sin);
    let cos_seen = -a / b;
    let sin_seen = (1.0 - cos_seen * cos_seen).max(0.0).sqrt();
    let seen = cos_seen.acos();
    let mean = (a * seen + b * sin_seen) * std::f32::consts::FRAC_1_PI;
    let first =
        (a * sin_seen + 0.5 * b * (seen + sin_seen * cos_seen)) * std::f32::consts::FRAC_1_PI;
    [2.0 * first / (sin * s * z), (z - mean) / ((1.0 - cos) * z)]
}

/// Light that arrives from somewhere, and its gradient.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Arrived {
    /// Irradiance / π, of unit light.
    pub(crate) light: f32,
    /// Zero if nobody asks for it.
    pub(crate) gradient: Vec3,
}

impl Arrived {
    pub(crate) const NOTHING: Self = Self {
        light: 0.0,
        gradient: Vec3::ZERO,
    };

    /// Light from one direction at a surface of this normal.
    pub(crate) fn from_direction(light: f32, normal: Vec3, direction: Vec3, asked: bool) -> Self {
        let gradient = match asked && light != 0.0 {
            true => gradient_of(normal, direction) * light,
            false => Vec3::ZERO,
        };
        Self { light, gradient }
    }
}

impl std::ops::Mul<f32> for Arrived {
    type Output = Self;

    fn mul(self, times: f32) -> Self {
        Self {
            light: self.light * times,
            gradient: self.gradient * times,
        }
    }
}

impl std::ops::AddAssign for Arrived {
    fn add_assign(&mut self, other: Self) {
        self.light += other.light;
        self.gradient += other.gradient;
    }
}

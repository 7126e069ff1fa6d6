use glam::Vec3;

/// A light with no surface of its own.
///
/// `power` is the colour times the intensity, linear RGB, in Bevy's units: lumens for point and
/// spot lights (of a spot as if it shone in all directions, as Bevy and glTF importers count it:
/// the cone cuts light off, it does not concentrate it), lux for directional lights.
#[derive(Clone, Debug)]
pub struct Light {
    /// Used in errors and reports.
    pub name: String,
    /// Linear RGB; lumens (point, spot) or lux (directional).
    pub power: Vec3,
    /// Where the light is and how it spreads.
    pub kind: LightKind,
}

/// Where a [`Light`] is and how it spreads.
#[derive(Clone, Copy, Debug)]
pub enum LightKind {
    /// Shines equally in all directions.
    Point {
        /// In metres, relative to [`Scene::origin`](super::Scene::origin).
        position: Vec3,
        /// Distance at which the light has faded to nothing, in metres; infinite for none.
        range: f32,
    },
    /// Shines in a cone.
    Spot {
        /// In metres, relative to [`Scene::origin`](super::Scene::origin).
        position: Vec3,
        /// Axis of the cone, pointing away from the light; any length.
        direction: Vec3,
        /// Half angle in radians up to which the light is full.
        inner_angle: f32,
        /// Half angle in radians at which the light ends; above `inner_angle`, at most π/2.
        outer_angle: f32,
        /// Distance at which the light has faded to nothing, in metres; infinite for none.
        range: f32,
    },
    /// Parallel light, as from the sun.
    Directional {
        /// The way the light travels; any length.
        direction: Vec3,
    },
}

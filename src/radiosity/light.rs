use glam::Vec3;

/// A light with no surface of its own.
///
/// `power` is the colour times the intensity, linear RGB, in Bevy's units: lumens for point, spot
/// and rectangular lights (of a spot as if it shone in all directions, as Bevy and glTF importers
/// count it: the cone cuts light off, it does not concentrate it), lux for directional lights.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Used in errors and reports.
    pub name: String,
    /// Linear RGB; lumens (point, spot, rectangle) or lux (directional).
    pub power: Vec3,
    /// Where the light is and how it spreads.
    pub kind: LightKind,
    /// Tells the light from others from one bake to the next (see [`Baker`](super::Baker)). Lights
    /// with one key are told apart by their order.
    pub key: u64,
    /// Whether its direct light goes into the result.
    pub direct: DirectLight,
}

impl Default for Light {
    /// A dark point light at the origin.
    fn default() -> Self {
        Self {
            name: String::new(),
            power: Vec3::ZERO,
            kind: LightKind::Point {
                position: Vec3::ZERO,
                range: f32::INFINITY,
            },
            key: 0,
            direct: DirectLight::Baked,
        }
    }
}

/// Whether the direct light of a [`Light`] is part of the baked light.
///
/// Light of emissive surfaces and of the sky, and all that bounces, is baked either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DirectLight {
    /// Direct and indirect light are baked; the engine must not light these surfaces again.
    #[default]
    Baked,
    /// Only bounced light is baked; the engine adds direct light and shadows in real time.
    Realtime,
}

/// Where a [`Light`] is and how it spreads.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// A rectangle that shines to one side, equally bright from everywhere, and stops no light.
    ///
    /// Its radiance is `power / (π · width · height)`, faded by the distance to its centre as a
    /// point light's, as Bevy shows a `RectLight`.
    Rect {
        /// Centre in metres, relative to [`Scene::origin`](super::Scene::origin).
        position: Vec3,
        /// The way it shines; any length.
        direction: Vec3,
        /// Along its width, across `direction`; any length.
        right: Vec3,
        /// In metres, above 0.
        width: f32,
        /// In metres, above 0.
        height: f32,
        /// Distance at which the light has faded to nothing, in metres; infinite for none.
        range: f32,
    },
    /// Parallel light, as from the sun.
    Directional {
        /// The way the light travels; any length.
        direction: Vec3,
    },
}

use bevy::ecs::system::SystemParam;
use bevy::light::RectLight;
use bevy::prelude::*;

use super::components::LightBaking;
use super::survey::{Shown, VisibilityRule};
use crate::radiosity::{DirectLight, LightKind};

/// All lights of the world.
#[derive(SystemParam)]
pub(super) struct Lights<'w, 's> {
    points: Query<'w, 's, (&'static PointLight, Placed)>,
    spots: Query<'w, 's, (&'static SpotLight, Placed)>,
    suns: Query<'w, 's, (&'static DirectionalLight, Placed)>,
    rects: Query<'w, 's, (&'static RectLight, Placed)>,
}

type Placed = (
    Entity,
    &'static GlobalTransform,
    Shown,
    Option<&'static LightBaking>,
);

/// A light of the world in the bake's terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct FoundLight {
    pub(super) entity: Entity,
    pub(super) power: Vec3,
    pub(super) kind: LightKind,
    pub(super) direct: DirectLight,
}

impl Lights<'_, '_> {
    /// The lights that the bake sees.
    pub(super) fn find(&self, visibility: VisibilityRule) -> Vec<FoundLight> {
        let found = self
            .points
            .iter()
            .filter_map(|l| found(l, visibility))
            .chain(self.spots.iter().filter_map(|l| found(l, visibility)))
            .chain(self.suns.iter().filter_map(|l| found(l, visibility)))
            .chain(self.rects.iter().filter_map(|l| found(l, visibility)));
        found.collect()
    }
}

fn found<L: Shines>(
    (light, (entity, at, shown, baking)): (
        &L,
        (
            Entity,
            &GlobalTransform,
            (Option<&Visibility>, Option<&InheritedVisibility>),
            Option<&LightBaking>,
        ),
    ),
    visibility: VisibilityRule,
) -> Option<FoundLight> {
    let direct = match baking {
        Some(LightBaking::Excluded) => return None,
        Some(LightBaking::Full) if L::CAN_BE_FULL => DirectLight::Baked,
        None if light.is_full() => DirectLight::Baked,
        _ => DirectLight::Realtime,
    };
    visibility.shown(shown).then(|| FoundLight {
        entity,
        power: light.power(),
        kind: light.kind(at),
        direct,
    })
}

/// What the kinds of lights have in common.
trait Shines {
    /// Whether Bevy can leave its diffuse part to the bake.
    const CAN_BE_FULL: bool = true;

    /// Whether Bevy leaves its diffuse part to the bake.
    fn is_full(&self) -> bool;

    /// Linear RGB, lumens or lux.
    fn power(&self) -> Vec3;

    fn kind(&self, at: &GlobalTransform) -> LightKind;
}

fn power(color: Color, strength: f32) -> Vec3 {
    color.to_linear().to_vec3() * strength
}

/// A unit vector in the world; zero where the transform leaves no direction.
fn direction(at: &GlobalTransform, local: Vec3) -> Vec3 {
    at.affine().transform_vector3(local).normalize_or_zero()
}

impl Shines for PointLight {
    fn is_full(&self) -> bool {
        !self.affects_lightmapped_mesh_diffuse
    }

    fn power(&self) -> Vec3 {
        power(self.color, self.intensity)
    }

    fn kind(&self, at: &GlobalTransform) -> LightKind {
        LightKind::Point {
            position: at.translation(),
            range: self.range,
        }
    }
}

impl Shines for SpotLight {
    fn is_full(&self) -> bool {
        !self.affects_lightmapped_mesh_diffuse
    }

    fn power(&self) -> Vec3 {
        power(self.color, self.intensity)
    }

    fn kind(&self, at: &GlobalTransform) -> LightKind {
        LightKind::Spot {
            position: at.translation(),
            direction: direction(at, Vec3::NEG_Z),
            inner_angle: self.inner_angle,
            outer_angle: self.outer_angle,
            range: self.range,
        }
    }
}

impl Shines for DirectionalLight {
    fn is_full(&self) -> bool {
        !self.affects_lightmapped_mesh_diffuse
    }

    fn power(&self) -> Vec3 {
        power(self.color, self.illuminance)
    }

    fn kind(&self, at: &GlobalTransform) -> LightKind {
        LightKind::Directional {
            direction: direction(at, Vec3::NEG_Z),
        }
    }
}

impl Shines for RectLight {
    const CAN_BE_FULL: bool = false;

    fn is_full(&self) -> bool {
        false
    }

    fn power(&self) -> Vec3 {
        power(self.color, self.intensity)
    }

    fn kind(&self, at: &GlobalTransform) -> LightKind {
        LightKind::Rect {
            position: at.translation(),
            direction: direction(at, Vec3::NEG_Z),
            right: direction(at, Vec3::X),
            width: self.width,
            height: self.height,
            range: self.range,
        }
    }
}

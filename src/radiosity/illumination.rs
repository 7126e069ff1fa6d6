use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::emitter::Receiver;
use super::facet::Facet;
use super::gradient::Arrived;
use super::light::{Light, LightKind};
use super::occlusion::{NO_TRIANGLE, Occluders};
use super::sampling::sobol;
use super::validate::HALF_EXTENT;

/// Shadow rays from a point to a rectangular light; to any other light it is one.
const RECT_RAYS: u32 = 4;

/// What shadow rays found: how many there were, and the least and the most light that passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shadow {
    pub(crate) rays: u64,
    least: f32,
    most: f32,
}

impl Shadow {
    /// Before any ray.
    pub(crate) const UNKNOWN: Self = Self {
        rays: 0,
        least: f32::INFINITY,
        most: f32::NEG_INFINITY,
    };

    pub(crate) fn ray(&mut self, passing: f32) -> f32 {
        self.rays += 1;
        self.least = self.least.min(passing);
        self.most = self.most.max(passing);
        passing
    }

    /// What share of light passed, if it was the same for all rays; 1 if there were none.
    pub(crate) fn agreed(&self) -> Option<f32> {
        match self.rays {
            0 => Some(1.0),
            _ => (self.least == self.most).then_some(self.least),
        }
    }
}

/// Light that a [`Light`] of power 1 gives a receiver (irradiance / π): its true light is this times
/// its power. `seed` and `index` place the shadow rays to a rectangle, each index a block of one
/// sequence.
pub(crate) fn illumination(
    light: &Light,
    occluders: &Occluders,
    receiver: &Receiver,
    place: (u32, u32),
    shadow: &mut Shadow,
) -> f32 {
    arrived(light, occluders, receiver, place, false, shadow).light
}

/// The same, with its gradient if that is asked for.
pub(crate) fn arrived(
    light: &Light,
    occluders: &Occluders,
    receiver: &Receiver,
    place: (u32, u32),
    gradients: bool,
    shadow: &mut Shadow,
) -> Arrived {
    if let LightKind::Rect { .. } = light.kind {
        return rectangle(light.kind, occluders, receiver, place, gradients, shadow);
    }
    let Some(arrival) = arrival(light.kind, receiver.position) else {
        return Arrived::NOTHING;
    };
    let cosine = receiver.normal.dot(arrival.direction);
    if cosine <= 0.0 || arrival.normal_irradiance == 0.0 {
        return Arrived::NOTHING;
    }
    let passing = shadow.ray(occluders.transmittance(
        receiver.position,
        arrival.direction,
        arrival.distance,
        [receiver.triangle, NO_TRIANGLE],
    ));
    let light = arrival.normal_irradiance * passing * cosine * FRAC_1_PI;
    Arrived::from_direction(light, receiver.normal, arrival.direction, gradients)
}

/// How a light of power 1 reaches a point.
struct Arrival {
    /// Unit vector towards the light.
    direction: Vec3,
    distance: f32,
    /// Irradiance of a surface that faces the light.
    normal_irradiance: f32,
}

/// A light's unshadowed effect at a point; `None` where it does not reach.
///
/// Distance and cone falloff as Bevy renders them: `saturate(1 − (d/range)⁴)² / d²` and
/// `saturate((cos θ − cos outer) / (cos inner − cos outer))²`. (`KHR_lights_punctual` recommends the
/// same but for the first square, which matters only near the end of a light's range.)
fn arrival(kind: LightKind, point: Vec3) -> Option<Arrival> {
    let at_distance = |position: Vec3, range: f32| {
        let to = position - point;
        let distance = to.length();
        let fade = range_falloff(distance, range);
        (distance > 0.0 && fade > 0.0).then(|| Arrival {
            direction: to / distance,
            distance,
            normal_irradiance: fade / (4.0 * PI * distance * distance),
        })
    };
    match kind {
        LightKind::Point { position, range } => at_distance(position, range),
        LightKind::Spot {
            position,
            direction,
            inner_angle,
            outer_angle,
            range,
        } => {
            let mut arrival = at_distance(position, range)?;
            let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
            let cosine = direction.dot(-arrival.direction);
            let cone = ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0);
            arrival.normal_irradiance *= cone * cone;
            Some(arrival)
        }
        LightKind::Directional { direction } => Some(Arrival {
            direction: -direction,
            distance: 8.0 * HALF_EXTENT,
            normal_irradiance: 1.0,
        }),
        LightKind::Rect { .. } => None,
    }
}

fn range_falloff(distance: f32, range: f32) -> f32 {
    if distance >= range {
        return 0.0;
    }
    (1.0 - (distance / range).powi(4)).powi(2)
}

/// A rectangle's light: its form factor times the share that shadow rays find visible (see
/// [`Facet`]).
fn rectangle(
    kind: LightKind,
    occluders: &Occluders,
    receiver: &Receiver,
    (seed, index): (u32, u32),
    gradients: bool,
    shadow: &mut Shadow,
) -> Arrived {
    let LightKind::Rect {
        position,
        direction,
        right,
        width,
        height,
        range,
    } = kind
    else {
        return Arrived::NOTHING;
    };
    let fade = range_falloff(position.distance(receiver.position), range);
    if fade == 0.0 || width * height <= 0.0 {
        return Arrived::NOTHING;
    }
    let (across, up) = (right * width, direction.cross(right) * height);
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        .map(|(u, v)| position + across * u + up * v);
    let Some(facet) = Facet::new(receiver, corners, direction) else {
        return Arrived::NOTHING;
    };
    let (mut seen, mut whole) = (Arrived::NOTHING, 0.0);
    for i in index * RECT_RAYS..(index + 1) * RECT_RAYS {
        let [u, v, ..] = sobol(i, 3, seed);
        if let Some(way) = facet.way(receiver.normal, [u, v]) {
            let skip = [receiver.triangle, NO_TRIANGLE];
            let (from, to) = (receiver.position, way.direction());
            whole += way.brings;
            let passing = occluders.transmittance(from, to, way.distance, skip);
            let brings = way.brings * shadow.ray(passing);
            seen += Arrived::from_direction(brings, receiver.normal, to, gradients);
        }
    }
    if whole > 0.0 {
        let light = facet.factor as f32 * (seen.light / whole) * fade / (PI * width * height);
        let gradient = facet.factor as f32 / whole * fade / (PI * width * height);
        Arrived {
            light,
            gradient: seen.gradient * gradient,
        }
    } else {
        Arrived::NOTHING
    }
}

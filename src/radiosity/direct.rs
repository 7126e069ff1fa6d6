use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::element::{ElementId, Elements, element_seed};
use super::emitter::{Emitters, Receiver};
use super::light::{Light, LightKind};
use super::observer::{Observer, Stage};
use super::occlusion::{NO_TRIANGLE, OFFSET, Occluders};
use super::parallel::{Cancelled, map_ranges};
use super::sampling::{hash, sobol};
use super::validate::{HALF_EXTENT, ValidScene};

/// Elements a thread takes at a time.
const CHUNK: usize = 64;

/// Points on an element at which lights without a surface are tested.
const POINTS: u32 = 4;

/// Direct light (irradiance / π) at each element: lights, sampled emitters, and what the
/// form-factor rays `found` of sky and emitters.
pub(crate) fn direct(
    scene: &ValidScene,
    occluders: &Occluders,
    elements: &Elements,
    emitters: &Emitters,
    found: &[Vec3],
    seed: u32,
    observer: &dyn Observer,
) -> Result<Vec<Vec3>, Cancelled> {
    let chunks = map_ranges(elements.len(), CHUNK, Stage::Direct, observer, |range| {
        range
            .map(|e| {
                found[e]
                    + at_element(
                        scene,
                        occluders,
                        elements,
                        emitters,
                        ElementId(e as u32),
                        seed,
                    )
            })
            .collect::<Vec<_>>()
    })?;
    Ok(chunks.concat())
}

/// Mean over points spread over the element; the light samples are shared out among them.
fn at_element(
    scene: &ValidScene,
    occluders: &Occluders,
    elements: &Elements,
    emitters: &Emitters,
    element: ElementId,
    seed: u32,
) -> Vec3 {
    let seed = element_seed(element, hash(seed, 1));
    let share = emitters.samples.div_ceil(POINTS);
    let mut sum = Vec3::ZERO;
    for i in 0..POINTS {
        let [u, v, ..] = sobol(i, 0, seed);
        let point = elements.point(scene, element, u, v);
        let receiver = Receiver {
            position: point.position + point.normal * OFFSET,
            normal: point.normal,
            triangle: point.triangle,
        };
        sum += lights(&scene.lights, occluders, &receiver);
        sum += emitters.sample(
            elements,
            occluders,
            &receiver,
            seed,
            i * share..(i + 1) * share,
        );
    }
    sum / POINTS as f32
}

/// Direct light (irradiance / π) of all lights without a surface, one shadow ray each.
pub(crate) fn lights(lights: &[Light], occluders: &Occluders, receiver: &Receiver) -> Vec3 {
    lights
        .iter()
        .map(|light| {
            let Some(arrival) = arrival(light, receiver.position) else {
                return Vec3::ZERO;
            };
            let cosine = receiver.normal.dot(arrival.direction);
            if cosine <= 0.0 || arrival.normal_irradiance == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let passing = occluders.transmittance(
                receiver.position,
                arrival.direction,
                arrival.distance,
                [receiver.triangle, NO_TRIANGLE],
            );
            arrival.normal_irradiance * (passing * cosine * FRAC_1_PI)
        })
        .sum()
}

/// How a light reaches a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    /// Unit vector towards the light.
    pub(crate) direction: Vec3,
    pub(crate) distance: f32,
    /// Irradiance of a surface that faces the light.
    pub(crate) normal_irradiance: Vec3,
}

/// A light's unshadowed effect at a point; `None` where it does not reach.
///
/// Distance and cone falloff as Bevy renders them: `saturate(1 − (d/range)⁴)² / d²` and
/// `saturate((cos θ − cos outer) / (cos inner − cos outer))²`. (`KHR_lights_punctual` recommends the
/// same but for the first square, which matters only near the end of a light's range.)
pub(crate) fn arrival(light: &Light, point: Vec3) -> Option<Arrival> {
    let at_distance = |position: Vec3, range: f32| {
        let to = position - point;
        let distance = to.length();
        if distance == 0.0 || distance >= range {
            return None;
        }
        let fade = 1.0 - (distance / range).powi(4);
        Some(Arrival {
            direction: to / distance,
            distance,
            normal_irradiance: light.power * (fade * fade / (4.0 * PI * distance * distance)),
        })
    };
    match light.kind {
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
            normal_irradiance: light.power,
        }),
    }
}

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::emitter::Receiver;
use super::light::{Light, LightKind};
use super::occlusion::{NO_TRIANGLE, Occluders};
use super::sampling::sobol;
use super::validate::HALF_EXTENT;

/// Shadow rays from a point to a rectangular light; to any other light it is one.
const RECT_RAYS: u32 = 4;

/// Light that a [`Light`] of power 1 gives a receiver (irradiance / π): its true light is this times
/// its power. `traced` counts shadow rays; `seed` and `index` place those to a rectangle, each
/// index a block of one sequence.
pub(crate) fn illumination(
    light: &Light,
    occluders: &Occluders,
    receiver: &Receiver,
    (seed, index): (u32, u32),
    traced: &mut u64,
) -> f32 {
    if let LightKind::Rect { .. } = light.kind {
        return rectangle(light.kind, occluders, receiver, (seed, index), traced);
    }
    let Some(arrival) = arrival(light.kind, receiver.position) else {
        return 0.0;
    };
    let cosine = receiver.normal.dot(arrival.direction);
    if cosine <= 0.0 || arrival.normal_irradiance == 0.0 {
        return 0.0;
    }
    *traced += 1;
    let passing = occluders.transmittance(
        receiver.position,
        arrival.direction,
        arrival.distance,
        [receiver.triangle, NO_TRIANGLE],
    );
    arrival.normal_irradiance * passing * cosine * FRAC_1_PI
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

/// A rectangle's light: the form factor in closed form, times the share that shadow rays find
/// visible, each weighted by what it would bring.
fn rectangle(
    kind: LightKind,
    occluders: &Occluders,
    receiver: &Receiver,
    (seed, index): (u32, u32),
    traced: &mut u64,
) -> f32 {
    let LightKind::Rect {
        position,
        direction,
        right,
        width,
        height,
        range,
    } = kind
    else {
        return 0.0;
    };
    let fade = range_falloff(position.distance(receiver.position), range);
    let in_front = direction.dot(receiver.position - position) > 0.0;
    if fade == 0.0 || !in_front || width * height <= 0.0 {
        return 0.0;
    }
    let (across, up) = (right * width, direction.cross(right) * height);
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        .map(|(u, v)| position + across * u + up * v - receiver.position);
    let factor = point_to_polygon(receiver.normal, &corners);
    if factor <= 0.0 {
        return 0.0;
    }
    let (mut seen, mut whole) = (0.0, 0.0);
    for i in index * RECT_RAYS..(index + 1) * RECT_RAYS {
        let [u, v, ..] = sobol(i, 3, seed);
        let to = position + across * (u - 0.5) + up * (v - 0.5) - receiver.position;
        let distance = to.length();
        let way = to / distance;
        let brings = receiver.normal.dot(way) * -direction.dot(way) / (distance * distance);
        if brings > 0.0 {
            *traced += 1;
            let skip = [receiver.triangle, NO_TRIANGLE];
            whole += brings;
            seen += brings * occluders.transmittance(receiver.position, way, distance, skip);
        }
    }
    if whole > 0.0 {
        factor * (seen / whole) * fade / (PI * width * height)
    } else {
        0.0
    }
}

/// Form factor from a point with normal `n` to a polygon given by corners relative to the point,
/// the part below the horizon left out: Lambert's formula, `1/2π Σ γ_k (n · Γ_k)` over the edges.
fn point_to_polygon(n: Vec3, corners: &[Vec3; 4]) -> f32 {
    let mut above = Vec::with_capacity(5);
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let (ha, hb) = (n.dot(a), n.dot(b));
        if ha >= 0.0 {
            above.push(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            above.push(a.lerp(b, ha / (ha - hb)));
        }
    }
    let edges = (0..above.len()).map(|k| {
        let (a, b) = (above[k].as_dvec3(), above[(k + 1) % above.len()].as_dvec3());
        let cross = a.cross(b);
        let sine = cross.length();
        if sine == 0.0 {
            return 0.0;
        }
        n.as_dvec3().dot(cross / sine) * sine.atan2(a.dot(b))
    });
    (edges.sum::<f64>().abs() / std::f64::consts::TAU) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2a, parallel to the receiver, straight above it at distance h.
    fn square_above(a: f32, h: f32) -> [Vec3; 4] {
        [(-a, -a), (a, -a), (a, a), (-a, a)].map(|(x, z)| Vec3::new(x, h, z))
    }

    #[test]
    fn factors_of_squares_overhead_are_as_in_howell_s_catalogue() {
        for (a, h) in [(0.5_f32, 1.0_f32), (1.0, 1.0), (3.0, 0.5)] {
            let x = f64::from(a / h);
            let root = (1.0 + x * x).sqrt();
            // Configuration C-11 (a point under the corner of a rectangle), four times.
            let truth = 4.0 * (2.0 * x / root * (x / root).atan()) / std::f64::consts::TAU;
            let found = point_to_polygon(Vec3::Y, &square_above(a, h));
            assert!((f64::from(found) - truth).abs() < 1e-6, "{found} {truth}");
        }
    }

    #[test]
    fn what_is_below_the_horizon_does_not_count() {
        // A wall square seen edge-on by the floor: its upper half alone.
        let whole = [
            Vec3::new(1.0, -1.0, -1.0),
            Vec3::new(1.0, 1.0, -1.0),
            Vec3::new(1.0, 1.0, 1.0),
            Vec3::new(1.0, -1.0, 1.0),
        ];
        let mut half = whole;
        for p in &mut half {
            p.y = p.y.max(0.0);
        }
        let (a, b) = (
            point_to_polygon(Vec3::Y, &whole),
            point_to_polygon(Vec3::Y, &half),
        );
        assert!((a - b).abs() < 1e-6 && a > 0.1, "{a} {b}");
        assert_eq!(point_to_polygon(Vec3::NEG_Y, &square_above(1.0, 1.0)), 0.0);
    }
}

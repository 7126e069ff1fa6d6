//! `KHR_lights_punctual`.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DVec3, Vec3};
use gltf::json::Root;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as FileLight, Spot, Type};
use gltf::json::validation::Checked;

use super::notes::Notes;
use crate::radiosity::{Light, LightKind};

/// The light of a node, with positions relative to `origin`; or nothing, if it has none or a
/// broken one (a note says so then).
pub(super) fn light_of(
    root: &Root,
    node: usize,
    world: &DAffine3,
    origin: DVec3,
    notes: &mut Notes,
) -> Option<Light> {
    let extension = root.nodes.get(node)?.extensions.as_ref()?;
    let index = extension.khr_lights_punctual.as_ref()?.light;
    let file = root.get(index)?;
    let name = [&root.nodes[node].name, &file.name];
    let name = name.into_iter().flatten().find(|name| !name.is_empty());
    let name = name.map_or_else(|| format!("light {index}"), Clone::clone);
    match convert(file, &name, world, origin, notes) {
        Ok((power, kind)) => Some(Light {
            name,
            power,
            kind,
            ..Light::default()
        }),
        Err(reason) => {
            notes.add(format!("Light {name} {reason}: left out."));
            None
        }
    }
}

fn convert(
    file: &FileLight,
    name: &str,
    world: &DAffine3,
    origin: DVec3,
    notes: &mut Notes,
) -> Result<(Vec3, LightKind), &'static str> {
    let Checked::Valid(kind) = file.type_ else {
        return Err("is of an unknown type");
    };
    // A lamp of one candela in all directions gives 4π lumens; spots are counted the same way.
    let unit = match kind {
        Type::Directional => 1.0,
        Type::Point | Type::Spot => 4.0 * PI,
    };
    let power = Vec3::from_array(file.color) * file.intensity * unit;
    if !power.is_finite() || file.intensity < 0.0 || power.min_element() < 0.0 {
        return Err("has a colour or intensity that is negative or no number");
    }
    let position = (world.translation - origin).as_vec3();
    if kind != Type::Directional && !position.is_finite() {
        return Err("is nowhere");
    }
    let direction = -world.matrix3.z_axis;
    let direction = direction.try_normalize().map(|d| d.as_vec3());
    if kind != Type::Point && direction.is_none() {
        return Err("shines in no direction, as its node is scaled to nothing");
    }
    let direction = direction.unwrap_or(Vec3::NEG_Z);
    let range = range_of(file, name, notes);
    let kind = match kind {
        Type::Directional => LightKind::Directional { direction },
        Type::Point => LightKind::Point { position, range },
        Type::Spot => {
            let (inner_angle, outer_angle) = cone(file.spot.as_ref(), name, notes)?;
            LightKind::Spot {
                position,
                direction,
                inner_angle,
                outer_angle,
                range,
            }
        }
    };
    Ok((power, kind))
}

fn range_of(file: &FileLight, name: &str, notes: &mut Notes) -> f32 {
    let range = file.range.unwrap_or(f32::INFINITY);
    if range > 0.0 {
        return range;
    }
    notes.add(format!(
        "Light {name} has a range of {range}: it is taken as unlimited."
    ));
    f32::INFINITY
}

/// Inner and outer half angle, in radians.
fn cone(spot: Option<&Spot>, name: &str, notes: &mut Notes) -> Result<(f32, f32), &'static str> {
    /// The widest inner cone, as a share of the outer: sharp, but not a step.
    const SHARPEST: f32 = 0.999;
    let (file_inner, file_outer) = spot.map_or((0.0, PI / 4.0), |s| {
        (s.inner_cone_angle, s.outer_cone_angle)
    });
    if !file_inner.is_finite() || !file_outer.is_finite() || file_outer <= 0.0 {
        return Err("has a cone that is empty or no number");
    }
    let outer = file_outer.min(FRAC_PI_2);
    let inner = file_inner.clamp(0.0, outer * SHARPEST);
    if (inner, outer) != (file_inner, file_outer) {
        notes.add(format!(
            "Light {name} has a cone of {file_inner} to {file_outer} radians: {inner} to {outer} \
             is used."
        ));
    }
    Ok((inner, outer))
}

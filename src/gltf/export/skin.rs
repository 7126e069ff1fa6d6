//! Joints and weights of refined vertices.

use std::collections::BTreeMap;

use super::{
    interpolate::{Blend, Corners, Rule},
    primitive::Attributes,
};
use crate::gltf::accessor_json::{AccessorData, ElementKind};

/// Joints in each set of attributes.
const PER_SET: usize = 4;

/// Whether [`blend`] has to see an attribute.
pub(super) fn is_skin(attribute: &str) -> bool {
    attribute.starts_with("JOINTS_") || attribute.starts_with("WEIGHTS_")
}

/// One set of joints with their weights.
struct Set<'a> {
    suffix: &'a str,
    joints: &'a AccessorData,
    weights: &'a AccessorData,
}

/// Merges the joints of the corners: each vertex gets the heaviest, as many as there is room for in
/// the sets of the source, with weights that add up to 1.
pub(super) fn blend(source: &Attributes, blend: &Blend) -> Result<Attributes, String> {
    let sets = find_sets(source)?;
    let mut outputs: Vec<(Vec<f64>, Vec<f64>)> = vec![Default::default(); sets.len()];
    for corners in blend.vertices() {
        match corners.single() {
            Some(vertex) => copy(&sets, vertex, &mut outputs),
            None => merge(&sets, &corners, &mut outputs),
        }
    }
    let mut result = Attributes::new();
    for (set, (joints, weights)) in sets.iter().zip(outputs) {
        for (name, values) in [("JOINTS", joints), ("WEIGHTS", weights)] {
            let kind = ElementKind::VEC4;
            result.push((
                format!("{name}_{}", set.suffix),
                AccessorData { kind, values },
            ));
        }
    }
    // Weights without joints mean nothing to glTF, but somebody put them there.
    for (name, data) in source {
        if !result.iter().any(|(known, _)| known == name) {
            result.push((name.clone(), blend.apply(data, Rule::Nearest)));
        }
    }
    Ok(result)
}

fn find_sets(source: &Attributes) -> Result<Vec<Set<'_>>, String> {
    let mut sets = Vec::new();
    for (name, joints) in source {
        let Some(suffix) = name.strip_prefix("JOINTS_") else {
            continue;
        };
        let partner = format!("WEIGHTS_{suffix}");
        let Some((_, weights)) = source.iter().find(|(name, _)| *name == partner) else {
            continue;
        };
        if joints.kind != ElementKind::VEC4 || weights.kind != ElementKind::VEC4 {
            return Err(format!("{name} and {partner} must be VEC4"));
        }
        sets.push(Set {
            suffix,
            joints,
            weights,
        });
    }
    sets.sort_by_key(|set| set.suffix);
    Ok(sets)
}

fn copy(sets: &[Set<'_>], vertex: usize, outputs: &mut [(Vec<f64>, Vec<f64>)]) {
    for (set, (joints, weights)) in sets.iter().zip(outputs) {
        joints.extend_from_slice(set.joints.element(vertex));
        weights.extend_from_slice(set.weights.element(vertex));
    }
}

fn merge(sets: &[Set<'_>], corners: &Corners, outputs: &mut [(Vec<f64>, Vec<f64>)]) {
    let mut merged = BTreeMap::<u32, f64>::new();
    for (vertex, share) in corners.iter() {
        for set in sets {
            let joints = set.joints.element(vertex).iter();
            for (&joint, &weight) in joints.zip(set.weights.element(vertex)) {
                if weight > 0.0 {
                    *merged.entry(joint as u32).or_default() += share * weight;
                }
            }
        }
    }
    // By joint so far: equal weights keep that order, whatever the order of the corners.
    let mut heaviest: Vec<(u32, f64)> = merged.into_iter().collect();
    heaviest.sort_by(|a, b| b.1.total_cmp(&a.1));
    heaviest.truncate(PER_SET * sets.len());
    let sum: f64 = heaviest.iter().map(|(_, weight)| weight).sum();
    // glTF wants joint 0 where the weight is 0.
    heaviest.resize(PER_SET * sets.len(), (0, 0.0));
    for (chunk, (joints, weights)) in heaviest.chunks_exact(PER_SET).zip(outputs) {
        joints.extend(chunk.iter().map(|&(joint, _)| f64::from(joint)));
        let normalised = |weight: f64| if sum > 0.0 { weight / sum } else { 0.0 };
        weights.extend(chunk.iter().map(|&(_, weight)| normalised(weight)));
    }
}

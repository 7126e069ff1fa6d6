//! Joints and weights of vertices between those of the source.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use crate::mesh::RefinedMesh;
use crate::plugin::radiosity::mesh_data::vectors;

/// Joints that a vertex can have.
const JOINTS: usize = 4;

/// Merges the joints of the corners: each vertex gets the heaviest, with weights that add up to 1. Each corner
/// has an order of joints of its own, so that weights cannot be interpolated one by one.
pub(super) fn merge(
    source: &Mesh,
    mesh: &mut Mesh,
    triangles: &[[u32; 3]],
    refinement: &RefinedMesh,
) {
    let (Some(joints), Some(weights)) = (
        joints(source),
        vectors(source, Mesh::ATTRIBUTE_JOINT_WEIGHT),
    ) else {
        return;
    };
    let merged = refinement.interpolate(triangles, |corners, shares| {
        let mut all: Vec<(u16, f32)> = Vec::with_capacity(3 * JOINTS);
        for (corner, share) in corners.into_iter().zip(shares.to_array()) {
            let vertex = corner as usize;
            for (&joint, weight) in joints[vertex].iter().zip(weights[vertex].to_array()) {
                add(&mut all, joint, share * weight);
            }
        }
        heaviest(all)
    });
    let (joints, weights): (Vec<[u16; JOINTS]>, Vec<[f32; JOINTS]>) = merged.into_iter().unzip();
    let joints = VertexAttributeValues::Uint16x4(joints);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
}

fn joints(mesh: &Mesh) -> Option<Vec<[u16; JOINTS]>> {
    match mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_INDEX).ok()? {
        VertexAttributeValues::Uint16x4(joints) => Some(joints.clone()),
        VertexAttributeValues::Uint8x4(joints) => {
            Some(joints.iter().map(|j| j.map(u16::from)).collect())
        }
        _ => None,
    }
}

fn add(all: &mut Vec<(u16, f32)>, joint: u16, weight: f32) {
    if weight > 0.0 {
        match all.iter_mut().find(|(known, _)| *known == joint) {
            Some((_, sum)) => *sum += weight,
            None => all.push((joint, weight)),
        }
    }
}

fn heaviest(mut all: Vec<(u16, f32)>) -> ([u16; JOINTS], [f32; JOINTS]) {
    // Of equal weights the lower joint, whatever the order of the corners.
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.truncate(JOINTS);
    let sum: f32 = all.iter().map(|(_, weight)| weight).sum();
    let mut merged = ([0; JOINTS], [0.0; JOINTS]);
    for (slot, (joint, weight)) in all.into_iter().enumerate() {
        merged.0[slot] = joint;
        merged.1[slot] = weight / sum;
    }
    merged
}

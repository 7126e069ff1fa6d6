//! Gradients of baked light, from world space to that of the mesh.

use glam::{DMat3, Vec3};
use serde_json::Value;

use super::glb::Glb;
use crate::gltf::hierarchy::local_transform;
use crate::radiosity::local_gradients;

/// The nodes above each node.
pub(super) struct Nodes {
    parents: Vec<Option<usize>>,
}

impl Nodes {
    pub(super) fn new(json: &Value) -> Self {
        let nodes = json["nodes"].as_array().map_or(&[][..], Vec::as_slice);
        let mut parents = vec![None; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            for child in node["children"].as_array().into_iter().flatten() {
                let child = child.as_u64().and_then(|child| usize::try_from(child).ok());
                if let Some(parent) = child.and_then(|child| parents.get_mut(child)) {
                    *parent = Some(index);
                }
            }
        }
        Self { parents }
    }

    /// World from node, without translation. A skin stands where its joints are, not where its node is:
    /// world space is its own.
    fn world_from(&self, json: &Value, node: usize) -> DMat3 {
        let mut world = DMat3::IDENTITY;
        if json["nodes"][node].get("skin").is_some() {
            return world;
        }
        let mut next = Some(node);
        // A node that were its own ancestor would have no end.
        for _ in 0..self.parents.len() {
            let Some(node) = next else { break };
            world = local_transform(&json["nodes"][node]).matrix3 * world;
            next = self.parents[node];
        }
        world
    }

    /// The gradients of a node's mesh in its own space; said if there is no way to have them there.
    pub(super) fn to_mesh(&self, glb: &mut Glb, node: usize, gradients: &[Vec3]) -> Vec<Vec3> {
        let world = self.world_from(&glb.json, node);
        local_gradients(world, gradients).unwrap_or_else(|| {
            glb.notes.push(format!(
                "node {node} flattens its mesh to a plane or less: its baked light does not answer to bumps"
            ));
            vec![Vec3::ZERO; gradients.len()]
        })
    }
}

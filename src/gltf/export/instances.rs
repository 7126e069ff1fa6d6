//! Gives each node a mesh of its own, since light differs from place to place.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use serde_json::Value;

use super::{BakedPrimitive, glb::Glb};
use crate::gltf::{GltfError, PrimitiveKey, accessor_json::whole};

/// Where the light of a baked primitive is written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Target {
    pub(super) mesh: usize,
    pub(super) primitive: usize,
}

impl Target {
    /// The primitive as the document has it, for all nodes that share its mesh.
    pub(super) fn shared(key: PrimitiveKey) -> Self {
        Self {
            mesh: key.mesh,
            primitive: key.primitive,
        }
    }

    /// The JSON of the primitive.
    pub(super) fn of(self, json: &Value) -> &Value {
        &json["meshes"][self.mesh]["primitives"][self.primitive]
    }

    /// The JSON of the primitive, to change it.
    pub(super) fn of_mut(self, json: &mut Value) -> &mut Value {
        &mut json["meshes"][self.mesh]["primitives"][self.primitive]
    }
}

/// Copies meshes until no two nodes share one that carries light; returns the target of each baked
/// primitive, in order.
pub(super) fn separate_instances(
    glb: &mut Glb,
    baked: &[BakedPrimitive<'_>],
) -> Result<Vec<Target>, GltfError> {
    check_keys(glb, baked)?;
    let mut baked_nodes = BTreeMap::<usize, BTreeSet<usize>>::new();
    for baked in baked {
        let nodes = baked_nodes.entry(baked.key.mesh).or_default();
        nodes.insert(baked.key.node);
    }
    let mut mesh_of_node = BTreeMap::new();
    for (mesh, nodes) in baked_nodes {
        // A node that is not baked (outside the scene, say) keeps the mesh as it is.
        let keeper = users(glb, mesh)
            .all(|user| nodes.contains(&user))
            .then(|| nodes.first().copied())
            .flatten();
        for node in nodes {
            let own = if keeper == Some(node) {
                mesh
            } else {
                copy_mesh(glb, mesh, node)
            };
            mesh_of_node.insert(node, own);
        }
    }
    let target = |baked: &BakedPrimitive<'_>| Target {
        mesh: mesh_of_node[&baked.key.node],
        primitive: baked.key.primitive,
    };
    Ok(baked.iter().map(target).collect())
}

fn users(glb: &Glb, mesh: usize) -> impl Iterator<Item = usize> {
    let nodes = glb.json["nodes"].as_array().into_iter().flatten();
    let uses = move |node: &Value| node["mesh"].as_u64() == Some(mesh as u64);
    nodes
        .enumerate()
        .filter(move |(_, node)| uses(node))
        .map(|(index, _)| index)
}

fn copy_mesh(glb: &mut Glb, mesh: usize, node: usize) -> usize {
    let mut copy = glb.json["meshes"][mesh].clone();
    if let Some(name) = copy["name"].as_str() {
        copy["name"] = format!("{name}_node{node}").into();
    }
    let copy = glb.push("meshes", copy);
    glb.json["nodes"][node]["mesh"] = copy.into();
    copy
}

/// Each key must name a primitive of the document, and no two the same.
fn check_keys(glb: &Glb, baked: &[BakedPrimitive<'_>]) -> Result<(), GltfError> {
    let mut seen = HashSet::new();
    for BakedPrimitive { key, .. } in baked {
        let node = &glb.json["nodes"][key.node];
        let primitive = &glb.json["meshes"][key.mesh]["primitives"][key.primitive];
        if whole(node, "mesh") != Ok(Some(key.mesh)) || !primitive.is_object() {
            return Err(glb.refuse(format!("it has no {key:?}")));
        }
        if !seen.insert((key.node, key.primitive)) {
            return Err(glb.refuse(format!("there is light twice for {key:?}")));
        }
    }
    Ok(())
}

//! The node tree: world transforms in double precision, and the nodes of the scene in order.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;
use serde_json::Value;

use super::notes::Notes;

/// Where all nodes are, and which ones the scene shows.
#[derive(Debug)]
pub(super) struct Hierarchy {
    /// World from node, of every node of the document.
    pub(super) world: Vec<DAffine3>,
    /// The nodes of the scene, parents before children, in the order of the file.
    pub(super) order: Vec<usize>,
    /// Whether `KHR_node_visibility` hides the node or one above it.
    pub(super) hidden: Vec<bool>,
}

impl Hierarchy {
    /// Walks the tree. `json` is the same document as `root`, whose numbers are only `f32`.
    pub(super) fn new(root: &Root, json: &Value, notes: &mut Notes) -> Result<Self, String> {
        let parents = find_parents(root)?;
        let tops = (0..parents.len()).filter(|&node| parents[node].is_none());
        let tops: Vec<usize> = tops.collect();
        let all = preorder(root, &tops);
        if let Some(node) = find_missing(&all, parents.len()) {
            return Err(format!(
                "nodes[{node}] is among its own ancestors or below such a node"
            ));
        }
        let mut world = vec![DAffine3::IDENTITY; parents.len()];
        let mut hidden = vec![false; parents.len()];
        for node in all {
            let local = local_transform(&json["nodes"][node]);
            let above = parents[node];
            world[node] = above.map_or(local, |parent| world[parent] * local);
            let itself = is_hidden(&root.nodes[node]);
            hidden[node] = itself || above.is_some_and(|parent| hidden[parent]);
            if itself {
                notes.add(format!(
                    "Node {} and what is below it is hidden by KHR_node_visibility: left out.",
                    node_name(root, node)
                ));
            }
        }
        let order = preorder(root, &scene_roots(root, &tops, notes));
        Ok(Self {
            world,
            order,
            hidden,
        })
    }
}

/// The name of a node, or one that says which it is.
pub(super) fn node_name(root: &Root, node: usize) -> String {
    let name = root.nodes.get(node).and_then(|node| node.name.clone());
    let name = name.filter(|name| !name.is_empty());
    name.unwrap_or_else(|| format!("node {node}"))
}

fn children(node: &Node) -> impl DoubleEndedIterator<Item = usize> {
    let children = node.children.as_deref().unwrap_or_default();
    children.iter().map(|child| child.value())
}

fn find_parents(root: &Root) -> Result<Vec<Option<usize>>, String> {
    let mut parents = vec![None; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for child in children(node) {
            match parents.get_mut(child) {
                None => return Err(format!("nodes[{index}] has a child that does not exist")),
                Some(Some(other)) => {
                    return Err(format!(
                        "nodes[{child}] has two parents, nodes[{other}] and nodes[{index}]"
                    ));
                }
                Some(parent) => *parent = Some(index),
            }
        }
    }
    Ok(parents)
}

/// The nodes at and below `tops`, each once; a stack, as trees may be deep.
fn preorder(root: &Root, tops: &[usize]) -> Vec<usize> {
    let mut seen = vec![false; root.nodes.len()];
    let mut order = Vec::new();
    let mut stack: Vec<usize> = tops.iter().rev().copied().collect();
    while let Some(node) = stack.pop() {
        if node < seen.len() && !std::mem::replace(&mut seen[node], true) {
            order.push(node);
            stack.extend(children(&root.nodes[node]).rev());
        }
    }
    order
}

fn find_missing(nodes: &[usize], count: usize) -> Option<usize> {
    let mut seen = vec![false; count];
    for &node in nodes {
        seen[node] = true;
    }
    seen.iter().position(|&seen| !seen)
}

fn scene_roots(root: &Root, tops: &[usize], notes: &mut Notes) -> Vec<usize> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    if root.scene.is_none() && root.scenes.len() > 1 {
        notes.add(format!(
            "The file names no default scene: the first of its {} scenes is used.",
            root.scenes.len()
        ));
    }
    match root.scenes.get(scene) {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => {
            if !tops.is_empty() {
                notes.add("The file has no scene: all its nodes are used.".to_owned());
            }
            tops.to_vec()
        }
    }
}

fn is_hidden(node: &Node) -> bool {
    let extensions = node.extensions.as_ref();
    let visibility = extensions.and_then(|all| all.others.get("KHR_node_visibility"));
    visibility.and_then(|v| v.get("visible")) == Some(&Value::Bool(false))
}

/// Parent from node. Shapes were checked with the typed document.
pub(super) fn local_transform(node: &Value) -> DAffine3 {
    if let Some(columns) = numbers::<16>(node, "matrix") {
        let matrix = DMat4::from_cols_array(&columns);
        return DAffine3::from_mat3_translation(DMat3::from_mat4(matrix), matrix.w_axis.truncate());
    }
    let translation = numbers(node, "translation").map_or(DVec3::ZERO, DVec3::from_array);
    let scale = numbers(node, "scale").map_or(DVec3::ONE, DVec3::from_array);
    let rotation = numbers(node, "rotation").map_or(DQuat::IDENTITY, DQuat::from_array);
    let length = rotation.length();
    let rotation = if length.is_finite() && length > 0.0 {
        DQuat::from_vec4(glam::DVec4::from(rotation) / length)
    } else {
        DQuat::IDENTITY
    };
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

fn numbers<const N: usize>(node: &Value, key: &str) -> Option<[f64; N]> {
    let values = node.get(key)?.as_array()?;
    let values: Option<Vec<f64>> = values.iter().map(Value::as_f64).collect();
    values?.try_into().ok()
}

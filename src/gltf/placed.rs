//! From mesh space to world space: node transforms, skins, mirrored nodes, normals.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use gltf::json::Root;
use gltf::json::accessor::Type;
use gltf::json::skin::Skin;

use super::accessor::Accessors;
use super::hierarchy::Hierarchy;
use super::primitive::Geometry;

/// Moves all vertices by one transform. A mirrored one flips the winding, so front stays front.
pub(super) fn place(geometry: &mut Geometry, world: &DAffine3) {
    let to_normal = normal_matrix(&world.matrix3);
    for position in &mut geometry.positions {
        *position = world.transform_point3(*position);
    }
    for normal in &mut geometry.normals {
        *normal = to_normal * *normal;
    }
    if world.matrix3.determinant() < 0.0 {
        flip(geometry);
    }
}

/// Moves each vertex with its joints, as they stand in the file.
pub(super) fn place_skinned(geometry: &mut Geometry, joints: &[DAffine3]) -> Result<(), String> {
    let per_vertex = geometry.joints.len() / geometry.positions.len().max(1);
    let mut handedness = 0.0;
    for vertex in 0..geometry.positions.len() {
        let slots = vertex * per_vertex..(vertex + 1) * per_vertex;
        let blend = blend(
            joints,
            &geometry.joints[slots.clone()],
            &geometry.weights[slots],
        )?;
        handedness += blend.matrix3.determinant();
        let position = &mut geometry.positions[vertex];
        *position = blend.transform_point3(*position);
        if let Some(normal) = geometry.normals.get_mut(vertex) {
            *normal = normal_matrix(&blend.matrix3) * *normal;
        }
    }
    if handedness < 0.0 {
        flip(geometry);
    }
    Ok(())
}

/// World from mesh for each joint of a skin: the joint's node and its inverse bind matrix.
pub(super) fn joint_transforms(
    skin: &Skin,
    accessors: Accessors<'_>,
    hierarchy: &Hierarchy,
) -> Result<Vec<DAffine3>, String> {
    let count = skin.joints.len();
    let mut binds = vec![DAffine3::IDENTITY; count];
    if let Some(accessor) = skin.inverse_bind_matrices {
        let (values, width) = accessors.floats(accessor.value(), &[Type::Mat4])?;
        if values.len() < count * width {
            return Err(format!(
                "has {count} joints but {} inverse bind matrices",
                values.len() / width
            ));
        }
        for (bind, m) in binds.iter_mut().zip(values.chunks_exact(width)) {
            let column = |c: usize| Vec3::from_slice(&m[4 * c..]).as_dvec3();
            *bind = DAffine3::from_cols(column(0), column(1), column(2), column(3));
        }
    }
    let nodes = skin.joints.iter().zip(binds);
    let transforms = nodes.map(|(node, bind)| Some(*hierarchy.world.get(node.value())? * bind));
    let transforms: Option<Vec<_>> = transforms.collect();
    transforms.ok_or_else(|| "has a joint that does not exist".to_owned())
}

fn blend(joints: &[DAffine3], indices: &[u32], weights: &[f32]) -> Result<DAffine3, String> {
    let joint = |index: u32| {
        let joint = joints.get(index as usize);
        joint.ok_or_else(|| format!("has joint {index}, but its skin has {}", joints.len()))
    };
    let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    if total <= 0.0 {
        return joint(indices.first().copied().unwrap_or(0)).copied();
    }
    let mut sum = DAffine3::from_mat3_translation(DMat3::ZERO, DVec3::ZERO);
    for (&index, &weight) in indices.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
        let joint = joint(index)?;
        let share = f64::from(weight) / total;
        sum.matrix3 += joint.matrix3 * share;
        sum.translation += joint.translation * share;
    }
    Ok(sum)
}

/// The inverse transpose but for a positive factor, and with no division: flattened meshes keep
/// normals, too.
fn normal_matrix(m: &DMat3) -> DMat3 {
    let cofactors = DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    );
    if m.determinant() < 0.0 {
        -cofactors
    } else {
        cofactors
    }
}

fn flip(geometry: &mut Geometry) {
    geometry.flipped = !geometry.flipped;
    for triangle in &mut geometry.triangles {
        triangle.swap(1, 2);
    }
}

/// Normals of length one. Where the file has none to speak of, those of the faces around; the
/// second value counts such vertices.
pub(super) fn unit_normals(geometry: &Geometry) -> (Vec<Vec3>, usize) {
    let unit = |normal: DVec3| normal.try_normalize().map(|normal| normal.as_vec3());
    let mut normals: Vec<_> = geometry.normals.iter().map(|&n| unit(n)).collect();
    let bad = normals.iter().filter(|normal| normal.is_none()).count();
    if bad > 0 {
        let mut around = vec![DVec3::ZERO; normals.len()];
        for triangle in &geometry.triangles {
            let [a, b, c] = triangle.map(|index| geometry.positions[index as usize]);
            let area = (b - a).cross(c - a);
            for &index in triangle {
                around[index as usize] += area;
            }
        }
        for (normal, around) in normals.iter_mut().zip(around) {
            *normal = normal.or_else(|| unit(around));
        }
    }
    let normals = normals.into_iter().map(|n| n.unwrap_or(Vec3::Y));
    (normals.collect(), bad)
}

/// A point to measure positions from, so that `f32` holds them well: zero, unless `points` lie
/// close together and far from it.
pub(super) fn choose_origin(points: impl Iterator<Item = DVec3>) -> DVec3 {
    const FAR: f64 = 16.0;
    const GRID: f64 = 16.0;
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(none, |(low, high), p| (low.min(p), high.max(p)));
    let extent = (high - low).max_element();
    let center = low + 0.5 * (high - low);
    if center.is_finite() && center.length() > FAR * extent {
        (center * GRID).round() / GRID
    } else {
        DVec3::ZERO
    }
}

/// The skin of a node, by index into `nodes`.
pub(super) fn skin_of(root: &Root, node: usize) -> Option<(usize, &Skin)> {
    let index = root.nodes.get(node)?.skin?.value();
    Some((index, root.skins.get(index)?))
}

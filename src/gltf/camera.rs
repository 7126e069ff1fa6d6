use glam::{DAffine3, DVec3, Vec3};
use gltf::json::Root;
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::hierarchy::node_name;
use super::notes::Notes;

/// A camera of a glTF file, as it stands in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfCamera {
    /// Name of its node.
    pub name: String,
    /// Index of its node.
    pub node: usize,
    /// Where it is, in metres, relative to [`Scene::origin`](crate::radiosity::Scene::origin).
    pub position: Vec3,
    /// Where it looks; length 1.
    pub forward: Vec3,
    /// What is up in its image; length 1, at right angles to `forward`.
    pub up: Vec3,
    /// How it maps the scene to its image.
    pub projection: GltfProjection,
}

/// How a [`GltfCamera`] maps the scene to its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GltfProjection {
    /// Far things are small.
    Perspective {
        /// Vertical angle of view in radians.
        yfov: f32,
        /// Width over height; that of the image, if not given.
        aspect: Option<f32>,
        /// Nearest distance shown, in metres.
        near: f32,
        /// Farthest distance shown, in metres; none for no limit.
        far: Option<f32>,
    },
    /// All things keep their size.
    Orthographic {
        /// Half the width shown, in metres.
        xmag: f32,
        /// Half the height shown, in metres.
        ymag: f32,
        /// Nearest distance shown, in metres.
        near: f32,
        /// Farthest distance shown, in metres.
        far: f32,
    },
}

/// The camera of a node, relative to `origin`; or nothing, if it has none or a broken one (a note
/// says so then).
pub(super) fn camera_of(
    root: &Root,
    node: usize,
    world: &DAffine3,
    origin: DVec3,
    notes: &mut Notes,
) -> Option<GltfCamera> {
    let index = root.nodes.get(node)?.camera?;
    let name = node_name(root, node);
    let position = (world.translation - origin).as_vec3();
    let axes = axes(world);
    let (Some(projection), Some((forward, up)), true) =
        (projection(root, index.value()), axes, position.is_finite())
    else {
        notes.add(format!(
            "Camera {name} has numbers that make no picture: it is ignored."
        ));
        return None;
    };
    Some(GltfCamera {
        name,
        node,
        position,
        forward,
        up,
        projection,
    })
}

/// Forward and up, at right angles whatever the node's scale.
fn axes(world: &DAffine3) -> Option<(Vec3, Vec3)> {
    let forward = (-world.matrix3.z_axis).try_normalize()?;
    let up = world.matrix3.y_axis.try_normalize()?;
    let up = (up - forward * up.dot(forward)).try_normalize()?;
    Some((forward.as_vec3(), up.as_vec3()))
}

fn projection(root: &Root, camera: usize) -> Option<GltfProjection> {
    let camera = root.cameras.get(camera)?;
    let good = |value: f32| value.is_finite() && value > 0.0;
    match camera.type_ {
        Checked::Valid(Type::Perspective) => {
            let p = camera.perspective.as_ref()?;
            let fine = good(p.yfov) && p.yfov < std::f32::consts::PI;
            fine.then_some(GltfProjection::Perspective {
                yfov: p.yfov,
                aspect: p.aspect_ratio.filter(|&aspect| good(aspect)),
                near: p.znear,
                far: p.zfar,
            })
        }
        Checked::Valid(Type::Orthographic) => {
            let o = camera.orthographic.as_ref()?;
            // Negative magnifications are allowed, and mirror the image: not of interest here.
            let fine = good(o.xmag.abs()) && good(o.ymag.abs());
            fine.then_some(GltfProjection::Orthographic {
                xmag: o.xmag.abs(),
                ymag: o.ymag.abs(),
                near: o.znear,
                far: o.zfar,
            })
        }
        Checked::Invalid => None,
    }
}

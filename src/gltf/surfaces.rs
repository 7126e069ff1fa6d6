use std::collections::HashMap;
use std::path::Path;

use glam::{DAffine3, Vec2, Vec3};
use gltf::json::Root;

use super::accessor::Accessors;
use super::document::{Document, PrimitiveKey};
use super::error::GltfError;
use super::hierarchy::Hierarchy;
use super::import::{Opened, open};
use super::notes::Notes;
use super::placed;
use super::primitive::Reader;
use super::relief::{MaterialDisplacement, Reliefs};

/// The meshes of a glTF file, each in its own space.
#[derive(Clone, Debug)]
pub struct GltfSurfaces {
    /// The file itself, to write results into.
    pub document: Document,
    /// Those that the scene shows, in the order of the file.
    pub meshes: Vec<MeshSurface>,
    /// Those that materials of these ask for, or why one cannot be had; none if texture coordinates were asked for
    /// by their set.
    pub displacements: Vec<Result<MaterialDisplacement, String>>,
    /// What in the file was left out or taken otherwise than it says, one sentence each.
    pub notes: Vec<String>,
}

/// A mesh, as it is before nodes, skins and morph targets move it.
#[derive(Clone, Debug, Default)]
pub struct MeshSurface {
    /// That of the first node that shows it, or its own.
    pub name: String,
    /// Metres that a unit of it is in the scene.
    pub scale: f64,
    /// Those made of triangles.
    pub primitives: Vec<PrimitiveSurface>,
}

/// One primitive of a mesh.
#[derive(Clone, Debug)]
pub struct PrimitiveSurface {
    /// Which of the file; its node is the first that shows it.
    pub key: PrimitiveKey,
    /// Name of its material, empty if it has none.
    pub material: String,
    /// Which of the [`displacements`](GltfSurfaces::displacements) its material asks for.
    pub displacement: Option<usize>,
    /// Of the vertices.
    pub positions: Vec<Vec3>,
    /// Of the vertices, or none.
    pub normals: Vec<Vec3>,
    /// Of the vertices, or none: those asked for.
    pub uvs: Vec<Vec2>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

/// Scales of a node along its axes, or of nodes that show one mesh, may differ by this share untold.
const SAME_SCALE: f64 = 0.01;

/// Loads the meshes of a `.glb` or `.gltf` file, with the set `uv_set` of texture coordinates; with `None`,
/// those that lay the material's displacement on the mesh, transformed.
///
/// # Errors
///
/// [`GltfError`] if a file cannot be read, is not glTF, contradicts itself or requires an extension that is not
/// supported.
pub fn load_surfaces(path: &Path, uv_set: Option<u32>) -> Result<GltfSurfaces, GltfError> {
    let bytes = std::fs::read(path).map_err(|source| GltfError::Read {
        path: path.to_owned(),
        source,
    })?;
    let Opened {
        document,
        root,
        hierarchy,
        mut notes,
    } = open(path, &bytes)?;
    let accessors = Accessors::new(&root, &document.buffers);
    let mut loader = Loader {
        root: &root,
        accessors,
        hierarchy: &hierarchy,
        uv_set,
        reliefs: Reliefs {
            path,
            root: &root,
            accessors,
            found: Vec::new(),
            known: HashMap::new(),
        },
    };
    let meshes = loader
        .meshes(&mut notes)
        .map_err(|reason| GltfError::Invalid {
            path: path.to_owned(),
            reason,
        })?;
    let displacements = loader.reliefs.found;
    Ok(GltfSurfaces {
        document,
        meshes,
        displacements,
        notes: notes.into_list(),
    })
}

struct Loader<'a> {
    root: &'a Root,
    accessors: Accessors<'a>,
    hierarchy: &'a Hierarchy,
    uv_set: Option<u32>,
    reliefs: Reliefs<'a>,
}

impl Loader<'_> {
    fn meshes(&mut self, notes: &mut Notes) -> Result<Vec<MeshSurface>, String> {
        let mut nodes = vec![Vec::new(); self.root.meshes.len()];
        for &node in &self.hierarchy.order {
            if let Some(mesh) = self.root.nodes[node].mesh
                && !self.hierarchy.hidden[node]
            {
                let fault = "a node has a mesh that does not exist";
                nodes.get_mut(mesh.value()).ok_or(fault)?.push(node);
            }
        }
        let shown = nodes
            .iter()
            .enumerate()
            .filter(|(_, nodes)| !nodes.is_empty());
        shown
            .map(|(mesh, nodes)| self.mesh(mesh, nodes, notes))
            .collect()
    }

    fn mesh(
        &mut self,
        mesh: usize,
        nodes: &[usize],
        notes: &mut Notes,
    ) -> Result<MeshSurface, String> {
        let given = [
            &self.root.nodes[nodes[0]].name,
            &self.root.meshes[mesh].name,
        ];
        let name = given.into_iter().flatten().find(|name| !name.is_empty());
        let name = name.cloned().unwrap_or_else(|| format!("mesh {mesh}"));
        let mut surface = MeshSurface {
            scale: self.scale(&name, nodes, notes)?,
            name,
            primitives: Vec::new(),
        };
        for (primitive, typed) in self.root.meshes[mesh].primitives.iter().enumerate() {
            let mut reader = Reader {
                accessors: self.accessors,
                name: &surface.name,
                notes,
            };
            let geometry = (reader.read(typed, &[]))
                .map_err(|reason| format!("meshes[{mesh}].primitives[{primitive}] {reason}"))?;
            let Some(mut geometry) = geometry else {
                continue;
            };
            let material = typed.material.and_then(|m| self.root.get(m)?.name.clone());
            // Images that nobody asks for are not read.
            let asked = typed.material.filter(|_| self.uv_set.is_none());
            let displacement = asked.and_then(|material| self.reliefs.of(material.value()));
            let own = displacement.and_then(|d| self.reliefs.found[d].as_ref().ok());
            let set = self.uv_set.or(own.map(|own| own.uv_set));
            let set = set.and_then(|set| usize::try_from(set).ok());
            let mut uvs = match set.filter(|&set| set < geometry.uvs.len()) {
                Some(set) => geometry.uvs.swap_remove(set),
                None => Vec::new(),
            };
            if let Some(own) = own {
                for uv in &mut uvs {
                    *uv = own.uv_transform.transform_point2(*uv);
                }
            }
            surface.primitives.push(PrimitiveSurface {
                key: PrimitiveKey {
                    node: nodes[0],
                    mesh,
                    primitive,
                },
                material: material.unwrap_or_default(),
                displacement,
                positions: geometry.positions.iter().map(|p| p.as_vec3()).collect(),
                normals: geometry.normals.iter().map(|n| n.as_vec3()).collect(),
                uvs,
                triangles: geometry.triangles,
            });
        }
        Ok(surface)
    }

    /// Metres a unit, by the first of the nodes.
    fn scale(&self, name: &str, nodes: &[usize], notes: &mut Notes) -> Result<f64, String> {
        let mut first = None;
        for &node in nodes {
            let world = self.world(node)?.matrix3;
            let axes = [world.x_axis, world.y_axis, world.z_axis].map(|axis| axis.length());
            let scale = world.determinant().abs().cbrt();
            let differs = |other: f64| (other - scale).abs() > SAME_SCALE * scale;
            if axes.into_iter().any(differs) {
                notes.add(format!(
                    "{name} is stretched by its node: relief has its height on average over the \
                     axes; apply the node's scale to the mesh to have it everywhere."
                ));
            }
            if first.is_some_and(differs) {
                notes.add(format!(
                    "{name} is shown by nodes of different scales: relief has its height at the \
                     first."
                ));
            }
            first.get_or_insert(scale);
        }
        let scale = first.unwrap_or(1.0);
        match scale > 0.0 && scale.is_finite() {
            true => Ok(scale),
            false => Err(format!("{name} is shrunk to nothing by its node")),
        }
    }

    /// Where a mesh stands: where its node does, or its skin's first joint.
    fn world(&self, node: usize) -> Result<DAffine3, String> {
        if let Some((_, skin)) = placed::skin_of(self.root, node) {
            let joints = placed::joint_transforms(skin, self.accessors, self.hierarchy)?;
            if let Some(&joint) = joints.first() {
                return Ok(joint);
            }
        }
        Ok(self.hierarchy.world[node])
    }
}

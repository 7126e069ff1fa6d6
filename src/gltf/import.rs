use std::path::Path;

use glam::{DAffine3, DVec3};
use gltf::json::Root;

use super::accessor::Accessors;
use super::camera::{GltfCamera, camera_of};
use super::document::{Document, PrimitiveKey};
use super::error::GltfError;
use super::hierarchy::{Hierarchy, node_name};
use super::material::Materials;
use super::notes::Notes;
use super::primitive::{Geometry, Reader};
use super::punctual::light_of;
use super::texture::Textures;
use super::{check, container, placed};
use crate::radiosity::{Light, MaterialId, Object, Scene};

/// What [`load`] makes of a glTF file.
#[derive(Clone, Debug)]
pub struct GltfScene {
    /// What to bake.
    pub scene: Scene,
    /// The file itself, to write results into.
    pub document: Document,
    /// Which primitive each of the scene's objects was made from, in the same order.
    ///
    /// Vertices of an object are those of the primitive, in the same order; so are its triangles,
    /// though wound the other way under a mirrored node.
    pub objects: Vec<PrimitiveKey>,
    /// Whether the triangles of each object were turned around, because its node is mirrored.
    pub flipped: Vec<bool>,
    /// Which node each of the scene's lights was made from, in the same order.
    pub light_nodes: Vec<usize>,
    /// The first camera of the scene.
    pub camera: Option<GltfCamera>,
    /// What in the file was left out or taken otherwise than it says, one sentence each.
    pub notes: Vec<String>,
}

/// Loads the default scene of a `.glb` or `.gltf` file, with the buffers and images it refers to.
///
/// # Errors
///
/// [`GltfError`] if a file cannot be read, is not glTF, contradicts itself or requires an
/// extension that is not supported. Images that cannot be read are no error: see
/// [`GltfScene::notes`].
pub fn load(path: &Path) -> Result<GltfScene, GltfError> {
    let bytes = std::fs::read(path).map_err(|source| GltfError::Read {
        path: path.to_owned(),
        source,
    })?;
    import(path, &bytes)
}

/// A file that was read and checked, and nothing made of it yet.
pub(super) struct Opened {
    pub(super) document: Document,
    pub(super) root: Root,
    pub(super) hierarchy: Hierarchy,
    pub(super) notes: Notes,
}

/// Reads and checks the file at `path`, whose content is `bytes`, with the buffers it refers to.
pub(super) fn open(path: &Path, bytes: &[u8]) -> Result<Opened, GltfError> {
    let invalid = |reason: String| GltfError::Invalid {
        path: path.to_owned(),
        reason,
    };
    let parts = container::split(bytes).map_err(invalid)?;
    let json = check::parse(parts.json).map_err(invalid)?;
    if let Some(extension) = check::unsupported_extension(&json) {
        return Err(GltfError::UnsupportedExtension {
            path: path.to_owned(),
            extension: extension.to_owned(),
        });
    }
    let mut notes = Notes::default();
    let root = check::typed(parts.json, &json, &mut notes).map_err(invalid)?;
    let hierarchy = Hierarchy::new(&root, &json, &mut notes).map_err(invalid)?;
    let buffers = container::load_buffers(path, &root, parts.bin)?;
    let document = Document {
        path: path.to_owned(),
        json,
        buffers,
    };
    Ok(Opened {
        document,
        root,
        hierarchy,
        notes,
    })
}

/// Like [`load`], with the content of the file at `path` given.
pub(super) fn import(path: &Path, bytes: &[u8]) -> Result<GltfScene, GltfError> {
    let Opened {
        document,
        root,
        hierarchy,
        notes,
    } = open(path, bytes)?;
    let importer = Importer::new(&root, &document, hierarchy, notes);
    let result = importer.run().map_err(|reason| GltfError::Invalid {
        path: path.to_owned(),
        reason,
    })?;
    Ok(GltfScene {
        document,
        scene: result.scene,
        objects: result.objects,
        flipped: result.flipped,
        light_nodes: result.light_nodes,
        camera: result.camera,
        notes: result.notes,
    })
}

/// All of a [`GltfScene`] but the document, which is still borrowed while this is made.
struct Imported {
    scene: Scene,
    objects: Vec<PrimitiveKey>,
    flipped: Vec<bool>,
    light_nodes: Vec<usize>,
    camera: Option<GltfCamera>,
    notes: Vec<String>,
}

/// A primitive in world space, before the scene's origin is known.
struct Placed {
    key: PrimitiveKey,
    name: String,
    geometry: Geometry,
    material: MaterialId,
}

struct Importer<'a> {
    root: &'a Root,
    accessors: Accessors<'a>,
    hierarchy: Hierarchy,
    materials: Materials<'a>,
    placed: Vec<Placed>,
    notes: Notes,
}

impl<'a> Importer<'a> {
    fn new(root: &'a Root, document: &'a Document, hierarchy: Hierarchy, notes: Notes) -> Self {
        let accessors = Accessors::new(root, &document.buffers);
        let textures = Textures::new(&document.path, root, accessors);
        Self {
            root,
            accessors,
            hierarchy,
            materials: Materials::new(root, textures),
            placed: Vec::new(),
            notes,
        }
    }

    fn run(mut self) -> Result<Imported, String> {
        let order = std::mem::take(&mut self.hierarchy.order);
        let shown: Vec<usize> = order
            .iter()
            .copied()
            .filter(|&n| !self.hierarchy.hidden[n])
            .collect();
        for &node in &shown {
            self.add_mesh(node)?;
        }
        let positions = self
            .placed
            .iter()
            .flat_map(|placed| &placed.geometry.positions);
        let origin = placed::choose_origin(positions.copied());
        let mut scene = Scene {
            origin,
            ..Scene::default()
        };
        let (lights, light_nodes) = self.lights(&shown, origin);
        scene.lights = lights;
        let camera = order.iter().find_map(|&node| {
            let world = &self.hierarchy.world[node];
            camera_of(self.root, node, world, origin, &mut self.notes)
        });
        let objects = self.placed.iter().map(|placed| placed.key).collect();
        let flipped = self.placed.iter().map(|placed| placed.geometry.flipped);
        let flipped = flipped.collect();
        for placed in std::mem::take(&mut self.placed) {
            scene.objects.push(finish(placed, origin, &mut self.notes)?);
        }
        scene.materials = self.materials.made;
        scene.textures = self.materials.textures.loaded;
        Ok(Imported {
            scene,
            objects,
            flipped,
            light_nodes,
            camera,
            notes: self.notes.into_list(),
        })
    }

    /// The lights of `nodes`, and which node each one is of.
    fn lights(&mut self, nodes: &[usize], origin: DVec3) -> (Vec<Light>, Vec<usize>) {
        let lights = nodes.iter().filter_map(|&node| {
            let world = &self.hierarchy.world[node];
            let light = light_of(self.root, node, world, origin, &mut self.notes)?;
            Some((light, node))
        });
        lights.unzip()
    }

    /// Adds the mesh of a node, if it has one.
    fn add_mesh(&mut self, node: usize) -> Result<(), String> {
        let root = self.root;
        let Some(mesh) = root.nodes[node].mesh else {
            return Ok(());
        };
        let index = mesh.value();
        let mesh = root
            .get(mesh)
            .ok_or("a node has a mesh that does not exist")?;
        self.note_instancing(node);
        let base = mesh_object_name(root, node, index);
        let joints = self.joints(node)?;
        for (primitive, _) in mesh.primitives.iter().enumerate() {
            let key = PrimitiveKey {
                node,
                mesh: index,
                primitive,
            };
            let name = if mesh.primitives.len() > 1 {
                format!("{base}/{primitive}")
            } else {
                base.clone()
            };
            self.add_primitive(key, name, joints.as_deref())
                .map_err(|reason| format!("meshes[{index}].primitives[{primitive}] {reason}"))?;
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        key: PrimitiveKey,
        name: String,
        joints: Option<&[DAffine3]>,
    ) -> Result<(), String> {
        let mesh = &self.root.meshes[key.mesh];
        let primitive = &mesh.primitives[key.primitive];
        let weights = self.root.nodes[key.node].weights.as_deref();
        let weights = weights.or(mesh.weights.as_deref()).unwrap_or_default();
        let mut reader = Reader {
            accessors: self.accessors,
            name: &name,
            notes: &mut self.notes,
        };
        let Some(mut geometry) = reader.read(primitive, weights)? else {
            return Ok(());
        };
        match joints {
            Some(joints) if !geometry.joints.is_empty() => {
                placed::place_skinned(&mut geometry, joints)?;
                self.notes
                    .add(format!("{name} is skinned: it is baked in its rest pose."));
            }
            _ => placed::place(&mut geometry, &self.hierarchy.world[key.node]),
        }
        let material = primitive.material.map(|material| material.value());
        if material.is_none() {
            self.notes
                .add(format!("{name} has no material: a white one is used."));
        }
        let material = self
            .materials
            .get(material, geometry.uvs.len(), &mut self.notes);
        self.placed.push(Placed {
            key,
            name,
            geometry,
            material,
        });
        Ok(())
    }

    fn joints(&self, node: usize) -> Result<Option<Vec<DAffine3>>, String> {
        let Some((index, skin)) = placed::skin_of(self.root, node) else {
            return Ok(None);
        };
        placed::joint_transforms(skin, self.accessors, &self.hierarchy)
            .map(Some)
            .map_err(|reason| format!("skins[{index}] {reason}"))
    }

    fn note_instancing(&mut self, node: usize) {
        const INSTANCING: &str = "EXT_mesh_gpu_instancing";
        let extensions = self.root.nodes[node].extensions.as_ref();
        if extensions.is_some_and(|all| all.others.contains_key(INSTANCING)) {
            self.notes.add(format!(
                "Node {} has instances ({INSTANCING}), of which only one at the node itself is \
                 used: export them as nodes.",
                node_name(self.root, node)
            ));
        }
    }
}

fn mesh_object_name(root: &Root, node: usize, mesh: usize) -> String {
    let names = [&root.nodes[node].name, &root.meshes[mesh].name];
    let name = names.into_iter().flatten().find(|name| !name.is_empty());
    name.cloned().unwrap_or_else(|| format!("node {node}"))
}

/// Makes positions relative to the origin, and single precision.
fn finish(placed: Placed, origin: DVec3, notes: &mut Notes) -> Result<Object, String> {
    let Placed {
        name,
        geometry,
        material,
        ..
    } = placed;
    let relative = |position: &DVec3| (*position - origin).as_vec3();
    let positions: Vec<_> = geometry.positions.iter().map(relative).collect();
    if positions.iter().any(|position| !position.is_finite()) {
        return Err(format!("the transforms of {name} lead beyond all numbers"));
    }
    let (normals, repaired) = placed::unit_normals(&geometry);
    if repaired > 0 {
        notes.add(format!(
            "{name} has normals that point nowhere ({repaired}): those of its faces are used \
             instead."
        ));
    }
    Ok(Object {
        name,
        positions,
        normals,
        uvs: geometry.uvs,
        colors: geometry.colors,
        triangles: geometry.triangles,
        material,
        ..Object::default()
    })
}

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::Session;
use super::failure::Failure;
use crate::gltf::{BakedPrimitive, Document, GltfCamera, GltfScene, PrimitiveKey};
use crate::radiosity::{Bake, ValidScene};

use std::sync::atomic::Ordering;

/// A scene file, read and checked, with what is needed to write it again.
pub(super) struct Loaded {
    pub(super) scene: ValidScene,
    pub(super) document: Document,
    pub(super) light_nodes: Vec<usize>,
    pub(super) camera: Option<GltfCamera>,
    pub(super) notes: Vec<String>,
    /// How long checking took.
    pub(super) validate: Duration,
    objects: Vec<PrimitiveKey>,
    flipped: Vec<bool>,
}

impl Loaded {
    pub(super) fn check(file: GltfScene) -> Result<Self, Failure> {
        let started = Instant::now();
        Ok(Self {
            scene: file.scene.validate()?,
            validate: started.elapsed(),
            document: file.document,
            light_nodes: file.light_nodes,
            camera: file.camera,
            notes: file.notes,
            objects: file.objects,
            flipped: file.flipped,
        })
    }

    /// The light of a bake beside the primitives it belongs to.
    pub(super) fn primitives<'a>(&'a self, bake: &'a Bake) -> Vec<BakedPrimitive<'a>> {
        (self.objects.iter().zip(&self.flipped))
            .zip(bake.objects.iter().zip(&self.scene.objects))
            .map(|((&key, &flipped), (light, object))| BakedPrimitive {
                key,
                light,
                triangles: &object.triangles,
                flipped,
            })
            .collect()
    }
}

/// Files beside the scene that it refers to.
pub(super) fn resources(document: &Document) -> Vec<PathBuf> {
    let lists = ["buffers", "images"].into_iter();
    let entries = lists
        .filter_map(|list| document.json[list].as_array())
        .flatten();
    let folder = document.path.parent();
    entries
        .filter_map(|entry| entry.get("uri").and_then(Value::as_str))
        .filter(|uri| !uri.starts_with("data:"))
        .map(|uri| folder.map_or_else(|| PathBuf::from(uri), |folder| folder.join(uri)))
        .collect()
}

/// Runs `work` on as many threads as asked, and says how many those are.
pub(super) fn on_threads<T: Send>(
    threads: Option<u16>,
    work: impl FnOnce(usize) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from))
        .build()
        .map_err(|error| {
            Failure::Error(format!(
                "cannot start the threads: {error}; lower --threads"
            ))
        })?;
    pool.install(|| work(rayon::current_num_threads()))
}

/// An error if the run was stopped.
pub(super) fn go_on(session: &Session) -> Result<(), Failure> {
    if session.cancel.load(Ordering::Relaxed) {
        Err(Failure::Cancelled)
    } else {
        Ok(())
    }
}

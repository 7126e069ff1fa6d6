use std::error::Error;
use std::path::Path;

use bevy_fresco::gltf::{BakedPrimitive, ExportOptions, Exported, load, to_glb};
use bevy_fresco::radiosity::{BakeSettings, Report, bake};

/// The file with light in its vertices, and how good that is. All notes are with the file.
pub(crate) fn baked(
    path: &Path,
    settings: &BakeSettings,
) -> Result<(Exported, Report), Box<dyn Error>> {
    let file = load(path)?;
    let triangles: Vec<_> = (file.scene.objects.iter())
        .map(|object| object.triangles.clone())
        .collect();
    let scene = file.scene.validate()?;
    // The observer could show how far it is, and stop it.
    let bake = bake(&scene, settings, &())?;
    let primitives: Vec<BakedPrimitive> = (file.objects.iter().zip(&file.flipped))
        .zip(triangles.iter().zip(&bake.objects))
        .map(|((&key, &flipped), (triangles, light))| BakedPrimitive {
            key,
            light,
            triangles,
            flipped,
        })
        .collect();
    let options = ExportOptions::default();
    let mut exported = to_glb(&file.document, &primitives, &file.light_nodes, &options)?;
    let before = file.notes.iter().chain(scene.notes());
    let before = before.chain(&bake.report.notes).cloned();
    exported.notes.splice(0..0, before);
    Ok((exported, bake.report))
}

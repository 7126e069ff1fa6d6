//! What the commands share that change a file's meshes one by one.

use std::path::{Path, PathBuf};

use super::failure::Failure;
use super::outputs::same;
use crate::gltf::MeshSurface;
use crate::text::bytes;

/// An error if the result would replace one of the files it is made from.
pub(super) fn spare<'a>(
    output: &Path,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), Failure> {
    match inputs.into_iter().find(|input| same(output, input)) {
        None => Ok(()),
        Some(path) => Err(Failure::Error(format!(
            "{} is what the result is made from and would be overwritten: choose another name (-o)",
            path.display()
        ))),
    }
}

/// Whether one of the names is asked for, or all are.
pub(super) fn wanted(only: &[String], names: &[&str]) -> bool {
    only.is_empty() || only.iter().any(|only| names.contains(&only.as_str()))
}

/// Why nothing was done: a file has no triangles, or nothing of a name.
pub(super) fn nothing(
    scene: &Path,
    only: &[String],
    meshes: &[MeshSurface],
    purpose: &str,
) -> Failure {
    let mut names: Vec<&str> = (meshes.iter())
        .flat_map(|mesh| {
            let materials = mesh.primitives.iter().map(|p| p.material.as_str());
            materials.chain([mesh.name.as_str()])
        })
        .filter(|name| !name.is_empty())
        .collect();
    names.sort_unstable();
    names.dedup();
    let scene = scene.display();
    match names.is_empty() {
        true => Failure::Error(format!("{scene} has no triangles {purpose}")),
        false => Failure::Error(format!(
            "{scene} has nothing named {}: it has {}",
            only.join(" or "),
            names.join(", ")
        )),
    }
}

/// For the terminal.
pub(super) fn summary(lines: &[String], notes: &[String], (output, size): (&Path, u64)) -> String {
    let mut text = String::new();
    for line in lines {
        text.push_str(&format!("{line}\n"));
    }
    if !notes.is_empty() {
        text.push_str("\nnotes\n");
    }
    for note in notes {
        text.push_str(&format!("  - {note}\n"));
    }
    text.push_str(&format!("\nwrote {} ({})\n", output.display(), bytes(size)));
    text
}

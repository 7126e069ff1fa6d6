//! Arrows point one way: plugin, command line and glTF know the core, the core knows none of them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::fs;
use std::path::{Path, PathBuf};

/// Room of the house, and what its source must not name.
const RULES: [(&str, &[&str]); 6] = [
    (
        "src/height_map",
        &[
            "bevy_",
            "crate::bump",
            "crate::displacement",
            "crate::mesh",
            "crate::radiosity",
            "crate::gltf",
            "crate::plugin",
            "crate::cli",
        ],
    ),
    (
        "src/bump",
        &[
            "bevy_",
            "crate::radiosity",
            "crate::gltf",
            "crate::plugin",
            "crate::cli",
        ],
    ),
    (
        "src/displacement",
        &[
            "bevy_",
            "crate::bump",
            "crate::radiosity",
            "crate::gltf",
            "crate::plugin",
            "crate::cli",
            "gltf::",
            "serde",
        ],
    ),
    (
        "src/mesh",
        &[
            "bevy_",
            "crate::radiosity",
            "crate::gltf",
            "crate::plugin",
            "crate::cli",
            "gltf::",
            "serde",
        ],
    ),
    (
        "src/radiosity",
        &[
            "bevy_",
            "crate::gltf",
            "crate::plugin",
            "crate::cli",
            "gltf::",
            "clap",
        ],
    ),
    (
        "src/gltf",
        &["bevy_", "crate::plugin", "crate::cli", "clap"],
    ),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn pure_rooms_name_nothing_above_them() {
    for (room, forbidden) in RULES {
        let mut files = Vec::new();
        sources(Path::new(room), &mut files);
        assert!(files.len() > 3, "{room} has moved");
        for file in files {
            let text = fs::read_to_string(&file)
                .unwrap()
                .replace("bevy_fresco", "");
            let code = text.lines().filter(|l| !l.trim_start().starts_with("//"));
            for (number, line) in code.enumerate() {
                for name in forbidden {
                    assert!(
                        !line.contains(name),
                        "{}: line {number} names {name}: {line}",
                        file.display()
                    );
                }
            }
        }
    }
}

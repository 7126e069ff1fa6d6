//! Writes the sample scenes to `assets/scenes` and their height maps to `assets/textures`:
//! `cargo run --example make_scenes`.

#![expect(clippy::print_stdout, reason = "a program that says what it wrote")]

#[path = "scenes/mod.rs"]
mod scenes;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for (folder, files) in [("scenes", scenes::all()), ("textures", scenes::maps())] {
        let folder = assets.join(folder);
        std::fs::create_dir_all(&folder)?;
        for (name, bytes) in files {
            let path = folder.join(name);
            std::fs::write(&path, &bytes)?;
            println!("{}: {} bytes", path.display(), bytes.len());
        }
    }
    Ok(())
}

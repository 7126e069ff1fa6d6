//! Writes the sample scenes to `assets/scenes`: `cargo run --example make_scenes`.

#![expect(clippy::print_stdout, reason = "a program that says what it wrote")]

#[path = "scenes/mod.rs"]
mod scenes;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    std::fs::create_dir_all(&folder)?;
    for (name, bytes) in scenes::all() {
        let path = folder.join(name);
        std::fs::write(&path, &bytes)?;
        println!("{}: {} bytes", path.display(), bytes.len());
    }
    Ok(())
}

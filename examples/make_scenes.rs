//! Writes the sample scenes to `assets/scenes`, one of them with baked light as well, and their height maps to
//! `assets/textures`:
//! `cargo run --example make_scenes`.

#![expect(clippy::print_stdout, reason = "a program that says what it wrote")]

#[path = "scenes/baked.rs"]
mod baked;
#[path = "scenes/mod.rs"]
mod scenes;

use std::error::Error;
use std::path::Path;

use bevy_fresco::radiosity::BakeSettings;

fn main() -> Result<(), Box<dyn Error>> {
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
    let room = assets.join("scenes").join("cornell_box.glb");
    let (file, _) = baked::baked(&room, &BakeSettings::BALANCED)?;
    let path = room.with_file_name("cornell_box_baked.glb");
    std::fs::write(&path, &file.bytes)?;
    println!("{}: {} bytes", path.display(), file.bytes.len());
    Ok(())
}

//! A bake in a program without a window, a renderer or Bevy: a glTF file in, the same file with light out.
//!
//! `cargo run --release --no-default-features --features gltf,parallel --example headless_bake -- IN.glb OUT.glb`

#![expect(clippy::print_stdout, reason = "a program that says what it did")]

#[path = "scenes/baked.rs"]
mod baked;

use std::error::Error;
use std::path::PathBuf;

use bevy_fresco::gltf::write_atomically;
use bevy_fresco::radiosity::BakeSettings;

fn main() -> Result<(), Box<dyn Error>> {
    let mut files = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(from), Some(to)) = (files.next(), files.next()) else {
        return Err("give two files: IN.glb OUT.glb".into());
    };
    let (file, report) = baked::baked(&from, &BakeSettings::BALANCED)?;
    write_atomically(&to, &file.bytes)?;
    for note in file.notes {
        println!("{note}");
    }
    let (vertices, error) = (report.counts.vertices, 100.0 * report.error.total);
    println!(
        "{}: {vertices} vertices, about {error:.1} % off",
        to.display()
    );
    Ok(())
}

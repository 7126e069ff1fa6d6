use std::path::PathBuf;

use super::args::HeightArgs;
use super::command::Made;
use crate::height_map::{Encoding, Photo, Precision, Stretch};
use crate::text::{bytes, percent};

/// What was made, for the terminal.
pub(super) fn summary(args: &HeightArgs, made: &Made, files: &[(PathBuf, Vec<u8>)]) -> String {
    let raster = &made.file.raster;
    let [width, height] = raster.size();
    let bits = match raster.precision() {
        Precision::Eight => "8 bits",
        Precision::Sixteen => "16 bits",
        Precision::Float => "floating point",
    };
    let colour = if raster.has_colour() {
        "colour"
    } else {
        "grey"
    };
    let mut text = format!(
        "{}: {width} × {height} texels, {bits}, {colour}, {}\n",
        args.image.display(),
        meaning(made.photo.as_ref())
    );
    let heights = made.prepared.map.heights();
    let low = heights.iter().copied().fold(f32::INFINITY, f32::min);
    let high = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let stretched = match args.settings().stretch {
        Stretch::AsIs => "as they were",
        Stretch::Full | Stretch::Percentile(_) => "stretched",
    };
    text.push_str(&format!("heights from {low} to {high}, {stretched}\n"));
    let mut warnings: Vec<String> = (made.prepared.warnings.iter())
        .map(ToString::to_string)
        .collect();
    if made.file.transparent > 0.0 {
        warnings.push(format!(
            "{} of the image are transparent, and were taken as if they were not: fill them in first",
            percent(made.file.transparent)
        ));
    }
    if !warnings.is_empty() {
        text.push_str("\nwarnings\n");
    }
    for warning in warnings {
        text.push_str(&format!("  - {warning}\n"));
    }
    text.push('\n');
    for (path, content) in files {
        let size = bytes(content.len() as u64);
        text.push_str(&format!("wrote {} ({size})\n", path.display()));
    }
    text
}

/// How the numbers were read, and what to say if that was wrong.
fn meaning(photo: Option<&Photo>) -> &'static str {
    match photo.map(Photo::encoding) {
        None => "read as heights",
        Some(Encoding::Srgb) => {
            "read as sRGB light (if it holds heights, say --data; if linear light, --linear)"
        }
        Some(Encoding::Linear) => {
            "read as linear light (if it holds heights, say --data; if sRGB, --srgb)"
        }
    }
}

use std::io::Write;
use std::path::PathBuf;

use glam::Vec2;

use super::args::{HeightArgs, KernelArg};
use super::read::{ImageFile, read, usual_encoding};
use super::{preview, summary, write};
use crate::cli::Session;
use crate::cli::failure::Failure;
use crate::cli::outputs::{all_writable, extension, same};
use crate::cli::scene::go_on;
use crate::gltf::write_atomically;
use crate::height_map::{
    Encoding, Kernel, NormalMapSettings, Photo, Precision, Prepared, derivative_map, normal_map,
    prepare, prepare_data,
};

/// An image and what was made from it.
pub(super) struct Made {
    pub(super) file: ImageFile,
    /// How its light was read; nothing if it holds heights.
    pub(super) photo: Option<Photo>,
    pub(super) prepared: Prepared,
}

/// Runs `fresco height`.
pub(in crate::cli) fn height_command(
    session: &Session,
    args: &HeightArgs,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    check_outputs(args)?;
    let made = make(args)?;
    go_on(session)?;
    let files = encode(args, &made)?;
    go_on(session)?;
    for (path, bytes) in &files {
        write_atomically(path, bytes)?;
    }
    if !args.results.quiet {
        write!(out, "{}", summary::summary(args, &made, &files))?;
    }
    Ok(())
}

/// Looks before the work at everything that could stop its results from being written.
fn check_outputs(args: &HeightArgs) -> Result<(), Failure> {
    let map = args.output();
    let results = &args.results;
    extension(
        &map,
        &["png", "exr"],
        "heights are written as PNG or OpenEXR",
    )?;
    let mut all = vec![map.as_path()];
    for (path, kinds, what) in [
        (
            &results.normal_map,
            &["png", "exr"][..],
            "normals are written as PNG or OpenEXR",
        ),
        (
            &results.derivative_map,
            &["exr"],
            "slopes are written as OpenEXR",
        ),
        (&results.preview, &["png"], "the preview is a PNG image"),
    ] {
        if let Some(path) = path {
            extension(path, kinds, what)?;
            all.push(path);
        }
    }
    all_writable(&all)?;
    match all.iter().find(|path| same(path, &args.image)) {
        None => Ok(()),
        Some(path) => Err(Failure::Error(format!(
            "{} is the image itself and would be overwritten: choose another name (-o, --normal-map, \
             --derivative-map, --preview)",
            path.display()
        ))),
    }
}

fn make(args: &HeightArgs) -> Result<Made, Failure> {
    let file = read(&args.image)?;
    let settings = args.settings();
    let photo = (!args.meaning.data).then(|| {
        let encoding: Encoding =
            (args.meaning.encoding()).unwrap_or_else(|| usual_encoding(&file.raster));
        Photo::new(file.raster.clone(), encoding)
    });
    let prepared = match &photo {
        Some(photo) => prepare(photo, &settings),
        None => prepare_data(&file.raster, &settings),
    };
    let prepared =
        prepared.map_err(|error| Failure::Error(format!("{}: {error}", args.image.display())))?;
    Ok(Made {
        file,
        photo,
        prepared,
    })
}

/// All files, none of them written yet.
fn encode(args: &HeightArgs, made: &Made) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let map = &made.prepared.map;
    let size = map.size();
    let results = &args.results;
    let kernel = kernel(args, made);
    let normals = NormalMapSettings {
        kernel,
        height: results.scale,
        // Texels are square.
        extent: Vec2::new(1.0, size[1] as f32 / size[0] as f32),
        green: results.green(),
    };
    let output = args.output();
    let mut files = vec![(output.clone(), write::heights(map, &output)?)];
    if let Some(path) = &results.normal_map {
        let normals = normal_map(map, &normals);
        files.push((path.clone(), write::normals(&normals, size, path)?));
    }
    if let Some(path) = &results.derivative_map {
        let slopes = derivative_map(map, kernel);
        files.push((path.clone(), write::derivatives(&slopes, map, path)?));
    }
    if let Some(path) = &results.preview {
        let picture = preview::draw(made, &normals);
        files.push((path.clone(), write::picture(picture, path)?));
    }
    Ok(files)
}

/// As asked, or the sharpest that does not show the steps of the image.
pub(super) fn kernel(args: &HeightArgs, made: &Made) -> Kernel {
    match (args.results.kernel, made.file.raster.precision()) {
        (Some(kernel), _) => KernelArg::kernel(kernel),
        (None, Precision::Eight) => Kernel::BSpline,
        (None, _) => Kernel::CatmullRom,
    }
}

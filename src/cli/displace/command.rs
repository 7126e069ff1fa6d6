use std::io::Write;
use std::time::Instant;

use glam::Vec2;

use super::args::DisplaceArgs;
use super::summary::{Done, summary};
use crate::cli::Session;
use crate::cli::failure::Failure;
use crate::cli::height::{KernelArg, read};
use crate::cli::outputs::{all_writable, extension, same};
use crate::cli::progress::Progress;
use crate::cli::scene::{go_on, on_threads, resources};
use crate::displacement::{Base, Displaced, DisplacementError, displace};
use crate::gltf::{
    DisplacedPrimitive, MeshSurface, PrimitiveSurface, load_surfaces, to_displaced_glb,
    write_atomically,
};
use crate::height_map::{HeightMap, Kernel, Precision, Warning, prepare_data};

/// A map and how it is looked up.
struct Map {
    heights: HeightMap,
    kernel: Kernel,
    warnings: Vec<Warning>,
}

/// Runs `fresco displace`.
pub(in crate::cli) fn displace_command(
    session: &Session,
    args: &DisplaceArgs,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let output = args.output();
    extension(&output, &["glb"], "the result is binary glTF")?;
    all_writable(&[&output])?;
    spare(args, [args.scene.as_path(), args.map.as_path()])?;
    let (bytes, done) = on_threads(args.threads, |_| make(session, args))?;
    go_on(session)?;
    write_atomically(&output, &bytes)?;
    if !args.quiet {
        write!(out, "{}", summary(&output, bytes.len() as u64, &done))?;
    }
    Ok(())
}

/// An error if the result would replace one of the files it is made from.
fn spare<'a>(
    args: &DisplaceArgs,
    inputs: impl IntoIterator<Item = &'a std::path::Path>,
) -> Result<(), Failure> {
    let output = args.output();
    match inputs.into_iter().find(|input| same(&output, input)) {
        None => Ok(()),
        Some(path) => Err(Failure::Error(format!(
            "{} is what the result is made from and would be overwritten: choose another name (-o)",
            path.display()
        ))),
    }
}

fn make(session: &Session, args: &DisplaceArgs) -> Result<(Vec<u8>, Done), Failure> {
    let progress = Progress::new(session, args.quiet);
    progress.step("load");
    let file = load_surfaces(&args.scene, args.relief.uv)?;
    let beside = resources(&file.document);
    spare(args, beside.iter().map(std::path::PathBuf::as_path))?;
    let map = read_map(args)?;
    go_on(session)?;

    // The others are about light in photos.
    let seams = (map.warnings.iter()).filter(|w| matches!(w, Warning::NotTiling { .. }));
    let warnings = seams.map(ToString::to_string);
    let notes = file.notes.iter().cloned().chain(warnings).collect();
    let mut done = Done::new(args.tolerance(), notes);
    let mut displaced: Vec<(Vec<&PrimitiveSurface>, Displaced)> = Vec::new();
    for mesh in &file.meshes {
        let wanted = wanted(args, mesh);
        if wanted.is_empty() {
            continue;
        }
        let started = Instant::now();
        let result = displace_mesh(args, mesh, &wanted, &map, &progress)?;
        done.add(mesh, &result.report, started.elapsed());
        displaced.push((wanted, result));
    }
    if displaced.is_empty() {
        return Err(nothing(args, &file.meshes));
    }
    progress.step("export");
    let primitives: Vec<DisplacedPrimitive> = (displaced.iter())
        .flat_map(|(of, result)| of.iter().zip(&result.parts))
        .map(|(of, part)| DisplacedPrimitive {
            key: of.key,
            triangles: &of.triangles,
            part,
        })
        .collect();
    let exported = to_displaced_glb(&file.document, &primitives)?;
    done.notes.extend(exported.notes);
    Ok((exported.bytes, done))
}

fn read_map(args: &DisplaceArgs) -> Result<Map, Failure> {
    let file = read(&args.map)?;
    let prepared = prepare_data(&file.raster, &args.prepare()).map_err(|error| {
        Failure::Error(format!(
            "{}: {error} (`fresco height` makes heights from a photo)",
            args.map.display()
        ))
    })?;
    let kernel = match (args.relief.kernel, file.raster.precision()) {
        (Some(kernel), _) => KernelArg::kernel(kernel),
        (None, Precision::Eight) => Kernel::BSpline,
        (None, _) => Kernel::CatmullRom,
    };
    Ok(Map {
        heights: prepared.map,
        kernel,
        warnings: prepared.warnings,
    })
}

/// The primitives that are to be displaced.
fn wanted<'a>(args: &DisplaceArgs, mesh: &'a MeshSurface) -> Vec<&'a PrimitiveSurface> {
    let wanted = |p: &&PrimitiveSurface| args.wanted(&[&mesh.name, &p.material]);
    mesh.primitives.iter().filter(wanted).collect()
}

fn displace_mesh(
    args: &DisplaceArgs,
    mesh: &MeshSurface,
    wanted: &[&PrimitiveSurface],
    map: &Map,
    progress: &Progress,
) -> Result<Displaced, Failure> {
    let uvs: Vec<Vec<Vec2>> = (wanted.iter())
        .map(|p| p.uvs.iter().map(|&uv| uv * args.relief.repeat).collect())
        .collect();
    let bases: Vec<Base> = (wanted.iter().zip(&uvs))
        .map(|(p, uvs)| Base {
            positions: &p.positions,
            normals: &p.normals,
            uvs,
            triangles: &p.triangles,
        })
        .collect();
    let settings = args.settings(map.kernel, mesh.scale as f32);
    displace(&bases, &map.heights, &settings, progress).map_err(|error| match error {
        DisplacementError::Cancelled => Failure::Cancelled,
        DisplacementError::NoUvs { .. } => Failure::Error(format!(
            "{}: {} has no TEXCOORD_{}, which tells where on the map it is: unwrap it, choose another \
             set (--uv), or leave it out (--only)",
            args.scene.display(),
            mesh.name,
            args.relief.uv
        )),
        other => Failure::Error(format!("{}: {}: {other}", args.scene.display(), mesh.name)),
    })
}

fn nothing(args: &DisplaceArgs, meshes: &[MeshSurface]) -> Failure {
    let mut names: Vec<&str> = (meshes.iter())
        .flat_map(|mesh| {
            let materials = mesh.primitives.iter().map(|p| p.material.as_str());
            materials.chain([mesh.name.as_str()])
        })
        .filter(|name| !name.is_empty())
        .collect();
    names.sort_unstable();
    names.dedup();
    let scene = args.scene.display();
    match names.is_empty() {
        true => Failure::Error(format!("{scene} has no triangles to displace")),
        false => Failure::Error(format!(
            "{scene} has nothing named {}: it has {}",
            args.only.join(" or "),
            names.join(", ")
        )),
    }
}

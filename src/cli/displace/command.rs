use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use glam::Vec2;

use super::args::DisplaceArgs;
use super::relief::{Relief, Reliefs};
use super::summary::{Done, summary};
use crate::cli::Session;
use crate::cli::failure::Failure;
use crate::cli::outputs::{all_writable, extension, same};
use crate::cli::progress::Progress;
use crate::cli::scene::{go_on, on_threads, resources};
use crate::displacement::{Base, Displaced, DisplacementError, displace};
use crate::gltf::{
    DisplacedPrimitive, MeshSurface, PrimitiveSurface, load_surfaces, to_displaced_glb,
    write_atomically,
};

/// Runs `fresco displace`.
pub(in crate::cli) fn displace_command(
    session: &Session,
    args: &DisplaceArgs,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let output = args.output();
    extension(&output, &["glb"], "the result is binary glTF")?;
    all_writable(&[&output])?;
    spare(
        args,
        [&args.scene]
            .into_iter()
            .chain(&args.map)
            .map(PathBuf::as_path),
    )?;
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
    let file = load_surfaces(&args.scene, args.map.as_ref().map(|_| args.relief.uv))?;
    let beside = resources(&file.document);
    spare(args, beside.iter().map(PathBuf::as_path))?;
    let mut reliefs = Reliefs::new(args, &file)?;
    go_on(session)?;

    let mut done = Done::default();
    let mut displaced: Vec<(Vec<&PrimitiveSurface>, Displaced)> = Vec::new();
    for mesh in &file.meshes {
        for (relief, wanted) in reliefs.of_mesh(args, mesh) {
            let started = Instant::now();
            let relief = reliefs.get(relief);
            let result = displace_mesh(args, mesh, &wanted, relief, &progress)?;
            let tolerance = args.tolerance(relief, mesh.scale as f32);
            done.add(mesh, tolerance, &result.report, started.elapsed());
            displaced.push((wanted, result));
        }
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
    let before = file.notes.iter().chain(&reliefs.notes).cloned();
    done.notes.splice(0..0, before);
    done.notes.extend(exported.notes);
    Ok((exported.bytes, done))
}

fn displace_mesh(
    args: &DisplaceArgs,
    mesh: &MeshSurface,
    wanted: &[&PrimitiveSurface],
    relief: &Relief,
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
    let settings = args.settings(relief, mesh.scale as f32);
    displace(&bases, &relief.heights, &settings, progress).map_err(|error| match error {
        DisplacementError::Cancelled => Failure::Cancelled,
        DisplacementError::NoUvs { .. } => Failure::Error(format!(
            "{}: {} has no TEXCOORD_{}, which tells where on the map it is: unwrap it, choose another \
             set{}, or leave it out (--only)",
            args.scene.display(),
            mesh.name,
            relief.uv_set,
            if args.map.is_some() { " (--uv)" } else { "" }
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

use std::io::Write;
use std::time::Instant;

use glam::Vec2;

use super::args::DisplaceArgs;
use super::relief::{Relief, Reliefs};
use super::summary::Done;
use crate::cli::Session;
use crate::cli::failure::Failure;
use crate::cli::meshes::{nothing, spare, summary};
use crate::cli::outputs::{all_writable, extension};
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
    spare(&output, [&args.scene].into_iter().chain(&args.map))?;
    let (bytes, done) = on_threads(args.threads, |_| make(session, args))?;
    go_on(session)?;
    write_atomically(&output, &bytes)?;
    if !args.quiet {
        let size = bytes.len() as u64;
        write!(
            out,
            "{}",
            summary(&done.lines, &done.notes, (&output, size))
        )?;
    }
    Ok(())
}

fn make(session: &Session, args: &DisplaceArgs) -> Result<(Vec<u8>, Done), Failure> {
    let progress = Progress::new(session, args.quiet);
    progress.step("load");
    let file = load_surfaces(&args.scene, args.map.as_ref().map(|_| args.relief.uv))?;
    let beside = resources(&file.document);
    spare(&args.output(), &beside)?;
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
        let purpose = "to displace";
        return Err(nothing(&args.scene, &args.only, &file.meshes, purpose));
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
            "{}: {} has no TEXCOORD_{}, which tells where on the map it is: unwrap it or lay some on it (fresco uv), \
             choose another set{}, or leave it out (--only)",
            args.scene.display(),
            mesh.name,
            relief.uv_set,
            if args.map.is_some() { " (--uv)" } else { "" }
        )),
        other => Failure::Error(format!("{}: {}: {other}", args.scene.display(), mesh.name)),
    })
}

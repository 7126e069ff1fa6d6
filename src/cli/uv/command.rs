use std::io::Write;

use glam::Vec3;

use super::args::UvArgs;
use crate::cli::Session;
use crate::cli::failure::Failure;
use crate::cli::meshes::{nothing, spare, summary, wanted};
use crate::cli::outputs::{all_writable, extension};
use crate::cli::progress::Progress;
use crate::cli::scene::{go_on, resources};
use crate::gltf::{
    Exported, MeshSurface, PrimitiveSurface, ProjectedPrimitive, load_surfaces, to_projected_glb,
    write_atomically,
};
use crate::mesh::{UvMesh, project_uvs};
use crate::text::counted;

/// Runs `fresco uv`.
pub(in crate::cli) fn uv_command(
    session: &Session,
    args: &UvArgs,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let output = args.output();
    extension(&output, &["glb"], "the result is binary glTF")?;
    all_writable(&[&output])?;
    spare(&output, [&args.scene])?;
    if let Some(fault) = args.fault() {
        return Err(Failure::Error(fault.to_owned()));
    }
    let (exported, lines) = make(session, args)?;
    go_on(session)?;
    write_atomically(&output, &exported.bytes)?;
    if !args.quiet {
        let size = exported.bytes.len() as u64;
        write!(out, "{}", summary(&lines, &exported.notes, (&output, size)))?;
    }
    Ok(())
}

/// The file, and what was done to each mesh.
fn make(session: &Session, args: &UvArgs) -> Result<(Exported, Vec<String>), Failure> {
    let progress = Progress::new(session, args.quiet);
    progress.step("load");
    let file = load_surfaces(&args.scene, Some(0))?;
    spare(&args.output(), &resources(&file.document))?;
    let mut lines = Vec::new();
    let mut notes = file.notes.clone();
    let mut projected: Vec<(&PrimitiveSurface, UvMesh)> = Vec::new();
    let mut any_wanted = false;
    progress.step("project");
    for mesh in &file.meshes {
        let middle = middle(mesh);
        for primitive in &mesh.primitives {
            go_on(session)?;
            if !wanted(&args.only, &[&mesh.name, &primitive.material]) {
                continue;
            }
            any_wanted = true;
            if !primitive.uvs.is_empty() && !args.replace {
                lines.push(format!(
                    "{}: has texture coordinates and keeps them (--replace)",
                    mesh.name
                ));
                continue;
            }
            let made = project(args, mesh, primitive, middle)?;
            lines.push(told(mesh, primitive, &made));
            if !made.over_poles.is_empty() {
                notes.push(format!(
                    "{}: {} reach over a pole or the axis, which no texture coordinates fit: give the mesh a \
                     vertex there",
                    mesh.name,
                    counted(made.over_poles.len() as u64, "triangle")
                ));
            }
            projected.push((primitive, made));
        }
    }
    if !any_wanted {
        let purpose = "to lay texture coordinates on";
        return Err(nothing(&args.scene, &args.only, &file.meshes, purpose));
    }
    progress.step("export");
    let primitives: Vec<ProjectedPrimitive> = (projected.iter())
        .map(|(primitive, mesh)| ProjectedPrimitive {
            key: primitive.key,
            triangles: &primitive.triangles,
            mesh,
        })
        .collect();
    let mut exported = to_projected_glb(&file.document, &primitives)?;
    exported.notes.splice(0..0, notes);
    Ok((exported, lines))
}

fn project(
    args: &UvArgs,
    mesh: &MeshSurface,
    primitive: &PrimitiveSurface,
    middle: Vec3,
) -> Result<UvMesh, Failure> {
    let settings = args.settings(middle, mesh.scale as f32);
    project_uvs(&primitive.positions, &primitive.triangles, &settings).map_err(|error| {
        Failure::Error(format!("{}: {}: {error}", args.scene.display(), mesh.name))
    })
}

fn told(mesh: &MeshSurface, primitive: &PrimitiveSurface, made: &UvMesh) -> String {
    format!(
        "{}: {} became {}, apart where charts meet",
        mesh.name,
        counted(primitive.positions.len() as u64, "vertex"),
        counted(made.uvs.len() as u64, "vertex")
    )
}

/// Of the box around a mesh.
fn middle(mesh: &MeshSurface) -> Vec3 {
    let all = || mesh.primitives.iter().flat_map(|p| &p.positions).copied();
    match (all().reduce(Vec3::min), all().reduce(Vec3::max)) {
        (Some(low), Some(high)) => 0.5 * (low + high),
        _ => Vec3::ZERO,
    }
}

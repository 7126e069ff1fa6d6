//! Where heights come from: the map of the command line, or those of the scene's materials.

use super::args::DisplaceArgs;
use crate::cli::failure::Failure;
use crate::cli::height::{ImageFile, KernelArg, decode, read};
use crate::cli::meshes::wanted;
use crate::gltf::{GltfSurfaces, MaterialDisplacement, MeshSurface, PrimitiveSurface};
use crate::height_map::{HeightMap, Kernel, Precision, Warning, Wrap, prepare_data};
use crate::radiosity;

/// Heights, and how they are looked up.
#[derive(Debug)]
pub(super) struct Relief {
    pub(super) heights: HeightMap,
    pub(super) kernel: Kernel,
    /// Height from black to white.
    pub(super) scale: f32,
    /// What of the map stays where it is.
    pub(super) mid_level: f32,
    /// Which texture coordinates lay it on meshes.
    pub(super) uv_set: u32,
    /// Whether the scale is one in metres, else in units of the mesh.
    pub(super) in_metres: bool,
}

/// All that a command needs, and what is to be known about them.
#[derive(Debug)]
pub(super) struct Reliefs {
    list: Vec<Relief>,
    /// One for all, whatever materials say.
    given: bool,
    pub(super) notes: Vec<String>,
}

impl Reliefs {
    pub(super) fn new(args: &DisplaceArgs, file: &GltfSurfaces) -> Result<Self, Failure> {
        let mut notes = Vec::new();
        let list = match &args.map {
            Some(path) => {
                let wrap = args.relief.wrap();
                let name = path.display().to_string();
                let (heights, kernel) = heights(args, &name, &read(path)?, [wrap; 2], &mut notes)?;
                vec![Relief {
                    heights,
                    kernel,
                    scale: args.relief.scale,
                    mid_level: args.relief.mid_level,
                    uv_set: args.relief.uv,
                    in_metres: true,
                }]
            }
            None if file.displacements.is_empty() => {
                return Err(Failure::Error(format!(
                    "{}: no material says what it is displaced by (KHR_materials_displacement): say which \
                     map (--map)",
                    args.scene.display()
                )));
            }
            None => {
                let of = |found: &Result<MaterialDisplacement, String>| match found {
                    Ok(found) => of_material(args, found, &mut notes),
                    Err(reason) => Err(Failure::Error(format!(
                        "{}: {reason}: say which map (--map)",
                        args.scene.display()
                    ))),
                };
                (file.displacements.iter().map(of)).collect::<Result<_, _>>()?
            }
        };
        Ok(Self {
            list,
            given: args.map.is_some(),
            notes,
        })
    }

    /// The primitives of a mesh that are to be displaced, by what they are displaced by.
    pub(super) fn of_mesh<'a>(
        &mut self,
        args: &DisplaceArgs,
        mesh: &'a MeshSurface,
    ) -> Vec<(usize, Vec<&'a PrimitiveSurface>)> {
        let asked = |p: &&PrimitiveSurface| wanted(&args.only, &[&mesh.name, &p.material]);
        let wanted: Vec<_> = mesh.primitives.iter().filter(asked).collect();
        let groups = (0..self.list.len()).map(|i| {
            let ours = |p: &&&PrimitiveSurface| self.given || p.displacement == Some(i);
            (i, wanted.iter().filter(ours).copied().collect::<Vec<_>>())
        });
        let groups: Vec<_> = groups.filter(|(_, group)| !group.is_empty()).collect();
        if groups.len() > 1 {
            self.notes.push(format!(
                "{}: its materials have {} height maps, each of which is followed by itself: the mesh may gape \
                 where they meet",
                mesh.name,
                groups.len()
            ));
        }
        groups
    }

    pub(super) fn get(&self, index: usize) -> &Relief {
        &self.list[index]
    }
}

/// What a material asks for: `offset + factor × red`.
fn of_material(
    args: &DisplaceArgs,
    asked: &MaterialDisplacement,
    notes: &mut Vec<String>,
) -> Result<Relief, Failure> {
    let name = format!("{}: {}", args.scene.display(), asked.image);
    if asked.wrap.contains(&radiosity::Wrap::Mirror) {
        notes.push(format!(
            "{name} is to be mirrored beyond its border, which is not supported: it is repeated"
        ));
    }
    let wrap = asked.wrap.map(|wrap| match wrap {
        radiosity::Wrap::Clamp => Wrap::Clamp,
        radiosity::Wrap::Repeat | radiosity::Wrap::Mirror => Wrap::Repeat,
    });
    let mut image = decode(&name, &asked.bytes)?;
    image.raster = image.raster.red();
    let (map, kernel) = heights(args, &name, &image, wrap, notes)?;
    let (factor, offset) = (asked.factor, asked.offset);
    // The map is what is multiplied: what stays is where offset and map cancel out.
    let mid_level = if offset == 0.0 { 0.0 } else { -offset / factor };
    if !mid_level.is_finite() {
        return Err(Failure::Error(format!(
            "{name} is raised by {offset} with a displacementGeometryFactor of {factor}: give it a factor, or              move the mesh"
        )));
    }
    Ok(Relief {
        heights: map,
        kernel,
        scale: factor,
        mid_level,
        uv_set: asked.uv_set,
        in_metres: false,
    })
}

fn heights(
    args: &DisplaceArgs,
    name: &str,
    image: &ImageFile,
    wrap: [Wrap; 2],
    notes: &mut Vec<String>,
) -> Result<(HeightMap, Kernel), Failure> {
    let prepared = prepare_data(&image.raster, &args.relief.prepare(wrap)).map_err(|error| {
        Failure::Error(format!(
            "{name}: {error} (`fresco height` makes heights from a photo)"
        ))
    })?;
    // The other warnings are about light in photos.
    let seams = (prepared.warnings.iter()).filter(|w| matches!(w, Warning::NotTiling { .. }));
    notes.extend(seams.map(ToString::to_string));
    let kernel = match (args.relief.kernel, image.raster.precision()) {
        (Some(kernel), _) => KernelArg::kernel(kernel),
        (None, Precision::Eight) => Kernel::BSpline,
        (None, _) => Kernel::CatmullRom,
    };
    Ok((prepared.map, kernel))
}

impl Relief {
    /// Height from black to white in units of a mesh, of which one is so many metres.
    pub(super) fn scale(&self, metres: f32) -> f32 {
        match self.in_metres {
            true => self.scale / metres,
            false => self.scale,
        }
    }
}

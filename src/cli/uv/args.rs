use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::{Quat, Vec2, Vec3};

use crate::cli::args::times;
use crate::mesh::{UvProjection, UvSettings};

pub(in crate::cli) const EXAMPLES: &str = "\
Examples:
  fresco uv rock.glb
      A square metre of the texture on every square metre of rock, from six sides, into rock.uv.glb.
  fresco uv column.glb --projection cylinder --repeat 4 --size 0.8
      Four times round, and again every 0.8 m upwards.
  fresco displace rock.uv.glb --map stone.png --scale 0.02
      Relief on what had nothing to lay it by.

Textures have to repeat: coordinates go on beyond 0 and 1.";

#[derive(Debug, Args)]
pub(in crate::cli) struct UvArgs {
    /// The meshes: a .glb or .gltf file
    pub(super) scene: PathBuf,
    /// Where the result goes, a .glb file [default: SCENE.uv.glb beside the scene]
    #[arg(short, long, value_name = "GLB")]
    pub(super) output: Option<PathBuf>,
    /// How they are laid on the meshes
    #[arg(short, long, value_enum, default_value = "box")]
    pub(super) projection: ProjectionArg,
    /// Metres that the texture is wide and high, one number or W,H, above 0; of a cylinder the height counts, of a
    /// sphere neither, and a box takes one number
    #[arg(short, long, value_name = "METRES", value_parser = times, default_value = "1")]
    pub(super) size: Vec2,
    /// How often the texture goes round a cylinder, or round a sphere and from pole to pole, one number or U,V,
    /// above 0
    #[arg(short, long, value_name = "TIMES", value_parser = times, default_value = "1")]
    pub(super) repeat: Vec2,
    /// Axis of a mesh's own space that planar looks along, and that cylinder and sphere go round [default: z for
    /// planar, else y]
    #[arg(long, value_enum)]
    axis: Option<AxisArg>,
    /// Also where there are texture coordinates: they are replaced
    #[arg(long)]
    pub(super) replace: bool,
    /// Only what has this material, or is in a mesh or node of this name; give it once for each
    #[arg(long, value_name = "NAME")]
    pub(super) only: Vec<String>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(super) quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ProjectionArg {
    /// As a slide projector would
    Planar,
    /// Each face from the side it faces most
    Box,
    /// Round an axis through the middle of each mesh
    Cylinder,
    /// By longitude and latitude round the middle of each mesh
    Sphere,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AxisArg {
    X,
    Y,
    Z,
}

impl UvArgs {
    pub(super) fn output(&self) -> PathBuf {
        (self.output.clone()).unwrap_or_else(|| self.scene.with_extension("uv.glb"))
    }

    /// For a mesh with its middle there, whose unit is so many metres.
    pub(super) fn settings(&self, middle: Vec3, metres: f32) -> UvSettings {
        let size = self.size / metres;
        let projection = match self.projection {
            ProjectionArg::Planar => UvProjection::Planar { size },
            ProjectionArg::Box => UvProjection::Box { size: size.x },
            ProjectionArg::Cylinder => UvProjection::Cylinder {
                repeats: self.repeat.x,
                height: size.y,
            },
            ProjectionArg::Sphere => UvProjection::Sphere {
                repeats: self.repeat,
            },
        };
        let is_planar = self.projection == ProjectionArg::Planar;
        let own = if is_planar { Vec3::Z } else { Vec3::Y };
        let axis = match self.axis {
            None => own,
            Some(AxisArg::X) => Vec3::X,
            Some(AxisArg::Y) => Vec3::Y,
            Some(AxisArg::Z) => Vec3::Z,
        };
        UvSettings {
            origin: match self.projection {
                // Where meshes with one origin meet, so do their textures.
                ProjectionArg::Planar | ProjectionArg::Box => Vec3::ZERO,
                ProjectionArg::Cylinder | ProjectionArg::Sphere => middle,
            },
            rotation: Quat::from_rotation_arc(own, axis),
            ..UvSettings::new(projection)
        }
    }

    /// What of the arguments contradicts itself.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let is_box = self.projection == ProjectionArg::Box;
        (is_box && self.size.x != self.size.y)
            .then_some("a box has one size for all sides: give --size one number")
    }
}

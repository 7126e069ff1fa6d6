use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::Vec2;

use super::relief::Relief;
use crate::cli::args::{number, positive, times, within};
use crate::cli::height::KernelArg;
use crate::cli::memory::amount;
use crate::displacement::{Direction, DisplacementSettings, Spacing, Tessellation};
use crate::height_map::{PrepareSettings, Stretch, Wrap};

pub(in crate::cli) const EXAMPLES: &str = "\
Examples:
  fresco displace wall.glb --map bricks.png --scale 0.03
      Raises wall.glb by up to 3 cm into wall.displaced.glb, with vertices where the relief needs them.
  fresco displace wall.glb --map bricks.png --scale 0.03 --tolerance 0.0005 --max-triangles 100000
      The same to half a millimetre, in 100,000 triangles at most.
  fresco displace tiles.glb
      By the maps that its materials name.
  fresco displace rock.glb --map noise.exr --mid-level 0.5 --texels 1 -o rough.glb
      One vertex a texel, grey staying where it is.
  fresco bake wall.displaced.glb --preview wall.png
      Draws the result, lit.

Make the map with `fresco height` from a photo. docs/displacement.md explains how it is done.";

#[derive(Debug, Args)]
pub(in crate::cli) struct DisplaceArgs {
    /// The meshes: a .glb or .gltf file
    pub(super) scene: PathBuf,
    /// Heights, one channel: PNG, JPEG, OpenEXR or Radiance HDR; bright is high [default: the maps that the
    /// scene's materials name by `KHR_materials_displacement`]
    #[arg(short, long, value_name = "IMAGE")]
    pub(super) map: Option<PathBuf>,
    /// Where the result goes, a .glb file [default: SCENE.displaced.glb beside the scene]
    #[arg(short, long, value_name = "GLB")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) relief: ReliefArgs,
    #[command(flatten)]
    pub(super) vertices: VertexArgs,
    /// Displace only what has this material, or is in a mesh or node of this name; give it once for each
    #[arg(long, value_name = "NAME")]
    pub(super) only: Vec<String>,
    /// Threads to work on, at least 1; the result is the same for any number [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// What the map says.
#[derive(Debug, Args)]
#[command(next_help_heading = "Relief")]
pub(super) struct ReliefArgs {
    /// Metres from black to white; negative digs
    #[arg(short, long, value_name = "METRES", value_parser = number, default_value = "0.05",
          allow_negative_numbers = true, requires = "map")]
    pub(super) scale: f32,
    /// The height that stays where it is: 0 raises everything, 0.5 raises the bright and lowers the dark
    #[arg(long, value_name = "LEVEL", value_parser = number, default_value = "0",
          allow_negative_numbers = true, requires = "map")]
    pub(super) mid_level: f32,
    /// Which set of texture coordinates lays the map on the meshes: 0 is `TEXCOORD_0`
    #[arg(long, value_name = "SET", default_value = "0", requires = "map")]
    pub(super) uv: u32,
    /// How often the map repeats where texture coordinates go from 0 to 1, one number or U,V, above 0
    #[arg(long, value_name = "TIMES", value_parser = times, default_value = "1", requires = "map")]
    pub(super) repeat: Vec2,
    /// How the map goes on beyond its border
    #[arg(long, value_enum, default_value = "repeat", requires = "map")]
    wrap: WrapArg,
    /// Which way is out
    #[arg(long, value_enum, default_value = "smooth")]
    direction: DirectionArg,
    /// Take the steps of 8 bits off, moving nothing by more than half a step
    #[arg(long)]
    dequantize: bool,
    /// How heights are found between texels [default: b-spline for images of 8 bits, else catmull-rom]
    #[arg(long, value_enum)]
    pub(super) kernel: Option<KernelArg>,
    /// Normals that differ by no more than this, in degrees, are one smooth surface across seams, 0 to 180
    #[arg(long, value_name = "DEGREES", value_parser = degrees, default_value = "30")]
    crease: f32,
    /// Keep heights below where the surface would fold through itself
    #[arg(long)]
    clamp_folds: bool,
}

/// Where vertices are put.
#[derive(Debug, Args)]
#[command(next_help_heading = "Vertices (default: --tolerance of a hundredth of the scale)")]
pub(super) struct VertexArgs {
    /// Put vertices where they are needed: no point of the surface is further from the mesh than this,
    /// above 0
    #[arg(long, value_name = "METRES", value_parser = positive, conflicts_with_all = ["texels", "edge"])]
    tolerance: Option<f32>,
    /// Put vertices evenly, so many texels of the map apart, above 0
    #[arg(long, value_name = "TEXELS", value_parser = positive, conflicts_with = "edge")]
    texels: Option<f32>,
    /// Put vertices evenly, so many metres apart, above 0
    #[arg(long, value_name = "METRES", value_parser = positive)]
    edge: Option<f32>,
    /// Triangles of each mesh at most; the mesh gets as good as that allows
    #[arg(long, value_name = "N", default_value = "2000000")]
    max_triangles: u32,
    /// Memory of each result at most, in bytes or like 64M, 2G
    #[arg(long, value_name = "BYTES", value_parser = amount, default_value = "1G")]
    max_memory: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum WrapArg {
    /// Again and again
    Repeat,
    /// With the texels of the border
    Clamp,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DirectionArg {
    /// Along the normals, the mean of them at edges: round things stay round
    Smooth,
    /// By the height along the normal of every face: boxes stay boxes
    FaceNormal,
}

impl DisplaceArgs {
    pub(super) fn output(&self) -> PathBuf {
        (self.output.clone()).unwrap_or_else(|| self.scene.with_extension("displaced.glb"))
    }

    /// For a mesh whose unit is so many metres.
    pub(super) fn settings(&self, relief: &Relief, metres: f32) -> DisplacementSettings {
        let vertices = &self.vertices;
        let tessellation = match (vertices.texels, vertices.edge) {
            (Some(texels), _) => Tessellation::Uniform(Spacing::Texels(texels)),
            (_, Some(edge)) => Tessellation::Uniform(Spacing::Metres(edge / metres)),
            _ => Tessellation::Adaptive {
                tolerance: self.tolerance(relief, metres),
            },
        };
        DisplacementSettings {
            scale: relief.scale(metres),
            mid_level: relief.mid_level,
            kernel: relief.kernel,
            direction: match self.relief.direction {
                DirectionArg::Smooth => Direction::Smooth,
                DirectionArg::FaceNormal => Direction::FaceNormal,
            },
            tessellation,
            max_triangles: vertices.max_triangles,
            max_bytes: vertices.max_memory,
            crease_angle: self.relief.crease.to_radians(),
            clamp_folds: self.relief.clamp_folds,
        }
    }

    /// As asked, or a hundredth of the scale; of no scale anything will do. In units of a mesh, of which one is
    /// so many metres.
    pub(super) fn tolerance(&self, relief: &Relief, metres: f32) -> f32 {
        let usual = (0.01 * relief.scale(metres).abs()).max(f32::MIN_POSITIVE);
        (self.vertices.tolerance).map_or(usual, |asked| asked / metres)
    }
}

impl ReliefArgs {
    pub(super) fn wrap(&self) -> Wrap {
        match self.wrap {
            WrapArg::Repeat => Wrap::Repeat,
            WrapArg::Clamp => Wrap::Clamp,
        }
    }

    pub(super) fn prepare(&self, wrap: [Wrap; 2]) -> PrepareSettings {
        PrepareSettings {
            wrap,
            dequantize: self.dequantize,
            stretch: Stretch::AsIs,
            ..PrepareSettings::default()
        }
    }
}

fn degrees(text: &str) -> Result<f32, String> {
    within(text, |v| (0.0..=180.0).contains(&v), "0 to 180")
}

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::args::{positive, within};
use crate::height_map::{Encoding, Green, Kernel, PrepareSettings, Stretch, Wrap};

pub(in crate::cli) const EXAMPLES: &str = "\
Examples:
  fresco height wall.jpg --preview wall.png
      Makes wall.height.png, 16 bits, bright is high, and a picture of photo, heights and lit relief.
  fresco height wall.jpg --tile --dequantize --flatten 64 -o wall.exr
      The same for a photo that tiles, without 8-bit steps and without uneven light.
  fresco height old.png --data --dequantize -o new.png --normal-map normals.png
      Takes the steps off a height map of 8 bits and makes a normal map from it.

docs/height_maps.md explains what makes a good photo and what each warning means.";

#[derive(Debug, Args)]
pub(in crate::cli) struct HeightArgs {
    /// The image: PNG, JPEG, OpenEXR or Radiance HDR
    pub(super) image: PathBuf,
    /// Where the map goes: a .png (16 bits, grey) or an .exr (32-bit float) [default: IMAGE.height.png
    /// beside the image]
    #[arg(short, long, value_name = "MAP")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) meaning: MeaningArgs,
    #[command(flatten)]
    pub(super) heights: HeightsArgs,
    #[command(flatten)]
    pub(super) results: MapArgs,
}

/// What the numbers of the image are.
#[derive(Debug, Args)]
#[command(
    next_help_heading = "What the numbers are (default: a photo; 8 bits and 16-bit colour are \
                               sRGB, 16-bit grey and floating point are linear light)"
)]
pub(super) struct MeaningArgs {
    /// They are heights already: take them as they are, decode nothing, stretch nothing
    #[arg(long, conflicts_with_all = ["srgb", "linear"])]
    pub(super) data: bool,
    /// They are light encoded as sRGB
    #[arg(long, conflicts_with = "linear")]
    pub(super) srgb: bool,
    /// They are light, and linear
    #[arg(long)]
    pub(super) linear: bool,
}

/// How light becomes height.
#[derive(Debug, Args)]
#[command(next_help_heading = "Heights")]
pub(super) struct HeightsArgs {
    /// Dark is high
    #[arg(long)]
    invert: bool,
    /// Leave out so many per cent of the heights at either end before contrast is stretched, above 0,
    /// below 50; 0.5 makes wild texels harmless [default: stretch from the lowest to the highest]
    #[arg(long, value_name = "PERCENT", value_parser = percentile)]
    percentile: Option<f32>,
    /// Stretch heights of --data to 0..1 too
    #[arg(long, requires = "data")]
    stretch: bool,
    /// Take out shading (with --data, waves) broader than a window of so many texels, above 0; 64 is a
    /// start for a photo of 1024
    #[arg(long, value_name = "TEXELS", value_parser = positive)]
    flatten: Option<f32>,
    /// Smooth with a window of so many texels, above 0; 1 takes noise out
    #[arg(long, value_name = "TEXELS", value_parser = positive)]
    smooth: Option<f32>,
    /// Take the steps of 8 bits off, moving nothing by more than half a step
    #[arg(long)]
    pub(super) dequantize: bool,
    /// The map repeats, so look at neighbours across its border; along which coordinates [default if
    /// given without: both]
    #[arg(long, value_enum, value_name = "AXES", num_args = 0..=1, require_equals = true,
          default_missing_value = "both")]
    tile: Option<Tile>,
}

/// What is written beside the map.
#[derive(Debug, Args)]
#[command(next_help_heading = "Results")]
pub(super) struct MapArgs {
    /// Write unit normals in tangent space too: a .png (8 bits a channel) or an .exr
    #[arg(long, value_name = "MAP")]
    pub(super) normal_map: Option<PathBuf>,
    /// Height of the relief from 0 to 1 in widths of the map, for the normal map and the preview,
    /// above 0
    #[arg(long, value_name = "WIDTHS", value_parser = positive, default_value = "0.03")]
    pub(super) scale: f32,
    /// Which way green of the normal map points: up as glTF, Bevy and OpenGL have it, or down as
    /// DirectX has it
    #[arg(long, value_enum, default_value = "up")]
    green: GreenArg,
    /// Write slopes too, an .exr: red and green are the height's derivatives by u and v, the map being 1
    /// wide and high, blue is the height
    #[arg(long, value_name = "EXR")]
    pub(super) derivative_map: Option<PathBuf>,
    /// How slopes are found between texels [default: b-spline for images of 8 bits, else catmull-rom]
    #[arg(long, value_enum)]
    pub(super) kernel: Option<KernelArg>,
    /// Draw photo, heights and lit relief side by side, highlights marked in magenta
    #[arg(long, value_name = "PNG")]
    pub(super) preview: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(super) quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Tile {
    /// Along u and v
    Both,
    /// From left to right
    U,
    /// From top to bottom
    V,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GreenArg {
    /// Up the image
    Up,
    /// Down the image
    Down,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum KernelArg {
    /// What a graphics card's filter does
    Bilinear,
    /// Differences to one texel ahead
    Forward,
    /// Differences between a texel ahead and one behind
    Central,
    /// Differences between half a texel ahead and half a texel behind
    HalfCentral,
    /// Smooth, past the texels
    BSpline,
    /// Smooth, through the texels
    CatmullRom,
}

impl KernelArg {
    pub(in crate::cli) fn kernel(self) -> Kernel {
        match self {
            Self::Bilinear => Kernel::Bilinear,
            Self::Forward => Kernel::Forward,
            Self::Central => Kernel::Central,
            Self::HalfCentral => Kernel::HalfCentral,
            Self::BSpline => Kernel::BSpline,
            Self::CatmullRom => Kernel::CatmullRom,
        }
    }
}

impl HeightArgs {
    pub(super) fn settings(&self) -> PrepareSettings {
        let heights = &self.heights;
        let wrap = match heights.tile {
            None => [Wrap::Clamp; 2],
            Some(Tile::Both) => [Wrap::Repeat; 2],
            Some(Tile::U) => [Wrap::Repeat, Wrap::Clamp],
            Some(Tile::V) => [Wrap::Clamp, Wrap::Repeat],
        };
        PrepareSettings {
            wrap,
            dequantize: heights.dequantize,
            flatten: heights.flatten,
            smooth: heights.smooth,
            invert: heights.invert,
            stretch: match heights.percentile {
                Some(percent) => Stretch::Percentile(percent),
                None if self.meaning.data && !heights.stretch => Stretch::AsIs,
                None => Stretch::Full,
            },
        }
    }

    pub(super) fn output(&self) -> PathBuf {
        (self.output.clone()).unwrap_or_else(|| self.image.with_extension("height.png"))
    }
}

impl MeaningArgs {
    /// What was said of the encoding.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        match (self.srgb, self.linear) {
            (true, _) => Some(Encoding::Srgb),
            (_, true) => Some(Encoding::Linear),
            _ => None,
        }
    }
}

impl MapArgs {
    pub(super) fn green(&self) -> Green {
        match self.green {
            GreenArg::Up => Green::Up,
            GreenArg::Down => Green::Down,
        }
    }
}

fn percentile(text: &str) -> Result<f32, String> {
    within(text, |v| v > 0.0 && v < 50.0, "above 0 and below 50")
}

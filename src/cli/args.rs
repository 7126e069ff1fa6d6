use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::{Vec2, Vec3};

use super::displace::DisplaceArgs;
use super::height::HeightArgs;
use super::method::MethodArgs;
use super::uv::UvArgs;
use crate::radiosity::{BakeSettings, Contribution, DirectLight};

/// Bakes the diffuse light of glTF scenes into their vertices, makes height maps from photos, and raises
/// meshes by them.
///
/// A .glb or .gltf file with lights (point, spot, sun, emissive materials) goes in. It comes back
/// as a .glb in which every vertex carries the light it receives: direct light with shadows, and
/// all that bounces between surfaces.
#[derive(Debug, Parser)]
#[command(name = "fresco", version, arg_required_else_help = true, after_help = EXAMPLES)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  fresco bake room.glb --preview room.png
      Bakes room.glb into room.baked.glb and draws what it looks like.
  fresco bake room.glb --max-edge 0.5 --preset final --vertex-colors -o lit.glb
      Splits edges longer than half a metre, bakes at shipping quality, and stores
      the light as vertex colours that any viewer shows.
  fresco height wall.jpg --preview wall.png
      Makes the height map wall.height.png from a photo and shows both, with the relief lit.
  fresco displace room.glb --map wall.height.png --only plaster
      Raises what has the material plaster by up to 5 cm, into room.displaced.glb.

`fresco info room.glb` says what a file holds and what a bake of it would take.
`fresco uv room.glb` lays texture coordinates on meshes that have none.
`fresco bake --help` and so on for each command explain every option.";

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Bake the light of a scene into its vertices.
    #[command(after_help = EXAMPLES)]
    Bake(Box<BakeArgs>),
    /// Say what a scene holds and what a bake would take.
    Info(Box<InfoArgs>),
    /// Make a height map from a photo, or maps of slopes and normals from a height map.
    #[command(after_help = super::height::EXAMPLES)]
    Height(Box<HeightArgs>),
    /// Raise the meshes of a scene by a height map: real relief, finely tessellated.
    #[command(after_help = super::displace::EXAMPLES)]
    Displace(Box<DisplaceArgs>),
    /// Lay texture coordinates on meshes that have none: planar, box, cylinder or sphere.
    #[command(after_help = super::uv::EXAMPLES)]
    Uv(Box<UvArgs>),
}

#[derive(Debug, Args)]
pub(super) struct InfoArgs {
    /// The scene: a .glb or .gltf file.
    pub(super) scene: PathBuf,
    #[command(flatten)]
    pub(super) settings: SettingsArgs,
}

#[derive(Debug, Args)]
pub(super) struct BakeArgs {
    /// The scene: a .glb or .gltf file.
    pub(super) scene: PathBuf,
    /// Where the result goes, a .glb file [default: SCENE.baked.glb beside the scene]
    #[arg(short, long, value_name = "GLB")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) settings: SettingsArgs,
    #[command(flatten)]
    pub(super) results: ResultArgs,
}

/// How light is stored and what is written beside it.
#[derive(Debug, Args)]
#[command(next_help_heading = "Results")]
pub(super) struct ResultArgs {
    /// Store light as vertex colours on unlit materials, which any viewer shows. What is brighter
    /// than white is cut off, and the file cannot be baked again
    #[arg(long, conflicts_with_all = ["directional", "emissive_gain"])]
    pub(super) vertex_colors: bool,
    /// Factor from cd/m² to the 0..1 of vertex colours and preview, above 0 [default: for vertex
    /// colours the mean light becomes mid grey, 0.18; for the preview it is chosen by the picture]
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub(super) exposure: Option<f32>,
    /// Draw a picture of the result, from the file's first camera if it has one
    #[arg(long, value_name = "PNG")]
    pub(super) preview: Option<PathBuf>,
    /// Size of the preview in pixels, each side 1 to 8192
    #[arg(long, value_name = "WxH", default_value = "960x720", value_parser = size)]
    pub(super) preview_size: (u32, u32),
    /// Write times, counts, errors and notes as JSON; the keys are explained in the file formats document
    #[arg(long, value_name = "JSON")]
    pub(super) report: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// What a bake is asked for; what is not given comes from the preset.
#[derive(Debug, Args)]
#[command(next_help_heading = "Quality (defaults come from the preset)")]
pub(super) struct SettingsArgs {
    /// Where to start from
    #[arg(long, value_enum, default_value = "balanced")]
    pub(super) preset: Preset,
    /// Error asked for, relative RMSE: 0.02 is 2 % of the mean light. Vertices and rays are added until
    /// the bake's own estimate is below, 0.001 to 1 [draft 0.06, balanced 0.03, final 0.015]
    #[arg(long, value_name = "E", value_parser = error)]
    error: Option<f32>,
    /// Vertices of the result at most; those given are kept in any case [draft 30000, balanced 100000,
    /// final 300000]
    #[arg(long, value_name = "N")]
    max_vertices: Option<u32>,
    /// Stop looking for less error after so many seconds, with the best result so far
    /// [default: no limit]
    #[arg(long, value_name = "S", value_parser = positive)]
    max_seconds: Option<f32>,
    /// Split mesh edges longer than this, in metres, above 0, whatever the light [default: leave it to
    /// the light]
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub(super) max_edge: Option<f32>,
    /// Do not place vertices by the light: keep those given, and those of --max-edge
    #[arg(long)]
    pub(super) no_refine: bool,
    /// Pieces of surface that bounced light is solved on, about, 1 to 4000000 [draft 4000,
    /// balanced 8000, final 16000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4_000_000))]
    elements: Option<u32>,
    /// Make all elements one size with as many rays, instead of placing them by the light
    #[arg(long)]
    no_adapt: bool,
    /// Rays from each element to find what it sees, 1 to 4096 [draft 32, balanced 48, final 128]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    element_rays: Option<u32>,
    /// Rays that gather bounced light at each sample, 1 to 4096 [draft 24, balanced 64, final 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    gather_rays: Option<u32>,
    /// Samples of light a vertex, on average, above 0 to 10000 [draft 6, balanced 10, final 24]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples_per_vertex: Option<f32>,
    /// Shadow rays from a point to all emissive surfaces together, 1 to 4096 [draft 8,
    /// balanced 24, final 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    emitter_rays: Option<u32>,
    /// Also store how light changes as normals turn, so that bump and normal maps are shaded by it
    #[arg(long)]
    directional: bool,
    /// Error at which the solver stops, relative to the mean, above 0 [draft 0.01,
    /// balanced 0.001, final 0.0001]
    #[arg(long, value_name = "E", value_parser = positive)]
    solver_tolerance: Option<f32>,
    /// Sweeps after which the solver gives up, at least 1 [100]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_sweeps: Option<u32>,
    /// Reflect at most this share of the light, 0 up to but not including 1 [0.99]
    #[arg(long, value_name = "R", value_parser = below_one)]
    max_reflectance: Option<f32>,
    /// Seed of the noise pattern [0]
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    #[command(flatten)]
    pub(super) method: MethodArgs,
    /// Refuse a bake that needs more memory, in bytes or like 500M, 4G [default: what is free]
    #[arg(long, value_name = "BYTES", value_parser = super::memory::amount, help_heading = "Work")]
    pub(super) max_memory: Option<u64>,
    /// Threads to work on, at least 1; the result is the same for any number [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
          help_heading = "Work")]
    pub(super) threads: Option<u16>,
    /// Whether direct light of point, spot and directional lights is baked, or left to the engine
    /// to add in real time
    #[arg(long, value_enum, default_value = "baked", help_heading = "Light")]
    direct: Direct,
    /// Part of the light to store: all of it, what comes straight from where it is made, or what surfaces reflected
    #[arg(long, value_enum, default_value = "all", help_heading = "Light")]
    contribution: Part,
    /// cd/m² of a surface whose emission in the file is 1, 0 or more. Bevy's default camera shows such a surface as
    /// bright as 998 cd/m² of lamplight: say so for scenes that have both kinds of light
    #[arg(long, value_name = "GAIN", value_parser = not_negative, default_value = "1",
          help_heading = "Light")]
    pub(super) emissive_gain: f32,
    /// Radiance of the sky in cd/m² (nits), one number or R,G,B; a blue sky has about 4000
    /// [default: no sky]
    #[arg(long, value_name = "NITS", value_parser = radiance, help_heading = "Light")]
    pub(super) sky: Option<Vec3>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Preset {
    /// For looking while working
    Draft,
    /// A good compromise
    Balanced,
    /// For shipping: five to ten times the time of balanced
    Final,
}

impl Preset {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Balanced => "balanced",
            Self::Final => "final",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Direct {
    /// Direct and bounced light are in the result
    Baked,
    /// Only bounced light is; the engine adds the rest
    Realtime,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Part {
    /// Direct and indirect light
    All,
    /// Light of lights, emissive surfaces and sky that no surface reflected
    Direct,
    /// Light that surfaces reflected at least once
    Indirect,
}

impl From<Part> for Contribution {
    fn from(part: Part) -> Self {
        match part {
            Part::All => Self::All,
            Part::Direct => Self::Direct,
            Part::Indirect => Self::Indirect,
        }
    }
}

impl SettingsArgs {
    /// The preset with everything that was given in its place.
    pub(super) fn settings(&self) -> BakeSettings {
        let preset = match self.preset {
            Preset::Draft => BakeSettings::DRAFT,
            Preset::Balanced => BakeSettings::BALANCED,
            Preset::Final => BakeSettings::FINAL,
        };
        BakeSettings {
            max_edge: self.max_edge,
            refine: !self.no_refine,
            error: self.error.unwrap_or(preset.error),
            max_vertices: self.max_vertices.unwrap_or(preset.max_vertices),
            max_seconds: self.max_seconds.or(preset.max_seconds),
            elements: self.elements.unwrap_or(preset.elements),
            adapt: !self.no_adapt,
            element_rays: self.element_rays.unwrap_or(preset.element_rays),
            gather_rays: self.gather_rays.unwrap_or(preset.gather_rays),
            samples_per_vertex: self.samples_per_vertex.unwrap_or(preset.samples_per_vertex),
            emitter_rays: self.emitter_rays.unwrap_or(preset.emitter_rays),
            solver_tolerance: self.solver_tolerance.unwrap_or(preset.solver_tolerance),
            max_sweeps: self.max_sweeps.unwrap_or(preset.max_sweeps),
            max_reflectance: self.max_reflectance.unwrap_or(preset.max_reflectance),
            seed: self.seed.unwrap_or(preset.seed),
            form_factors: self.method.form_factors(self.preset),
            contribution: self.contribution.into(),
            directional: self.directional,
            vertex_quality: false,
            sample_emitters: !self.method.no_emitter_sampling,
            solver: self.method.solver(),
            max_memory: self.max_memory.unwrap_or(preset.max_memory),
        }
    }

    /// What becomes of the direct light of all lights.
    pub(super) fn direct(&self) -> DirectLight {
        match self.direct {
            Direct::Baked => DirectLight::Baked,
            Direct::Realtime => DirectLight::Realtime,
        }
    }
}

pub(super) fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("not a number".into()),
    }
}

pub(super) fn within(text: &str, fits: impl Fn(f32) -> bool, limits: &str) -> Result<f32, String> {
    let value = number(text)?;
    if fits(value) {
        Ok(value)
    } else {
        Err(format!("it must be {limits}"))
    }
}

pub(super) fn positive(text: &str) -> Result<f32, String> {
    within(text, |v| v > 0.0, "above 0")
}

fn not_negative(text: &str) -> Result<f32, String> {
    within(text, |v| v >= 0.0, "0 or more")
}

fn error(text: &str) -> Result<f32, String> {
    within(text, |v| (0.001..=1.0).contains(&v), "0.001 to 1")
}

fn samples(text: &str) -> Result<f32, String> {
    within(text, |v| v > 0.0 && v <= 1e4, "above 0, up to 10000")
}

fn below_one(text: &str) -> Result<f32, String> {
    within(
        text,
        |v| (0.0..1.0).contains(&v),
        "0 or more, and less than 1",
    )
}

fn radiance(text: &str) -> Result<Vec3, String> {
    let parts: Vec<f32> = text
        .split(',')
        .map(not_negative)
        .collect::<Result<_, _>>()?;
    match parts[..] {
        [grey] => Ok(Vec3::splat(grey)),
        [r, g, b] => Ok(Vec3::new(r, g, b)),
        _ => Err("give one number, or three as R,G,B".into()),
    }
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |side: &str| side.parse().ok().filter(|s| (1..=8192).contains(s));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| "give width x height, each 1 to 8192, like 960x720".into())
}

/// One number above 0 for both ways, or two.
pub(super) fn times(text: &str) -> Result<Vec2, String> {
    let parts: Vec<f32> = text.split(',').map(positive).collect::<Result<_, _>>()?;
    match parts[..] {
        [both] => Ok(Vec2::splat(both)),
        [u, v] => Ok(Vec2::new(u, v)),
        _ => Err("give one number, or two as U,V".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn commands_are_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn presets_give_what_is_not_given() {
        let cli = Cli::try_parse_from(["fresco", "info", "a.glb", "--gather-rays", "7"]).unwrap();
        let Command::Info(info) = cli.command else {
            panic!("another command");
        };
        let expected = BakeSettings {
            gather_rays: 7,
            ..BakeSettings::BALANCED
        };
        assert_eq!(info.settings.settings(), expected);
    }

    #[test]
    fn help_tells_the_presets() {
        let mut cli = Cli::command();
        let help = cli.find_subcommand_mut("bake").unwrap().render_long_help();
        let help = help.to_string();
        let of = |value: fn(&BakeSettings) -> f32| {
            let [d, b, f] = [
                BakeSettings::DRAFT,
                BakeSettings::BALANCED,
                BakeSettings::FINAL,
            ]
            .map(|preset| value(&preset));
            format!("[draft {d}, balanced {b}, final {f}]")
        };
        for told in [
            of(|s| s.elements as f32),
            of(|s| s.element_rays as f32),
            of(|s| s.gather_rays as f32),
            of(|s| s.samples_per_vertex),
            of(|s| s.emitter_rays as f32),
            of(|s| s.solver_tolerance),
        ] {
            assert!(help.contains(&told), "{told} is not in {help}");
        }
    }

    #[test]
    fn values_are_read_strictly() {
        assert_eq!(radiance("3"), Ok(Vec3::splat(3.0)));
        assert_eq!(radiance("1, 2,3"), Ok(Vec3::new(1.0, 2.0, 3.0)));
        assert!(radiance("1,2").is_err() && radiance("-1").is_err() && radiance("NaN").is_err());
        assert_eq!(size("64x48"), Ok((64, 48)));
        assert!(size("64").is_err() && size("0x4").is_err() && size("9000x4").is_err());
        assert!(below_one("1").is_err() && below_one("0").is_ok());
        assert!(positive("0").is_err() && positive("inf").is_err());
    }
}

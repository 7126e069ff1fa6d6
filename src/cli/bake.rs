use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use super::Session;
use super::args::BakeArgs;
use super::failure::Failure;
use super::outputs::Outputs;
use super::progress::Progress;
use super::report::report_json;
use super::scene::{Loaded, go_on, on_threads, resources};
use super::summary::summary;
use super::{memory, picture};
use crate::gltf::{ExportOptions, LightEncoding, load, to_glb, write_atomically};
use crate::radiosity::{Bake, BakeSettings, DirectLight, bake, estimate_counts};

/// Mean light that vertex colours show as this: mid grey.
const MID_GREY: f32 = 0.18;

/// Below this mean light, in cd/m², a scene is all but black: a full moon's night has a hundred
/// times more.
const NEAR_BLACK: f32 = 1e-4;

/// Everything a bake made, before any of it is written.
pub(super) struct Made {
    pub(super) bake: Bake,
    pub(super) settings: BakeSettings,
    pub(super) threads: usize,
    /// Wall time of every step, in order.
    pub(super) times: Vec<(&'static str, Duration)>,
    pub(super) notes: Vec<String>,
    /// Factor of the vertex colours, if that is how light is stored.
    pub(super) exposure: Option<f32>,
    pub(super) glb: Vec<u8>,
    pub(super) png: Option<Vec<u8>>,
}

/// Runs `fresco bake`.
pub(super) fn bake_command(
    session: &Session,
    args: &BakeArgs,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let outputs = Outputs::new(args)?;
    let made = on_threads(args.settings.threads, |threads| {
        make(session, args, &outputs, threads)
    })?;
    let report = outputs
        .report
        .as_ref()
        .map(|_| report_json(args, &outputs, &made));
    go_on(session)?;
    write(&outputs.glb, &made.glb)?;
    if let (Some(path), Some(png)) = (&outputs.preview, &made.png) {
        write(path, png)?;
    }
    if let (Some(path), Some(report)) = (&outputs.report, &report) {
        write(path, report.as_bytes())?;
    }
    if !args.results.quiet {
        write!(out, "{}", summary(&args.scene, &outputs, &made))?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Ok(write_atomically(path, bytes)?)
}

fn make(
    session: &Session,
    args: &BakeArgs,
    outputs: &Outputs,
    threads: usize,
) -> Result<Made, Failure> {
    let progress = Progress::new(session, args.results.quiet);
    let mut times = Vec::new();
    let mut settings = args.settings.settings();

    progress.step("load");
    let started = Instant::now();
    let mut file = load(&args.scene)?;
    times.push(("load", started.elapsed()));
    outputs.spare(&resources(&file.document))?;
    if let Some(sky) = args.settings.sky {
        file.scene.sky = sky;
    }
    for light in &mut file.scene.lights {
        light.direct = args.settings.direct();
    }
    for material in &mut file.scene.materials {
        material.emissive *= args.settings.emissive_gain;
    }
    let origin = file.scene.origin;
    let loaded = Loaded::check(file)?;
    times.push(("validate", loaded.validate));
    go_on(session)?;
    let needed = estimate_counts(&loaded.scene, &settings).bytes;
    memory::check(needed, args.settings.max_memory)?;
    settings.max_memory = u64::MAX;

    let bake = bake(&loaded.scene, &settings, &progress)?;
    times.extend((bake.report.stages.iter()).map(|&(stage, time)| (stage.name(), time)));

    let mut notes = loaded.notes.clone();
    notes.extend(bake.report.notes.iter().cloned());
    notes.extend(remarks(&bake, args, &loaded));

    progress.step("export");
    let started = Instant::now();
    let exposure = args.results.vertex_colors.then(|| exposure(args, &bake));
    let options = ExportOptions {
        encoding: exposure.map_or(LightEncoding::Attribute, |exposure| {
            LightEncoding::VertexColors { exposure }
        }),
        direct: args.settings.direct(),
    };
    let exported = to_glb(
        &loaded.document,
        &loaded.primitives(&bake),
        &loaded.light_nodes,
        &options,
    )?;
    notes.extend(exported.notes);
    times.push(("export", started.elapsed()));
    go_on(session)?;

    let started = Instant::now();
    let png = match outputs.preview {
        Some(_) => Some(picture::draw(
            &loaded,
            origin,
            &bake,
            &args.results,
            &progress,
        )?),
        None => None,
    };
    if png.is_some() {
        times.push(("preview", started.elapsed()));
    }
    Ok(Made {
        bake,
        settings,
        threads,
        times,
        notes,
        exposure,
        glb: exported.bytes,
        png,
    })
}

/// The factor of vertex colours: as asked, or so that the mean light becomes mid grey.
fn exposure(args: &BakeArgs, bake: &Bake) -> f32 {
    let mean = bake.report.mean_light;
    args.results
        .exposure
        .unwrap_or(if mean > 0.0 { MID_GREY / mean } else { 1.0 })
}

/// What the core cannot know: how the result will look to who asked for it.
fn remarks(bake: &Bake, args: &BakeArgs, loaded: &Loaded) -> Vec<String> {
    let mut notes = Vec::new();
    let mean = bake.report.mean_light;
    if mean > 0.0 && mean < NEAR_BLACK {
        notes.push(format!(
            "the result is nearly black, {mean:.1e} cd/m² on average: check the intensities of the \
             lights (candela, lux, nits) and the scale of the scene (metres)"
        ));
    }
    if args.settings.direct() == DirectLight::Realtime
        && args.results.preview.is_some()
        && !loaded.light_nodes.is_empty()
    {
        notes.push(
            "direct light is left to the engine: the preview shows the baked light alone".into(),
        );
    }
    notes
}

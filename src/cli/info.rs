use std::io::{self, Write};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::Session;
use super::args::{InfoArgs, Preset};
use super::failure::Failure;
use super::progress::Progress;
use super::scene::{Loaded, on_threads};
use crate::gltf::{GltfProjection, GltfScene, load};
use crate::radiosity::{
    BakeError, Estimate, Light, LightKind, Material, Scene, ValidScene, estimate,
};
use crate::text::{bytes, count, counted, seconds, short};

/// Lines of a list before the rest is only counted.
const LINES: usize = 40;

/// Runs `fresco info`.
pub(super) fn info_command(
    session: &Session,
    args: &InfoArgs,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let started = Instant::now();
    let mut file = load(&args.scene)?;
    let time = started.elapsed();
    if let Some(sky) = args.settings.sky {
        file.scene.sky = sky;
    }
    writeln!(out, "{} (read in {})", args.scene.display(), seconds(time))?;
    contents(out, &file)?;
    // A file that cannot be baked is described all the same, and then it is said why.
    let loaded = Loaded::check(file)?;
    extent(out, &loaded.scene)?;
    let settings = args.settings.settings();
    let scene = &loaded.scene;
    let (found, threads) = on_threads(args.settings.threads, |threads| {
        let progress = Progress::new(session, true);
        let found: Result<Estimate, BakeError> = estimate(scene, &settings, &progress);
        Ok((found?, threads))
    })?;
    cost(
        out,
        (args.settings.preset, settings.refine),
        &found,
        threads,
    )?;
    list(out, "notes", &loaded.notes)?;
    list(out, "mended", loaded.scene.notes())?;
    Ok(())
}

fn contents(out: &mut dyn Write, file: &GltfScene) -> io::Result<()> {
    let scene = &file.scene;
    let objects = scene.objects.iter().map(|object| {
        let material = &scene.materials[object.material.0 as usize];
        format!(
            "{}: {}, {}, material \"{}\"",
            object.name,
            counted(object.triangles.len() as u64, "triangle"),
            counted(object.positions.len() as u64, "vertex"),
            material.name
        )
    });
    let objects: Vec<String> = objects.collect();
    list(out, "objects", &objects)?;
    let materials: Vec<String> = scene.materials.iter().map(material).collect();
    list(out, "materials", &materials)?;
    let textures = scene.textures.iter();
    let textures: Vec<String> = textures
        .map(|t| format!("{}: {} x {}", t.name, t.width, t.height))
        .collect();
    list(out, "textures", &textures)?;
    let lights: Vec<String> = scene.lights.iter().map(light).collect();
    list(out, "lights", &lights)?;
    list(out, "camera", &camera(file))?;
    let extensions = file.document.json["extensionsUsed"].as_array();
    let extensions: Vec<String> = (extensions.into_iter().flatten())
        .filter_map(Value::as_str)
        .map(str::to_owned)
        .collect();
    list(out, "extensions", &extensions)?;
    writeln!(out, "\nsky: {}", sky(scene))
}

/// A heading with its lines; nothing for an empty list.
fn list(out: &mut dyn Write, heading: &str, lines: &[String]) -> io::Result<()> {
    if lines.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{heading} ({})", lines.len())?;
    for line in lines.iter().take(LINES) {
        writeln!(out, "  {line}")?;
    }
    if lines.len() > LINES {
        writeln!(out, "  and {} more", lines.len() - LINES)?;
    }
    Ok(())
}

fn material(m: &Material) -> String {
    let [r, g, b, _] = m.base_color.to_array();
    let mut text = format!("{}: base colour {r:.2} {g:.2} {b:.2}", m.name);
    let mut add = |holds: bool, what: &str| {
        if holds {
            text.push_str(", ");
            text.push_str(what);
        }
    };
    add(m.base_color_texture.is_some(), "textured");
    add(m.metallic > 0.0, "metallic");
    let [r, g, b] = m.emissive.to_array().map(|c| short(c.into()));
    let emits = m.emissive.max_element() > 0.0;
    add(emits, &format!("emits {r} {g} {b} cd/m²"));
    add(m.double_sided, "double-sided");
    add(m.alpha != Default::default(), "see-through in part");
    add(m.unlit, "unlit");
    text
}

fn light(light: &Light) -> String {
    let power = light.power.to_array().map(|c| short(c.into())).join(" ");
    let kind = match light.kind {
        LightKind::Point { .. } => format!("point, {power} lm"),
        LightKind::Spot { outer_angle, .. } => format!(
            "spot of {:.0}° across, {power} lm",
            2.0 * outer_angle.to_degrees()
        ),
        LightKind::Rect { width, height, .. } => {
            format!("rectangle of {width:.2} by {height:.2} m, {power} lm")
        }
        LightKind::Directional { .. } => format!("directional, {power} lx"),
    };
    format!("{}: {kind}", light.name)
}

fn camera(file: &GltfScene) -> Vec<String> {
    let text = |camera: &crate::gltf::GltfCamera| {
        let view = match camera.projection {
            GltfProjection::Perspective { yfov, .. } => {
                format!("perspective, {:.0}° high", yfov.to_degrees())
            }
            GltfProjection::Orthographic { ymag, .. } => {
                format!("orthographic, {} m high", short(2.0 * f64::from(ymag)))
            }
        };
        format!("{}: {view}", camera.name)
    };
    file.camera.iter().map(text).collect()
}

fn sky(scene: &Scene) -> String {
    if scene.sky.max_element() > 0.0 {
        let [r, g, b] = scene.sky.to_array().map(|c| short(c.into()));
        format!("{r} {g} {b} cd/m²")
    } else {
        "none (see --sky)".into()
    }
}

fn extent(out: &mut dyn Write, scene: &ValidScene) -> io::Result<()> {
    let (mut low, mut high) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
    for corner in scene.triangles.iter().flat_map(|&t| scene.corners(t)) {
        low = low.min(corner);
        high = high.max(corner);
    }
    let size = (high - low) * scene.scale;
    let [x, y, z] = size.to_array().map(|s| short(s.into()));
    writeln!(out, "extent: {x} x {y} x {z} m")
}

fn cost(
    out: &mut dyn Write,
    (preset, refine): (Preset, bool),
    found: &Estimate,
    threads: usize,
) -> io::Result<()> {
    writeln!(out, "\na bake with the preset {}", preset.name())?;
    let mut row = |name: &str, value: String| writeln!(out, "  {name:<10} {value}");
    let and_more = if refine {
        " given; the light asks for more, which is not known before and not in the figures below"
    } else {
        ""
    };
    row("vertices", count(found.vertices) + and_more)?;
    row("elements", count(found.elements))?;
    row("samples", format!("about {}", count(found.samples)))?;
    let rays = found.rays + found.shadow_rays;
    row("rays", format!("about {}, with shadow rays", count(rays)))?;
    row("memory", format!("about {} (estimate)", bytes(found.bytes)))?;
    let time = seconds(Duration::from_secs_f64(found.seconds));
    let threads = counted(threads as u64, "thread");
    row("time", format!("about {time} on {threads} (estimate)"))
}

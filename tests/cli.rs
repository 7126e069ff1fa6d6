//! The command line, run in this process.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;

use bevy_fresco::cli::{Session, run, run_in};
use serde_json::Value;

const FURNACE: &str = "assets/scenes/furnace.glb";

struct Ran {
    code: u8,
    out: String,
    err: String,
}

fn code(exit: ExitCode) -> u8 {
    (0..=255).find(|&c| ExitCode::from(c) == exit).unwrap()
}

fn fresco<S: Into<OsString>>(args: impl IntoIterator<Item = S>) -> Ran {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let args = std::iter::once("fresco".into()).chain(args.into_iter().map(Into::into));
    let exit = run(args, &mut out, &mut err);
    Ran {
        code: code(exit),
        out: String::from_utf8(out).unwrap(),
        err: String::from_utf8(err).unwrap(),
    }
}

/// `fresco bake` of a scene at draft quality into a file.
fn bake(scene: &Path, output: &Path, more: &[&str]) -> Ran {
    let mut args: Vec<OsString> = vec!["bake".into(), scene.into(), "-o".into(), output.into()];
    args.extend(["--preset", "draft"].map(Into::into));
    args.extend(more.iter().map(Into::into));
    fresco(args)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Exit code 1, one line that has all of `parts`, and nothing on standard output.
fn assert_error(ran: &Ran, parts: &[&str]) {
    assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{}", ran.err);
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    assert!(ran.err.starts_with("error: "), "{}", ran.err);
    for part in parts {
        assert!(ran.err.contains(part), "{part} is not in: {}", ran.err);
    }
}

#[test]
fn bakes_with_picture_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (glb, png, json) = (path("a.glb"), path("a.png"), path("a.json"));
    let more = [
        "--preview",
        png.to_str().unwrap(),
        "--preview-size",
        "80x60",
        "--report",
        json.to_str().unwrap(),
    ];
    let ran = bake(Path::new(FURNACE), &glb, &more);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert!(
        ran.out.contains("wrote") && ran.out.contains("a.glb"),
        "{}",
        ran.out
    );
    assert_eq!(names(folder.path()), ["a.glb", "a.json", "a.png"]);

    let document = gltf::Gltf::from_slice(&fs::read(&glb).unwrap()).unwrap();
    let json_chunk = document.document.into_json();
    for mesh in &json_chunk.meshes {
        for primitive in &mesh.primitives {
            let names: Vec<String> = primitive
                .attributes
                .keys()
                .map(|name| format!("{name:?}"))
                .collect();
            assert!(names.iter().any(|n| n.contains("BAKED_LIGHT")), "{names:?}");
        }
    }
    let picture = image::open(&png).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (80, 60));
    let lit = picture.pixels().filter(|p| p.0[0] > 60).count();
    assert!(lit > 1000, "{lit} pixels of 4800 are not black");
    assert_sane(&serde_json::from_slice(&fs::read(&json).unwrap()).unwrap());
}

fn assert_sane(report: &Value) {
    for key in [
        "version",
        "input",
        "output",
        "preview",
        "preset",
        "settings",
        "threads",
        "exposure",
        "seconds",
        "counts",
        "bytes",
        "energy",
        "solver",
        "sampling_error",
        "mean_light",
        "notes",
    ] {
        assert!(report.get(key).is_some(), "no {key} in {report:#}");
    }
    for step in [
        "load",
        "validate",
        "mesh",
        "occlusion",
        "form_factors",
        "direct_light",
        "solve",
        "gather",
        "fit_vertices",
        "export",
        "preview",
        "total",
    ] {
        assert!(report["seconds"][step].as_f64().unwrap() >= 0.0, "{step}");
    }
    // A furnace of emission 1 and reflectance one half.
    assert!((report["mean_light"].as_f64().unwrap() - 2.0).abs() < 0.02);
    assert!(report["energy"]["relative_error"].as_f64().unwrap() < 0.01);
    assert!(report["sampling_error"].as_f64().unwrap() < 0.01);
    assert_eq!(report["solver"]["converged"], true);
    assert_eq!(report["settings"]["gather_rays"], 24);
    assert!(report["counts"]["triangles"].as_u64().unwrap() > 100);
    assert!(report["bytes"]["output"].as_u64().unwrap() > 1000);
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut results = Vec::new();
    for threads in ["1", "2", "8"] {
        let (glb, png) = (folder.path().join("t.glb"), folder.path().join("t.png"));
        let more = [
            "--threads",
            threads,
            "--preview",
            png.to_str().unwrap(),
            "--preview-size",
            "64x48",
        ];
        let ran = bake(Path::new("assets/scenes/courtyard.glb"), &glb, &more);
        assert_eq!(ran.code, 0, "{}", ran.err);
        results.push((fs::read(glb).unwrap(), fs::read(png).unwrap()));
    }
    assert!(results.windows(2).all(|w| w[0] == w[1]));
}

#[test]
fn vertex_colors_have_mid_grey_as_mean() {
    let folder = tempfile::tempdir().unwrap();
    let (glb, json) = (folder.path().join("v.glb"), folder.path().join("v.json"));
    let more = ["--vertex-colors", "--report", json.to_str().unwrap(), "-q"];
    let ran = bake(Path::new("assets/scenes/cornell_box.glb"), &glb, &more);
    assert_eq!((ran.code, ran.out.as_str(), ran.err.as_str()), (0, "", ""));
    let file = gltf::Gltf::from_slice(&fs::read(&glb).unwrap()).unwrap();
    assert!(
        file.meshes()
            .flat_map(|m| m.primitives())
            .all(|p| { p.get(&gltf::Semantic::Colors(0)).is_some() })
    );
    let report: Value = serde_json::from_slice(&fs::read(json).unwrap()).unwrap();
    let mean = report["mean_light"].as_f64().unwrap() * report["exposure"].as_f64().unwrap();
    assert!((mean - 0.18).abs() < 1e-4, "{mean}");
}

#[test]
fn directional_light_is_stored_beside_the_light() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("lit.glb");
    let json = folder.path().join("report.json");
    let more = ["--directional", "--report", json.to_str().unwrap(), "-q"];
    let ran = bake(Path::new(FURNACE), &output, &more);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let report: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
    assert_eq!(report["settings"]["directional"], true);
    let document = bevy_fresco::gltf::load(&output).unwrap().document;
    assert_eq!(
        document.json["asset"]["extras"]["fresco"]["directional"],
        true
    );
    for mesh in document.json["meshes"].as_array().unwrap() {
        let attributes = &mesh["primitives"][0]["attributes"];
        let count = |name: &str| {
            let accessor = attributes[name].as_u64().unwrap() as usize;
            document.json["accessors"][accessor]["count"]
                .as_u64()
                .unwrap()
        };
        assert_eq!(count("_BAKED_LIGHT_GRADIENT"), count("_BAKED_LIGHT"));
    }
    let ran = bake(
        Path::new(FURNACE),
        &output,
        &["--directional", "--vertex-colors"],
    );
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("--vertex-colors"), "{}", ran.err);
}

#[test]
fn refines_and_takes_a_sky() {
    let folder = tempfile::tempdir().unwrap();
    let vertices = |more: &[&str]| {
        let json = folder.path().join("r.json");
        let mut all = vec!["--report", json.to_str().unwrap()];
        all.extend(more);
        let ran = bake(Path::new(FURNACE), &folder.path().join("r.glb"), &all);
        assert_eq!(ran.code, 0, "{}", ran.err);
        let report: Value = serde_json::from_slice(&fs::read(json).unwrap()).unwrap();
        report["counts"]["vertices"].as_u64().unwrap()
    };
    let given = vertices(&["--no-refine", "--sky", "1,2,3"]);
    assert!(vertices(&["--max-edge", "0.1"]) > 2 * given);
}

#[test]
fn says_what_is_wrong_with_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let missing = bake(&path("none.glb"), &path("o.glb"), &[]);
    assert_error(&missing, &["cannot read", "none.glb"]);
    fs::write(path("garbage.glb"), b"glTF but not really").unwrap();
    let garbage = bake(&path("garbage.glb"), &path("o.glb"), &[]);
    assert_error(&garbage, &["garbage.glb"]);
    let furnace = Path::new(FURNACE);
    let folderless = bake(furnace, &path("no/where/o.glb"), &[]);
    assert_error(&folderless, &["no/where", "create it"]);
    let report = bake(furnace, &path("o.glb"), &["--report", "no/where/r.json"]);
    assert_error(&report, &["no/where"]);
    let text = bake(furnace, &path("o.txt"), &[]);
    assert_error(&text, &["o.txt", ".glb"]);
    let twice = path("o.png");
    let twice = twice.to_str().unwrap();
    let twice = bake(
        furnace,
        &path("o.glb"),
        &["--preview", twice, "--report", twice],
    );
    assert_error(&twice, &["different names"]);
    assert_eq!(names(folder.path()), ["garbage.glb"]);
}

#[test]
fn never_writes_over_its_input() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.glb");
    fs::copy(FURNACE, &scene).unwrap();
    let before = fs::read(&scene).unwrap();
    let detour: PathBuf = folder.path().join(".").join("s.glb");
    assert_error(&bake(&scene, &detour, &[]), &["overwritten", "-o"]);
    assert_eq!(fs::read(&scene).unwrap(), before);
    // By default the result stands beside the scene.
    let ran = fresco([
        "bake".into(),
        scene.into_os_string(),
        "-q".into(),
        "--preset=draft".into(),
    ]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert_eq!(names(folder.path()), ["s.baked.glb", "s.glb"]);
}

#[test]
fn stopping_leaves_nothing_and_spares_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("old.glb");
    fs::write(&output, b"old").unwrap();
    let session = Session::default();
    session.cancel.store(true, Ordering::Relaxed);
    let preview = folder.path().join("p.png");
    let args: [OsString; 7] = [
        "fresco".into(),
        "bake".into(),
        FURNACE.into(),
        "-o".into(),
        output.clone().into(),
        "--preview".into(),
        preview.into(),
    ];
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let exit = run_in(&session, args, &mut out, &mut err);
    assert_eq!(code(exit), 130);
    assert!(out.is_empty());
    assert_eq!(names(folder.path()), ["old.glb"]);
    assert_eq!(fs::read(&output).unwrap(), b"old");
}

#[test]
fn failing_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("old.glb");
    fs::write(&output, b"old").unwrap();
    let scene = folder.path().join("cut.glb");
    let bytes = fs::read(FURNACE).unwrap();
    fs::write(&scene, &bytes[..bytes.len() / 2]).unwrap();
    assert_error(&bake(&scene, &output, &[]), &["cut.glb"]);
    assert_eq!(fs::read(&output).unwrap(), b"old");
}

#[test]
fn too_fine_a_mesh_is_refused_before_it_swaps() {
    let folder = tempfile::tempdir().unwrap();
    let ran = bake(
        Path::new(FURNACE),
        &folder.path().join("o.glb"),
        &["--max-edge", "1e-6"],
    );
    assert_error(&ran, &["max"]);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn bad_options_are_usage_errors() {
    for options in [
        &["--gather-rays", "0"][..],
        &["--gather-rays", "many"],
        &["--max-edge", "-1"],
        &["--error", "2"],
        &["--max-vertices", "few"],
        &["--max-seconds", "0"],
        &["--max-reflectance", "1"],
        &["--samples-per-vertex", "NaN"],
        &["--preset", "best"],
        &["--sky", "1,2"],
        &["--threads", "0"],
        &["--preview-size", "big"],
        &["--exposure", "0"],
        &["--colour"],
    ] {
        let ran = fresco(["bake", FURNACE].iter().chain(options));
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{options:?}");
        assert!(ran.err.contains("error:"), "{options:?}: {}", ran.err);
    }
    assert_eq!(fresco(Vec::<OsString>::new()).code, 2);
}

#[test]
fn info_describes_the_scene_and_the_cost() {
    let ran = fresco(["info", "assets/scenes/courtyard.glb", "--max-edge", "0.5"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    for part in [
        "objects (",
        "materials (",
        "textures (",
        "lights (",
        "camera (",
        "extensions (",
        "sky:",
        "extent:",
        "vertices",
        "memory",
        "(estimate)",
        "KHR_lights_punctual",
    ] {
        assert!(ran.out.contains(part), "no {part} in {}", ran.out);
    }
}

#[test]
fn help_lets_a_stranger_start() {
    let ran = fresco(["--help"]);
    assert_eq!(ran.code, 0);
    assert!(ran.out.contains("fresco bake room.glb --preview room.png"));
    assert!(ran.out.contains("--vertex-colors -o lit.glb"));
    let ran = fresco(["bake", "--help"]);
    assert!(ran.out.contains("--max-edge <METRES>"), "{}", ran.out);
}

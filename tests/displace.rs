//! `fresco displace`, run in this process on files that the tests make.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bevy_fresco::cli::{Session, run_in};
use bevy_fresco::gltf::load;
use image::{ImageBuffer, Luma};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a scene, `wall.glb`, and a map, `map.png`.
struct Folder(TempDir);

struct Ran {
    code: u8,
    out: String,
    err: String,
}

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        fs::write(folder.path("wall.glb"), wall()).unwrap();
        // A ramp from the left to the right of the map.
        let map = ImageBuffer::from_fn(64, 64, |x, _| Luma([(x * 1000) as u16]));
        map.save(folder.path("map.png")).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.collect();
        names.sort();
        names
    }

    /// `fresco displace`, with the folder for `@` in arguments.
    fn run(&self, session: &Session, args: &[&str]) -> Ran {
        let folder = format!("{}/", self.0.path().display());
        let args = args.iter().map(|a| OsString::from(a.replace('@', &folder)));
        let all = ["fresco".into(), "displace".into()].into_iter().chain(args);
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let exit = run_in(session, all, &mut out, &mut err);
        Ran {
            code: (0..=255).find(|&c| ExitCode::from(c) == exit).unwrap(),
            out: String::from_utf8(out).unwrap(),
            err: String::from_utf8(err).unwrap(),
        }
    }

    fn makes(&self, args: &[&str]) -> String {
        let ran = self.run(&Session::default(), args);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{args:?}");
        ran.out
    }

    /// Exit code 1, one line that has all of `parts`, nothing written.
    fn refuses(&self, args: &[&str], parts: &[&str]) {
        let before = self.names();
        let ran = self.run(&Session::default(), args);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{}", ran.err);
        assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
        for part in parts {
            assert!(ran.err.contains(part), "{part} is not in: {}", ran.err);
        }
        assert_eq!(self.names(), before);
    }
}

fn wall() -> Vec<u8> {
    let (json, bin) = wall_parts();
    glb(&json, bin)
}

/// Two triangles of 1 m in a node of scale 2, with everything that a vertex may have.
fn wall_parts() -> (Value, Vec<u8>) {
    let mut bin: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |kind: &str, width: usize, component: u32, bytes: Vec<u8>, more: Value| {
        views.push(json!({"buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len()}));
        let size = if component == 5121 { 1 } else { 4 };
        let mut accessor = json!({"bufferView": views.len() - 1, "componentType": component,
            "count": bytes.len() / width / size, "type": kind});
        accessor
            .as_object_mut()
            .unwrap()
            .extend(more.as_object().unwrap().clone());
        accessors.push(accessor);
        bin.extend(bytes);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let none = json!({});
    let positions = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    let bounds = json!({"min": [0., 0., 0.], "max": [1., 1., 0.]});
    let attributes = json!({
        "POSITION": add("VEC3", 3, 5126, floats(&positions), bounds),
        "NORMAL": add("VEC3", 3, 5126, floats(&[0., 0., 1.].repeat(4)), none.clone()),
        "TANGENT": add("VEC4", 4, 5126, floats(&[1., 0., 0., 1.].repeat(4)), none.clone()),
        "TEXCOORD_0": add("VEC2", 2, 5126, floats(&[0., 1., 1., 1., 1., 0., 0., 0.]), none.clone()),
        "TEXCOORD_1": add("VEC2", 2, 5126, floats(&[0.1, 0.9, 0.5, 0.9, 0.5, 0.5, 0.1, 0.5]), none.clone()),
        "COLOR_0": add("VEC3", 3, 5126, floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]), none.clone()),
        "JOINTS_0": add("VEC4", 4, 5121, [1, 0, 0, 0].repeat(4), none.clone()),
        "WEIGHTS_0": add("VEC4", 4, 5126, floats(&[0.75, 0.25, 0., 0.].repeat(4)), none.clone()),
        "_BAKED_LIGHT": add("VEC3", 3, 5126, floats(&[1.; 12]), none.clone()),
    });
    let indices: Vec<u8> = [0_u32, 1, 2, 0, 2, 3]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let indices = add("SCALAR", 1, 5125, indices, none);
    let json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "Wall", "mesh": 0, "scale": [2., 2., 2.]}, {"name": "Marks", "mesh": 1}],
        "materials": [{"name": "Plaster"}],
        "meshes": [
            {"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": 0}, "indices": indices}]},
        ],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": bin.len()}],
        "extras": {"kept": true},
    });
    (json, bin)
}

fn glb(json: &Value, mut bin: Vec<u8>) -> Vec<u8> {
    let mut text = serde_json::to_vec(json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let word = |n: usize| (n as u32).to_le_bytes();
    let head = [*b"glTF", word(2), word(12 + 8 + text.len() + 8 + bin.len())].concat();
    let text = [&word(text.len())[..], b"JSON", &text].concat();
    [head, text, [&word(bin.len())[..], b"BIN\0", &bin].concat()].concat()
}

/// The numbers of an attribute of the first primitive, all of them floats.
fn attribute(file: &[u8], name: &str) -> Vec<f32> {
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
    let accessor = &json["meshes"][0]["primitives"][0]["attributes"][name];
    let view = &json["accessors"][accessor.as_u64().unwrap() as usize]["bufferView"];
    let view = &json["bufferViews"][view.as_u64().unwrap() as usize];
    let start = 28 + length + view["byteOffset"].as_u64().unwrap_or(0) as usize;
    let bytes = &file[start..start + view["byteLength"].as_u64().unwrap() as usize];
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    bytes.chunks_exact(4).map(number).collect()
}

const SCENE: &str = "@wall.glb";

#[test]
fn a_scene_comes_back_displaced() {
    let folder = Folder::new();
    let out = folder.makes(&[
        SCENE, "--map", "@map.png", "--only", "Plaster", "--scale", "0.2", "--texels", "1",
        "--wrap", "clamp", "-o", "@out.glb",
    ]);
    assert!(
        out.starts_with("Wall: 2 triangles became 8,192 triangles with 4,225 vertices"),
        "{out}"
    );
    assert!(out.contains("earlier bake"), "{out}");
    let file = fs::read(folder.path("out.glb")).unwrap();
    let [positions, normals, tangents, uvs, second, colors, weights] = [
        "POSITION",
        "NORMAL",
        "TANGENT",
        "TEXCOORD_0",
        "TEXCOORD_1",
        "COLOR_0",
        "WEIGHTS_0",
    ]
    .map(|name| attribute(&file, name));
    assert_eq!(positions.len(), 3 * 4225);
    for i in 0..4225 {
        let [x, y, z] = [0, 1, 2].map(|k| positions[3 * i + k]);
        // Half of it in a node of scale 2. Away from the border the map is the ramp itself.
        let height = 0.1 * (64.0 * x - 0.5) * 1000.0 / 65_535.0;
        if (0.05..0.95).contains(&x) {
            assert!((z - height).abs() < 1e-5, "{x} {y}: {z} and {height}");
            let slope = 0.1 * 64.0 * 1000.0 / 65_535.0;
            assert!((normals[3 * i] / normals[3 * i + 2] + slope).abs() < 1e-3);
        }
        assert!((uvs[2 * i] - x).abs() < 1e-6 && (uvs[2 * i + 1] - (1.0 - y)).abs() < 1e-6);
        assert!((second[2 * i] - (0.1 + 0.4 * x)).abs() < 1e-6);
        assert!((colors[3 * i] - x).abs() < 1e-6 && (colors[3 * i + 1] - y).abs() < 1e-6);
        assert_eq!(weights[4 * i..4 * i + 2], [0.75, 0.25]);
        let along: f32 = (0..3)
            .map(|k| tangents[4 * i + k] * normals[3 * i + k])
            .sum();
        assert!(along.abs() < 1e-5 && tangents[4 * i] > 0.9 && tangents[4 * i + 3] == 1.0);
    }
    // The file is sound, the other mesh as it was, what nobody knows kept, the old light gone.
    let loaded = load(&folder.path("out.glb")).unwrap();
    assert_eq!(loaded.scene.objects.len(), 2);
    assert_eq!(loaded.scene.objects[1].triangles.len(), 2);
    assert_eq!(loaded.document.json["extras"]["kept"], true);
    let attributes = &loaded.document.json["meshes"][0]["primitives"][0]["attributes"];
    assert!(attributes.get("_BAKED_LIGHT").is_none());
}

#[test]
fn vertices_go_where_they_are_needed_by_default() {
    let folder = Folder::new();
    let args = [SCENE, "-m", "@map.png", "--only", "Wall", "--wrap", "clamp"];
    let out = folder.makes(&args);
    // The default name; a ramp needs few.
    assert!(
        folder.names().contains(&"wall.displaced.glb".to_owned()),
        "{out}"
    );
    assert!(out.contains("error at most"), "{out}");
    let loaded = load(&folder.path("wall.displaced.glb")).unwrap();
    let triangles = loaded.scene.objects[0].triangles.len();
    assert!((2..50).contains(&triangles), "{triangles}");
}

#[test]
fn room_is_kept_to_and_told() {
    let folder = Folder::new();
    let run = |more: &[&str]| {
        let args = [
            &[SCENE, "-m", "@map.png", "--only", "Wall", "-o", "@o.glb"],
            more,
        ]
        .concat();
        folder.makes(&args)
    };
    let out = run(&["--texels", "0.1", "--max-triangles", "1000"]);
    assert!(out.contains("raise --max-triangles"), "{out}");
    let out = run(&["--edge", "0.001", "--max-memory", "64k"]);
    assert!(out.contains("raise --max-memory"), "{out}");
    assert_eq!(run(&["-q"]), "");
}

#[test]
fn what_cannot_be_done_is_told_and_nothing_written() {
    let folder = Folder::new();
    let color = image::RgbImage::from_fn(4, 4, |x, _| image::Rgb([x as u8, 0, 9]));
    color.save(folder.path("color.png")).unwrap();
    folder.refuses(
        &[SCENE, "-m", "@map.png"],
        &["Marks has no TEXCOORD_0", "--uv", "--only"],
    );
    folder.refuses(
        &[SCENE, "-m", "@map.png", "--only", "Wood"],
        &["nothing named Wood", "Plaster, Wall"],
    );
    folder.refuses(
        &[SCENE, "-m", "@color.png"],
        &["color.png", "has a colour", "fresco height"],
    );
    folder.refuses(&[SCENE, "-m", "@none.png"], &["cannot read", "none.png"]);
    folder.refuses(
        &["@none.glb", "-m", "@map.png"],
        &["cannot read", "none.glb"],
    );
    folder.refuses(
        &[SCENE, "-m", "@map.png", "-o", "@wall.glb"],
        &["would be overwritten", "-o"],
    );
    folder.refuses(
        &[SCENE, "-m", "@map.png", "-o", "@x.png"],
        &["binary glTF", ".glb"],
    );
    folder.refuses(
        &[SCENE, "-m", "@map.png", "--only", "Wall", "--scale", "1e30"],
        &["Wall", "choose a smaller scale"],
    );
    let usage = folder.run(
        &Session::default(),
        &[SCENE, "-m", "@map.png", "--tolerance", "0"],
    );
    assert_eq!(usage.code, 2);
    assert!(usage.err.contains("above 0"), "{}", usage.err);
}

const EXTENSION: &str = "KHR_materials_displacement";

/// The folder's scene, its material displaced by the folder's map, from −5 to 5 cm in units of the mesh.
fn displaced_by_its_material(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let (mut json, bin) = wall_parts();
    json["images"] = json!([{"uri": "map.png"}]);
    json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33071}]);
    json["textures"] = json!([{"source": 0, "sampler": 0}]);
    json["extensionsUsed"] = json!([EXTENSION]);
    json["materials"][0]["extensions"] = json!({EXTENSION: {
        "displacementGeometryTexture": {"index": 0},
        "displacementGeometryFactor": 0.1,
        "displacementGeometryOffset": -0.05,
    }});
    change(&mut json);
    fs::write(folder.path("own.glb"), glb(&json, bin)).unwrap();
}

#[test]
fn materials_say_what_they_are_displaced_by() {
    let folder = Folder::new();
    displaced_by_its_material(&folder, |_| ());
    let note = load(&folder.path("own.glb")).unwrap().notes.join(" ");
    assert!(
        note.contains("Plaster is displaced") && note.contains("fresco displace"),
        "{note}"
    );
    folder.makes(&["@own.glb", "--texels", "1", "-o", "@own.out.glb"]);
    // Half of it by the map are 10 cm of the scene.
    let args = [
        SCENE, "-m", "@map.png", "--only", "Wall", "--wrap", "clamp", "--texels", "1",
    ];
    folder.makes(
        &[
            &args[..],
            &["--scale", "0.2", "--mid-level", "0.5", "-o", "@out.glb"],
        ]
        .concat(),
    );
    let [own, given] = ["own.out.glb", "out.glb"].map(|name| fs::read(folder.path(name)).unwrap());
    let [own_positions, positions] = [&own, &given].map(|file| attribute(file, "POSITION"));
    assert_eq!(own_positions.len(), positions.len());
    for (own, given) in own_positions.iter().zip(&positions) {
        assert!((own - given).abs() < 1e-6, "{own} {given}");
    }
    assert!(positions.iter().skip(2).step_by(3).any(|&z| z < -0.04));
    // Once is enough.
    let json = load(&folder.path("own.out.glb")).unwrap().document.json;
    assert!(json.get("extensionsUsed").is_none());
    assert!(json["materials"][0]["extensions"].get(EXTENSION).is_none());
}

/// Set, turned and moved texture coordinates: the same as those written into the mesh.
#[test]
fn texture_transforms_of_maps_are_followed() {
    let folder = Folder::new();
    displaced_by_its_material(&folder, |json| {
        json["extensionsUsed"] = json!([EXTENSION, "KHR_texture_transform"]);
        json["materials"][0]["extensions"][EXTENSION]["displacementGeometryTexture"] = json!({
            "index": 0, "texCoord": 0,
            "extensions": {"KHR_texture_transform": {"texCoord": 1, "scale": [2.0, 1.0], "offset": [-0.1, 0.0]}},
        });
    });
    folder.makes(&["@own.glb", "--edge", "0.1", "-o", "@out.glb"]);
    let file = fs::read(folder.path("out.glb")).unwrap();
    let positions = attribute(&file, "POSITION");
    for p in positions.chunks_exact(3) {
        // u = 0.1 + 0.4 x is the second set.
        let texel = 64.0 * (2.0 * (0.1 + 0.4 * p[0]) - 0.1) - 0.5;
        let height = -0.05 + 0.1 * texel * 1000.0 / 65_535.0;
        assert!((p[2] - height).abs() < 1e-5, "{p:?} {height}");
    }
}

#[test]
fn materials_of_others_stay_as_they_are() {
    let folder = Folder::new();
    displaced_by_its_material(&folder, |json| {
        json["meshes"][1]["primitives"][0]["material"] = 0.into();
    });
    folder.makes(&[
        "@own.glb", "--only", "Wall", "--edge", "0.5", "-o", "@out.glb",
    ]);
    let json = load(&folder.path("out.glb")).unwrap().document.json;
    let displaced = |mesh: usize| {
        let material = json["meshes"][mesh]["primitives"][0]["material"]
            .as_u64()
            .unwrap();
        let extensions = &json["materials"][material as usize]["extensions"];
        extensions.get(EXTENSION).is_some()
    };
    assert!(!displaced(0) && displaced(1));
    assert_eq!(json["extensionsUsed"], json!([EXTENSION]));
}

#[test]
fn maps_of_materials_that_cannot_be_had_are_told() {
    let folder = Folder::new();
    folder.refuses(&[SCENE], &["wall.glb", EXTENSION, "--map"]);
    displaced_by_its_material(&folder, |json| json["images"][0]["uri"] = "none.png".into());
    folder.refuses(&["@own.glb"], &["own.glb", "none.png"]);
    let factor = |factor: f32| {
        displaced_by_its_material(&folder, |json| {
            json["materials"][0]["extensions"][EXTENSION]["displacementGeometryFactor"] =
                factor.into();
        });
    };
    factor(0.0);
    folder.refuses(
        &["@own.glb"],
        &["own.glb", "map.png", "displacementGeometryFactor of 0"],
    );
    let usage = folder.run(&Session::default(), &["@own.glb", "--scale", "2"]);
    assert_eq!(usage.code, 2);
    assert!(usage.err.contains("--map"), "{}", usage.err);
}

#[test]
fn a_run_that_is_stopped_leaves_nothing() {
    let folder = Folder::new();
    let before = folder.names();
    let session = Session {
        cancel: Arc::new(AtomicBool::new(true)),
        ..Session::default()
    };
    let ran = folder.run(&session, &[SCENE, "-m", "@map.png", "--only", "Wall"]);
    assert_eq!((ran.code, ran.out.as_str()), (130, ""));
    assert_eq!(folder.names(), before);
}

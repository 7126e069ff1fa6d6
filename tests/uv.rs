//! `fresco uv`, run in this process.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bevy_fresco::cli::run;
use bevy_fresco::gltf::{GltfSurfaces, PrimitiveSurface, load_surfaces};
use glam::{Vec2, Vec3};
use tempfile::TempDir;

fn asset(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("assets").join(name).display().to_string()
}

/// Runs a command; what it says and whether all went well.
fn fresco(args: &[&str]) -> (bool, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let all = ["fresco"].iter().chain(args).map(OsString::from);
    let done = run(all, &mut out, &mut err) == ExitCode::SUCCESS;
    let said = if done { out } else { err };
    (done, String::from_utf8(said).unwrap())
}

/// A folder, and a file that is made in it.
fn made(args: &[&str]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    let output = path.display().to_string();
    let (done, said) = fresco(&[&["uv"], args, &["-o", &output]].concat());
    assert!(done, "{said}");
    (folder, path)
}

fn surfaces(path: impl AsRef<Path>) -> GltfSurfaces {
    load_surfaces(path.as_ref(), Some(0)).unwrap()
}

fn primitives(file: &GltfSurfaces) -> impl Iterator<Item = &PrimitiveSurface> {
    file.meshes.iter().flat_map(|mesh| &mesh.primitives)
}

fn corners<T: Copy>(values: &[T], triangle: [u32; 3]) -> [T; 3] {
    triangle.map(|v| values[v as usize])
}

#[test]
fn meshes_get_coordinates_in_metres_and_stay_what_they_were() {
    let scene = asset("scenes/cornell_box.glb");
    let (_folder, path) = made(&[&scene, "--size", "0.5"]);
    let (before, after) = (surfaces(&scene), surfaces(path));
    let mut along_axes = 0;
    for (old, new) in primitives(&before).zip(primitives(&after)) {
        assert!(old.uvs.is_empty());
        assert_eq!(new.uvs.len(), new.positions.len());
        assert_eq!(old.triangles.len(), new.triangles.len());
        for (&was, &is) in old.triangles.iter().zip(&new.triangles) {
            let [a, b, c] = corners(&new.positions, is);
            assert_eq!(corners(&old.positions, was), [a, b, c]);
            assert_eq!(corners(&old.normals, was), corners(&new.normals, is));
            let [u, v, w] = corners(&new.uvs, is);
            let normal = (b - a).cross(c - a);
            let on_map = 0.25 * (v - u).perp_dot(w - u).abs();
            let share = on_map / normal.length();
            assert!((0.57..1.001).contains(&share), "{share}");
            if normal.abs().max_element() > 0.9999 * normal.length() {
                along_axes += 1;
                assert!((share - 1.0).abs() < 1e-4, "{share}");
            }
        }
    }
    assert!(along_axes >= 12, "{along_axes}");
}

#[test]
fn coordinates_that_are_there_stay_unless_they_are_to_go() {
    let scene = asset("scenes/relief.glb");
    let before = surfaces(&scene);
    let uvs = |file: &GltfSurfaces| -> Vec<Vec<Vec2>> {
        primitives(file).map(|p| p.uvs.clone()).collect()
    };
    let (_folder, kept) = made(&[&scene]);
    assert_eq!(uvs(&surfaces(kept)), uvs(&before));
    let (_folder, replaced) = made(&[&scene, "--replace", "--only", "Ball"]);
    let replaced = surfaces(replaced);
    for (old, new) in before.meshes.iter().zip(&replaced.meshes) {
        let same = old.primitives[0].uvs == new.primitives[0].uvs;
        assert_eq!(same, old.name != "Ball", "{}", old.name);
    }
}

#[test]
fn nothing_is_smeared_round_a_ball() {
    let scene = asset("scenes/relief.glb");
    let args = ["--projection", "sphere", "--repeat", "3,2", "--replace"];
    let (_folder, path) = made(&[&[scene.as_str(), "--only", "Ball"], &args[..]].concat());
    let file = surfaces(path);
    let ball = file.meshes.iter().find(|mesh| mesh.name == "Ball").unwrap();
    let ball = &ball.primitives[0];
    let middle = {
        let low = ball.positions.iter().copied().reduce(Vec3::min).unwrap();
        let high = ball.positions.iter().copied().reduce(Vec3::max).unwrap();
        0.5 * (low + high)
    };
    for &triangle in &ball.triangles {
        let uvs = corners(&ball.uvs, triangle);
        let at = corners(&ball.positions, triangle);
        let across = |k: usize| (uvs[k].x - uvs[(k + 1) % 3].x).abs();
        assert!((0..3).all(|k| across(k) < 1.0), "{uvs:?}");
        for (uv, at) in uvs.iter().zip(at) {
            let latitude = ((at - middle).normalize().y).acos() / std::f32::consts::PI;
            assert!((uv.y - 2.0 * latitude).abs() < 1e-3, "{uv} at {at}");
        }
    }
}

/// From a mesh that nothing could be laid on to relief.
#[test]
fn what_had_no_coordinates_can_be_displaced() {
    let scene = asset("scenes/cornell_box.glb");
    let map = asset("textures/bricks.png");
    let (folder, path) = made(&[&scene]);
    let output = folder.path().join("relief.glb").display().to_string();
    let displace = |scene: &str| {
        let fixed = ["--scale", "0.02", "--edge", "0.1", "--only", "Short block"];
        let args = ["displace", scene, "--map", &map, "-o", &output];
        fresco(&[&args[..], &fixed[..]].concat())
    };
    let (done, said) = displace(&scene);
    assert!(!done && said.contains("fresco uv"), "{said}");
    let (done, said) = displace(&path.display().to_string());
    assert!(done, "{said}");
    assert!(said.contains("Short block: 640 triangles became"), "{said}");
}

#[test]
fn what_makes_no_sense_is_told_and_nothing_is_written() {
    let scene = asset("scenes/cornell_box.glb");
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.glb").display().to_string();
    for (args, part) in [
        (&[&*scene, "--size", "1,2", "-o", &output][..], "one number"),
        (&[&*scene, "--only", "sofa", "-o", &output], "Short block"),
        (&[&*scene, "-o", &scene], "overwritten"),
        (&[&*scene, "--size", "0", "-o", &output], "--size"),
        (&["no.glb", "-o", &output], "no.glb"),
    ] {
        let (done, said) = fresco(&[&["uv"], args].concat());
        assert!(!done && said.contains(part), "{args:?}: {said}");
        assert!(!Path::new(&output).exists());
    }
}

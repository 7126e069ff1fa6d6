//! How good the truth is.

use std::path::Path;
use std::sync::OnceLock;

use bevy_fresco::gltf::load;
use bevy_fresco::radiosity::{BakeSettings, bake};
use glam::{DVec3, Vec3, dvec3, vec3};

use crate::known::direct::Direct;
use crate::known::error::{Sample, judge, luminance, measure, samples};
use crate::known::layout::{Layout, Source, ground, solid};
use crate::known::scenes::{CARE, lit_scenes};
use crate::known::truth::{Care, Truth};

/// A scene and its light.
pub(crate) struct Known {
    pub(crate) layout: Layout,
    pub(crate) truth: Truth,
}

impl Known {
    pub(crate) fn new(layout: Layout, care: Care) -> Self {
        let truth = Truth::find(&layout, care).unwrap();
        Self { layout, truth }
    }
}

/// One of [`lit_scenes`], its truth found once for all tests.
pub(crate) fn known(scene: usize) -> &'static Known {
    static KNOWN: [OnceLock<Known>; 5] = [const { OnceLock::new() }; 5];
    KNOWN[scene].get_or_init(|| {
        let layout = lit_scenes()[scene].clone();
        Known::new(layout, CARE)
    })
}

/// The same points for all that is compared on a scene, spread evenly.
fn evenly(layout: &Layout, points: usize) -> Vec<Sample> {
    let scene = layout.scene();
    let settings = BakeSettings {
        elements: 100,
        ..BakeSettings::DRAFT
    };
    let baked = bake(&scene.clone().validate().unwrap(), &settings, &()).unwrap();
    samples(layout, &scene, &baked, points)
}

/// Two halves of the bakes that bounced light is the mean of: half their difference is the error
/// that chance leaves in it.
#[test]
fn chance_leaves_a_few_thousandths() {
    for scene in 0..5 {
        let Known { layout, truth } = known(scene);
        let (mut square, mut sum, mut area) = (0.0, 0.0, 0.0);
        for s in evenly(layout, 4000) {
            let Some(light) = truth.at(s.face, s.position) else {
                continue;
            };
            let [a, b] = truth.bounced(s.face, s.position).unwrap();
            square += s.area * (0.5 * luminance(a - b)).powi(2);
            sum += s.area * luminance(light);
            area += s.area;
        }
        let noise = (square / area).sqrt() / (sum / area);
        eprintln!("{}: {noise:.4}", layout.name);
        assert!(noise < 0.003, "{}: {noise}", layout.name);
    }
}

/// The Cornell box against Mitsuba: see the file for how its points were made. Measured 0.8 %, of
/// which 0.4 % are its own noise; half of the rest is on the ceiling within 15 cm of the lamp's
/// casing, where light falls off faster than the truth has vertices.
#[test]
fn the_cornell_box_agrees_with_mitsuba() {
    let Known { layout, truth } = known(4);
    let asset = load(Path::new("assets/scenes/cornell_box.glb"))
        .unwrap()
        .scene;
    let (mut square, mut gain, mut sum, mut count) = (0.0, 0.0, 0.0, 0);
    let lines = include_str!("../data/cornell_box_mitsuba.csv").lines();
    for line in lines.filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        let object = asset.objects.iter().find(|o| o.name == fields[0]).unwrap();
        let corners = object.triangles[number(1) as usize];
        let [a, b, c] = corners.map(|v| object.positions[v as usize].as_dvec3());
        let position = a + (b - a) * number(2) + (c - a) * number(3);
        let face = face_at(layout, fields[0], position);
        let known = luminance(DVec3::from_array([4, 5, 6].map(number)));
        let off = luminance(truth.at(face, position).unwrap()) - known;
        (square, gain, sum, count) = (square + off * off, gain + off, sum + known, count + 1);
    }
    let (count, mean) = (f64::from(count), sum / f64::from(count));
    let (rmse, gain) = ((square / count).sqrt() / mean, gain / sum);
    eprintln!("relative RMSE {rmse:.4}, gain {gain:.4}");
    assert!(rmse < 0.009, "relative RMSE {rmse}");
    assert!(gain.abs() < 0.003, "gain {gain}");
}

/// The face of a part that a point lies on.
fn face_at(layout: &Layout, part: &str, point: DVec3) -> usize {
    let polygons = layout.polygons();
    let of_part = layout.faces().enumerate();
    let mut faces = of_part.filter(|(_, (p, _))| layout.parts[*p].name == part);
    let on = |f: usize| polygons[f].height(point).abs() < 1e-4 && polygons[f].depth(point) > -1e-4;
    faces.find(|&(f, _)| on(f)).unwrap().0
}

/// A floor alone: the cosine of the sun, the inverse square of a bulb, the form factor of a panel.
#[test]
fn direct_light_of_a_floor_is_known() {
    let low = vec3(-2.0, 0.0, -2.0);
    let floor = Layout::new("floor").with("floor", Vec3::ONE, &[ground(low, -low)]);
    let light = |source: Source, at: DVec3| {
        let direct = Direct::new(&floor.clone().lit_by(source));
        direct.at(at, DVec3::Y).x
    };
    let sun = Source::Sun {
        direction: vec3(3.0, -4.0, 0.0),
        light: Vec3::ONE,
    };
    assert!((light(sun, dvec3(0.3, 0.0, 0.2)) - 0.8).abs() < 1e-7);
    let bulb = Source::Bulb {
        position: vec3(0.0, 3.0, 4.0),
        light: Vec3::ONE,
    };
    assert!((light(bulb, DVec3::ZERO) - 0.6 / 25.0).abs() < 1e-7);
    let [_, corners, ..] = solid(vec3(-1.0, 1.0, -1.0), vec3(1.0, 1.0, 1.0));
    let panel = Source::Panel {
        corners,
        radiance: Vec3::ONE,
    };
    // A point under the corner of a unit square at distance 1 (Howell's catalogue, C-11), four
    // times.
    let root = 0.5_f64.sqrt();
    let known = 4.0 * 2.0 * root * root.atan() / std::f64::consts::TAU;
    assert!((light(panel, DVec3::ZERO) - known).abs() < 1e-6);
    // A board over one half leaves the other.
    let board = ground(vec3(-2.0, 0.5, -2.0), vec3(0.0, 0.5, 2.0));
    let half = Direct::new(&floor.with("board", Vec3::ONE, &[board]).lit_by(panel));
    assert!((half.at(DVec3::ZERO, DVec3::Y).x - 0.5 * known).abs() < 1e-6);
}

/// Truth as a bake would be if it were right, at the light of each face, is no error; a tenth more
/// light than is true is an error of a tenth of the root of the mean square.
#[test]
fn errors_are_found() {
    let Known { layout, truth } = known(1);
    let mut points = evenly(layout, 2000);
    points.retain(|s| truth.at(s.face, s.position).is_some());
    for s in &mut points {
        s.found = luminance(truth.at(s.face, s.position).unwrap());
    }
    assert!(judge(truth, &points).rmse < 1e-12);
    let (mut square, mut sum, mut area) = (0.0, 0.0, 0.0);
    for s in &mut points {
        (square, sum, area) = (
            square + s.area * s.found * s.found,
            sum + s.area * s.found,
            area + s.area,
        );
        s.found *= 1.1;
    }
    let off = judge(truth, &points);
    let known = 0.1 * (square / area).sqrt() / (sum / area);
    assert!((off.rmse - known).abs() < 1e-9 && (off.gain - 0.1).abs() < 1e-9);
    assert!((off.mean - sum / area).abs() < 1e-9);
}

/// Errors get smaller with edges, and samples say the same whether they are many or few.
#[test]
fn finer_meshes_have_less_error() {
    let Known { layout, truth } = known(1);
    let scene = layout.scene().validate().unwrap();
    let off = [1.0, 0.5, 0.25].map(|edge| {
        let settings = BakeSettings {
            max_edge: Some(edge),
            refine: false,
            ..BakeSettings::BALANCED
        };
        let baked = bake(&scene, &settings, &()).unwrap();
        let [few, many] = [4000, 40_000].map(|n| measure(layout, truth, &baked, n).rmse);
        assert!((few / many - 1.0).abs() < 0.15, "{edge}: {few} {many}");
        many
    });
    assert!(off[0] > 1.3 * off[1] && off[1] > 1.3 * off[2], "{off:?}");
}

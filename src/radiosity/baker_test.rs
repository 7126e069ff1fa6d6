//! Bakes that resume against bakes from nothing: every kind of change, one by one and many in a
//! row.

use glam::{Affine2, DVec3, Quat, Vec2, Vec3, Vec4};

use super::baker::Baker;
use super::sampling::{hash, unit_float};
use super::{
    AlphaMode, Bake, BakeSettings, DirectLight, Light, LightKind, Material, MaterialId, Object,
    Report, Scene, Texture, TextureId, TextureRef, Wrap, bake,
};

const SETTINGS: BakeSettings = BakeSettings {
    elements: 1500,
    element_rays: 32,
    gather_rays: 16,
    samples_per_vertex: 4.0,
    emitter_rays: 8,
    solver_tolerance: 1e-4,
    refine: false,
    directional: true,
    ..BakeSettings::DRAFT
};

/// The quad `a`, `a + u`, `a + u + v`, `a + v` in `n × n` cells, facing `u × v`.
pub(super) fn quad(key: u64, [a, u, v]: [Vec3; 3], n: u32, material: u32) -> Object {
    let mut object = Object {
        name: format!("object {key}"),
        key,
        material: MaterialId(material),
        uvs: vec![Vec::new()],
        ..Object::default()
    };
    for i in 0..=n {
        for j in 0..=n {
            let (s, t) = (i as f32 / n as f32, j as f32 / n as f32);
            object.positions.push(a + u * s + v * t);
            object.normals.push(u.cross(v));
            object.uvs[0].push(Vec2::new(s, t));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let k = i * (n + 1) + j;
            object.triangles.push([k, k + n + 1, k + n + 2]);
            object.triangles.push([k, k + n + 2, k + 1]);
        }
    }
    object
}

/// A cube of flat faces.
fn cube(key: u64, center: Vec3, side: f32, material: u32) -> Object {
    let mut cube = Object {
        name: format!("cube {key}"),
        key,
        material: MaterialId(material),
        ..Object::default()
    };
    for i in 0..8_u32 {
        let corner = Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        cube.positions.push(center + (corner - 0.5) * side);
    }
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        cube.triangles.push([a, b, c]);
        cube.triangles.push([a, c, d]);
    }
    cube
}

fn paint(r: f32, g: f32, b: f32) -> Material {
    Material {
        base_color: Vec4::new(r, g, b, 1.0),
        ..Material::default()
    }
}

fn stripes(first: u8) -> Texture {
    Texture {
        width: 8,
        height: 1,
        texels: (0..8)
            .map(|i| {
                if i % 2 == 0 {
                    [first; 4]
                } else {
                    [60, 120, 200, 80]
                }
            })
            .collect(),
        wrap: [Wrap::Repeat; 2],
        ..Texture::default()
    }
}

/// A room with one side open to sky and sun, a lamp below the ceiling, two cubes, a masked sheet.
pub(super) fn room() -> Scene {
    let [x, y, z] = Vec3::AXES;
    let mut sheet = paint(0.8, 0.8, 0.8);
    sheet.alpha = AlphaMode::Mask(0.5);
    sheet.double_sided = true;
    let image = TextureRef {
        texture: TextureId(0),
        uv_set: 0,
        transform: Affine2::IDENTITY,
    };
    sheet.base_color_texture = Some(image);
    let mut poster = paint(1.0, 1.0, 1.0);
    poster.base_color_texture = Some(image);
    let mut lamp = paint(0.0, 0.0, 0.0);
    lamp.emissive = Vec3::new(60.0, 50.0, 40.0);
    Scene {
        objects: vec![
            quad(1, [Vec3::ZERO, z * 3.0, x * 4.0], 6, 0),
            quad(2, [y * 2.5, x * 4.0, z * 3.0], 6, 0),
            quad(3, [x * 4.0, z * 3.0, y * 2.5], 6, 1),
            quad(4, [Vec3::ZERO, x * 4.0, y * 2.5], 6, 4),
            quad(5, [z * 3.0, y * 2.5, x * 4.0], 6, 2),
            quad(6, [Vec3::new(2.0, 2.4, 1.5), x * 0.4, z * 0.4], 1, 3),
            cube(7, Vec3::new(1.3, 0.5, 1.0), 0.7, 1),
            cube(8, Vec3::new(2.8, 0.4, 2.0), 0.6, 2),
            quad(9, [Vec3::new(0.6, 1.0, 0.8), x * 0.9, z * 0.9], 2, 5),
        ],
        materials: vec![
            paint(0.7, 0.7, 0.7),
            paint(0.7, 0.2, 0.1),
            paint(0.1, 0.6, 0.2),
            lamp,
            poster,
            sheet,
        ],
        textures: vec![stripes(250)],
        lights: vec![
            Light {
                power: Vec3::new(300.0, 280.0, 240.0),
                kind: LightKind::Point {
                    position: Vec3::new(3.2, 1.8, 0.6),
                    range: 20.0,
                },
                key: 100,
                ..Light::default()
            },
            Light {
                power: Vec3::splat(20.0),
                kind: LightKind::Directional {
                    direction: Vec3::new(1.0, -0.7, 0.2),
                },
                key: 101,
                ..Light::default()
            },
            Light {
                power: Vec3::splat(120.0),
                kind: LightKind::Rect {
                    position: Vec3::new(1.0, 2.3, 2.4),
                    direction: -y,
                    right: x,
                    width: 0.6,
                    height: 0.3,
                    range: 20.0,
                },
                key: 102,
                ..Light::default()
            },
        ],
        sky: Vec3::new(1.0, 1.5, 2.0),
        origin: DVec3::ZERO,
    }
}

/// Largest difference of vertex light and of its gradients, relative to the brightest.
pub(super) fn difference(a: &Bake, b: &Bake) -> f32 {
    let light = |b: &Bake| -> Vec<Vec3> {
        b.objects
            .iter()
            .flat_map(|o| [&o.light[..], &o.gradient])
            .flatten()
            .copied()
            .collect()
    };
    let (a, b) = (light(a), light(b));
    assert_eq!(a.len(), b.len());
    let brightest = a.iter().map(|v| v.max_element()).fold(1e-6, f32::max);
    (a.iter().zip(&b))
        .map(|(p, q)| (*p - *q).abs().max_element())
        .fold(0.0, f32::max)
        / brightest
}

/// The same, root of the mean square relative to the mean.
fn noise(a: &Bake, b: &Bake) -> f32 {
    let light = |b: &Bake| -> Vec<f32> {
        let all = b.objects.iter().flat_map(|o| o.light.iter());
        all.map(|l| l.element_sum()).collect()
    };
    let (a, b) = (light(a), light(b));
    let mean = b.iter().sum::<f32>() / b.len() as f32;
    let square = a.iter().zip(&b).map(|(p, q)| (p - q).powi(2)).sum::<f32>();
    (square / b.len() as f32).sqrt() / mean
}

/// Holds what the baker resumed to against a bake from nothing with the same plan: each ray must
/// have met the same, and vertex light must agree within the solver's tolerance.
fn check(baker: &Baker, resumed: &Bake, what: &str) {
    let (scratch, stages) = baker.scratch().unwrap();
    assert!(
        baker.stages().unwrap().traced.hits() == stages.traced.hits(),
        "{what}: rays of elements differ"
    );
    assert!(
        baker.stages().unwrap().same_gathered(&stages),
        "{what}: rays of samples differ"
    );
    let apart = difference(resumed, &scratch);
    let allowed = 20.0 * baker.settings().solver_tolerance;
    assert!(apart <= allowed, "{what}: {apart} apart");
}

type Edit = fn(&mut Scene);
type Did = fn(&Report) -> bool;

pub(super) fn moved(object: &mut Object, by: Vec3) {
    object.positions.iter_mut().for_each(|p| *p += by);
}

fn turned(object: &mut Object, angle: f32, scale: Vec3) {
    let center = object.positions.iter().sum::<Vec3>() / object.positions.len() as f32;
    for p in &mut object.positions {
        *p = center + Quat::from_rotation_y(angle) * ((*p - center) * scale);
    }
}

fn no_rays(r: &Report) -> bool {
    r.work.rays() == 0 && r.work.hierarchy_builds == 0 && r.work.cross_validations == 0
}

fn lights_only(r: &Report) -> bool {
    r.work.light_rays > 0 && r.work.element_rays == 0 && r.work.hierarchy_builds == 0
}

/// Some rays, but nowhere near all (of 1500 × 32 or more).
fn some_rays(r: &Report) -> bool {
    let elements = r.counts.elements * 32;
    r.work.hierarchy_builds == 1
        && r.work.element_rays > 0
        && r.work.element_rays < elements * 2 / 3
}

const EDITS: [(&str, Edit, Did); 29] = [
    (
        "nothing",
        |_| (),
        |r| r.work == super::Work::default() && r.stages.is_empty(),
    ),
    (
        "light colour",
        |s| s.lights[0].power = Vec3::new(10.0, 300.0, 20.0),
        no_rays,
    ),
    ("light off", |s| s.lights[1].power = Vec3::ZERO, no_rays),
    (
        "light on again",
        |s| s.lights[1].power = Vec3::splat(25.0),
        no_rays,
    ),
    (
        "light moved",
        |s| {
            s.lights[0].kind = LightKind::Point {
                position: Vec3::new(3.0, 1.2, 0.9),
                range: 20.0,
            }
        },
        lights_only,
    ),
    (
        "sun turned",
        |s| {
            s.lights[1].kind = LightKind::Directional {
                direction: Vec3::new(1.0, -0.4, -0.2),
            }
        },
        lights_only,
    ),
    (
        "light added",
        |s| {
            s.lights.insert(
                0,
                Light {
                    power: Vec3::splat(50.0),
                    key: 103,
                    kind: LightKind::Spot {
                        position: Vec3::new(2.0, 2.0, 2.5),
                        direction: Vec3::new(0.2, -1.0, -0.3),
                        inner_angle: 0.3,
                        outer_angle: 0.7,
                        range: 9.0,
                    },
                    ..Light::default()
                },
            );
        },
        lights_only,
    ),
    (
        "light removed",
        |s| {
            s.lights.remove(1);
        },
        |r| r.work.element_rays == 0 && r.work.light_rays == 0,
    ),
    (
        "realtime",
        |s| s.lights[0].direct = DirectLight::Realtime,
        |r| no_rays(r) && r.work.sweeps == 0,
    ),
    (
        "baked",
        |s| s.lights[0].direct = DirectLight::Baked,
        |r| no_rays(r) && r.work.sweeps == 0,
    ),
    ("sky", |s| s.sky = Vec3::new(3.0, 2.0, 1.0), no_rays),
    (
        "reflectance",
        |s| s.materials[1].base_color = Vec4::new(0.2, 0.3, 0.8, 1.0),
        no_rays,
    ),
    (
        "emission colour",
        |s| s.materials[3].emissive = Vec3::new(20.0, 50.0, 90.0),
        no_rays,
    ),
    (
        "emission off",
        |s| s.materials[3].emissive = Vec3::ZERO,
        |r| r.work.hierarchy_builds == 0,
    ),
    (
        "emission on",
        |s| s.materials[3].emissive = Vec3::splat(70.0),
        |r| r.work.hierarchy_builds == 0 && r.work.emitter_rays > 0,
    ),
    (
        "texture swapped",
        |s| s.textures.push(stripes(120)),
        no_rays,
    ),
    (
        "texture used",
        |s| s.materials[4].base_color_texture.as_mut().unwrap().texture = TextureId(1),
        no_rays,
    ),
    (
        "mask",
        |s| s.materials[5].alpha = AlphaMode::Mask(0.2),
        some_rays,
    ),
    (
        "veil",
        |s| s.materials[5].alpha = AlphaMode::Blend,
        some_rays,
    ),
    (
        "one-sided",
        |s| s.materials[5].double_sided = false,
        some_rays,
    ),
    (
        "object moved",
        |s| moved(&mut s.objects[6], Vec3::new(0.2, 0.1, 0.4)),
        some_rays,
    ),
    (
        "object turned",
        |s| turned(&mut s.objects[7], 0.5, Vec3::ONE),
        some_rays,
    ),
    (
        "object mirrored",
        |s| turned(&mut s.objects[7], 0.1, Vec3::new(-1.1, 1.2, 0.9)),
        some_rays,
    ),
    (
        "object added",
        |s| {
            s.objects
                .insert(2, cube(10, Vec3::new(2.2, 1.4, 0.8), 0.4, 0));
        },
        some_rays,
    ),
    (
        "object removed",
        |s| {
            s.objects.remove(7);
        },
        some_rays,
    ),
    (
        "lamp moved",
        |s| moved(&mut s.objects[6], Vec3::new(-0.5, -0.1, 0.0)),
        |r| r.work.hierarchy_builds == 1 && r.work.emitter_rays > 0,
    ),
    (
        "mesh edited",
        |s| s.objects[7].positions[3].y += 0.3,
        some_rays,
    ),
    ("no casting", |s| s.objects[7].casts = false, some_rays),
    (
        "no receiving, no reflecting",
        |s| {
            s.objects[8].receives = false;
            s.objects[4].reflects = false;
        },
        |r| r.work.element_rays == 0 && r.work.light_rays == 0,
    ),
];

#[test]
fn every_kind_of_change_redoes_its_part_and_no_other() {
    let mut baker = Baker::new(SETTINGS);
    let mut scene = room();
    baker.bake(scene.clone(), &()).unwrap();
    for (what, edit, did) in EDITS {
        edit(&mut scene);
        let resumed = baker.bake(scene.clone(), &()).unwrap();
        assert!(did(&resumed.report), "{what}: {:?}", resumed.report.work);
        check(&baker, &resumed, what);
        let fresh = bake(&scene.clone().validate().unwrap(), &SETTINGS, &()).unwrap();
        let noise = noise(&resumed, &fresh);
        assert!(noise < 0.08, "{what}: noise {noise}");
    }
}

/// One of many small edits.
fn random_edit(scene: &mut Scene, i: u32) {
    let random = |k: u32| unit_float(hash(hash(77, i), k));
    let anywhere = || {
        Vec3::new(
            0.6 + 2.6 * random(1),
            0.5 + 1.2 * random(2),
            0.5 + 1.8 * random(3),
        )
    };
    let object = 5 + (random(4) * (scene.objects.len() - 5) as f32) as usize;
    match hash(i, 5) % 9 {
        0 => scene.lights[0].power = anywhere() * 100.0,
        1 => {
            scene.lights[0].kind = LightKind::Point {
                position: anywhere(),
                range: 20.0,
            }
        }
        2 => scene.materials[1].base_color = anywhere().min(Vec3::ONE).extend(1.0),
        3 => scene.materials[3].emissive = anywhere() * 20.0,
        4 => scene
            .objects
            .push(cube(1000 + u64::from(i), anywhere(), 0.3, i % 3)),
        5 if scene.objects.len() > 7 => drop(scene.objects.remove(object)),
        6 => turned(&mut scene.objects[object], random(6), Vec3::ONE),
        7 => scene.materials[5].alpha = AlphaMode::Mask(random(7)),
        _ => moved(&mut scene.objects[object], (anywhere() - 1.2) * 0.2),
    }
}

#[test]
fn a_hundred_edits_do_not_drift() {
    let mut baker = Baker::new(SETTINGS);
    let mut scene = room();
    for i in 0..100 {
        random_edit(&mut scene, i);
        let resumed = baker.bake(scene.clone(), &()).unwrap();
        if i % 10 == 9 {
            check(&baker, &resumed, &format!("edit {i}"));
        }
    }
}

#[test]
fn there_and_back_is_where_it_was() {
    let mut baker = Baker::new(SETTINGS);
    let scene = room();
    let first = baker.bake(scene.clone(), &()).unwrap();
    let hits = baker.stages().unwrap().traced.clone();
    let mut other = scene.clone();
    moved(&mut other.objects[6], Vec3::new(0.3, 0.0, 0.5));
    other.objects.push(cube(11, Vec3::splat(1.8), 0.3, 0));
    baker.bake(other, &()).unwrap();
    assert!(baker.stages().unwrap().traced.hits() != hits.hits());
    let back = baker.bake(scene, &()).unwrap();
    assert!(baker.stages().unwrap().traced.hits() == hits.hits());
    assert!(difference(&first, &back) <= 20.0 * SETTINGS.solver_tolerance);
}

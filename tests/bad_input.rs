//! Bad input gives an error that names the thing, or a repair that is counted; never a panic or NaN.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use bevy_fresco::radiosity::{
    BakeError, BakeSettings, FormFactors, Light, LightKind, MaterialId, Object, Scene, SceneError,
    bake,
};
use common::{grey, quad, room, scene, values};
use glam::{DVec3, Vec3};
use proptest::prelude::*;

fn draft() -> BakeSettings {
    BakeSettings {
        elements: 200,
        element_rays: 8,
        gather_rays: 4,
        emitter_rays: 2,
        samples_per_vertex: 2.0,
        refine: false,
        ..BakeSettings::DRAFT
    }
}

/// A room with a luminous ceiling.
fn lit_room() -> Scene {
    scene(
        room(Vec3::ONE, 2, [0, 1, 0, 0, 0, 0]),
        vec![grey(0.5, 0.0), grey(0.5, 1.0)],
    )
}

fn message(result: Result<impl std::fmt::Debug, SceneError>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn empty_scenes() {
    assert_eq!(Scene::default().validate().unwrap_err(), SceneError::Empty);
    let mut no_area = lit_room();
    no_area.objects.truncate(1);
    for p in &mut no_area.objects[0].positions {
        *p = Vec3::ONE;
    }
    assert_eq!(no_area.validate().unwrap_err(), SceneError::Empty);
}

#[test]
fn no_light_is_an_error_that_says_what_to_add() {
    let dark = scene(room(Vec3::ONE, 1, [0; 6]), vec![grey(0.5, 0.0)]);
    let text = message(dark.validate());
    assert!(
        text.contains("emits light") && text.contains("sky"),
        "{text}"
    );
}

#[test]
fn non_finite_positions_name_object_triangle_and_vertex() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut s = lit_room();
        s.objects[3].positions[4].y = bad;
        let text = message(s.validate());
        assert!(
            text.contains("high x") && text.contains("triangle 0") && text.contains("vertex 4"),
            "{text}"
        );
    }
}

#[test]
fn unused_vertices_may_be_anything() {
    let mut s = lit_room();
    s.objects[0].positions.push(Vec3::NAN);
    s.objects[0].normals.push(Vec3::NAN);
    let bake = bake(&s.validate().unwrap(), &draft(), &()).unwrap();
    assert!(values(&bake).iter().all(|v| v.is_finite()));
}

#[test]
fn indices_out_of_range_name_the_triangle() {
    let mut s = lit_room();
    s.objects[1].triangles[2][1] = 99;
    let text = message(s.validate());
    assert!(
        text.contains("ceiling") && text.contains("triangle 2") && text.contains("99"),
        "{text}"
    );
    let mut s = lit_room();
    s.objects[1].material = MaterialId(7);
    assert!(message(s.validate()).contains("material 7"));
}

#[test]
fn attributes_of_the_wrong_length() {
    let mut s = lit_room();
    s.objects[0].normals.pop();
    assert!(message(s.validate()).contains("normals has 8 entries for 9 vertices"));
}

#[test]
fn numbers_that_are_none() {
    let mut s = lit_room();
    s.materials[1].emissive.x = f32::NAN;
    assert!(message(s.validate()).contains("emissive"));
    let mut s = lit_room();
    s.lights.push(Light {
        name: "sun".into(),
        power: Vec3::ONE,
        kind: LightKind::Directional {
            direction: Vec3::ZERO,
        },
        ..Light::default()
    });
    assert!(message(s.validate()).contains("light \"sun\": the direction"));
}

#[test]
fn flat_and_duplicate_triangles_are_counted_and_change_nothing() {
    let clean = bake(
        &lit_room().validate().unwrap(),
        &BakeSettings {
            refine: false,
            ..BakeSettings::DRAFT
        },
        &(),
    )
    .unwrap();
    let mut s = lit_room();
    for object in &mut s.objects {
        let first = object.triangles[0];
        object.triangles.push([first[0], first[0], first[1]]);
        object.triangles.push([first[1], first[2], first[0]]);
    }
    let s = s.validate().unwrap();
    assert_eq!(
        s.notes()
            .iter()
            .filter(|n| n.contains("without area"))
            .count(),
        6
    );
    assert_eq!(s.notes().iter().filter(|n| n.contains("twice")).count(), 6);
    assert_eq!(s.triangle_count(), 48);
    let mended = bake(
        &s,
        &BakeSettings {
            refine: false,
            ..BakeSettings::DRAFT
        },
        &(),
    )
    .unwrap();
    let mean = |b| values(b).iter().sum::<f32>() / values(b).len() as f32;
    assert!((mean(&clean) / mean(&mended) - 1.0).abs() < 0.02);
}

#[test]
fn reflectance_of_one_is_clamped_and_counted() {
    let s = scene(
        room(Vec3::ONE, 2, [0, 1, 0, 0, 0, 0]),
        vec![grey(1.0, 0.0), grey(7.0, 1.0)],
    );
    let s = s.validate().unwrap();
    assert!(s.notes().iter().any(|n| n.contains("outside 0..1")));
    let bake = bake(&s, &draft(), &()).unwrap();
    assert!(bake.report.notes.iter().any(|n| n.contains("were clamped")));
    assert!(values(&bake).iter().all(|v| v.is_finite() && *v > 0.0));
}

#[test]
fn settings_out_of_range_name_the_setting() {
    let s = lit_room().validate().unwrap();
    let with = |f: &dyn Fn(&mut BakeSettings)| {
        let mut settings = draft();
        f(&mut settings);
        match bake(&s, &settings, &()) {
            Err(BakeError::Setting(e)) => e.to_string(),
            other => panic!("{other:?}"),
        }
    };
    assert!(with(&|s| s.element_rays = 0).contains("element_rays is 0"));
    assert!(with(&|s| s.max_reflectance = 1.0).contains("max_reflectance"));
    assert!(with(&|s| s.max_edge = Some(f32::NAN)).contains("max_edge"));
    assert!(with(&|s| s.samples_per_vertex = -1.0).contains("samples_per_vertex"));
}

#[test]
fn edges_too_short_to_split_are_refused() {
    let settings = BakeSettings {
        max_edge: Some(1e-6),
        max_memory: u64::MAX,
        ..draft()
    };
    let error = bake(&lit_room().validate().unwrap(), &settings, &()).unwrap_err();
    assert!(matches!(error, BakeError::Split(_)), "{error}");
}

#[test]
fn more_memory_than_allowed_is_refused() {
    let scene = lit_room().validate().unwrap();
    let refused = |settings: &BakeSettings| {
        let error = bake(&scene, settings, &()).unwrap_err();
        assert!(matches!(error, BakeError::Memory { .. }), "{error}");
        error.to_string()
    };
    let pairs = BakeSettings {
        elements: 200_000,
        form_factors: FormFactors::Analytic { visibility_rays: 1 },
        ..draft()
    };
    let text = refused(&pairs);
    assert!(
        text.contains("max_memory") && text.contains("elements"),
        "{text}"
    );
    refused(&BakeSettings {
        max_memory: 1 << 20,
        ..draft()
    });
}

/// Light does not depend on the unit of length: bit for bit, as long as it is a power of two.
#[test]
fn scale() {
    let reference = values(&bake(&lit_room().validate().unwrap(), &draft(), &()).unwrap());
    for exponent in [-26, -10, 1, 26] {
        let mut s = lit_room();
        for p in s.objects.iter_mut().flat_map(|o| &mut o.positions) {
            *p *= (exponent as f32).exp2();
        }
        let scaled = values(&bake(&s.validate().unwrap(), &draft(), &()).unwrap());
        assert_eq!(scaled, reference, "2^{exponent}");
    }
    for factor in [1e-8, 1e8] {
        let mut s = lit_room();
        for p in s.objects.iter_mut().flat_map(|o| &mut o.positions) {
            *p *= factor;
        }
        let scaled = values(&bake(&s.validate().unwrap(), &draft(), &()).unwrap());
        let mean = |v: &[f32]| v.iter().sum::<f32>() / v.len() as f32;
        assert!(
            (mean(&scaled) / mean(&reference) - 1.0).abs() < 0.02,
            "{factor}"
        );
    }
}

/// A million metres from the origin: the same bits, given as an origin or in coordinates that
/// hold it exactly.
#[test]
fn far_from_the_origin() {
    let reference = values(&bake(&lit_room().validate().unwrap(), &draft(), &()).unwrap());
    let mut s = lit_room();
    s.origin = DVec3::splat(1e6);
    assert_eq!(
        values(&bake(&s.validate().unwrap(), &draft(), &()).unwrap()),
        reference
    );
    let mut s = lit_room();
    for p in s.objects.iter_mut().flat_map(|o| &mut o.positions) {
        *p += Vec3::splat(1e6);
    }
    assert_eq!(
        values(&bake(&s.validate().unwrap(), &draft(), &()).unwrap()),
        reference
    );
}

/// Numbers that break things: zeros of both signs, neighbours in the last place, extremes.
fn nasty() -> impl Strategy<Value = f32> {
    prop_oneof![
        60 => -2.0_f32..2.0,
        16 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 0.5, f32::EPSILON, 1.0 + f32::EPSILON, 1e-20, 1e-38, 1e6, -1e6]),
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, 1e30, f32::MAX, f32::MIN_POSITIVE / 2.0]),
    ]
}

fn vector() -> impl Strategy<Value = Vec3> {
    (nasty(), nasty(), nasty()).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn broken_object() -> impl Strategy<Value = Object> {
    let corners = prop::collection::vec(vector(), 1..12);
    let triangles = prop::collection::vec((0_u32..12, 0_u32..12, 0_u32..12), 0..16);
    (
        corners,
        triangles,
        any::<bool>(),
        0_u32..3,
        prop::collection::vec(vector(), 12),
        0_u32..16,
    )
        .prop_map(|(positions, triangles, smooth, material, normals, slip)| {
            // Mostly within range: an index error would hide all others.
            let n = if slip == 0 {
                12
            } else {
                positions.len() as u32
            };
            Object {
                name: "broken".into(),
                normals: if smooth {
                    normals[..positions.len()].to_vec()
                } else {
                    Vec::new()
                },
                positions,
                triangles: triangles
                    .into_iter()
                    .map(|(a, b, c)| [a % n, b % n, c % n])
                    .collect(),
                material: MaterialId(material % 2),
                ..Object::default()
            }
        })
}

fn broken_light() -> impl Strategy<Value = Light> {
    (vector(), vector(), vector(), nasty(), 0..3).prop_map(
        |(position, direction, power, range, kind)| Light {
            name: "broken".into(),
            power,
            kind: match kind {
                0 => LightKind::Point { position, range },
                1 => LightKind::Spot {
                    position,
                    direction,
                    inner_angle: range * 0.5,
                    outer_angle: range,
                    range,
                },
                _ => LightKind::Directional { direction },
            },
            ..Light::default()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever comes in: an error with words, or finite light that is not negative.
    #[test]
    fn broken_scenes(
        objects in prop::collection::vec(broken_object(), 0..4),
        lights in prop::collection::vec(broken_light(), 0..3),
        colors in prop::collection::vec(nasty(), 8),
        two_sided in any::<bool>(),
        refine in prop::option::of(0.1_f32..1.0),
        in_a_room in any::<bool>(),
    ) {
        let mut s = if in_a_room { lit_room() } else { scene(Vec::new(), vec![grey(0.5, 0.0), grey(0.5, 1.0)]) };
        s.objects.extend(objects);
        s.lights = lights;
        s.materials[0].double_sided = two_sided;
        s.materials[0].base_color.x = colors[0];
        s.materials[1].emissive = Vec3::new(colors[1], colors[2], colors[3]);
        s.materials[1].metallic = colors[4];
        s.sky = Vec3::new(colors[5], colors[6], colors[7]);
        match s.validate() {
            Err(e) => prop_assert!(!e.to_string().is_empty()),
            Ok(valid) => {
                let settings = BakeSettings {
                    max_edge: refine.map(|share| share * valid.bounds().1 as f32),
                    element_rays: 2,
                    gather_rays: 2,
                    elements: 50,
                    ..draft()
                };
                let bake = bake(&valid, &settings, &());
                prop_assert!(bake.is_ok(), "{bake:?}");
                if let Ok(bake) = bake {
                    for light in bake.objects.iter().flat_map(|o| &o.light) {
                        prop_assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
                    }
                    prop_assert!(bake.report.energy.relative_error().is_finite());
                }
            }
        }
    }
}

#[test]
fn a_quad_alone_under_the_sky() {
    let mut s = scene(
        vec![quad("floor", Vec3::ZERO, Vec3::Z, Vec3::X, 1, 0)],
        vec![grey(0.5, 0.0)],
    );
    s.sky = Vec3::splat(2.0);
    let bake = bake(&s.validate().unwrap(), &draft(), &()).unwrap();
    // Uniform radiance L from the whole hemisphere: irradiance / π = L.
    assert!(values(&bake).iter().all(|v| (v - 2.0).abs() < 1e-5));
}

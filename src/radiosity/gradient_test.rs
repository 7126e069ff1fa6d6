//! Gradients of light against closed forms.

use std::f32::consts::{FRAC_PI_3, PI, TAU};

use glam::{DMat3, DVec3, Quat, Vec3, Vec4};

use super::baker_test::quad;
use super::gradient::{bounded, gradient_about_z, gradient_of};
use super::sampling::cosine_hemisphere;
use super::{
    BakeSettings, Light, LightKind, Material, ObjectLight, Scene, bake, local_gradients,
    point_to_polygon, reshade,
};
use crate::mesh::test_meshes::random;

const SETTINGS: BakeSettings = BakeSettings {
    elements: 200,
    refine: false,
    directional: true,
    ..BakeSettings::DRAFT
};

fn numbers<const N: usize>(seed: u32) -> [f32; N] {
    let mut random = random(seed.wrapping_mul(7919));
    [(); N].map(|()| random())
}

fn unit([x, y]: [f32; 2]) -> Vec3 {
    let (z, phi) = (2.0 * x - 1.0, TAU * y);
    let s = (1.0 - z * z).sqrt();
    Vec3::new(s * phi.cos(), s * phi.sin(), z)
}

/// The unit normal +Y turned by `slope` towards an azimuth.
fn turned(slope: f32, azimuth: f32) -> Vec3 {
    let (s, c) = slope.sin_cos();
    Vec3::new(s * azimuth.cos(), c, s * azimuth.sin())
}

/// A black floor around the origin that faces +Y, and what lights it.
fn floor(lights: Vec<LightKind>, sky: f32, lamp: Option<[Vec3; 3]>) -> Scene {
    let black = |emission| Material {
        base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
        emissive: Vec3::splat(emission),
        ..Material::default()
    };
    let ground = [Vec3::new(-0.5, 0.0, -0.5), Vec3::Z, Vec3::X];
    let mut objects = vec![quad(1, ground, 4, 0)];
    objects.extend(lamp.map(|lamp| quad(2, lamp, 1, 1)));
    let light = |kind| Light {
        kind,
        power: Vec3::splat(PI),
        ..Light::default()
    };
    Scene {
        objects,
        materials: vec![black(0.0), black(7.0)],
        lights: lights.into_iter().map(light).collect(),
        sky: Vec3::splat(sky),
        ..Scene::default()
    }
}

/// The floor's light and gradient.
fn baked(scene: Scene) -> ObjectLight {
    let scene = scene.validate().unwrap();
    bake(&scene, &SETTINGS, &()).unwrap().objects.swap_remove(0)
}

/// The least squares around the cone, by summing up.
#[test]
fn gradients_are_the_least_squares_at_their_slope() {
    let slope = 30.0_f32.to_radians();
    for degrees in [0.0_f32, 20.0, 59.0, 61.0, 70.0, 80.0, 88.0] {
        let alpha = degrees.to_radians();
        let (s, z) = alpha.sin_cos();
        let n = 20_000;
        let (mut first, mut mean) = (0.0_f64, 0.0_f64);
        for i in 0..n {
            let phi = TAU * (i as f32 + 0.5) / n as f32;
            let f = (slope.cos() * z + slope.sin() * s * phi.cos()).max(0.0);
            first += f64::from(f * phi.cos()) / f64::from(n);
            mean += f64::from(f) / f64::from(n);
        }
        let across = 2.0 * first / f64::from(slope.sin());
        let up = (f64::from(z) - mean) / f64::from(1.0 - slope.cos());
        let found = gradient_about_z(Vec3::new(s, 0.0, z)) * z;
        let expected = Vec3::new(across as f32, 0.0, up as f32);
        assert!(
            (found - expected).length() < 2e-3,
            "{degrees}: {found} {expected}"
        );
        if degrees < 60.0 {
            assert!(
                (found - Vec3::new(s, 0.0, z)).length() < 1e-5,
                "{degrees}: {found}"
            );
        }
    }
}

#[test]
fn gradients_turn_with_the_normal() {
    for i in 0..100 {
        let [a, b, c, d] = numbers(i);
        let normal = unit([a, b]);
        let local = cosine_hemisphere(c, d);
        let turn = Quat::from_rotation_arc(Vec3::Z, normal);
        let found = gradient_of(normal, turn * local);
        let expected = turn * gradient_about_z(local);
        let scale = expected.length();
        assert!(
            (found - expected).length() < 1e-4 * scale,
            "{found} {expected}"
        );
    }
}

/// Whatever comes in: nothing changes at the normal itself, and nothing is negative or out of bounds.
#[test]
fn light_is_unchanged_at_the_normal_and_bounded_elsewhere() {
    for i in 0..10_000 {
        let [r, g, b, x, y, z, u, v, s, t] = numbers(i);
        let light = Vec3::new(r, g * g, b * b * b) * 100.0;
        let wild = (Vec3::new(x, y, z) - 0.5) * 1e4;
        let (normal, bumped) = (unit([u, v]), unit([s, t]));
        for gradient in [wild, bounded(wild, light)] {
            assert_eq!(reshade(light, gradient, normal, normal), light);
            let shaded = reshade(light, gradient, normal, bumped);
            assert!(shaded.min_element() >= 0.0, "{shaded}");
            assert!((shaded - light * 16.0).max_element() <= 1e-3, "{shaded}");
        }
    }
    assert_eq!(bounded(Vec3::ONE, Vec3::ZERO), Vec3::ZERO);
    assert_eq!(reshade(Vec3::ZERO, Vec3::ONE, Vec3::Z, Vec3::X), Vec3::ZERO);
}

/// `E(n′) = E₀ max(0, n′ · l)`: exact for lamps within 60° of the normal down to 0.4 of the light at the normal, and off
/// by less than 0.2 E₀ beyond as long as they stay above the horizon of the bump. Below that it fades, without a step.
#[test]
fn a_sun_answers_by_the_cosine() {
    for (degrees, limit) in [
        (0.0_f32, 2e-5),
        (40.0, 2e-5),
        (59.0, 2e-5),
        (70.0, 0.1),
        (80.0, 0.2),
    ] {
        let to_sun = turned(degrees.to_radians(), 0.7);
        let sun = LightKind::Directional { direction: -to_sun };
        let lit = baked(floor(vec![sun], 0.0, None));
        let mut worst = 0.0_f32;
        for (light, gradient) in lit.light.iter().zip(&lit.gradient) {
            for i in 0..200 {
                let [a, b] = numbers(i);
                let bumped = turned(a * 0.25 * PI, TAU * b);
                let truth = bumped.dot(to_sun);
                if degrees > 60.0 && truth < 0.0 {
                    continue;
                }
                let told = reshade(*light, *gradient, Vec3::Y, bumped);
                let faint = 0.4 * light.x;
                if degrees < 60.0 && truth < faint {
                    let brighter = told.x > truth && told.x > 0.0;
                    assert!(brighter && told.x < faint, "{told} {truth}");
                    continue;
                }
                let apart = (told - truth.max(0.0)).length() / 3.0_f32.sqrt();
                worst = worst.max(apart);
            }
        }
        assert!(worst < limit, "{degrees}: {worst}");
    }
}

/// A uniform sky over an open floor: the part of it that a slope of θ sees is `(1 + cos θ) / 2`.
#[test]
fn a_sky_answers_by_the_part_that_is_seen() {
    let lit = baked(floor(vec![], 3.0, None));
    for (light, gradient) in lit.light.iter().zip(&lit.gradient) {
        assert!((*light - 3.0).length() < 1e-4, "{light}");
        for slope in [0.0, 0.3, FRAC_PI_3] {
            let bumped = turned(slope, 1.9);
            let told = reshade(*light, *gradient, Vec3::Y, bumped);
            let truth = 1.5 * (1.0 + slope.cos());
            assert!(
                (told.x / truth - 1.0).abs() < 1e-4,
                "{slope}: {told} {truth}"
            );
        }
    }
}

/// Lamps of all kinds, seen within 60° of the normal, where bumps see what Lambert's formula says.
#[test]
fn lamps_answer_by_their_form_factors() {
    let corner = Vec3::new(0.5, 1.2, 0.3);
    let lamp = [corner, Vec3::X * 0.4, Vec3::Z * 0.4];
    let [a, u, v] = lamp;
    let corners = [a, a + u, a + u + v, a + v].map(|p| p.as_dvec3());
    let rect = LightKind::Rect {
        position: a + 0.5 * (u + v),
        direction: -Vec3::Y,
        right: Vec3::X,
        width: 0.4,
        height: 0.4,
        range: f32::INFINITY,
    };
    let place = Vec3::new(0.6, 1.4, -0.2);
    let point = LightKind::Point {
        position: place,
        range: f32::INFINITY,
    };
    // Of unit power: radiance 1 / (π A), or intensity 1 / 4π.
    let area = |at: Vec3, n: Vec3, radiance: f64| {
        (radiance * point_to_polygon(at.as_dvec3(), n.as_dvec3(), &corners)) as f32
    };
    let by_rect = |at: Vec3, n: Vec3| area(at, n, 1.0 / 0.16);
    let by_lamp = |at: Vec3, n: Vec3| area(at, n, 7.0);
    let by_point = |at: Vec3, n: Vec3| {
        let to = place - at;
        PI * n.dot(to.normalize()).max(0.0) / (4.0 * PI * PI * to.length_squared())
    };
    type Truth<'a> = &'a dyn Fn(Vec3, Vec3) -> f32;
    let cases: [(&str, Scene, Truth); 3] = [
        ("rect", floor(vec![rect], 0.0, None), &by_rect),
        ("lamp", floor(vec![], 0.0, Some(lamp)), &by_lamp),
        ("point", floor(vec![point], 0.0, None), &by_point),
    ];
    for (what, scene, truth) in cases {
        let places = scene.objects[0].positions.clone();
        let lit = baked(scene);
        let mut worst = 0.0_f32;
        for (i, at) in (0..).zip(places) {
            let (light, gradient) = (lit.light[i as usize], lit.gradient[i as usize]);
            let [a, b] = numbers(i);
            let bumped = turned(0.5 * a, TAU * b);
            let expected = truth(at, bumped) / truth(at, Vec3::Y);
            let told = reshade(light, gradient, Vec3::Y, bumped).x / light.x;
            worst = worst.max((told / expected - 1.0).abs());
        }
        // Linear light between vertices, and lamps that are asked by few rays.
        assert!(worst < 0.05, "{what}: {worst}");
    }
}

/// Light on the back of a surface: its gradient belongs to the normals of the mesh all the same.
#[test]
fn what_is_lit_from_behind_answers_the_same() {
    let to_sun = turned(0.6, 0.3);
    let sun = LightKind::Directional { direction: -to_sun };
    let front = baked(floor(vec![sun], 0.0, None));
    let mut scene = floor(vec![sun], 0.0, None);
    scene.materials[0].double_sided = true;
    for normal in &mut scene.objects[0].normals {
        *normal = -*normal;
    }
    for t in &mut scene.objects[0].triangles {
        t.swap(1, 2);
    }
    let back = baked(scene);
    let bumped = turned(0.4, 2.0);
    for i in 0..front.light.len() {
        let of = |lit: &ObjectLight, side: f32| {
            let (light, gradient) = (lit.light[i], lit.gradient[i]);
            reshade(light, gradient, Vec3::Y * side, bumped * side)
        };
        let (a, b) = (of(&front, 1.0), of(&back, -1.0));
        assert!((a - b).length() < 1e-5 && a.x > 0.1, "{a} {b}");
    }
}

/// Turned, mirrored and stretched meshes: in the space of the mesh and back.
#[test]
fn gradients_are_found_again_in_world_space() {
    for i in 0..100 {
        let [a, b, c, d, e] = numbers(i);
        let turn = Quat::from_axis_angle(unit([a, b]), TAU * c).as_dquat();
        let size = DVec3::new(0.3 + f64::from(d), -2.0 * f64::from(e) - 0.1, 1.5);
        let world = DMat3::from_quat(turn) * DMat3::from_diagonal(size);
        let gradient = unit([d, e]) * 5.0;
        let local = local_gradients(world, &[gradient]).unwrap()[0];
        let scale = world.determinant().abs().cbrt();
        let back = (world * local.as_dvec3() / scale).as_vec3();
        assert!((back - gradient).length() < 1e-4, "{back} {gradient}");
        // A scene that is turned and scaled later takes its gradients along.
        let later = DMat3::from_rotation_x(1.0) * 7.0;
        let whole = later * world;
        let back = (whole * local.as_dvec3() / whole.determinant().abs().cbrt()).as_vec3();
        let turned = Quat::from_rotation_x(1.0) * gradient;
        assert!((back - turned).length() < 1e-4, "{back} {turned}");
    }
    let flat = DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
    assert_eq!(local_gradients(flat, &[Vec3::X]), None);
}

//! Lights, shadows, transparency and sides, against what can be worked out by hand.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod common;

use bevy_fresco::radiosity::{
    AlphaMode, Bake, BakeSettings, DirectLight, Light, LightKind, Object, Scene, Texture,
    TextureId, TextureRef, bake,
};
use common::{grey, mean_over, quad, room, scene, values};
use glam::{Affine2, Vec2, Vec3};

fn sun(lux: f32, direction: Vec3) -> Light {
    Light {
        name: "sun".into(),
        power: Vec3::splat(lux),
        kind: LightKind::Directional { direction },
        ..Light::default()
    }
}

/// A floor of ±`half` metres at height `y`, facing up.
fn floor(half: f32, y: f32, n: u32, material: u32) -> Object {
    quad(
        "floor",
        Vec3::new(-half, y, -half),
        Vec3::Z * 2.0 * half,
        Vec3::X * 2.0 * half,
        n,
        material,
    )
}

fn run(s: Scene) -> Bake {
    bake(
        &s.validate().unwrap(),
        &BakeSettings {
            refine: false,
            adapt: false,
            ..BakeSettings::BALANCED
        },
        &(),
    )
    .unwrap()
}

#[test]
fn sunlight_falls_with_the_cosine() {
    let mut s = scene(vec![floor(1.0, 0.0, 4, 0)], vec![grey(0.5, 0.0)]);
    s.lights.push(sun(3.0, Vec3::new(1.0, -1.0, 0.0)));
    for v in values(&run(s)) {
        let truth = 3.0 * std::f32::consts::FRAC_1_SQRT_2 / std::f32::consts::PI;
        assert!((v / truth - 1.0).abs() < 1e-4, "{v} for {truth}");
    }
}

#[test]
fn spot_lights_end_at_their_cone() {
    let mut s = scene(vec![floor(2.0, 0.0, 64, 0)], vec![grey(0.5, 0.0)]);
    let (inner, outer) = (0.3_f32, 0.6_f32);
    s.lights.push(Light {
        name: "spot".into(),
        power: Vec3::splat(4.0 * std::f32::consts::PI),
        kind: LightKind::Spot {
            position: Vec3::Y,
            direction: Vec3::NEG_Y,
            inner_angle: inner,
            outer_angle: outer,
            range: f32::INFINITY,
        },
        ..Light::default()
    });
    let positions = s.objects[0].positions.clone();
    for (p, v) in positions.iter().zip(values(&run(s))) {
        let angle = p.length().atan();
        let fade = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos()))
            .clamp(0.0, 1.0)
            .powi(2);
        let truth = fade * angle.cos().powi(3) / std::f32::consts::PI;
        // Cells of 6 cm across a slope of 3 per metre cannot do better at its kinks.
        assert!((v - truth).abs() < 0.015, "at {p}: {v} for {truth}");
    }
}

#[test]
fn a_range_ends_the_light() {
    let mut s = scene(vec![floor(2.0, 0.0, 32, 0)], vec![grey(0.5, 0.0)]);
    s.lights.push(Light {
        name: "lamp".into(),
        power: Vec3::splat(100.0),
        kind: LightKind::Point {
            position: Vec3::Y * 0.5,
            range: 1.0,
        },
        ..Light::default()
    });
    let positions = s.objects[0].positions.clone();
    for (p, v) in positions.iter().zip(values(&run(s))) {
        assert!((v > 0.0) || p.length() > 0.8, "dark within range at {p}");
        // The fit's pull between neighbours reaches a little further.
        assert!(v < 1e-3 || p.length() < 1.1, "lit beyond range at {p}: {v}");
    }
}

/// A small one-sided lamp is, from afar, a point of intensity L A.
#[test]
fn a_tiny_emitter_is_a_point_light() {
    let side = 1e-3;
    let lamp = quad(
        "lamp",
        Vec3::new(0.0, 1.0, 0.0),
        Vec3::X * side,
        Vec3::Z * side,
        1,
        1,
    );
    let mut objects = vec![floor(1.0, 0.0, 16, 0), lamp];
    let positions = objects[0].positions.clone();
    objects.swap(0, 1);
    let bake = run(scene(objects, vec![grey(0.0, 0.0), grey(0.0, 1e6)]));
    for (p, light) in positions.iter().zip(&bake.objects[1].light) {
        let d2 = p.x * p.x + p.z * p.z + 1.0;
        let truth = 1e6 * side * side / (d2 * d2) / std::f32::consts::PI;
        assert!(
            (light.x / truth - 1.0).abs() < 0.015,
            "at {p}: {} for {truth}",
            light.x
        );
    }
}

/// Half of the light passes a surface of alpha 0.5, and half of the holes of a mask.
#[test]
fn transparency_lets_its_share_through() {
    let lit = |material: bevy_fresco::radiosity::Material, texture: Option<Texture>| {
        let mut veil = floor(50.0, 1.0, 1, 1);
        veil.uvs = vec![
            veil.positions
                .iter()
                .map(|p| Vec2::new(p.x, p.z) * 20.0)
                .collect(),
        ];
        let mut s = scene(
            vec![floor(1.0, 0.0, 8, 0), veil],
            vec![grey(0.0, 0.0), material],
        );
        s.textures.extend(texture);
        s.lights.push(sun(std::f32::consts::PI, Vec3::NEG_Y));
        let shape = s.objects[0].clone();
        mean_over(&shape, &run(s).objects[0].light)
    };
    let mut blend = grey(0.0, 0.0);
    blend.base_color.w = 0.5;
    blend.alpha = AlphaMode::Blend;
    let found = lit(blend, None);
    assert!((found - 0.5).abs() < 0.05, "blend {found}");

    let mut mask = grey(0.0, 0.0);
    mask.alpha = AlphaMode::Mask(0.5);
    mask.base_color_texture = Some(TextureRef {
        texture: TextureId(0),
        uv_set: 0,
        transform: Affine2::IDENTITY,
    });
    let stripes = Texture {
        width: 16,
        height: 1,
        texels: (0..16)
            .map(|i| [255, 255, 255, if i < 4 { 255 } else { 0 }])
            .collect(),
        ..Texture::default()
    };
    let found = lit(mask.clone(), Some(stripes));
    assert!((found - 0.75).abs() < 0.05, "mask {found}");
    mask.alpha = AlphaMode::Opaque;
    assert_eq!(
        lit(
            mask,
            Some(Texture {
                width: 1,
                height: 1,
                texels: vec![[255, 255, 255, 0]],
                ..Texture::default()
            })
        ),
        0.0
    );
}

/// A two-room house whose wall is one two-sided sheet: no light on the dark side.
#[test]
fn no_light_leaks_through_a_wall() {
    for thickness in [0.0, 0.01] {
        let mut objects = room(Vec3::ONE, 6, [0, 1, 0, 0, 0, 0]);
        let mut dark = room(Vec3::ONE, 6, [0; 6]);
        for p in dark.iter_mut().flat_map(|o| &mut o.positions) {
            p.x += 1.0 + thickness;
        }
        objects.extend(dark);
        let bake = run(scene(objects, vec![grey(0.5, 0.0), grey(0.5, 1.0)]));
        let brightest = values(&bake).into_iter().fold(0.0, f32::max);
        for object in &bake.objects[6..] {
            for light in &object.light {
                assert!(
                    light.x <= 1e-4 * brightest,
                    "thickness {thickness}: {} leaks",
                    light.x
                );
            }
        }
    }
}

/// Every wall modelled twice, and again with its back: within 1 % of once.
#[test]
fn walls_modelled_twice() {
    let lit = |twins: u32| {
        let mut objects = room(Vec3::ONE, 4, [0, 1, 0, 0, 0, 0]);
        let mut twin = objects.clone();
        for object in &mut twin {
            for t in &mut object.triangles {
                if twins == 2 {
                    t.swap(1, 2);
                }
            }
            for n in &mut object.normals {
                *n *= if twins == 2 { -1.0 } else { 1.0 };
            }
        }
        let shapes = objects.clone();
        if twins > 0 {
            objects.extend(twin);
        }
        // Flipped twins of the luminous ceiling would shine outwards: that is fine, nobody is there.
        let bake = run(scene(objects, vec![grey(0.7, 0.0), grey(0.7, 1.0)]));
        (0..6)
            .map(|i| mean_over(&shapes[i], &bake.objects[i].light))
            .sum::<f64>()
    };
    let once = lit(0);
    for twins in [1, 2] {
        assert!(
            (lit(twins) / once - 1.0).abs() < 0.01,
            "{twins}: {} for {once}",
            lit(twins)
        );
    }
}

/// One side or both: a one-sided sheet in the sun is black behind, a two-sided one reflects.
#[test]
fn sides() {
    for (double_sided, lit_below) in [(false, false), (true, true)] {
        let mut sheet = grey(0.8, 0.0);
        sheet.double_sided = double_sided;
        // Light comes from below onto the back of a sheet that faces up; a floor far below it
        // faces up too and can only be lit by what the sheet's back reflects.
        let mut s = scene(
            vec![floor(1.0, 0.0, 4, 0), floor(10.0, 1.0, 4, 1)],
            vec![grey(0.0, 0.0), sheet],
        );
        s.lights.push(sun(1.0, Vec3::Y));
        // The floor must not shade the sheet: it is one-sided but blocks all the same.
        s.objects[0].positions.iter_mut().for_each(|p| *p *= 0.5);
        let bake = run(s);
        let below = bake.objects[0]
            .light
            .iter()
            .map(|l| l.x)
            .fold(0.0, f32::max);
        assert_eq!(below > 0.05, lit_below, "{below}");
    }
}

/// A room modelled inside out, double-sided: the light is on the side that is seen.
#[test]
fn rooms_inside_out() {
    let mut objects = room(Vec3::ONE, 4, [0; 6]);
    for object in &mut objects {
        object.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        object.normals.iter_mut().for_each(|n| *n = -*n);
    }
    let mut white = grey(0.5, 0.0);
    white.double_sided = true;
    let mut s = scene(objects, vec![white]);
    s.lights.push(Light {
        name: "lamp".into(),
        power: Vec3::splat(10.0),
        kind: LightKind::Point {
            position: Vec3::splat(0.5),
            range: f32::INFINITY,
        },
        ..Light::default()
    });
    let bake = run(s);
    assert!(values(&bake).iter().all(|&v| v > 0.1));
    assert!(
        bake.report
            .notes
            .iter()
            .any(|n| n.contains("lit from behind"))
    );
}

/// What is left when direct light is the engine's: with it, the sum is the whole.
#[test]
fn realtime_direct_light_is_left_out() {
    let lit = |direct| {
        let mut s = scene(room(Vec3::ONE, 8, [0; 6]), vec![grey(0.5, 0.0)]);
        s.lights.push(Light {
            name: "lamp".into(),
            power: Vec3::splat(10.0),
            kind: LightKind::Point {
                position: Vec3::splat(0.5),
                range: f32::INFINITY,
            },
            direct,
            ..Light::default()
        });
        let shapes = s.objects.clone();
        let bake = run(s);
        shapes
            .iter()
            .zip(&bake.objects)
            .map(|(o, l)| mean_over(o, &l.light))
            .sum::<f64>()
            / 6.0
    };
    let (whole, bounced) = (lit(DirectLight::Baked), lit(DirectLight::Realtime));
    // In a closed box of ρ = 0.5 light bounces 1 + 1/2 + 1/4 …: half of what arrives is direct.
    assert!(
        (bounced / whole - 0.5).abs() < 0.005,
        "{bounced} of {whole}"
    );
}

/// Textures are averaged over each element as light, so a fine pattern reflects its mean.
#[test]
fn textures_reflect_their_mean() {
    let lit = |textured: bool| {
        let mut objects = room(Vec3::ONE, 4, [0, 1, 2, 2, 2, 2]);
        objects[0].uvs = vec![
            objects[0]
                .positions
                .iter()
                .map(|p| Vec2::new(p.x, p.z) * 64.0)
                .collect(),
        ];
        let mut floor = grey(if textured { 1.0 } else { 0.5 }, 0.0);
        if textured {
            floor.base_color_texture = Some(TextureRef {
                texture: TextureId(0),
                uv_set: 0,
                transform: Affine2::IDENTITY,
            });
        }
        let mut s = scene(objects, vec![floor, grey(0.0, 1.0), grey(0.3, 0.0)]);
        s.textures.push(Texture {
            width: 2,
            height: 2,
            texels: vec![[255; 4], [0, 0, 0, 255], [0, 0, 0, 255], [255; 4]],
            ..Texture::default()
        });
        let ceiling = s.objects[1].clone();
        mean_over(&ceiling, &run(s).objects[1].light)
    };
    let (textured, plain) = (lit(true), lit(false));
    assert!(
        (textured / plain - 1.0).abs() < 0.01,
        "{textured} for {plain}"
    );
}

/// A floor under a rectangular light that faces it: L times the form factor, in closed form.
#[test]
fn a_rectangle_shines_as_its_form_factor_says() {
    let (width, height, distance, lumens) = (0.8_f32, 0.5_f32, 1.0_f32, 40.0_f32);
    let mut s = scene(vec![floor(1.5, 0.0, 24, 0)], vec![grey(0.5, 0.0)]);
    s.lights.push(Light {
        power: Vec3::splat(lumens),
        kind: LightKind::Rect {
            position: Vec3::Y * distance,
            direction: Vec3::NEG_Y,
            right: Vec3::X,
            width,
            height,
            range: f32::INFINITY,
        },
        ..Light::default()
    });
    let radiance = lumens / (std::f32::consts::PI * width * height);
    // A point under the corner of an a × b rectangle at distance 1, signed for the sides.
    let corner = |a: f32, b: f32| {
        let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        (a / x * (b / x).atan() + b / y * (a / y).atan()) / std::f32::consts::TAU
    };
    let positions = s.objects[0].positions.clone();
    let lit = run(s.clone());
    for (p, v) in positions.iter().zip(values(&lit)) {
        let (x, z) = (
            (p.x - width / 2.0, p.x + width / 2.0),
            (p.z - height / 2.0, p.z + height / 2.0),
        );
        let factor = corner(x.1, z.1) - corner(x.0, z.1) - corner(x.1, z.0) + corner(x.0, z.0);
        let truth = radiance * factor;
        assert!((v / truth - 1.0).abs() < 0.02, "at {p}: {v} for {truth}");
    }
    // The same as a luminous surface of that size, and nothing behind it.
    let mut lamp = scene(
        vec![
            floor(1.5, 0.0, 24, 0),
            quad(
                "lamp",
                Vec3::new(-width / 2.0, distance, -height / 2.0),
                Vec3::X * width,
                Vec3::Z * height,
                1,
                1,
            ),
        ],
        vec![grey(0.5, 0.0), grey(0.0, radiance)],
    );
    lamp.objects[1].receives = false;
    let mean = |bake: &Bake| mean_over(&s.objects[0], &bake.objects[0].light);
    assert!((mean(&run(lamp)) / mean(&lit) - 1.0).abs() < 0.02);
    s.objects[0].positions.iter_mut().for_each(|p| p.y = 2.0);
    assert!(values(&run(s)).iter().all(|&v| v == 0.0));
}

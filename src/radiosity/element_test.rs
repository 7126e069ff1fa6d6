//! Elements and rays placed by the light, against ones of one size.

use glam::{Vec3, Vec3A, Vec4};

use super::baker_test::{quad, room};
use super::direct::loose_emission;
use super::element_error::{Sent, apart};
use super::emitter::Emitters;
use super::form_factor::View;
use super::occlusion::Occluders;
use super::pipeline::run;
use super::report::Report;
use super::stages::{Stages, Start};
use super::surface::Surfaces;
use super::validate::ValidScene;
use super::{BakeSettings, Light, LightKind, Material, MaterialId, Object, Scene};

const SETTINGS: BakeSettings = BakeSettings {
    elements: 2000,
    element_rays: 48,
    gather_rays: 1,
    samples_per_vertex: 1.0,
    emitter_rays: 24,
    solver_tolerance: 1e-4,
    ..BakeSettings::DRAFT
};

fn grey(reflectance: f32) -> Material {
    Material {
        base_color: Vec4::new(reflectance, reflectance, reflectance, 1.0),
        ..Material::default()
    }
}

/// A closed room lit by the sun through a window in a wall.
fn window() -> Scene {
    let [x, y, z] = Vec3::AXES;
    let hole = [
        (0.0, 0.0, 6.0, 1.0),
        (0.0, 2.0, 6.0, 1.0),
        (0.0, 1.0, 4.0, 1.0),
        (5.0, 1.0, 1.0, 1.0),
    ];
    let mut objects = vec![
        quad(1, [Vec3::ZERO, z * 6.0, x * 6.0], 1, 0),
        quad(2, [y * 3.0, x * 6.0, z * 6.0], 1, 0),
        quad(3, [x * 6.0, z * 6.0, y * 3.0], 1, 0),
        quad(4, [Vec3::ZERO, x * 6.0, y * 3.0], 1, 0),
        quad(5, [z * 6.0, y * 3.0, x * 6.0], 1, 1),
    ];
    for (key, (a, b, w, h)) in (6..).zip(hole) {
        let corner = Vec3::new(0.0, b, a);
        objects.push(quad(key, [corner, y * h, z * w], 1, 0));
    }
    Scene {
        objects,
        materials: vec![grey(0.7), grey(0.5)],
        lights: vec![Light {
            power: Vec3::splat(100.0),
            kind: LightKind::Directional {
                direction: Vec3::new(1.0, -1.1, -0.3),
            },
            key: 100,
            ..Light::default()
        }],
        sky: Vec3::splat(0.5),
        ..Scene::default()
    }
}

/// A box with a lamp and two blocks.
fn cornell() -> Scene {
    let [x, y, z] = Vec3::AXES;
    let block = |key: u64, low: Vec3, size: Vec3| {
        let (x, y, z) = (x * size.x, y * size.y, z * size.z);
        [
            quad(key, [low + y, z, x], 1, 0),
            quad(key + 1, [low, z, y], 1, 0),
            quad(key + 2, [low + x, y, z], 1, 0),
            quad(key + 3, [low, y, x], 1, 0),
            quad(key + 4, [low + z, x, y], 1, 0),
        ]
    };
    let mut objects = vec![
        quad(1, [Vec3::ZERO, z, x], 6, 0),
        quad(2, [y, x, z], 6, 0),
        quad(3, [Vec3::ZERO, y, z], 6, 1),
        quad(4, [x, z, y], 6, 2),
        quad(5, [Vec3::ZERO, x, y], 6, 0),
        quad(6, [Vec3::new(0.35, 0.99, 0.35), x * 0.3, z * 0.3], 1, 3),
    ];
    objects.extend(block(
        10,
        Vec3::new(0.15, 0.0, 0.2),
        Vec3::new(0.3, 0.6, 0.3),
    ));
    objects.extend(block(20, Vec3::new(0.55, 0.0, 0.5), Vec3::splat(0.3)));
    let mut lamp = grey(0.0);
    lamp.emissive = Vec3::splat(20.0);
    Scene {
        objects,
        materials: vec![grey(0.73), grey(0.3), grey(0.4), lamp],
        sky: Vec3::splat(0.0),
        ..Scene::default()
    }
}

/// The room of the window, with a bumpy ball of 70,000 triangles.
fn statue() -> Scene {
    let mut scene = window();
    let (rows, columns) = (132_u32, 266_u32);
    let mut ball = Object {
        key: 50,
        material: MaterialId(1),
        uvs: vec![Vec::new()],
        ..Object::default()
    };
    for i in 0..=rows {
        for j in 0..=columns {
            let theta = std::f32::consts::PI * i as f32 / rows as f32;
            let phi = std::f32::consts::TAU * (j % columns) as f32 / columns as f32;
            let d = Vec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            );
            let bump = 1.0 + 0.05 * (20.0 * theta).sin() * (20.0 * phi).sin();
            ball.positions
                .push(Vec3::new(3.0, 1.0, 3.0) + d * (0.8 * bump));
            ball.uvs[0].push(glam::Vec2::ZERO);
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let k = i * (columns + 1) + j;
            ball.triangles.push([k, k + 1, k + columns + 2]);
            ball.triangles.push([k, k + columns + 2, k + columns + 1]);
        }
    }
    ball.uvs = vec![];
    scene.objects.push(ball);
    scene
}

fn solved(scene: &ValidScene, settings: &BakeSettings) -> (Report, Stages) {
    let (bake, stages) = run(scene, settings, Start::default(), &()).unwrap();
    (bake.report, stages)
}

/// RMS of the difference of light that two solutions send, beside the mean light that arrives.
fn error(scene: &ValidScene, settings: &BakeSettings, of: &Stages, truth: &Stages) -> f64 {
    let surfaces = Surfaces::new(scene, &truth.pyramids);
    let emitters = Emitters::at_elements(&truth.plan.emitters, settings);
    let marks = emitters.marks(&truth.elements);
    let view = View {
        scene,
        occluders: Occluders::new(&truth.hierarchy, &surfaces),
        elements: &truth.elements,
        emitters,
        marks: &marks,
        settings,
        remember: false,
    };
    let sent = |s: &Stages| -> Vec<Vec3A> {
        let loose = loose_emission(&s.elements, &emitters.marks(&s.elements));
        s.solution
            .reflected
            .iter()
            .zip(loose)
            .map(|(&r, e)| r + e)
            .collect()
    };
    let (a, b) = (sent(of), sent(truth));
    let [a, b] = [(of, &a), (truth, &b)].map(|(s, light)| Sent {
        elements: &s.elements,
        light,
    });
    let arriving: Vec<Vec3A> = truth.solution.arriving.iter().map(|&l| l.into()).collect();
    let mean = truth.elements.mean(&arriving).element_sum() / 3.0;
    apart(&view, a, b, &()).unwrap().0 / mean
}

fn even(settings: &BakeSettings) -> BakeSettings {
    BakeSettings {
        adapt: false,
        ..settings.clone()
    }
}

#[test]
#[ignore = "a study"]
fn study() {
    for (name, scene) in [
        ("window", window()),
        ("cornell", cornell()),
        ("room", room()),
        ("statue", statue()),
    ] {
        let scene = scene.validate().unwrap();
        for (elements, element_rays) in [(2000, 48), (4000, 12)] {
            let dense = BakeSettings {
                elements: 64_000,
                element_rays: 192,
                emitter_rays: 64,
                ..even(&SETTINGS)
            };
            let truth = solved(&scene, &dense).1;
            for adapt in [0, 1, 2] {
                    super::first_look::STUDY.store(adapt, std::sync::atomic::Ordering::Relaxed);
                for seed in [1, 2, 3] {
                    let settings = BakeSettings {
                        elements,
                        element_rays,
                        adapt: adapt > 0,
                        seed,
                        ..SETTINGS
                    };
                    let (report, stages) = solved(&scene, &settings);
                    let error = error(&scene, &settings, &stages, &truth);
                    let ms: Vec<String> = report
                        .stages
                        .iter()
                        .take(6)
                        .map(|(s, d)| format!("{}:{:.0}", &s.name()[..4], d.as_secs_f64() * 1e3))
                        .collect();
                    println!(
                        "{name:8} {elements:5} x {element_rays} adapt {adapt} seed {seed}: {:6} elements {:7} rays, error {:.3} % estimate {:.3} % sampling {:.2}  {}",
                        stages.elements.len(),
                        report.work.element_rays,
                        100.0 * error,
                        100.0 * report.error.elements,
                        100.0 * report.element_error,
                        ms.join(" ")
                    );
                }
            }
        }
    }
}
